#include "common/receiver.glsl"
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
#include "common/sample_patterns.glsl"

const int kMaxTaps = 1024;
layout(std140, binding = 1) uniform Taps { vec4 taps[kMaxTaps]; };  // xy on [-1, 1]^2
uniform int tapCount;
uniform vec2 kernelHalfM;  // half extents of the kernel at the receiver, along the light's u and v
layout(binding = 1) uniform sampler2DArrayShadow comparedMap;  // the same map, filtered

// The kernel in texture coordinates of the receiver's tile. Side tiles see the light edge-on, where
// the two widths have no axis of their own: the wider one serves for both.
vec2 kernelHalfUv(LightPoint point) {
    vec2 extent = point.tile == 0 ? kernelHalfM : vec2(max(kernelHalfM.x, kernelHalfM.y));
    return extent / point.zM * tileTangents[point.tile].zw;
}

// Four comparisons weighted by distance, all with one reference: the receiver's plane at that of the
// four texel centres where it is nearest to the light, so that none of them shadows a plane. Past
// the map's border the sampler finds no caster.
float litBetween(LightPoint point, vec2 uv) {
    float texel = 1.0 / float(mapSize);
    vec2 first = (floor(uv * float(mapSize) - 0.5) + 0.5) * texel;
    vec2 most = max(point.gradient, 0.0) * texel;
    float rise = max(dot(point.gradient, first - point.uv) + most.x + most.y, 0.0);
    return texture(comparedMap, vec4(uv, point.tile, (point.s + rise) * point.biasScale));
}

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    if (!point.inFront) {
        visibility = 1.0;
        return;
    }
#ifdef NO_KERNEL
    visibility = litAt(point, point.uv);
#else
    vec2 kernel = kernelHalfUv(point);
    mat2 turned = mat2(kernel.x, 0.0, 0.0, kernel.y);
#ifdef ROTATION
    turned *= pixelRotation(uvec2(gl_FragCoord.xy));
#endif
    float lit = 0.0;
    for (int i = 0; i < tapCount; ++i) {
        vec2 uv = point.uv + turned * taps[i].xy;
#ifdef COMPARE_HARDWARE
        lit += litBetween(point, uv);
#else
        lit += litAt(point, uv);
#endif
    }
    visibility = lit / float(tapCount);
#endif
}
#endif
