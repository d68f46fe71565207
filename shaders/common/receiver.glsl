// The shade pass's doors: one full-screen triangle in, one visibility out.
#ifndef UNDECIDED_TILES  // common/pixel_classes.glsl draws those
#include "common/fullscreen.glsl"
#endif
#ifdef STAGE_FRAGMENT
layout(binding = 8) uniform sampler2D gbufferPosition;  // relative position (m), class
layout(binding = 9) uniform sampler2D gbufferNormal;    // geometric normal

layout(location = 0) out float visibility;

// False where nobody asks: background (visibility 1) and surfaces facing away (0) are written here.
bool receivesAt(ivec2 pixel, out vec3 position, out vec3 normal) {
    vec4 p = texelFetch(gbufferPosition, pixel, 0);
    position = p.xyz;
    normal = texelFetch(gbufferNormal, pixel, 0).xyz;
    visibility = p.w == 0.0 ? 1.0 : 0.0;
    return p.w == 1.0 || p.w == 2.0;
}

bool receives(out vec3 position, out vec3 normal) {
    return receivesAt(ivec2(gl_FragCoord.xy), position, normal);
}
#endif
