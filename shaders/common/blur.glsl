// One axis of a separable blur of one layer (core/passes/blur.hpp).
#include "common/fullscreen.glsl"
#ifdef STAGE_FRAGMENT
layout(binding = 0) uniform sampler2DArray source;
layout(std430, binding = 0) readonly buffer Weights {
    float weights[];
};
uniform int stepX, stepY;  // (1, 0) or (0, 1)
uniform int reach;         // texels to each side
uniform int layer;

layout(location = 0) out vec2 blurred;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy), stride = ivec2(stepX, stepY);
    ivec2 size = textureSize(source, 0).xy;
    int at = stepX * texel.x + stepY * texel.y, end = stepX * size.x + stepY * size.y;
    int from = max(-reach, -at), to = min(reach, end - 1 - at);
    vec2 sum = vec2(0.0);
    for (int i = from; i <= to; ++i)
        sum += weights[abs(i)] * texelFetch(source, ivec3(texel + i * stride, layer), 0).rg;
    if (to - from < 2 * reach) {
        float within = 0.0;
        for (int i = from; i <= to; ++i) within += weights[abs(i)];
        sum /= within;
    }
    blurred = sum;
}
#endif
