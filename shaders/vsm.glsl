#ifdef PASS_MOMENTS
// Stored near / z to the first two moments of linear depth.
#include "common/fullscreen.glsl"
#ifdef STAGE_FRAGMENT
layout(binding = 0) uniform sampler2DArray depthMap;
uniform int layer;
uniform float nearM;
uniform vec2 depthRangeM;  // what -1 and 1 stand for
uniform float depthStep;   // depths are rounded to multiples of it, 0: not

layout(location = 0) out vec2 moments;

// The depth that the first moment will hold. Squaring that one keeps the first moment's rounding
// out of the variance, which would double it.
float asStored(float depth) {
#ifdef FORMAT_HALF
    return unpackHalf2x16(packHalf2x16(vec2(depth, 0.0))).x;
#else
    return depthStep > 0.0 ? round((depth + 1.0) / depthStep) * depthStep - 1.0 : depth;
#endif
}

void main() {
    float s = texelFetch(depthMap, ivec3(gl_FragCoord.xy, layer), 0).r;
    // No caster: at the far end, behind every receiver.
    float zM = s > 0.0 ? nearM / s : depthRangeM.y;
    float depth = (zM - depthRangeM.x) / (depthRangeM.y - depthRangeM.x) * 2.0 - 1.0;
    depth = asStored(clamp(depth, -1.0, 1.0));
    moments = vec2(depth, depth * depth);
#ifdef FORMAT_UNORM
    moments.x = 0.5 * moments.x + 0.5;
#endif
}
#endif

#else

#ifdef UNDECIDED_TILES
#include "common/pixel_classes.glsl"
#else
#include "common/receiver.glsl"
#endif
#include "common/light_view.glsl"
#ifdef STAGE_FRAGMENT
#ifdef KERNEL_POINT
void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    visibility = point.inFront ? litAt(point, point.uv) : 1.0;
}
#else

#include "common/chebyshev.glsl"
#ifdef PREFILTER_TABLE
#define TABLE_CELLS SUBDIVISIONS
#include "common/summed_area_table.glsl"
#else
layout(binding = 1) uniform sampler2DArray momentsMap;
uniform vec2 blurTexels;  // width of the blur before the mip levels
#endif

uniform vec2 lightHalfM;
uniform vec2 tileDepth[kMaxTiles];         // metres at depth -1, and depths per metre
uniform float tileCasterNearM[kMaxTiles];
uniform float minVariance;       // of depths in [-1, 1]
uniform float minTexelVariance;  // and in addition of a box of one texel, falling with its area
uniform float p_kernel_size;
uniform float p_search;
uniform int p_searches;
uniform float p_bleed;

float toDepth(float zM, int tile) {
    return (zM - tileDepth[tile].x) * tileDepth[tile].y - 1.0;
}

// Half of the receiver's plane's range of depths over a cell along each side, at its own depth.
vec2 depthReach(LightPoint point, vec2 cellTexels) {
    float perUv = tileDepth[point.tile].y * point.zM * point.zM / tileNear[point.tile];
    return 0.5 * perUv / float(mapSize) * abs(point.gradient) * cellTexels;
}

// The receiver's plane at the texels that were averaged.
struct PlaneDepth {
    float compared;    // no farther than the receiver itself, less the bias
    float unoccluded;  // what the map holds there where nothing is in front
};

// Linear depth is convex over a plane, so the mean depth of an unoccluded plane is never less than
// its depth at the texels' centroid: whatever its slope, Chebyshev finds it lit, and the texel's
// own slope (a quarter of the squared derivatives, added to the second moment at write) need not
// widen every variance. As in litAt, depths beyond the receiver's own do not count where the plane
// recedes from the light.
PlaneDepth planeDepth(LightPoint point, vec2 middle, float reach, float bias) {
    vec2 slope = point.gradient / float(mapSize);
    float there = point.s + dot(slope, middle - point.uv * float(mapSize));
    float near = tileNear[point.tile];
    float depthThere = toDepth(near / there, point.tile);
    float t = there > point.s ? depthThere : toDepth(near / point.s, point.tile);
    PlaneDepth plane;
    plane.unoccluded = there > 0.0 ? min(depthThere, 1.0) : 1.0;
    // The map ends at the farthest receiver's depth. By how much that lowers the mean of a plane
    // that goes on: of depths spread evenly over t - r .. t + r the part beyond 1 comes to
    // (t + r - 1)^2 / 4 r, and of any other symmetric unimodal spread to less.
    float beyond = max(t + reach - 1.0, 0.0);
    const float kLeastReach = 1e-12;  // for the division; of no effect on what is left of `beyond`
    plane.compared = t - bias - 0.25 * beyond * min(beyond * (1.0 / max(reach, kLeastReach)), 1.0);
    return plane;
}

#ifndef PREFILTER_TABLE
// Moments over a box. Between two texels of side a bilinear interpolation averages with variance
// a^2 / 4 (a^2 / 12 of the texel and, over all positions, a^2 / 6 between them), a box of width w
// with w^2 / 12: equal for a = w / sqrt 3. The blur's share is there already. The level is that of
// the narrower side; lookups along the longer one cover it, as anisotropic filters do it, which a
// software renderer takes hundreds of times as long for. llvmpipe picks one level for every 2 x 2
// pixels.
vec2 mipMean(vec2 middle, vec2 size, int tile) {
    vec2 side = sqrt(max(size * size - blurTexels * blurTexels, 0.0) / 3.0);
    float narrow = max(min(side.x, side.y), 1.0), wide = max(side.x, side.y);
    const float kMostLookups = 16.0;
    float lookups = clamp(ceil(wide / narrow - 0.01), 1.0, kMostLookups);
    narrow = max(narrow, wide / lookups);
    vec2 along = (side.x > side.y ? vec2(size.x, 0.0) : vec2(0.0, size.y)) / lookups;
    vec2 sum = vec2(0.0);
    for (float k = 0.5; k < lookups; ++k) {
        vec2 at = middle + (k - 0.5 * lookups) * along;
        sum += textureLod(momentsMap, vec3(at / float(mapSize), tile), log2(narrow)).rg;
    }
    return sum / lookups;
}
#endif

// What a kernel sees: shares of its area, and the blockers' mean depth times theirs.
struct Kernel {
    float lit;
    float blocked;
    float blockerDepth;
};

// Adds a cell of the kernel: its moments, the receiver's plane there, the variance of that plane's
// depths over the cell, and the cell's weight in the sum.
void addCell(inout Kernel sum, vec2 moments, PlaneDepth plane, float planeVariance,
             float leastVariance, float weight) {
#ifdef FORMAT_UNORM
    moments.x = moments.x * 2.0 - 1.0;
#endif
    float p = chebyshev(moments, plane.compared, leastVariance);
    // Against light bleeding (Lauritzen 2007): what a bound below p_bleed says is nothing.
    sum.lit += weight * max((p - p_bleed) * (1.0 / (1.0 - p_bleed)), 0.0);
    // A factor and no way out of here: software renderers go all ways, and pay for each.
    float blocking = p < 1.0 ? weight : 0.0;
    // Mean = p unoccluded + (1 - p) blockers (Yang 2010, eq. 5), p for the very depth and variance
    // that the unoccluded part has: any other would put blockers anywhere where they are few. (The
    // bound above must not use these.)
    p = chebyshev(vec2(moments.x, moments.y - planeVariance), plane.unoccluded, leastVariance);
    sum.blocked += blocking * (1.0 - p);
    sum.blockerDepth += blocking * (moments.x - p * plane.unoccluded);
}

// The kernel's part inside the map in cells, each with its own Chebyshev bound against the plane's
// depth there; their mean is a bound on the whole. Outside the map all is lit.
Kernel look(LightPoint point, vec2 halfTexels) {
    vec2 centre = point.uv * float(mapSize);
    vec2 lo = clamp(centre - halfTexels, vec2(0.0), vec2(mapSize));
    vec2 hi = clamp(centre + halfTexels, vec2(0.0), vec2(mapSize));
    vec2 extent = hi - lo, cell = extent / float(SUBDIVISIONS);
    float inside = min(extent.x * extent.y / (4.0 * halfTexels.x * halfTexels.y), 1.0);
    if (inside <= 0.0) return Kernel(1.0, 0.0, 0.0);
    float leastVariance = minVariance + minTexelVariance / max(cell.x * cell.y, 1.0);
    vec2 sides = depthReach(point, cell);
    float planeVariance = dot(sides, sides) / 3.0;
    // Cells are equal but for a texel each way.
    vec2 widest = depthReach(point, cell + 2.0);
    float reach = widest.x + widest.y;
    float bias = tileDepth[point.tile].y * point.zM * (1.0 - 1.0 / point.biasScale);
    Kernel sum = Kernel(0.0, 0.0, 0.0);
    float weights = 0.0;
#ifdef PREFILTER_TABLE
    BoxCells box = tableBox(lo, hi, point.tile);
    for (int j = 0; j < kCells; ++j)
        for (int i = 0; i < kCells; ++i) {
            float weight = box.x.size[i] * box.y.size[j];
            vec2 middle = vec2(box.x.middle[i], box.y.middle[j]);
            addCell(sum, box.mean[j * kCells + i], planeDepth(point, middle, reach, bias),
                    planeVariance, leastVariance, weight);
            weights += weight;
        }
#else
    for (int j = 0; j < SUBDIVISIONS; ++j)
        for (int i = 0; i < SUBDIVISIONS; ++i) {
            vec2 middle = lo + (vec2(i, j) + 0.5) * cell;
            addCell(sum, mipMean(middle, cell, point.tile), planeDepth(point, middle, reach, bias),
                    planeVariance, leastVariance, 1.0);
            weights += 1.0;
        }
#endif
    float share = inside / weights;
    const float kNothing = 1e-4;  // a share that no display shows: lit to the last digit
    if (share * sum.blocked < kNothing) return Kernel(1.0, 0.0, 0.0);
    return Kernel(clamp(share * sum.lit + 1.0 - inside, 0.0, 1.0), share * sum.blocked,
                  share * sum.blockerDepth);
}

// Half extents at the receiver, along the light's u and v, to texels of its tile. Side tiles see
// the light edge-on, where the two have no axis of their own: the wider one serves for both.
vec2 toTexels(LightPoint point, float lightSizes) {
    vec2 extent = point.tile == 0 ? lightHalfM : vec2(max(lightHalfM.x, lightHalfM.y));
    return lightSizes * extent / point.zM * tileTangents[point.tile].zw * float(mapSize);
}

// No kernel is narrower than a texel: cells within one have no variance and compare its depth.
Kernel lookNoNarrower(LightPoint point, vec2 halfTexels) {
    return look(point, max(halfTexels, vec2(0.5)));
}

// What the light shows as a point, where the widest kernel it can have is at most a texel, and
// `soft`, from two texels on.
float softened(LightPoint point, vec2 widestHalfTexels, float soft) {
    float width = 2.0 * max(widestHalfTexels.x, widestHalfTexels.y);
    return width >= 2.0 ? soft : mix(litAt(point, point.uv), soft, max(width - 1.0, 0.0));
}

#ifdef KERNEL_FIXED
float softVisibility(LightPoint point) {
    vec2 halfTexels = toTexels(point, p_kernel_size);
    return softened(point, halfTexels, lookNoNarrower(point, halfTexels).lit);
}
#else
float softVisibility(LightPoint point) {
    // The pyramid from the receiver to the light, cut where the nearest caster may be.
    float search = clamp(point.zM / tileCasterNearM[point.tile] - 1.0, 0.0, p_search);
    vec2 searchTexels = toTexels(point, search), halfTexels = searchTexels;
    float lit = 1.0;
    // Searches, each as wide as the penumbra that the one before it found, so that casters which
    // cannot matter fall out of the mean; then the filter. As a loop the compiler has one lookup to
    // deal with.
    for (int step = 0; step <= p_searches; ++step) {
        Kernel seen = lookNoNarrower(point, halfTexels);
        lit = seen.lit;
        if (seen.blocked == 0.0) break;
        float depth = clamp(seen.blockerDepth / seen.blocked, -1.0, toDepth(point.zM, point.tile));
        float blockerM = tileDepth[point.tile].x + (depth + 1.0) / tileDepth[point.tile].y;
        // Fernando 2005: the penumbra of a blocker parallel to the light, at most what was seen.
        halfTexels = toTexels(point, clamp(point.zM / blockerM - 1.0, 0.0, search));
    }
    return softened(point, searchTexels, lit);
}
#endif

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    visibility = point.inFront ? softVisibility(point) : 1.0;
}
#endif
#endif
#endif
