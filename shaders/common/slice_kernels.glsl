// The light as receivers see it on the slices of core/frame/slice_view.hpp, and what the table of
// counts tells of it at once. Include after common/light_view.glsl, whose mapSize is the slices', too.
#ifdef STAGE_FRAGMENT
uniform mat3 lightAxes;  // world to light: rows x, y, z
uniform vec2 lightHalfM;
uniform bool orthographic;
uniform float copM;
uniform vec2 uvScale, uvOffset;
uniform vec4 slices[SLICES];  // with casters: depths of plane and lower boundary, 1 / metres of the fade, number
uniform int used;             // of them, those with casters
uniform float lowerM[SLICES]; // lower boundaries of all slices
uniform float p_bias;

float shrink(float zM) {
    return orthographic ? 1.0 : 1.0 / (zM + copM);
}

// Slopes are moved off their own rasterised outline, by the more the steeper they are; surfaces
// parallel to the light lie within one slice and stay where they are. Light coordinates.
vec3 movedOff(vec3 p, vec3 n) {
    vec2 texelM = 1.0 / (uvScale * shrink(p.z) * mapSize);
    return p + n * (p_bias * max(texelM.x, texelM.y) * sqrt(max(1.0 - n.z * n.z, 0.0)));
}

// The slice that holds the receiver does not count, the one above it fades in.
float weightOf(float zM, int slice) {
    return min((zM - slices[slice].y) * slices[slice].z, 1.0);
}

int slicesAbove(vec3 p) {
    int count = 0;
    for (int k = 0; k < SLICES; ++k) count += int(p.z > lowerM[k]);
    return count;
}

// Where the last of them ends.
float aboveM(vec3 p) {
    int above = slicesAbove(p);
    return above > 0 ? lowerM[above - 1] : 0.0;
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

#ifdef PREFILTER_SAT
layout(binding = 4) uniform usampler2DArray counts;  // core/passes/count_table.hpp
uniform int lanes;
// Of the slices' texels, the table's first, and its size. Beside it all texels are empty, so that
// sums are those of its border.
uniform ivec4 table;

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
    ivec2 extent = to - from;
    from = clamp(from - table.xy, ivec2(0), table.zw - 1);
    to = clamp(to - table.xy, ivec2(0), table.zw - 1);
    int plane = lanes == 1 ? slice : slice >> 1;
    uint inside = texelFetch(counts, ivec3(to, plane), 0).r -
                  texelFetch(counts, ivec3(from.x, to.y, plane), 0).r -
                  texelFetch(counts, ivec3(to.x, from.y, plane), 0).r +
                  texelFetch(counts, ivec3(from, plane), 0).r;
    if (lanes == 2) inside = (slice & 1) == 0 ? inside & 0xffffu : inside >> 16;
    return inside == 0u ? 0.0 : inside == uint(extent.x * extent.y) ? 1.0 : 0.5;
}
#endif
#endif
