#include "common/receiver.glsl"
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
#include "common/sample_patterns.glsl"

uniform vec2 kernelHalfM;  // half extents of the kernel at the receiver, along the light's u and v
uniform int p_taps;

// The kernel in texture coordinates of the receiver's tile. Side tiles see the light edge-on, where
// the two widths have no axis of their own: the wider one serves for both.
vec2 kernelHalfUv(LightPoint point) {
    vec2 extent = point.tile == 0 ? kernelHalfM : vec2(max(kernelHalfM.x, kernelHalfM.y));
    return extent / point.zM * tileTangents[point.tile].zw;
}

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    if (!point.inFront) {
        visibility = 1.0;
        return;
    }
#ifdef KERNEL_POINT
    visibility = litAt(point, point.uv);
#else
    vec2 kernel = kernelHalfUv(point);
    float lit = 0.0;
#ifdef KERNEL_GRID
    int k = int(sqrt(float(p_taps) + 0.5));
    for (int j = 0; j < k; ++j)
        for (int i = 0; i < k; ++i)
            lit += litAt(point, point.uv + kernel * ((2.0 * vec2(i, j) + 1.0) / float(k) - 1.0));
    visibility = lit / float(k * k);
#else
    for (int i = 0; i < p_taps; ++i) lit += litAt(point, point.uv + kernel * vogel(i, p_taps));
    visibility = lit / float(p_taps);
#endif
#endif
}
#endif
