// core/passes/pixel_classes.hpp: classes of tiles, and the answers of decided and shaded ones.
#ifdef PASS_CLASSIFY
#include "common/fullscreen.glsl"
#include "common/light_view.glsl"
#include "common/nearest_blocker.glsl"
#include "common/tile_class.glsl"
#ifdef STAGE_FRAGMENT
uniform float minKernel, maxKernel;
#ifdef BOX
uniform vec2 boxHalfM;                   // half extents of the box at a kernel of 1, metres
uniform float boxPad;                    // Receivers.pad
uniform float tileNearestS[kMaxTiles];   // s of the nearest caster that the box reaches out for
#endif
#ifdef MOMENTS
uniform float depthPerM[kMaxTiles];      // as the moments have it
uniform float leastVariance;             // of a cell
uniform float bleed;                     // what Chebyshev's bound says up to here is nothing
#endif

#ifdef BOX
const int kRounds = 1;
const int kFiner = 1;
#else
// A round looks only as far as the nearest caster reaches that the one before it found.
const int kRounds = 3;
const int kFiner = 2;  // in the last: what it costs is shared by the tile's pixels
#endif

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

// What of the tile's receivers is common to all. False where the pyramid is not to be asked; `asked`
// where there are any.
bool boundReceivers(ivec2 first, ivec2 last, out Receivers all, out float mostReach,
                    out bool asked) {
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
    asked = false;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec4 p = texelFetch(gbufferPosition, ivec2(x, y), 0);
            vec3 n = axes * texelFetch(gbufferNormal, ivec2(x, y), 0).xyz;
            vec3 l = axes * (p.xyz - lightCentre);
            bool asks = p.w == 1.0 || p.w == 2.0;
            asked = asked || asks;
            float inverse = 1.0 / l.z, s = near * inverse, k = dot(n, l);
            vec2 t = l.xy * inverse;
            vec2 gradient = k < 0.0 ? near / k * n.xy : vec2(0.0);
            vec3 error = abs(vec3(gradient - slope, s - all.planeS - dot(slope, t - from)));
            // Beside the reference's tile, on its border, or where part of the light is behind.
            float beside = tileCount > 1 ? max(abs(t.x), abs(t.y)) : 0.0;
            // Below its own horizon it is the surface's back that hides the light, which is below
            // the tangent plane.
#ifdef BOX
            bool front = l.z > 0.0;
#else
            bool front = l.z > 0.0 && k < -abs(dot(n, u)) - abs(dot(n, v));
#endif
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
#ifdef BOX
    // Side tiles see the light edge-on: methods take the wider extent for both there.
    vec2 halfM = point.tile == 0 ? boxHalfM : vec2(max(boxHalfM.x, boxHalfM.y));
    all.extent = halfM * toTexels / near;
    all.pad = boxPad;
#else
    // Of Footprint: affine in t, so that it is widest at a corner.
    all.extent = (max(abs(u.xy - u.z * lo), abs(u.xy - u.z * hi)) +
                  max(abs(v.xy - v.z * lo), abs(v.xy - v.z * hi))) * toTexels / near;
#endif
    all.minReach = minKernel * maxS;
    mostReach = max(maxKernel, minKernel) * maxS;
    return usable && widest < 0.9999;
}

bool isInMap(vec2 centre, vec2 around) {
    return all(greaterThanEqual(centre - around, vec2(0.0))) &&
           all(lessThanEqual(centre + around, vec2(mapSize)));
}

#ifdef MOMENTS
// Whether Chebyshev's bound is nothing for all, whatever of the box is averaged. Of depths between a
// and b, both before t, it is at most ((b - a) / (b - a + 2 (t - b)))^2: that of the two-point
// distribution on a and b with the worst weights.
bool isDarkByMoments(Receivers r, float reach, Blockers found) {
    float near = tileNear[r.tile];
    vec2 across = r.extent * reach + r.pad, around = r.halfBox + across;
    float plane = r.planeS + r.planeError + dot(r.slopeError, across + 0.5) +
                  dot(abs(r.slope), around);
    float t = near / (max(r.maxS, plane) * r.scale), zM = near / r.minS;
    // What vsm takes off for planes that go on beyond the farthest receiver, for a cell as the box.
    t -= 0.25 * zM * zM / near * dot(abs(r.slope) + r.slopeError, around);
    float a = near / found.nearest, b = near / found.least;
    float gap = t - b;
    if (gap <= 0.0) return false;
    float share = (b - a) / (b - a + 2.0 * gap);
    float gapDepth = gap * depthPerM[r.tile];
    float most = max(share * share, leastVariance / (leastVariance + gapDepth * gapDepth));
    return most - bleed <= (1.0 - bleed) / 510.0;  // half of what a display shows
}
#endif

void main() {
    ivec2 first = firstOfTile(), last = lastOfTile();
    Receivers all;
    float mostReach;
    bool asked;
    bool usable = boundReceivers(first, last, all, mostReach, asked);
    tileClass = asked ? kEverywhere : kLit;  // the answers of those that do not ask are known
    if (!usable) return;
    Blockers found;
    found.dark = false;
#ifdef BOX
    float nearest = tileNearestS[all.tile];
    float reach = clamp(nearest - all.minS, all.minReach, mostReach);
#else
    float nearest = 1.0;
#endif
    for (int i = 0; i < kRounds && nearest > 0.0 && !found.dark; ++i) {
#ifndef BOX
        float reach = min(nearest - all.minS + all.minReach, mostReach);
#endif
        found = nearestBlocker(all, reach, i + 1 < kRounds ? 0 : kFiner);
        nearest = min(nearest, found.nearest);
    }
    if (nearest == 0.0) {
        tileClass = kLit;
        return;
    }
#ifdef DARK
#ifdef BOX
    // Beyond the map all is lit.
    found.dark = found.dark && isInMap(all.centre, all.halfBox + all.extent * reach + all.pad);
#endif
#ifdef MOMENTS
    found.dark = found.dark && isDarkByMoments(all, reach, found);
#endif
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
layout(binding = 11) uniform sampler2D shaded;

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    vec4 tile = tileOfPixel();
    visibility = isDecided(tile) ? tile.z : texelFetch(shaded, ivec2(gl_FragCoord.xy), 0).r;
}
#endif
#endif
