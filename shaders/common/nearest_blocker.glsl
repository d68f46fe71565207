// The nearest caster that may hide part of the light from one receiver or from any of several, by
// the min/max pyramid of the map. Include after common/light_view.glsl.
#include "common/footprint.glsl"
#include "common/min_max_pyramid.glsl"
#ifdef STAGE_FRAGMENT

// Receivers of one light tile. All of them are in a box of the map, and the tangent plane of each
// is near one that they share: s at texel t is planeS + slope . (t - centre), give or take
// `planeError` and, for one that is away from its own receiver by d, dot(slopeError, abs(d)).
// Lengths are in texels.
struct Receivers {
    int tile;
    vec2 centre, halfBox;
    float minS, maxS;
    float planeS, planeError;
    vec2 slope, slopeError;
    float scale;     // LightPoint.biasScale
    vec2 extent;     // half of the widest footprint per unit of s
    float minReach;  // in s: of the widest filter that is drawn around a receiver at least
    float pad;       // taps compare texels up to this and a half away, all with one reference
};

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
    r.pad = 0.0;
    return r;
}

struct Blockers {
    float nearest;  // greatest s of a caster that may hide part of the light; 0: none may
    bool dark;      // all texels within reach of any of the receivers block it
    vec2 lo, hi;    // texels: none within reach that blocks is outside of this box
    float least;    // s of the farthest texel, whether it blocks or not
};

// Casters within `reach` of s around the receivers. Windows of the pyramid, 2^finer times as many
// along each side as there need be, are passed over that hold nothing above the receivers' planes,
// by the comparison that a tap makes, or whose nearest caster is too far from the light to reach
// out to them. With BOX nothing counts that is not above the very planes, as a filter of depths
// wants it, where a comparison also passes what is behind the receiver itself.
Blockers nearestBlocker(Receivers r, float reach, int finer) {
    vec2 around = reach * r.extent + r.pad;
    Windows windows = windowsOver(r.centre - r.halfBox - around, r.centre + r.halfBox + around,
                                  mapSize, finer);
    float error = r.planeError + dot(r.slopeError, around + 0.5);
    vec2 slope = r.slope * r.scale;
    float least = r.minS * r.scale, most = r.maxS * r.scale;
    float planeLeast = (r.planeS - error) * r.scale, planeMost = (r.planeS + error) * r.scale;
    Blockers blockers = Blockers(0.0, true, vec2(1e30), vec2(-1e30), 1e30);
    // One loop, for two cost software renderers more; its way out is at the end, and no branch in it.
    ivec2 at = ivec2(0);
    while (true) {
        Window w = windowAt(windows, at, r.tile);
        vec2 away = w.centre - r.centre;
        float rise = dot(slope, away);
        float across = abs(slope.x) + abs(slope.y);  // of the slope over a texel
        float highest = rise + (w.toTexel + 2.0 * r.pad) * across;
        vec2 tilt = abs(w.gradient - slope);
        bool lit = w.planeS + w.toTexel * (tilt.x + tilt.y) <= planeLeast + rise;
#ifdef BOX
        lit = lit || w.maxS <= max(planeLeast + rise - w.toTexel * across, 0.0);
        bool within = true;
#else
        lit = lit || w.maxS <= least;
        bool within = all(lessThanEqual(abs(away) - r.halfBox - w.toTexel - 0.5,
                                        r.extent * (w.maxS - r.minS + r.minReach) + r.pad));
#endif
        vec2 texels = vec2(w.toTexel + 0.5);
        blockers.dark = blockers.dark && w.minS > max(most, planeMost + highest);
        blockers.least = min(blockers.least, w.minS);
        blockers.nearest = !lit && within ? max(blockers.nearest, w.maxS) : blockers.nearest;
        blockers.lo = lit ? blockers.lo : min(blockers.lo, w.centre - texels);
        blockers.hi = lit ? blockers.hi : max(blockers.hi, w.centre + texels);
        at = at.x + 1 < windows.count.x ? ivec2(at.x + 1, at.y) : ivec2(0, at.y + 1);
        if (at.y >= windows.count.y) break;
    }
    return blockers;
}
#endif
