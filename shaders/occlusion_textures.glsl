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
layout(binding = 1) uniform usampler2DArray counts;  // core/passes/count_table.hpp
uniform int lanes;

const int kLines = CELLS + 1;  // between and around rows of cells

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
    int plane = lanes == 1 ? slice : slice >> 1;
    uint inside = texelFetch(counts, ivec3(to, plane), 0).r -
                  texelFetch(counts, ivec3(from.x, to.y, plane), 0).r -
                  texelFetch(counts, ivec3(to.x, from.y, plane), 0).r +
                  texelFetch(counts, ivec3(from, plane), 0).r;
    if (lanes == 2) inside = (slice & 1) == 0 ? inside & 0xffffu : inside >> 16;
    ivec2 extent = to - from;
    return inside == 0u ? 0.0 : inside == uint(extent.x * extent.y) ? 1.0 : 0.5;
}

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
            uvec4 at = textureGather(counts, vec3((corner + 1.0) / (mapSize + 1.0), plane));
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

void coverBy(Kernel kernel, int slice, float weight) {
    vec2 cell = kernel.size / float(CELLS);
    for (int i = 0; i < kAll; ++i)
        cover(covered[i],
              weight * boxMean(kernel.lo + vec2(i % CELLS, i / CELLS) * cell, cell, slice));
}
#endif

// The slice that holds the receiver does not count, the one above it fades in.
float weightOf(vec3 p, int slice) {
    return min((p.z - slices[slice].y) * slices[slice].z, 1.0);
}

#ifdef CONTACT
LightPoint receiver;

// Whether the shadow map knows a caster between `fromM` and `toM` on the way from the light's
// centre through `q`, light coordinates, that is not the receiver's own plane.
bool castsAt(vec3 q, float fromM, float toM, out float casterM) {
    casterM = 0.0;
    vec3 l = tileAxes[receiver.tile] * (q * lightAxes);
    vec4 tangents = tileTangents[receiver.tile];
    vec2 uv = (l.xy / l.z - tangents.xy) * tangents.zw;
    if (litAt(receiver, uv) == 1.0) return false;
    float caster = texelFetch(shadowMap, ivec3(floor(uv * float(mapSize)), receiver.tile), 0).r;
    casterM = q.z * tileNear[receiver.tile] / (caster * l.z);  // both on one way
    return casterM >= fromM && casterM < toM;
}

// Where the way from the receiver to a point of the light, in half its size, crosses a depth.
vec3 wayTo(vec2 onLight, vec3 p, float zM) {
    return vec3(mix(lightHalfM * onLight, p.xy, zM / p.z), zM);
}

// A slice fades in because the receiver's own surface may go on in it. Where the map sees another
// one there, on the ways through the light's centre and rim, it counts in full.
bool castsFrom(int slice, vec3 p) {
#ifdef FILLED
    const int kFirst = 2;  // what goes on in a slice is drawn into it from the one above
#else
    const int kFirst = 1;
#endif
    float topM = slice >= kFirst ? slices[slice - kFirst].y : 0.0, casterM;
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
    float depthM = 0.0, casterM;
    bool any = castsAt(p, topM, p.z, depthM);
    for (int i = 0; i < 4 && !any; ++i)
        any = castsAt(wayTo(vec2(i & 1, i >> 1) * 2.0 - 1.0, p, 0.5 * (topM + p.z)), topM, p.z,
                      depthM);
    if (!any) return;
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

// First what each slice is roughly: most are empty, and one that is full decides. Then those that
// are neither, bit by bit: a renderer that runs both sides of every branch for neighbouring pixels,
// as llvmpipe does, leaves loops as soon as none of them has work left.
float lit(vec3 p, vec3 unmoved) {
    int counting = 0;
    uint partial[(SLICES + 31) / 32];
    for (int w = 0; w < partial.length(); ++w) {
        partial[w] = 0u;
        for (int b = 0; b < min(32, SLICES - 32 * w); ++b) {
            int k = 32 * w + b;
            float weight = weightOf(p, k);
            if (weight <= 0.0) break;
            counting = k + 1;
#ifdef EARLY_OUTS
            float rough = roughly(kernelOn(p, slices[k].x), k);
            if (rough == 1.0 && weight == 1.0) return 0.0;
            if (rough == 0.0) continue;
#endif
            partial[w] |= 1u << b;
        }
    }
    for (int i = 0; i < kAll; ++i) covered[i] = Covered(0.0, 0.0, 0.0);
    int previous = -1;
    for (int w = 0; w < partial.length(); ++w)
        for (uint left = partial[w]; left != 0u; left &= left - 1u) {
            int k = 32 * w + findLSB(left);
            // Past empty slices a run of them is over.
            if (k > previous + 1)
                for (int i = 0; i < kAll; ++i) cover(covered[i], 0.0);
            previous = k;
            float weight = weightOf(p, k);
#ifdef CONTACT
            if (weight < 1.0 && castsFrom(k, p)) weight = 1.0;
#endif
            coverBy(kernelOn(p, slices[k].x), k, weight);
        }
#ifdef CONTACT
    coverByContact(unmoved, counting > 0 ? slices[counting - 1].y : 0.0, previous == counting - 1);
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
    // Slopes are moved off their own rasterised outline, by the more the steeper they are; surfaces
    // parallel to the light lie within one slice and stay where they are.
    vec2 texelM = 1.0 / (uvScale * shrink(p.z) * mapSize);
    vec3 moved =
        p + n * (p_bias * max(texelM.x, texelM.y) * sqrt(max(1.0 - n.z * n.z, 0.0)));
#ifdef CONTACT
    receiver = lightPoint(position, normal);
#endif
    visibility = lit(moved, p);
}
#endif
#endif
