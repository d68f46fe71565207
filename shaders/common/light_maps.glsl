// Lookups in maps from several points of the light (core/passes/light_maps.hpp). Their image planes
// are parallel, so a receiver's z, its s and its plane's slope but for one factor are the same in all
// of them: a map costs one fetch and no division. LIGHT_MAPS_PCF: four comparisons, weighted as the
// receiver lies between their texels. LIGHT_MAPS_KERNEL n: n x n of them, 3 or 5, which a box of n - 1
// texels around the receiver covers.
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
const int kMaxLightSamples = 256;
struct LightSample {
    vec4 shift;         // texels: a place in the centre's map moves by xy + zw / z
    vec4 offsetWeight;  // the point's offset from the light's centre, metres; its weight
};
layout(std140, binding = 1) uniform LightSamples { LightSample lightSamples[kMaxLightSamples]; };
uniform int firstLightSample;     // looked up are this one and those after it,
uniform int lightSampleCount;     // so many
uniform float lightSampleWeight;  // of all that are looked up

// A receiver as every point of the light sees it.
struct Receiver {
    vec2 texel;       // its place in the map of the light's centre, texels
    float inverseZ;   // 1 / metres
    float level;      // s = near / z, scaled against bias: casters above it block
    vec2 slope;       // n.xy in tangents per texel ...
    vec2 levelSlope;  // ... and scaled so that the level rises by levelSlope / k per texel ...
    float k;          // ... with k = n.l, seen from the centre; negative where the plane faces it
};

Receiver receiverOf(LightPoint point, vec3 position, vec3 normal) {
    vec3 n = tileAxes[0] * normal;
    vec2 slope = n.xy / (tileTangents[0].zw * float(mapSize));
    return Receiver(point.uv * float(mapSize), 1.0 / point.zM, point.s * point.biasScale, slope,
                    tileNear[0] * point.biasScale * slope,
                    dot(n, tileAxes[0] * (position - lightCentre)));
}

// Weights in steps of 1/32: with sample weights of 1, 2 and 4 the sum of a thousand maps is exact,
// in any order.
vec2 weightsBetween(vec2 fraction) { return floor(32.0 * fraction + 0.5) / 32.0; }

// Where map i has the receiver, texels. Views hold every receiver with a margin of one texel, so that
// its texel and those beside it are inside.
vec2 placeIn(Receiver r, int i) {
    vec4 shift = lightSamples[i].shift;
    return r.texel + (shift.xy + shift.zw * r.inverseZ);
}

#ifdef LIGHT_MAPS_KERNEL
// How much of a texel's width the box covers; texel 0 is the first of LIGHT_MAPS_KERNEL.
float coverage(int texel, float weight) {
    return texel == 0 ? 1.0 - weight : texel == LIGHT_MAPS_KERNEL - 1 ? weight : 1.0;
}
const float kBoxArea = float((LIGHT_MAPS_KERNEL - 1) * (LIGHT_MAPS_KERNEL - 1));
#endif

// litAt of common/light_view.glsl in map i, the plane followed to every texel asked; 0 where the
// map's point of the light is below the receiver's horizon, whose own surface is in the way. A caster
// is at most at the level where caster - level <= max(rise / k, 0); times k, which is negative where
// it counts, that needs no division.
float litFrom(Receiver r, int i) {
    vec2 place = placeIn(r, i);
    float k = r.k + dot(r.slope, lightSamples[i].shift.zw);
#ifdef LIGHT_MAPS_PCF
    vec2 first = floor(place - 0.5), weight = weightsBetween(place - 0.5 - first);
    vec4 caster = textureGather(shadowMap, vec3((first + 1.0) / float(mapSize), i));
    vec2 rises = r.levelSlope;
    float riseToFirst = dot(rises, first + 0.5 - place);
    vec4 rise = riseToFirst + vec4(rises.y, rises.x + rises.y, rises.x, 0.0);
    vec4 lit = vec4(greaterThanEqual((caster - r.level) * k, min(rise, 0.0)));
    vec2 rows = mix(lit.wx, lit.zy, weight.x);
    float v = mix(rows.x, rows.y, weight.y);
#elif defined(LIGHT_MAPS_KERNEL)
    vec2 corner = place - 0.5 * float(LIGHT_MAPS_KERNEL - 1);
    vec2 first = floor(corner), weight = weightsBetween(corner - first);
    float v = 0.0;
    for (int y = 0; y < LIGHT_MAPS_KERNEL; ++y)
        for (int x = 0; x < LIGHT_MAPS_KERNEL; ++x) {
            vec2 texel = first + vec2(x, y);
            float rise = dot(r.levelSlope, texel + 0.5 - place);
            ivec2 inside = clamp(ivec2(texel), ivec2(0), ivec2(mapSize - 1));
            float caster = texelFetch(shadowMap, ivec3(inside, i), 0).r;
            if ((caster - r.level) * k >= min(rise, 0.0))
                v += coverage(x, weight.x) * coverage(y, weight.y);
        }
    v /= kBoxArea;
#else
    vec2 texel = floor(place);
    float rise = dot(r.levelSlope, texel + 0.5 - place);
    float caster = texelFetch(shadowMap, ivec3(texel, i), 0).r;
    float v = (caster - r.level) * k >= min(rise, 0.0) ? 1.0 : 0.0;
#endif
    return k < 0.0 ? v : 0.0;
}

// The same where a map has five tiles and each point of the light its own choice among them.
float litFromHalfCube(vec3 position, vec3 normal, int i) {
    vec3 moved = position - lightSamples[i].offsetWeight.xyz;
    if (dot(normal, moved - lightCentre) >= 0.0) return 0.0;
    LightPoint point = lightPoint(moved, normal);
    point.tile += i * tileCount;
#ifdef LIGHT_MAPS_PCF
    float texel = 1.0 / float(mapSize);
    vec2 place = point.uv * float(mapSize) - 0.5, weight = weightsBetween(fract(place));
    vec2 corner = (floor(place) + 0.5) * texel;
    return mix(mix(litAt(point, corner), litAt(point, corner + vec2(texel, 0)), weight.x),
               mix(litAt(point, corner + vec2(0, texel)), litAt(point, corner + texel), weight.x),
               weight.y);
#elif defined(LIGHT_MAPS_KERNEL)
    vec2 corner = point.uv * float(mapSize) - 0.5 * float(LIGHT_MAPS_KERNEL - 1);
    vec2 weight = weightsBetween(fract(corner));
    float v = 0.0;
    for (int y = 0; y < LIGHT_MAPS_KERNEL; ++y)
        for (int x = 0; x < LIGHT_MAPS_KERNEL; ++x)
            v += coverage(x, weight.x) * coverage(y, weight.y) *
                 litAt(point, (floor(corner) + vec2(x, y) + 0.5) / float(mapSize));
    return v / kBoxArea;
#else
    return litAt(point, point.uv);
#endif
}

// Hard visibility of map i.
float litFromMap(Receiver receiver, vec3 position, vec3 normal, int i) {
    return tileCount > 1 ? litFromHalfCube(position, normal, i) : litFrom(receiver, i);
}

// Weighted sum over all samples of the receiver's hard visibilities.
float litSum(vec3 position, vec3 normal) {
    LightPoint centre = lightPoint(position, normal);
    if (!centre.inFront) return lightSampleWeight;
    float sum = 0.0;
    if (tileCount > 1) {
        for (int i = firstLightSample; i < firstLightSample + lightSampleCount; ++i)
            sum += lightSamples[i].offsetWeight.w * litFromHalfCube(position, normal, i);
    } else {
        Receiver receiver = receiverOf(centre, position, normal);
        for (int i = firstLightSample; i < firstLightSample + lightSampleCount; ++i)
            sum += lightSamples[i].offsetWeight.w * litFrom(receiver, i);
    }
    return sum;
}
#endif
