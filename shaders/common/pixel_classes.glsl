// Tiles of pixels that are answered at once, and those that are not: core/passes/pixel_classes.hpp.
// With UNDECIDED_TILES a program runs on the latter's pixels only.
#include "common/receiver.glsl"

const int kTilePixels = 4;
layout(binding = 10) uniform sampler2D tileClasses;

// A tile's texel: the box of the map, lo and hi in texels, outside of which no texel blocks any of
// the tile's receivers; or, where that is empty, the answer for all of them in z.
bool isDecided(vec4 tile) {
    return tile.x > tile.z;
}

#if defined(STAGE_VERTEX) && defined(UNDECIDED_TILES)
// A tile is a point, so that no block of pixels is shaded for two triangles. Those that are decided
// are clipped.
void main() {
    ivec2 across = textureSize(tileClasses, 0);
    ivec2 tile = ivec2(gl_VertexID % across.x, gl_VertexID / across.x);
    vec2 centre = (vec2(tile) + 0.5) / vec2(across);
    bool decided = isDecided(texelFetch(tileClasses, tile, 0));
    gl_Position = vec4(2.0 * centre - 1.0, decided ? 2.0 : 0.0, 1.0);
    gl_PointSize = float(kTilePixels);
}
#endif

#ifdef STAGE_FRAGMENT
vec4 tileOfPixel() {
    return texelFetch(tileClasses, ivec2(gl_FragCoord.xy) / kTilePixels, 0);
}
#endif
