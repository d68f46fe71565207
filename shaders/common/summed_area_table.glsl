// Means over boxes of a summed-area table (core/passes/summed_area_table.hpp), which is bound to
// unit 1 and its mean to unit 2. TABLE_CELLS says into how many cells along each side a box is cut.
#ifdef STAGE_FRAGMENT
#ifdef TABLE_UINT
#define SUM uvec2
layout(binding = 1) uniform usampler2DArray summedAreas;
uniform float tableStepsPerUnit;
#else
#define SUM vec2
layout(binding = 1) uniform sampler2DArray summedAreas;
layout(binding = 2) uniform sampler2DArray tableMean;
#endif
uniform float tableMaxBox;  // area of the largest cell, texels

const int kCells = TABLE_CELLS;
const int kBands = kCells + 2;  // whole texels between lines; the outer two are one texel wide

// One side of a box: its first and last texels count by the part of them that the box covers, and
// the lines between its cells lie between texels, so that neighbours share their fetches.
struct BoxSide {
    int line[kBands + 1];
    float firstWeight, lastWeight;
    float size[kCells];    // of cells, texels; 0 where a side has fewer texels than cells
    float middle[kCells];  // weighted mean of a cell's texel centres, texels
};

BoxSide boxSide(float lo, float hi, int size) {
    BoxSide side;
    int first = int(lo), last = max(int(hi), first + 1);
    side.firstWeight = 1.0 - fract(lo);
    side.lastWeight = hi - float(last);
    side.line[0] = first;
    side.line[1] = first + 1;
    for (int i = 1; i < kCells; ++i)
        side.line[i + 1] =
            clamp(int(round(mix(lo, hi, float(i) / float(kCells)))), first + 1, last);
    side.line[kBands - 1] = last;
    side.line[kBands] = min(last + 1, size);
    for (int i = 0; i < kCells; ++i) {
        int from = side.line[i + 1], to = side.line[i + 2];
        // Counted from the first texel, so that no digits are lost far from the map's corner.
        float n = float(to - from), moment = n * (float(from - first) + 0.5 * n);
        if (i == 0) {
            n += side.firstWeight;
            moment += 0.5 * side.firstWeight;
        }
        if (i == kCells - 1) {
            n += side.lastWeight;
            moment += side.lastWeight * (float(last - first) + 0.5);
        }
        side.size[i] = n;
        side.middle[i] = float(first) + (n > 0.0 ? moment / n : 0.0);
    }
    return side;
}

struct BoxCells {
    BoxSide x, y;
    vec2 mean[kCells * kCells];  // of the source over the cell, row by row
};

// The box from lo to hi, in texels and inside the map, each texel of the source constant over its
// square. A box narrower than a texel is widened to one; one whose cells would be larger than the
// table allows is shrunk about its centre.
BoxCells tableBox(vec2 lo, vec2 hi, int layer) {
    ivec2 size = textureSize(summedAreas, 0).xy - 1;
    const float kRounding = kCells > 1 ? 1.0 : 0.0;  // each line moves by up to half a texel
    vec2 extent = hi - lo, cell = extent / float(kCells) + kRounding;
    float excess = cell.x * cell.y / tableMaxBox;
    if (excess > 1.0) extent = (cell / sqrt(excess) - kRounding) * float(kCells);
    extent = max(extent, vec2(1.0));
    lo = clamp(0.5 * (lo + hi - extent), vec2(0.0), vec2(size) - 1.0);
    hi = clamp(lo + extent, lo + 1.0, vec2(size));
    BoxCells box;
    box.x = boxSide(lo.x, hi.x, size.x);
    box.y = boxSide(lo.y, hi.y, size.y);
    for (int i = 0; i < kCells * kCells; ++i) box.mean[i] = vec2(0.0);
    SUM above[kBands];
    for (int j = 0; j <= kBands; ++j) {
        // Differences along a row first and between rows next: exact modulo 2^32.
        SUM band[kBands];
        SUM left = texelFetch(summedAreas, ivec3(box.x.line[0], box.y.line[j], layer), 0).rg;
        for (int b = 0; b < kBands; ++b) {
            SUM right =
                texelFetch(summedAreas, ivec3(box.x.line[b + 1], box.y.line[j], layer), 0).rg;
            band[b] = right - left;
            left = right;
        }
        if (j > 0) {
            float weight = j == 1 ? box.y.firstWeight : j == kBands ? box.y.lastWeight : 1.0;
            int row = kCells * clamp(j - 2, 0, kCells - 1);
            for (int b = 0; b < kBands; ++b)
                box.mean[row + clamp(b - 1, 0, kCells - 1)] +=
                    (b == 0            ? weight * box.x.firstWeight
                     : b == kBands - 1 ? weight * box.x.lastWeight
                                       : weight) *
                    vec2(band[b] - above[b]);
        }
        above = band;
    }
#ifdef TABLE_UINT
    float scale = 2.0 / tableStepsPerUnit;
    vec2 offset = vec2(-1.0);
#else
    float scale = 1.0;
    vec2 offset = texelFetch(tableMean, ivec3(0, size.y, layer), 0).rg;
#endif
    for (int j = 0; j < kCells; ++j)
        for (int i = 0; i < kCells; ++i) {
            float area = box.x.size[i] * box.y.size[j];
            box.mean[j * kCells + i] =
                box.mean[j * kCells + i] * (area > 0.0 ? scale / area : 0.0) + offset;
        }
    return box;
}
#endif
