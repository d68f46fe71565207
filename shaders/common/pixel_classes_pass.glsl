// core/passes/pixel_classes.hpp: classes of tiles, and the answers of decided and shaded ones.
#ifdef PASS_CLASSIFY
#include "common/fullscreen.glsl"
#include "common/light_view.glsl"
#include "common/nearest_blocker.glsl"
#ifdef STAGE_FRAGMENT
layout(binding = 8) uniform sampler2D gbufferPosition;  // as in common/receiver.glsl
layout(binding = 9) uniform sampler2D gbufferNormal;
layout(location = 0) out vec4 tileClass;

uniform int tilePixels;
uniform float minKernel, maxKernel;

const vec4 kLit = vec4(2.0, 0.0, 1.0, 0.0), kDark = vec4(2.0, 0.0, 0.0, 0.0);
const vec4 kEverywhere = vec4(-1e30, -1e30, 1e30, 1e30);

// A round looks only as far as the nearest caster reaches that the one before it found.
const int kRounds = 3;
const int kFiner = 2;  // in the last: what it costs is shared by the tile's pixels

// The first of a few pixels of the tile that asks, whose plane the others are compared with.
bool findReference(ivec2 first, ivec2 last, out LightPoint point) {
    vec4 found = vec4(0.0);
    vec3 normal = vec3(0.0);
    for (int i = 0; i < 5; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1) * (last - first);
        ivec2 pixel = i == 4 ? (first + last) / 2 : first + corner;
        vec4 p = texelFetch(gbufferPosition, pixel, 0);
        if (p.w != 1.0 && p.w != 2.0) continue;
        found = p;
        normal = texelFetch(gbufferNormal, pixel, 0).xyz;
    }
    point = lightPoint(found.xyz, normal);
    return found.w != 0.0 && point.inFront;
}

// What of the tile's receivers is common to all. False where the pyramid is not to be asked.
bool boundReceivers(ivec2 first, ivec2 last, out Receivers all, out float mostReach) {
    LightPoint point;
    bool usable = findReference(first, last, point);
    Footprint reference = footprint(point, minKernel, maxKernel);
    all = only(reference);

    // lightPoint for all, in the reference's tile, the plane in tangents from the reference on.
    mat3 axes = tileAxes[point.tile];
    vec3 u = axes * lightU, v = axes * lightV;
    vec4 tangents = tileTangents[point.tile];
    vec2 toTexels = tangents.zw * float(mapSize), toTangents = 1.0 / toTexels;
    float near = tileNear[point.tile];
    vec2 slope = all.slope * toTexels;
    vec2 from = reference.centre * toTangents + tangents.xy;
    vec2 lo = from, hi = from, slopeError = vec2(0.0);
    float minS = all.minS, maxS = all.maxS, planeError = 0.0, widest = 0.0;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec4 p = texelFetch(gbufferPosition, ivec2(x, y), 0);
            vec3 n = axes * texelFetch(gbufferNormal, ivec2(x, y), 0).xyz;
            vec3 l = axes * (p.xyz - lightCentre);
            bool asks = p.w == 1.0 || p.w == 2.0;
            float inverse = 1.0 / l.z, s = near * inverse, k = dot(n, l);
            vec2 t = l.xy * inverse;
            vec2 gradient = k < 0.0 ? near / k * n.xy : vec2(0.0);
            vec3 error = abs(vec3(gradient - slope, s - all.planeS - dot(slope, t - from)));
            // Beside the reference's tile, on its border, or where part of the light is behind.
            float beside = tileCount > 1 ? max(abs(t.x), abs(t.y)) : 0.0;
            // Below its own horizon it is the surface's back that hides the light, which is below
            // the tangent plane.
            bool front = l.z > 0.0 && k < -abs(dot(n, u)) - abs(dot(n, v));
            widest = asks ? max(widest, front ? beside : 2.0) : widest;
            lo = asks ? min(lo, t) : lo;
            hi = asks ? max(hi, t) : hi;
            minS = asks ? min(minS, s) : minS;
            maxS = asks ? max(maxS, s) : maxS;
            slopeError = asks ? max(slopeError, error.xy) : slopeError;
            planeError = asks ? max(planeError, error.z) : planeError;
        }
    vec2 middle = 0.5 * (lo + hi);
    all.centre = (middle - tangents.xy) * toTexels;
    all.halfBox = 0.5 * (hi - lo) * toTexels;
    all.minS = minS;
    all.maxS = maxS;
    all.planeS += dot(slope, middle - from);
    all.planeError = planeError;
    all.slopeError = slopeError * toTangents;
    // Of Footprint: affine in t, so that it is widest at a corner.
    all.extent = (max(abs(u.xy - u.z * lo), abs(u.xy - u.z * hi)) +
                  max(abs(v.xy - v.z * lo), abs(v.xy - v.z * hi))) * toTexels / near;
    all.minReach = minKernel * maxS;
    mostReach = max(maxKernel, minKernel) * maxS;
    return usable && widest < 0.9999;
}

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * tilePixels;
    ivec2 last = min(first + tilePixels, textureSize(gbufferPosition, 0)) - 1;
    Receivers all;
    float mostReach;
    tileClass = kEverywhere;
    if (!boundReceivers(first, last, all, mostReach)) return;
    Blockers found;
    found.dark = false;
    float nearest = 1.0;
    for (int i = 0; i < kRounds && nearest > 0.0 && !found.dark; ++i) {
        float reach = min(nearest - all.minS + all.minReach, mostReach);
        found = nearestBlocker(all, reach, i + 1 < kRounds ? 0 : kFiner);
        nearest = min(nearest, found.nearest);
    }
    if (nearest == 0.0) {
        tileClass = kLit;
        return;
    }
#ifdef DARK
    if (found.dark) {
        tileClass = kDark;
        return;
    }
#endif
    // The map's edge goes on beyond it.
    tileClass.xy = mix(found.lo, tileClass.xy, lessThanEqual(found.lo, vec2(0.0)));
    tileClass.zw = mix(found.hi, tileClass.zw, greaterThanEqual(found.hi, vec2(mapSize)));
}
#endif
#endif

#ifdef PASS_ANSWERS
#include "common/pixel_classes.glsl"
#ifdef STAGE_FRAGMENT
layout(binding = 3) uniform sampler2D shaded;

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    vec4 tile = tileOfPixel();
    visibility = isDecided(tile) ? tile.z : texelFetch(shaded, ivec2(gl_FragCoord.xy), 0).r;
}
#endif
#endif
