// One level of N-buffers from the one before it (core/passes/n_buffers.hpp).
#ifdef STAGE_COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2DArray source;
layout(binding = 0, rgba16f) uniform image2DArray buffers;
uniform int level, levels;

vec4 before(ivec2 at, int layer) {
    ivec2 size = imageSize(buffers).xy;
    if (at.x >= size.x || at.y >= size.y) return vec4(0.0);
    return imageLoad(buffers, ivec3(at, layer * levels + level - 1));
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    ivec2 size = imageSize(buffers).xy;
    if (at.x >= size.x || at.y >= size.y) return;
#ifdef PASS_BASE
    vec4 mean = texelFetch(source, at, 0);
#else
    // Decoret 2005's recurrence with the mean for the maximum.
    int step = 1 << (level - 1);
    vec4 mean = 0.25 * (before(at.xy, at.z) + before(at.xy + ivec2(step, 0), at.z) +
                        before(at.xy + ivec2(0, step), at.z) + before(at.xy + step, at.z));
#endif
    imageStore(buffers, ivec3(at.xy, at.z * levels + level), mean);
}
#endif
