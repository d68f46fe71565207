// Occlusion textures (Eisemann, Decoret 2006). Passes: PASS_HARD compares with the hard map alone,
// PASS_CLASSIFY tells which tiles of pixels need no shading, the other one shades, with UNDECIDED_TILES
// the rest of them only.
#include "common/light_view.glsl"
#ifdef PASS_CLASSIFY
#include "common/fullscreen.glsl"
#include "common/tile_class.glsl"
#include "common/slice_kernels.glsl"
#ifdef CONTACT
#include "common/slice_contact.glsl"
#endif
#ifdef STAGE_FRAGMENT
// A box around the kernels of all of a tile's receivers on a slice.
struct Tile {
    vec2 lo, hi;       // tangents of the receivers
    float minM, maxM;  // depths
};

Kernel kernelsOn(Tile tile, float planeM) {
    Kernel lo = kernelOn(vec3(tile.lo, 1.0) * tile.maxM, planeM);
    Kernel hi = kernelOn(vec3(tile.hi, 1.0) * tile.maxM, planeM);
    const float kRoundingTexels = 1.0 / 64.0;  // a receiver's own is rounded otherwise
    vec2 least = max(lo.size, vec2(1.0)) + 2.0 * kRoundingTexels;
    vec2 from = lo.lo + 0.5 * (lo.size - least);
    return Kernel(from, hi.lo - lo.lo + least);
}

vec3 toLight(vec4 position) {
    return lightAxes * (position.xyz - lightCentre);
}

vec4 positionOf(ivec2 pixel, out vec3 normal, out bool asks) {
    vec4 position = texelFetch(gbufferPosition, pixel, 0);
    normal = texelFetch(gbufferNormal, pixel, 0).xyz;
    asks = position.w == 1.0 || position.w == 2.0;
    return position;
}

#ifdef CONTACT
bool anyTouched(ivec2 first, ivec2 last) {
    ivec2 size = last - first + 1;
    bool any = false;
    for (int i = 0; i < size.x * size.y && !any; ++i) {
        vec3 normal;
        bool asks;
        vec4 position = positionOf(first + ivec2(i % size.x, i / size.x), normal, asks);
        vec3 p = toLight(position);
        receiver = lightPoint(position.xyz, normal);
        float casterM;
        any = asks && touched(p, aboveM(movedOff(p, lightAxes * normal)), casterM);
    }
    return any;
}
#endif

void main() {
    ivec2 first = firstOfTile(), last = lastOfTile();
    Tile tile = Tile(vec2(1e30), vec2(-1e30), 1e30, -1e30);
    bool any = false, usable = true;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec3 normal;
            bool asks;
            vec3 p = toLight(positionOf(ivec2(x, y), normal, asks));
            vec3 moved = movedOff(p, lightAxes * normal);
            vec2 t = moved.xy / moved.z;
            any = any || asks;
            usable = usable && (!asks || min(p.z, moved.z) > 0.0);
            tile.lo = asks ? min(tile.lo, t) : tile.lo;
            tile.hi = asks ? max(tile.hi, t) : tile.hi;
            tile.minM = asks ? min(tile.minM, moved.z) : tile.minM;
            tile.maxM = asks ? max(tile.maxM, moved.z) : tile.maxM;
        }
    tileClass = kLit;
    if (!any) return;
    uvec2 mayHide = uvec2(0u);
    bool dark = false;
    for (int i = 0; i < used; ++i) {
        if (usable && weightOf(tile.maxM, i) <= 0.0) break;
        Kernel kernels = kernelsOn(tile, slices[i].x);
        // Counts of two slices that share a number are right up to there.
        const float kMostTexels = 65535.0;
        vec2 texels = kernels.size + 2.0;
        bool counted = usable && (lanes == 1 || texels.x * texels.y <= kMostTexels);
        float rough = counted ? roughly(kernels, i) : 0.5;
        dark = dark || (rough == 1.0 && weightOf(tile.minM, i) == 1.0);
        mayHide[i >> 5] |= uint(rough > 0.0) << (i & 31);
    }
    if (dark) {
        tileClass = kDark;
        return;
    }
    bool undecided = !usable || mayHide != uvec2(0u);
#ifdef CONTACT
    undecided = undecided || anyTouched(first, last);
#endif
    if (undecided)
        tileClass = vec4(-1.0 - float(mayHide.y & 0xffffu), mayHide.x & 0xffffu, mayHide.y >> 16,
                         mayHide.x >> 16);
}
#endif
#else

#include "common/pixel_classes.glsl"
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

#include "common/slice_kernels.glsl"
#ifdef CONTACT
#include "common/slice_contact.glsl"
#endif
#ifdef STAGE_FRAGMENT
const int kAll = CELLS * CELLS;

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
const int kLines = CELLS + 1;  // between and around rows of cells

// Sums at the crossings of the lines around cells, each between four texels. They are counted from
// the kernel's first texel on, exactly and modulo 2^32, so that they are small enough for floats
// however large the table's entries are.
void coverBy(Kernel kernel, int slice, float weight) {
    kernel = within(kernel);
    vec2 cell = kernel.size / float(CELLS), hi = kernel.lo + kernel.size;
    int plane = lanes == 1 ? slice : slice >> 1;
    uint shift = uint(lanes - 1) * uint(slice & 1) * 16u, mask = lanes == 1 ? ~0u : 0xffffu;
    float scale = weight / (cell.x * cell.y);
    uvec4 top[kLines];    // crossings of the first line of each direction
    float before[kLines]; // counts up to the line before
    for (int j = 0; j < kLines; ++j) {
        float y = j == CELLS ? hi.y : kernel.lo.y + float(j) * cell.y;
        uvec4 left;
        float last = 0.0;
        for (int i = 0; i < kLines; ++i) {
            float x = i == CELLS ? hi.x : kernel.lo.x + float(i) * cell.x;
            vec2 corner = floor(vec2(x, y)), part = vec2(x, y) - corner;
            // (0, 1), (1, 1), (1, 0) and (0, 0)
            vec2 place = (corner - vec2(table.xy) + 1.0) / vec2(table.zw);
            uvec4 at = textureGather(counts, vec3(place, plane));  // clamped to the border
            if (j == 0) top[i] = at;
            if (i == 0) left = at;
            uvec4 count = at - left.xxww - top[i].wzzw + uvec4(top[0].w);
            vec4 sums = vec4((count >> shift) & mask);
            vec2 both = mix(sums.wz, sums.xy, part.y);
            float sum = mix(both.x, both.y, part.x);
            if (i > 0 && j > 0)
                cover(covered[(j - 1) * CELLS + i - 1],
                      clamp(scale * (sum - before[i] - last), 0.0, weight));
            last = sum - (j > 0 ? before[i] : 0.0);
            before[i] = sum;
        }
    }
}
#else

#ifdef PREFILTER_N_BUFFERS
layout(binding = 4) uniform sampler2DArray buffers;  // NBuffers
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
layout(binding = 4) uniform sampler2DArray occlusion;  // with mip levels

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

void coverBy(Kernel kernel, int slice, float weight) {
    vec2 cell = kernel.size / float(CELLS);
    for (int i = 0; i < kAll; ++i)
        cover(covered[i],
              weight * boxMean(kernel.lo + vec2(i % CELLS, i / CELLS) * cell, cell, slice));
}
#endif

#ifdef CONTACT
// A slice fades in because the receiver's own surface may go on in it. Where the map sees another
// one there, on the ways through the light's centre and rim, it counts in full.
bool castsFrom(int slice, vec3 p) {
#ifdef FILLED
    const int kFirst = 2;  // what goes on in a slice is drawn into it from the one above
#else
    const int kFirst = 1;
#endif
    int number = int(slices[slice].w);
    float topM = number >= kFirst ? lowerM[number - kFirst] : 0.0, casterM;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            if (castsAt(wayTo(vec2(x, y), p, slices[slice].x), topM, slices[slice].y, casterM))
                return true;
    return false;
}

// What the slice that holds the receiver hides, which its texture cannot tell from the receiver: by
// comparisons, as percentage-closer filtering has them, with what lies below `topM`, at the depth of
// the first caster there that the light's centre or corners see. `continues` where the slice above is not
// empty: both may show one surface.
void coverByContact(vec3 p, float topM, bool continues) {
    float depthM, casterM;
    if (!touched(p, topM, depthM)) return;
    for (int c = 0; c < kAll; ++c) {
        float hidden = 0.0;
        for (int i = 0; i < 4; ++i) {
            vec2 at = vec2(2 * (c % CELLS) + (i & 1), 2 * (c / CELLS) + (i >> 1)) + 0.5;
            vec3 q = wayTo(at / float(CELLS) - 1.0, p, depthM);
            if (castsAt(q, topM, p.z, casterM)) hidden += 0.25;
        }
        if (!continues) cover(covered[c], 0.0);
#ifdef COMBINE_CONTINUED
        covered[c].other = max(covered[c].other, covered[c].before);
        covered[c].before = covered[c].other;
#endif
        cover(covered[c], hidden);
    }
}
#endif

#ifdef UNDECIDED_TILES
// Slices that may hide light from this pixel's tile, as PASS_CLASSIFY packs them.
uint mayHide(int word) {
    vec4 tile = tileOfPixel();
    return word == 0 ? uint(tile.y) | uint(tile.w) << 16 : uint(-1.0 - tile.x) | uint(tile.z) << 16;
}
#endif

// First what each slice is roughly: most are empty, and one that is full decides. Then those that
// are neither, bit by bit: a renderer that runs both sides of every branch for neighbouring pixels,
// as llvmpipe does, leaves loops as soon as none of them has work left.
float lit(vec3 p, vec3 unmoved) {
    uint partial[(SLICES + 31) / 32];
    for (int w = 0; w < partial.length(); ++w) {
        partial[w] = 0u;
#ifdef UNDECIDED_TILES
        for (uint left = mayHide(w); left != 0u; left &= left - 1u) {
            int i = 32 * w + findLSB(left);
#else
        for (int i = 32 * w; i < min(32 * w + 32, used); ++i) {
#endif
            float weight = weightOf(p.z, i);
            if (weight <= 0.0) break;
#ifdef EARLY_OUTS
            float rough = roughly(kernelOn(p, slices[i].x), i);
            if (rough == 1.0 && weight == 1.0) return 0.0;
            if (rough == 0.0) continue;
#endif
            partial[w] |= 1u << (i & 31);
        }
    }
    for (int i = 0; i < kAll; ++i) covered[i] = Covered(0.0, 0.0, 0.0);
    int previous = -1;
    for (int w = 0; w < partial.length(); ++w)
        for (uint left = partial[w]; left != 0u; left &= left - 1u) {
            int i = 32 * w + findLSB(left), number = int(slices[i].w);
            // Past empty slices a run of them is over.
            if (number > previous + 1)
                for (int c = 0; c < kAll; ++c) cover(covered[c], 0.0);
            previous = number;
            float weight = weightOf(p.z, i);
#ifdef CONTACT
            if (weight < 1.0 && castsFrom(i, p)) weight = 1.0;
#endif
            coverBy(kernelOn(p, slices[i].x), i, weight);
        }
#ifdef CONTACT
    coverByContact(unmoved, aboveM(p), previous == slicesAbove(p) - 1);
#endif
    float sum = 0.0;
    for (int i = 0; i < kAll; ++i) sum += total(covered[i]);
    return clamp(1.0 - sum / float(kAll), 0.0, 1.0);
}

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    vec3 p = lightAxes * (position - lightCentre), n = lightAxes * normal;
    if (p.z <= 0.0) {
        visibility = 1.0;
        return;
    }
#ifdef CONTACT
    receiver = lightPoint(position, normal);
#endif
    visibility = lit(movedOff(p, n), p);
}
#endif
#endif
#endif
