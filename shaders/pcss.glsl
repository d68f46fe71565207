#ifdef EARLY_OUTS
#define UNDECIDED_TILES
#include "common/pixel_classes.glsl"
#else
#include "common/receiver.glsl"
#endif
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
#ifdef SOFT
#include "common/nearest_blocker.glsl"
#include "common/sample_patterns.glsl"

uniform float p_min_kernel, p_max_kernel;

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
    vec4 box = tileOfPixel() - taps.centre.xyxy;
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

float softVisibility(LightPoint point) {
    Footprint f = footprint(point, p_min_kernel, p_max_kernel);
    // As if a caster were at the near plane, then down to the nearest that is found to matter.
    float reach = min(1.0 - f.s + f.minReach, f.maxReach);
#ifdef NARROW
    const int kRounds = 3;  // a fourth settles one pixel in fifty and costs all of them
    Receivers receiver = only(f);
    bool lit = false, dark = false;
    for (int i = 0; i < kRounds && !lit && !dark; ++i) {
        Blockers found = nearestBlocker(receiver, reach, 0);
        lit = found.nearest <= f.s;
        dark = found.dark;
        if (!lit) reach = min(reach, found.nearest - f.s + f.minReach);
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
    if (nearestBlocker(receiver, reach, 0).dark) return 0.0;
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
