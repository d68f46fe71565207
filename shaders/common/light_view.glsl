// Shadow-map lookups in a light view: core/frame/light_view.hpp says what is stored and why.
#ifdef STAGE_FRAGMENT
const int kMaxTiles = 5;
uniform vec3 lightCentre;
uniform int tileCount;
uniform mat3 tileAxes[kMaxTiles];      // world to light: rows x, y, z
uniform vec4 tileTangents[kMaxTiles];  // tangentLo, 1 / tangentSize
uniform float tileNear[kMaxTiles];     // metres
uniform int mapSize;                   // texels across
#ifndef NO_BIAS  // defined where no caster comes near a receiver
uniform float biasTexels;              // constant bias, texel footprints towards the light
#endif
layout(binding = 0) uniform sampler2DArray shadowMap;

// A receiver in its tile: where it is, how deep, and how its own plane runs there.
struct LightPoint {
    int tile;
    vec2 uv;
    float zM;        // linear depth, metres
    float s;         // near / z of the receiver
    vec2 gradient;   // ds/duv of its tangent plane, exact: 1/z is affine over a plane
    float biasScale; // s is compared after scaling by this: z - bias, relative as is a texel's footprint
    bool inFront;    // false on or behind the light's plane: nothing shadows it
};

LightPoint lightPoint(vec3 position, vec3 normal) {
    LightPoint point;
    vec3 p = position - lightCentre;
    vec3 l = tileAxes[0] * p;
    point.tile = 0;
    if (tileCount > 1) {
        vec2 a = abs(l.xy);
        if (max(a.x, a.y) > l.z) point.tile = a.x >= a.y ? (l.x > 0.0 ? 1 : 2) : (l.y > 0.0 ? 3 : 4);
        l = tileAxes[point.tile] * p;
    }
    point.inFront = l.z > 0.0;
    vec4 tangents = tileTangents[point.tile];
    float near = tileNear[point.tile];
    point.zM = l.z;
    point.uv = (l.xy / l.z - tangents.xy) * tangents.zw;
    point.s = near / l.z;
    // Plane n.l = k, so 1/z = (n.x t.x + n.y t.y + n.z) / k; k < 0 where the receiver faces the light.
    // Where the centre is below its horizon the plane says nothing about what the centre sees.
    vec3 n = tileAxes[point.tile] * normal;
    float k = dot(n, l);
    point.gradient = k < 0.0 ? near * n.xy / (k * tangents.zw) : vec2(0.0);
#ifdef NO_BIAS
    point.biasScale = 1.0;
#else
    point.biasScale = 1.0 + biasTexels / (float(mapSize) * min(tangents.z, tangents.w));
#endif
    return point;
}

// Hard visibility of the receiver at `uv`, its plane followed to the very place where the nearest
// texel was sampled, so that a plane of any slope never shadows itself. Where the plane recedes from
// the light, casters between it and the receiver's own depth do not count either: no way from the
// receiver to the light leads past them. Outside the map: lit.
float litAt(LightPoint point, vec2 uv) {
    ivec2 texel = ivec2(floor(uv * float(mapSize)));
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(mapSize)))) return 1.0;
    vec2 centre = (vec2(texel) + 0.5) / float(mapSize);
    float rise = max(dot(point.gradient, centre - point.uv), 0.0);
    float caster = texelFetch(shadowMap, ivec3(texel, point.tile), 0).r;
    return caster <= (point.s + rise) * point.biasScale ? 1.0 : 0.0;
}
#endif
