#ifdef EARLY_OUTS
#include "common/pixel_tiles.glsl"
#else
#include "common/receiver.glsl"
#endif
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
#ifdef SOFT
#include "common/nearest_blocker.glsl"
#include "common/sample_patterns.glsl"

uniform vec3 lightU, lightV;  // the light's half axes, metres
uniform float p_min_kernel, p_max_kernel;

// What of the map a receiver's light rays pass over, in texels of its tile. A ray to the point
// C + a lightU + b lightV, a and b in [-1, 1], meets a caster of s_b beside the receiver by
// (s_b - s) (a u + b v): 1/z_b - 1/z is the difference of s over near. Exact in tile 0, which is
// parallel to the light; in a side tile the perspective over the light's own depth is left out.
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

Footprint footprint(LightPoint point) {
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
    f.minReach = p_min_kernel * point.s;
    f.maxReach = max(p_max_kernel, p_min_kernel) * point.s;
    return f;
}

Receivers only(Footprint f) {
    Receivers r;
    r.tile = f.tile;
    r.centre = f.centre;
    r.halfBox = vec2(0.0);
    r.minS = r.maxS = r.planeS = f.s;
    r.planeError = 0.0;
    r.slope = f.plane;
    r.slopeError = vec2(0.0);
    r.scale = f.scale;
    r.extent = abs(f.u) + abs(f.v);
    r.minReach = f.minReach;
    return r;
}

#ifdef PASS_TILES
layout(location = 1) out vec4 box;  // of the map: nothing outside it blocks one of the receivers

const int kRounds = 3;
const int kFiner = 2;  // windows of the last round: what it costs is shared by the tile's pixels

// What of a tile's receivers is common to all.
void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * kTilePixels;
    ivec2 last = min(first + kTilePixels, textureSize(gbufferPosition, 0)) - 1;
    Receivers all;
    vec2 lo = vec2(1e30), hi = vec2(-1e30), reference;
    float mostReach = 0.0;
    bool any = false, litOnly = false, apart = false;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec4 p = texelFetch(gbufferPosition, ivec2(x, y), 0);
            if (p.w != 1.0 && p.w != 2.0) continue;
            LightPoint point = lightPoint(p.xyz, texelFetch(gbufferNormal, ivec2(x, y), 0).xyz);
            if (!point.inFront) {
                litOnly = true;
                continue;
            }
            Footprint f = footprint(point);
            if (!any) {
                all = only(f);
                reference = f.centre;
            }
            any = true;
            apart = apart || f.tile != all.tile;
            lo = min(lo, f.centre);
            hi = max(hi, f.centre);
            all.minS = min(all.minS, f.s);
            all.maxS = max(all.maxS, f.s);
            float planeS = all.planeS + dot(all.slope, f.centre - reference);
            all.planeError = max(all.planeError, abs(f.s - planeS));
            all.slopeError = max(all.slopeError, abs(f.plane - all.slope));
            all.extent = max(all.extent, abs(f.u) + abs(f.v));
            all.minReach = max(all.minReach, f.minReach);
            mostReach = max(mostReach, f.maxReach);
        }
    visibility = any ? 1.0 : 0.0;
    box = vec4(-1e30, -1e30, 1e30, 1e30);
    if (!any || apart) return;
    all.centre = 0.5 * (lo + hi);
    all.halfBox = 0.5 * (hi - lo);
    all.planeS += dot(all.slope, all.centre - reference);
    Blockers found;
    found.dark = false;
    float nearest = 1.0;
    for (int i = 0; i < kRounds && nearest > 0.0 && !found.dark; ++i) {
        float reach = min(nearest - all.minS + all.minReach, mostReach);
        found = nearestBlocker(all, reach, i + 1 < kRounds ? 0 : kFiner);
        nearest = min(nearest, found.nearest);
    }
    visibility = found.dark && !litOnly ? -1.0 : nearest;
    // The map's edge goes on beyond it.
    box.xy = mix(found.lo, box.xy, lessThanEqual(found.lo, vec2(0.0)));
    box.zw = mix(found.hi, box.zw, greaterThanEqual(found.hi, vec2(mapSize)));
}
#else
#ifdef ROTATION
uniform uint seed;

// Wellons' lowbias32.
uint hashed(uint x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}
#endif

// A pixel's own shift of the grid's taps within their cells, or turn of the disc.
vec2 pixelTurn() {
    vec2 random = vec2(0.0);
#ifdef ROTATION
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint h = hashed(pixel.x + hashed(pixel.y + hashed(seed)));
    random = vec2(h & 0xffffu, h >> 16) / 65536.0;
#endif
#ifdef PATTERN_GRID
    return random;
#else
    float angle = 6.28318531 * random.x;
    return vec2(cos(angle), sin(angle));
#endif
}

#ifdef PATTERN_GRID
// Tap (i, j) of k x k on [-1, 1]^2: cell centres, each row and column sheared by one cell over its
// length, so that edges along the light's axes meet k^2 distances and not k (the canonical
// arrangement of Chiu, Shirley, Wang 1994).
vec2 tapAt(int i, int j, int k, vec2 turn) {
#ifdef ROTATION
    vec2 inCell = fract((vec2(j, i) + 0.5) / float(k) + turn);
#else
    vec2 inCell = (vec2(j, i) + 0.5) / float(k);
#endif
    return (vec2(i, j) + inCell) * (2.0 / float(k)) - 1.0;
}
#else
vec2 tapAt(int i, int j, int k, vec2 turn) {
    vec2 tap = vogel(j * k + i, k * k);
    return mat2(turn.x, turn.y, -turn.y, turn.x) * tap;
}
#endif

// The footprint's taps at `reach`, and litAt with all but the fetch hoisted.
struct Taps {
    vec2 centre, u, v;
    float level, base;  // of the comparison: (s + plane . (texel centre - receiver)) scale
    vec2 slope;         //                    = base + slope . texel
    int tile;
};

Taps tapsOf(Footprint f, float reach) {
    Taps taps;
    taps.centre = f.centre;
    taps.u = reach * f.u;
    taps.v = reach * f.v;
    taps.slope = f.plane * f.scale;
    taps.level = f.s * f.scale;
    taps.base = taps.level + dot(taps.slope, 0.5 - f.centre);
    taps.tile = f.tile;
    return taps;
}

// First column and row of the k x k taps that may find a blocker, and one past the last.
ivec4 tapRange(Taps taps, int k) {
#if defined(EARLY_OUTS) && defined(PATTERN_GRID)
    // Taps a u + b v that meet the tile's box for some b in [-1, 1], or for some a.
    vec4 box = texelFetch(tileNotes, ivec2(gl_FragCoord.xy) / kTilePixels, 0) - taps.centre.xyxy;
    vec2 u = mix(taps.u, vec2(1e-6), lessThan(abs(taps.u), vec2(1e-6)));
    vec2 v = mix(taps.v, vec2(1e-6), lessThan(abs(taps.v), vec2(1e-6)));
    vec4 byU = (box + vec4(-abs(taps.v), abs(taps.v))) / u.xyxy;
    vec4 byV = (box + vec4(-abs(taps.u), abs(taps.u))) / v.xyxy;
    vec2 leastU = min(byU.xy, byU.zw), mostU = max(byU.xy, byU.zw);
    vec2 leastV = min(byV.xy, byV.zw), mostV = max(byV.xy, byV.zw);
    vec2 least = vec2(max(leastU.x, leastU.y), max(leastV.x, leastV.y));
    vec2 most = vec2(min(mostU.x, mostU.y), min(mostV.x, mostV.y));
    // A tap stays within its cell; a hundredth of it is for rounding.
    vec4 cells = clamp(0.5 * float(k) * (vec4(least, most) + 1.0) + vec4(-0.01, -0.01, 1.01, 1.01),
                       0.0, float(k));
    return ivec4(cells);
#else
    return ivec4(0, 0, k, k);
#endif
}

// s of the caster at `tap` where it blocks, else 0. Beyond the map its edge goes on.
float blockerAt(Taps taps, vec2 tap) {
    vec2 at = taps.centre + tap.x * taps.u + tap.y * taps.v;
    vec2 texel = floor(clamp(at, 0.0, float(mapSize) - 0.5));
    float caster = texelFetch(shadowMap, ivec3(texel, taps.tile), 0).r;
    return caster > max(taps.level, taps.base + dot(taps.slope, texel)) ? caster : 0.0;
}

// Mean of s - f.s over the casters inside the pyramid from the receiver to the light, cut `reach`
// above the receiver; 0 where there are none. The kernel's width is proportional to it: a mean of
// 1/z, which stands for the harmonic mean of linear depths. Every caster weighs as the share of the
// light that a texel at its depth covers.
float meanReach(Footprint f, LightPoint point, float reach, vec2 turn) {
    Taps taps = tapsOf(f, reach);
    float weights = 0.0, sum = 0.0;
    ivec4 range = tapRange(taps, SEARCH_SIDE);
    for (int j = range.y; j < range.w; ++j)
        for (int i = range.x; i < range.z; ++i) {
            vec2 tap = tapAt(i, j, SEARCH_SIDE, turn);
            float above = blockerAt(taps, tap) - f.s;
            bool inside = above + f.minReach >= reach * max(abs(tap.x), abs(tap.y));
            float inverse = above > 0.0 && inside ? 1.0 / above : 0.0;
            weights += inverse * inverse;
            sum += inverse;
        }
    // The receiver's own texel too, so that a sparse search never loses a contact.
    if (litAt(point, point.uv) == 0.0) {
        float above = texelFetch(shadowMap, ivec3(f.centre, f.tile), 0).r - f.s;
        weights += 1.0 / (above * above);
        sum += 1.0 / above;
    }
    return weights > 0.0 ? sum / weights : 0.0;
}

float litShare(Footprint f, float reach, vec2 turn) {
    Taps taps = tapsOf(f, reach);
    float blocked = 0.0;
    ivec4 range = tapRange(taps, FILTER_SIDE);
    for (int j = range.y; j < range.w; ++j)
        for (int i = range.x; i < range.z; ++i)
            blocked += blockerAt(taps, tapAt(i, j, FILTER_SIDE, turn)) > 0.0 ? 1.0 : 0.0;
    return 1.0 - blocked / float(FILTER_SIDE * FILTER_SIDE);
}

#if defined(EARLY_OUTS)
const int kRounds = 1;  // from what is known of the tile
#else
const int kRounds = 3;  // a fourth settles one pixel in fifty and costs all of them
#endif

float softVisibility(LightPoint point) {
    Footprint f = footprint(point);
    // As if a caster were at the near plane, then down to the nearest that is found to matter.
    float nearest = 1.0;
#ifdef EARLY_OUTS
    nearest = texelFetch(tiles, ivec2(gl_FragCoord.xy) / kTilePixels, 0).r;
#endif
    float reach = min(nearest - f.s + f.minReach, f.maxReach);
#ifdef NARROW
    bool dark = false;
    for (int i = 0; i < kRounds && nearest > f.s && !dark; ++i) {
        Blockers found = nearestBlocker(only(f), reach, 0);
        nearest = found.nearest;
        dark = found.dark;
        if (nearest > f.s) reach = min(reach, nearest - f.s + f.minReach);
    }
#ifdef EARLY_OUTS
    if (nearest <= f.s) return 1.0;
    if (dark) return 0.0;
#endif
#endif
    vec2 turn = pixelTurn();
    reach = meanReach(f, point, reach, turn);
    if (reach == 0.0) return 1.0;
    return litShare(f, clamp(reach, f.minReach, f.maxReach), turn);
}
#endif
#endif

#ifndef PASS_TILES
void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    if (!point.inFront) {
        visibility = 1.0;
        return;
    }
#ifdef SOFT
    visibility = softVisibility(point);
#else
    visibility = litAt(point, point.uv);
#endif
}
#endif
#endif
