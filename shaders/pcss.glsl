#include "common/receiver.glsl"
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
#ifdef SOFT
#include "common/min_max_pyramid.glsl"
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

// Greatest s of a caster that may hide part of the light within `reach` of s around the receiver;
// f.s where none may. `dark`: all texels within reach are blockers. Windows of the pyramid are
// passed over that hold nothing above the receiver's plane, by the comparison that a tap makes, or
// whose nearest caster is too far from the light to reach out to them.
float nearestBlocker(Footprint f, float reach, out bool dark) {
    vec2 extent = abs(f.u) + abs(f.v);
    vec2 lo = f.centre - reach * extent, hi = f.centre + reach * extent;
    Windows windows = windowsOver(lo, hi, mapSize);
    vec2 slope = f.plane * f.scale;
    float level = f.s * f.scale;
    float nearest = f.s;
    dark = true;
    for (int y = 0; y < windows.count.y; ++y)
        for (int x = 0; x < windows.count.x; ++x) {
            Window w = windowAt(windows, ivec2(x, y), f.tile);
            vec2 away = w.centre - f.centre;
            float rise = dot(slope, away);
            float highest = rise + w.toTexel * (abs(slope.x) + abs(slope.y));
            vec2 tilt = abs(w.gradient - slope);
            bool lit = w.maxS <= level || w.planeS + w.toTexel * (tilt.x + tilt.y) <= level + rise;
            bool within = all(lessThanEqual(abs(away) - w.toTexel - 0.5,
                                            extent * (w.maxS - f.s + f.minReach)));
            dark = dark && w.minS > level + max(highest, 0.0);
            if (!lit && within) nearest = max(nearest, w.maxS);
        }
    return nearest;
}

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
    for (int j = 0; j < SEARCH_SIDE; ++j)
        for (int i = 0; i < SEARCH_SIDE; ++i) {
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
    for (int j = 0; j < FILTER_SIDE; ++j)
        for (int i = 0; i < FILTER_SIDE; ++i)
            blocked += blockerAt(taps, tapAt(i, j, FILTER_SIDE, turn)) > 0.0 ? 1.0 : 0.0;
    return 1.0 - blocked / float(FILTER_SIDE * FILTER_SIDE);
}

float softVisibility(LightPoint point) {
    Footprint f = footprint(point);
    // As if a caster were at the near plane, then down to the nearest that is found to matter.
    float reach = min(1.0 - f.s + f.minReach, f.maxReach);
#ifdef NARROW
    const int kRounds = 3;  // a fourth settles one pixel in fifty and costs all of them
    bool lit = false, dark = false;
    for (int i = 0; i < kRounds && !lit && !dark; ++i) {
        float nearest = nearestBlocker(f, reach, dark);
        lit = nearest <= f.s;
        if (!lit) reach = min(reach, nearest - f.s + f.minReach);
    }
#ifdef EARLY_OUTS
    if (lit) return 1.0;
    if (dark) return 0.0;
#endif
#endif
    vec2 turn = pixelTurn();
    reach = meanReach(f, point, reach, turn);
    if (reach == 0.0) return 1.0;
    reach = clamp(reach, f.minReach, f.maxReach);
#ifdef EARLY_OUTS
    nearestBlocker(f, reach, dark);
    if (dark) return 0.0;
#endif
    return litShare(f, reach, turn);
}
#endif

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
