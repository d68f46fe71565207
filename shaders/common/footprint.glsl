// What of the map a receiver's light rays pass over. Include after common/light_view.glsl.
#ifdef STAGE_FRAGMENT
uniform vec3 lightU, lightV;  // the light's half axes, metres

// In texels of the receiver's tile. A ray to the point C + a lightU + b lightV, a and b in [-1, 1],
// meets a caster of s_b beside the receiver by (s_b - s) (a u + b v): 1/z_b - 1/z is the difference
// of s over near. Exact in tile 0, which is parallel to the light; in a side tile the perspective
// over the light's own depth is left out.
struct Footprint {
    vec2 centre;    // the receiver
    vec2 u, v;      // texels per unit of s
    float s;        // of the receiver
    vec2 plane;     // ds per texel of its tangent plane
    float scale;    // LightPoint.biasScale
    int tile;
    float minReach; // of the filter, in s: half the kernel is reach (u, v)
    float maxReach;
};

// Kernels are between `minKernel` and `maxKernel` sizes of the light wide at the receiver.
Footprint footprint(LightPoint point, float minKernel, float maxKernel) {
    Footprint f;
    vec4 tangents = tileTangents[point.tile];
    vec2 t = point.uv / tangents.zw + tangents.xy;
    vec3 u = tileAxes[point.tile] * lightU, v = tileAxes[point.tile] * lightV;
    vec2 texelsPerS = tangents.zw * float(mapSize) / tileNear[point.tile];
    f.centre = point.uv * float(mapSize);
    f.u = (u.xy - u.z * t) * texelsPerS;
    f.v = (v.xy - v.z * t) * texelsPerS;
    f.s = point.s;
    f.plane = point.gradient / float(mapSize);
    f.scale = point.biasScale;
    f.tile = point.tile;
    // Kernel over light size at the receiver: (z - z_b) / z_b = (s_b - s) / s.
    f.minReach = minKernel * point.s;
    f.maxReach = max(maxKernel, minKernel) * point.s;
    return f;
}
#endif
