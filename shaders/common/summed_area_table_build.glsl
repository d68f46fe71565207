// A summed-area table by two scans, of rows and of columns (core/passes/summed_area_table.hpp).
// A line is cut into kSegments pieces: each invocation sums its piece, the pieces' sums are shared,
// and each piece is then scanned from the sum of all before it. Two reads and one write per texel
// and axis, whatever the size, with one barrier (after Blelloch 1990, three-phase scan).
#ifdef STAGE_COMPUTE
#if defined(TABLE_COUNTS)
#define SUM uvec4
#define CHANNELS rgba
#define STORED(sum) sum
#define TABLE_IMAGE uimage2DArray
#define TABLE_FORMAT rgba32ui
uniform int lanes;  // slices that share a number, 1 or 2 (core/passes/count_table.hpp)
uniform ivec4 region;  // of the source, first texel and size: what is beside it is left out
#elif defined(TABLE_UINT)
#define SUM uvec2
#define CHANNELS rg
#define STORED(sum) uvec4(sum, 0u, 0u)
#define TABLE_IMAGE uimage2DArray
#define TABLE_FORMAT rg32ui
#else
#define SUM vec2
#define CHANNELS rg
#define STORED(sum) vec4(sum, 0.0, 0.0)
#define TABLE_IMAGE image2DArray
#define TABLE_FORMAT rg32f
#endif
#ifdef SOURCE_BITS
layout(binding = 0) uniform usampler2D source;
#else
layout(binding = 0) uniform sampler2DArray source;
#endif
#ifdef SOURCE_ROW_SUMS
layout(binding = 2, r32ui) writeonly uniform uimage2DArray planes;
#endif
layout(binding = 0, TABLE_FORMAT) uniform TABLE_IMAGE tableImage;
layout(binding = 1, rg32f) uniform image2DArray meanImage;  // of rows; of all after the last row
uniform float stepsPerUnit;

#if defined(PASS_ROW_MEANS)
layout(local_size_x = 8) in;
void main() {
    int y = int(gl_GlobalInvocationID.x), layer = int(gl_GlobalInvocationID.z);
    ivec2 size = textureSize(source, 0).xy;
    if (y >= size.y) return;
    vec2 sum = vec2(0.0);
    for (int x = 0; x < size.x; ++x) sum += texelFetch(source, ivec3(x, y, layer), 0).rg;
    imageStore(meanImage, ivec3(0, y, layer), vec4(sum / float(size.x), 0.0, 0.0));
}
#elif defined(PASS_MEAN)
layout(local_size_x = 1) in;
void main() {
    int rows = imageSize(meanImage).y - 1, layer = int(gl_GlobalInvocationID.z);
    vec2 sum = vec2(0.0);
    for (int y = 0; y < rows; ++y) sum += imageLoad(meanImage, ivec3(0, y, layer)).rg;
    imageStore(meanImage, ivec3(0, rows, layer), vec4(sum / float(rows), 0.0, 0.0));
}
#else

const int kSegments = SEGMENTS, kLines = LINES;
#ifdef PASS_ROWS
layout(local_size_x = SEGMENTS, local_size_y = LINES) in;
#else
layout(local_size_x = LINES, local_size_y = SEGMENTS) in;
#endif
shared SUM segmentSums[kSegments * kLines];

// Entry `i` of line `line`: a source texel in the first scan, what that left in the second.
#ifdef PASS_ROWS
SUM entry(int i, int line, int layer, vec2 mean) {
#if defined(SOURCE_BITS)
    // Four or eight slices of 32: a channel's own bit and, 16 bits up, the one after it.
    int first = 4 * lanes * layer;
    uint bits = texelFetch(source, region.xy + ivec2(i, line), 0)[first >> 5] >> (first & 31);
    uvec4 of = uvec4(0u, 1u, 2u, 3u) * uint(lanes);
    uvec4 low = (uvec4(bits) >> of) & 1u, high = (uvec4(bits) >> (of + 1u)) & 1u;
    return lanes == 1 ? low : low | high << 16u;
#elif defined(SOURCE_CHANNELS)
    ivec2 texel = region.xy + ivec2(i, line);
    uvec4 a = uvec4(round(texelFetch(source, ivec3(texel, lanes * layer), 0)));
    if (lanes == 1) return a;
    int next = min(2 * layer + 1, textureSize(source, 0).z - 1);
    uvec4 b = uvec4(round(texelFetch(source, ivec3(texel, next), 0)));
    return uvec4(a.xz, b.xz) | uvec4(a.yw, b.yw) << 16u;
#else
    vec2 v = texelFetch(source, ivec3(i, line, layer), 0).rg;
#ifdef TABLE_UINT
    return uvec2(round((clamp(v, -1.0, 1.0) * 0.5 + 0.5) * stepsPerUnit));
#else
    return v - mean;
#endif
#endif
}
#else
SUM entry(int i, int line, int layer, vec2 mean) {
    return imageLoad(tableImage, ivec3(line + 1, i + 1, layer)).CHANNELS;
}
#endif

void main() {
    ivec2 size = imageSize(tableImage).xy - 1;
#ifdef PASS_ROWS
    int segment = int(gl_LocalInvocationID.x), localLine = int(gl_LocalInvocationID.y);
    int line = int(gl_GlobalInvocationID.y), length = size.x, lines = size.y;
#else
    int segment = int(gl_LocalInvocationID.y), localLine = int(gl_LocalInvocationID.x);
    int line = int(gl_GlobalInvocationID.x), length = size.y, lines = size.x;
#endif
    int layer = int(gl_GlobalInvocationID.z);
    vec2 mean = vec2(0.0);
#ifdef SUBTRACT_MEAN
    mean = imageLoad(meanImage, ivec3(0, size.y, layer)).rg;
#endif
    int piece = (length + kSegments - 1) / kSegments;
    int from = min(segment * piece, length), to = min(from + piece, length);
    SUM sum = SUM(0);
    if (line < lines)
        for (int i = from; i < to; ++i) sum += entry(i, line, layer, mean);
    segmentSums[segment * kLines + localLine] = sum;
    barrier();
    sum = SUM(0);
    for (int s = 0; s < segment; ++s) sum += segmentSums[s * kLines + localLine];
    if (line >= lines) return;
    for (int i = from; i < to; ++i) {
        sum += entry(i, line, layer, mean);
#ifdef PASS_ROWS
        ivec3 at = ivec3(i + 1, line + 1, layer);
#else
        ivec3 at = ivec3(line + 1, i + 1, layer);
#endif
#ifdef SOURCE_ROW_SUMS
        for (int c = 0; c < 4; ++c) imageStore(planes, ivec3(at.xy, 4 * layer + c), uvec4(sum[c]));
#else
        imageStore(tableImage, at, STORED(sum));
#endif
    }
}
#endif
#endif
