// Levels of core/passes/farthest_pyramid.hpp: PASS_BASE from a map, PASS_REDUCE from the level below.
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f, binding = 0) writeonly uniform image2DArray level;
layout(binding = 0) uniform sampler2DArray source;
uniform int layer;  // PASS_BASE: of the pyramid
uniform int below;  // PASS_REDUCE: the source's level

void main() {
    ivec3 block = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(block.xy, imageSize(level).xy))) return;
    float least = 2.0;
#ifdef PASS_BASE
    block.z = layer;
    const int kBlockTexels = 8;
    ivec2 last = textureSize(source, 0).xy - 1;
    for (int y = 0; y < kBlockTexels; ++y)
        for (int x = 0; x < kBlockTexels; ++x) {
            ivec2 texel = min(block.xy * kBlockTexels + ivec2(x, y), last);
            float s = texelFetch(source, ivec3(texel, 0), 0).r;
            least = s > 0.0 ? min(least, s) : least;
        }
#else
    for (int i = 0; i < 4; ++i)
        least = min(least, texelFetch(source, ivec3(2 * block.xy + ivec2(i & 1, i >> 1), block.z), below).r);
#endif
    imageStore(level, block, vec4(least));
}
