// One fragment a tile: a pass that tells the classes of core/passes/pixel_classes.hpp.
#ifdef STAGE_FRAGMENT
layout(binding = 8) uniform sampler2D gbufferPosition;  // as in common/receiver.glsl
layout(binding = 9) uniform sampler2D gbufferNormal;
layout(location = 0) out vec4 tileClass;  // as common/pixel_classes.glsl reads it

uniform int tilePixels;

const vec4 kLit = vec4(2.0, 0.0, 1.0, 0.0), kDark = vec4(2.0, 0.0, 0.0, 0.0);
const vec4 kEverywhere = vec4(-1e30, -1e30, 1e30, 1e30);

ivec2 firstOfTile() {
    return ivec2(gl_FragCoord.xy) * tilePixels;
}

ivec2 lastOfTile() {
    return min(firstOfTile() + tilePixels, textureSize(gbufferPosition, 0)) - 1;
}
#endif
