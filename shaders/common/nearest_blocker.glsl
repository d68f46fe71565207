// The nearest caster that may hide part of the light from one receiver or from any of several, by
// the min/max pyramid of the map. Include after common/light_view.glsl.
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
    vec2 extent;     // half of the widest footprint per unit of s, see pcss.glsl
    float minReach;  // in s: of the widest filter that is drawn around a receiver at least
};

struct Blockers {
    float nearest;  // s; 0: none
    bool dark;
    vec2 lo, hi;    // texels: none that blocks is outside of this box
};

// nearest: greatest s of a caster that may hide part of the light within `reach` of s around the receivers;
// 0 where none may. dark: all texels within reach of any of them block it. Windows of the pyramid
// are passed over that hold nothing above the receivers' planes, by the comparison that a tap makes,
// or whose nearest caster is too far from the light to reach out to them. `finer`: see windowsOver.
Blockers nearestBlocker(Receivers r, float reach, int finer) {
    vec2 around = reach * r.extent;
    Windows windows = windowsOver(r.centre - r.halfBox - around, r.centre + r.halfBox + around,
                                  mapSize, finer);
    float error = r.planeError + dot(r.slopeError, around + 0.5);
    vec2 slope = r.slope * r.scale;
    float least = r.minS * r.scale, most = r.maxS * r.scale;
    float planeLeast = (r.planeS - error) * r.scale, planeMost = (r.planeS + error) * r.scale;
    Blockers blockers = Blockers(0.0, true, vec2(1e30), vec2(-1e30));
    for (int y = 0; y < windows.count.y; ++y)
        for (int x = 0; x < windows.count.x; ++x) {
            Window w = windowAt(windows, ivec2(x, y), r.tile);
            vec2 away = w.centre - r.centre;
            float rise = dot(slope, away);
            float highest = rise + w.toTexel * (abs(slope.x) + abs(slope.y));
            vec2 tilt = abs(w.gradient - slope);
            bool lit =
                w.maxS <= least || w.planeS + w.toTexel * (tilt.x + tilt.y) <= planeLeast + rise;
            bool within = all(lessThanEqual(abs(away) - r.halfBox - w.toTexel - 0.5,
                                            r.extent * (w.maxS - r.minS + r.minReach)));
            blockers.dark = blockers.dark && w.minS > max(most, planeMost + highest);
            if (lit) continue;
            if (within) blockers.nearest = max(blockers.nearest, w.maxS);
            blockers.lo = min(blockers.lo, w.centre - w.toTexel - 0.5);
            blockers.hi = max(blockers.hi, w.centre + w.toTexel + 0.5);
        }
    return blockers;
}
#endif
