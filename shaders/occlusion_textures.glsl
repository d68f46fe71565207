#include "common/receiver.glsl"
#include "common/light_view.glsl"
#ifdef PASS_HARD
#ifdef STAGE_FRAGMENT
void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    visibility = point.inFront ? litAt(point, point.uv) : 1.0;
}
#endif

#else

#ifdef STAGE_FRAGMENT
// Slices as core/frame/slice_view.hpp cuts them.
uniform mat3 lightAxes;  // world to light: rows x, y, z
uniform vec2 lightHalfM;
uniform bool orthographic;
uniform float copM;
uniform vec2 uvScale, uvOffset;
uniform vec3 slices[SLICES];  // depth of the plane, of the lower boundary, 1 / metres of the fade
uniform float p_bias;

const int kCells = CELLS;
const int kAll = CELLS * CELLS;

float shrink(float zM) {
    return orthographic ? 1.0 : 1.0 / (zM + copM);
}

// The light as a receiver sees it on a slice's plane (eq. 4), texels.
struct Kernel {
    vec2 lo, size;
};

Kernel kernelOn(vec3 p, float planeM) {
    float t = planeM / p.z;
    vec2 scale = uvScale * shrink(planeM) * mapSize;
    vec2 size = 2.0 * lightHalfM * (1.0 - t) * scale;
    return Kernel(p.xy * t * scale + uvOffset * mapSize - 0.5 * size, size);
}

// What one cell of the light has behind all slices so far.
struct Covered {
    float all;
    float other;   // mean: the sum beside the maximum; continued: of the open run of slices
    float before;  // continued, filled: of the same run up to the slice before
};

void cover(inout Covered cell, float occlusion) {
#if defined(COMBINE_MAX)
    cell.all = max(cell.all, occlusion);
#elif defined(COMBINE_SUM)
    cell.all = min(cell.all + occlusion, 1.0);
#elif defined(COMBINE_PRODUCT)
    cell.all += occlusion * (1.0 - cell.all);  // eq. 5
#elif defined(COMBINE_MEAN)
    cell.all = max(cell.all, occlusion);
    cell.other = min(cell.other + occlusion, 1.0);
#else
    // Slices next to each other show pieces of one surface, which cover different parts of the
    // light; past an empty slice something else begins, which knows nothing of them. Where slices
    // are filled with the one above, every other slice shows all pieces, and none of them twice.
    cell.all += occlusion > 0.0 ? 0.0 : max(cell.other, cell.before) * (1.0 - cell.all);
#ifdef FILLED
    float run = min(cell.before + occlusion, 1.0);
    cell.before = occlusion > 0.0 ? cell.other : 0.0;
#else
    float run = min(cell.other + occlusion, 1.0);
#endif
    cell.other = occlusion > 0.0 ? run : 0.0;
#endif
}

float total(Covered cell) {
#if defined(COMBINE_MEAN)
    return 0.5 * (cell.all + cell.other);
#elif defined(COMBINE_CONTINUED)
    return cell.all + max(cell.other, cell.before) * (1.0 - cell.all);
#else
    return cell.all;
#endif
}

Covered covered[kAll];

#ifdef PREFILTER_SAT
layout(binding = 1) uniform usampler2DArray counts;  // SummedAreaTable::Kind::counts

const int kSteps = CELLS + 1;       // lines between and around rows of cells
const int kColumns = 2 * CELLS + 2;  // texels' borders on both sides of each line

uint count(int x, int y, int slice) {
    return texelFetch(counts, ivec3(x, y, slice >> 2), 0)[slice & 3];
}

// Where a kernel lies in the table; no kernel is narrower than a texel.
Kernel within(Kernel kernel) {
    vec2 size = max(kernel.size, vec2(1.0));
    vec2 lo = clamp(kernel.lo + 0.5 * (kernel.size - size), vec2(0.0), vec2(mapSize) - 1.0);
    return Kernel(lo, clamp(lo + size, lo + 1.0, vec2(mapSize)) - lo);
}

// Four fetches tell the texels under the kernel all empty (0) or all full (1); else 1/2.
float roughly(Kernel kernel, int slice) {
    kernel = within(kernel);
    ivec2 from = ivec2(kernel.lo), to = min(ivec2(ceil(kernel.lo + kernel.size)), ivec2(mapSize));
    uint inside = count(to.x, to.y, slice) - count(from.x, to.y, slice) -
                  count(to.x, from.y, slice) + count(from.x, from.y, slice);
    ivec2 extent = to - from;
    return inside == 0u ? 0.0 : inside == uint(extent.x * extent.y) ? 1.0 : 0.5;
}

uint top[kColumns];        // counts at the kernel's first row
float above[CELLS + 1];  // sums over the kernel down to the line before

// Adds line `step` of the lines around the cells' rows: the row of cells above it is then known.
// Sums are counted from the kernel's first texel on, exactly and modulo 2^32, so that they are
// small enough for floats however large the table's entries are.
void addStep(Kernel kernel, int slice, float weight, int step) {
    kernel = within(kernel);
    vec2 cell = kernel.size / float(kCells), hi = kernel.lo + kernel.size;
    float y = step == kCells ? hi.y : kernel.lo.y + float(step) * cell.y;
    int left = int(kernel.lo.x), row = int(y), next = min(row + 1, int(mapSize));
    uint before = count(left, row, slice), nextBefore = count(left, next, slice);
    float scale = weight / (cell.x * cell.y), last = 0.0;
    for (int i = 0; i <= kCells; ++i) {
        float x = i == kCells ? hi.x : kernel.lo.x + float(i) * cell.x;
        vec2 upper, lower;
        for (int s = 0; s < 2; ++s) {
            int column = min(int(x) + s, int(mapSize));
            uint up = count(column, row, slice) - before,
                 down = count(column, next, slice) - nextBefore;
            top[2 * i + s] = step == 0 ? up : top[2 * i + s];
            upper[s] = float(up - top[2 * i + s]);
            lower[s] = float(down - top[2 * i + s]);
        }
        vec2 both = mix(upper, lower, fract(y));
        float line = mix(both.x, both.y, fract(x)), band = line - above[i];
        above[i] = line;
        if (i > 0)
            for (int r = 0; r < kCells; ++r)
                if (r == step - 1)
                    cover(covered[r * kCells + i - 1], clamp(scale * (band - last), 0.0, weight));
        last = band;
    }
}
#else

const int kSteps = kAll;

#ifdef PREFILTER_N_BUFFERS
layout(binding = 1) uniform sampler2DArray buffers;  // NBuffers
uniform int levels;

// Level l's texels hold the boxes that begin there. Boxes larger than the kernel may begin outside
// the texture, which has no texel for that: they are moved in.
float levelMean(vec2 middle, int level, int slice) {
    vec2 at = max(middle - 0.5 * float(1 << level) + 0.5, vec2(0.5));
    return texture(buffers, vec3(at / mapSize, (slice >> 2) * levels + level))[slice & 3];
}

float squareMean(vec2 middle, float side, int slice) {
    float l = clamp(log2(max(side, 1.0)), 0.0, float(levels - 1));
    int level = min(int(l), max(levels - 2, 0));
    float low = levelMean(middle, level, slice);
    return levels == 1 ? low : mix(low, levelMean(middle, level + 1, slice), l - float(level));
}
#else
layout(binding = 1) uniform sampler2DArray occlusion;  // with mip levels

// Bilinear interpolation between texels of side a has the variance a^2 / 4, a box of side w has
// w^2 / 12.
float squareMean(vec2 middle, float side, int slice) {
    float level = log2(max(side * inversesqrt(3.0), 1.0));
    return textureLod(occlusion, vec3(middle / mapSize, slice >> 2), level)[slice & 3];
}
#endif

// Squares along the longer side, as anisotropic filters do it.
float boxMean(vec2 lo, vec2 size, int slice) {
    float narrow = max(min(size.x, size.y), 1.0), wide = max(size.x, size.y);
    const float kMostLookups = 16.0;
    float lookups = clamp(ceil(wide / narrow - 0.01), 1.0, kMostLookups);
    vec2 along = (size.x > size.y ? vec2(size.x, 0.0) : vec2(0.0, size.y)) / lookups;
    float sum = 0.0;
    for (float k = 0.5; k < lookups; ++k)
        sum += squareMean(lo + 0.5 * size + (k - 0.5 * lookups) * along,
                          max(narrow, wide / lookups), slice);
    return sum / lookups;
}

float roughly(Kernel kernel, int slice) {
    return boxMean(kernel.lo, kernel.size, slice);
}

// Adds one cell.
void addStep(Kernel kernel, int slice, float weight, int step) {
    vec2 cell = kernel.size / float(kCells);
    float mean =
        boxMean(kernel.lo + vec2(step % kCells, step / kCells) * cell, cell, slice);
    for (int i = 0; i < kAll; ++i)
        if (i == step) cover(covered[i], weight * mean);
}
#endif

// The slice that holds the receiver does not count, the one above it fades in.
float weightOf(vec3 p, int slice) {
    return min((p.z - slices[slice].y) * slices[slice].z, 1.0);
}

// First what each slice is roughly: most are empty, and one that is full decides. Then those that
// are neither, bit by bit and step by step: a renderer that runs both sides of every branch for
// neighbouring pixels, as llvmpipe does, leaves loops as soon as none of them has work left.
float lit(vec3 p) {
    uint partial[(SLICES + 31) / 32];
    for (int w = 0; w < partial.length(); ++w) {
        partial[w] = 0u;
        for (int b = 0; b < min(32, SLICES - 32 * w); ++b) {
            int k = 32 * w + b;
            float weight = weightOf(p, k);
            if (weight <= 0.0) break;
            float rough = roughly(kernelOn(p, slices[k].x), k);
            if (rough == 1.0 && weight == 1.0) return 0.0;
            if (rough > 0.0) partial[w] |= 1u << b;
        }
    }
    for (int i = 0; i < kAll; ++i) covered[i] = Covered(0.0, 0.0, 0.0);
    int previous = -1;
    for (int w = 0; w < partial.length(); ++w) {
        uint left = partial[w];
        int step = 0;
        while (left != 0u) {
            int k = 32 * w + findLSB(left);
            // Past empty slices a run of them is over.
            if (step == 0 && k > previous + 1)
                for (int i = 0; i < kAll; ++i) cover(covered[i], 0.0);
            addStep(kernelOn(p, slices[k].x), k, weightOf(p, k), step);
            previous = k;
            if (++step == kSteps) {
                step = 0;
                left &= left - 1u;
            }
        }
    }
    float sum = 0.0;
    for (int i = 0; i < kAll; ++i) sum += total(covered[i]);
    return clamp(1.0 - sum / float(kAll), 0.0, 1.0);
}

#ifdef CONTACT
// What hides the light's centre from within the slices that do not count, or not yet in full.
float contact(vec3 p, LightPoint point) {
    if (litAt(point, point.uv) == 1.0) return 0.0;
    ivec2 texel = ivec2(floor(point.uv * float(mapSize)));
    float caster = texelFetch(shadowMap, ivec3(texel, point.tile), 0).r;
    float casterM = p.z * point.s / caster;  // both along one ray
    for (int k = 0; k < SLICES; ++k)
        if (casterM < slices[k].y) return 1.0 - clamp(weightOf(p, k), 0.0, 1.0);
    return 1.0;
}
#endif

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    vec3 p = lightAxes * (position - lightCentre), n = lightAxes * normal;
    if (p.z <= 0.0) {
        visibility = 1.0;
        return;
    }
    // Slopes are moved off their own rasterised outline, by the more the steeper they are; surfaces
    // parallel to the light lie within one slice and stay where they are.
    vec2 texelM = 1.0 / (uvScale * shrink(p.z) * mapSize);
#ifdef CONTACT
    float near = contact(p, lightPoint(position, normal));
#else
    const float near = 0.0;
#endif
    p += n * (p_bias * max(texelM.x, texelM.y) * sqrt(max(1.0 - n.z * n.z, 0.0)));
    // A caster that has faded in by half hides one half there and the other here.
    visibility = max(lit(p) - near, 0.0);
}
#endif
#endif
