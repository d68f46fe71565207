// Casters too near a receiver for slices to tell the two apart, by comparisons with the map from the
// light's centre. Include after common/slice_kernels.glsl.
#ifdef STAGE_FRAGMENT
LightPoint receiver;

// Whether the shadow map knows a caster between `fromM` and `toM` on the way from the light's
// centre through `q`, light coordinates, that is not the receiver's own plane.
bool castsAt(vec3 q, float fromM, float toM, out float casterM) {
    casterM = 0.0;
    vec3 l = tileAxes[receiver.tile] * (q * lightAxes);
    vec4 tangents = tileTangents[receiver.tile];
    vec2 uv = (l.xy / l.z - tangents.xy) * tangents.zw;
    if (litAt(receiver, uv) == 1.0) return false;
    float caster = texelFetch(shadowMap, ivec3(floor(uv * float(mapSize)), receiver.tile), 0).r;
    casterM = q.z * tileNear[receiver.tile] / (caster * l.z);  // both on one way
    return casterM >= fromM && casterM < toM;
}

// Where the way from the receiver to a point of the light, in half its size, crosses a depth.
vec3 wayTo(vec2 onLight, vec3 p, float zM) {
    return vec3(mix(lightHalfM * onLight, p.xy, zM / p.z), zM);
}

// Whether something below `topM` hides the light's centre or a corner of it, as the map has it, and how
// deep the first such caster is.
bool touched(vec3 p, float topM, out float casterM) {
    bool any = castsAt(p, topM, p.z, casterM);
    for (int i = 0; i < 4 && !any; ++i)
        any = castsAt(wayTo(vec2(i & 1, i >> 1) * 2.0 - 1.0, p, 0.5 * (topM + p.z)), topM, p.z,
                      casterM);
    return any;
}
#endif
