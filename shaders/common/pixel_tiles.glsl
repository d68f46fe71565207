// Tiles of pixels that are answered, or not, at once: core/passes/pixel_tiles.hpp.
#include "common/receiver.glsl"

const int kTilePixels = 8;
layout(binding = 2) uniform sampler2D tiles;  // 0 lit, < 0 dark, > 0 to be shaded
layout(binding = 4) uniform sampler2D tileNotes;  // of those to be shaded

#if defined(STAGE_VERTEX) && defined(TILE_POINTS)
// A tile is a point, so that no pixel block is shaded for two triangles. Those that are decided are
// clipped.
void main() {
    ivec2 across = textureSize(tiles, 0);
    ivec2 tile = ivec2(gl_VertexID % across.x, gl_VertexID / across.x);
    vec2 centre = (vec2(tile) + 0.5) / vec2(across);
    bool decided = texelFetch(tiles, tile, 0).r <= 0.0;
    gl_Position = vec4(2.0 * centre - 1.0, decided ? 2.0 : 0.0, 1.0);
    gl_PointSize = float(kTilePixels);
}
#endif

#if defined(STAGE_FRAGMENT) && defined(PASS_ANSWERS)
layout(binding = 3) uniform sampler2D pixels;

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float tile = texelFetch(tiles, pixel / kTilePixels, 0).r;
    visibility = tile > 0.0 ? texelFetch(pixels, pixel, 0).r : tile == 0.0 ? 1.0 : 0.0;
}
#endif
