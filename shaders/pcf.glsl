#ifdef UNDECIDED_TILES
#include "common/pixel_classes.glsl"
#else
#include "common/receiver.glsl"
#endif
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
#include "common/sample_patterns.glsl"

uniform vec2 kernelHalfM;  // half extents of the kernel at the receiver, along the light's u and v
layout(binding = 1) uniform sampler2DArrayShadow comparedMap;  // the same map, filtered

// The kernel's half extents in texels of the receiver's tile. Side tiles see the light edge-on,
// where the two widths have no axis of their own: the wider one serves for both.
vec2 kernelHalfTexels(LightPoint point) {
    vec2 extent = point.tile == 0 ? kernelHalfM : vec2(max(kernelHalfM.x, kernelHalfM.y));
    return extent / point.zM * tileTangents[point.tile].zw * float(mapSize);
}

#ifdef GRID_SIDE
// Taps are counted from the first cell's centre.
const float kFirstTap = 1.0 / float(GRID_SIDE) - 1.0, kTapUnit = 2.0 / float(GRID_SIDE);
#else
const float kFirstTap = 0.0, kTapUnit = 1.0 / 32767.0;
#endif

// What taps share: litAt with all but the fetch and the plane's rise hoisted, in texels.
struct Kernel {
    int tile;
    vec2 beside;  // from the receiver to the centre of texel 0
    float level;  // s of the receiver, as compared
    vec2 slope;   // and per texel of its plane
    vec2 first;   // where tap (0, 0) is
#ifdef ROTATION
    mat2 reach;   // per unit of taps
#else
    vec2 reach;
#endif
};

Kernel kernelOf(LightPoint point) {
    vec2 halfTexels = kernelHalfTexels(point);
#ifdef ROTATION
    mat2 reach = mat2(halfTexels.x, 0.0, 0.0, halfTexels.y) * pixelRotation(uvec2(gl_FragCoord.xy));
#else
    vec2 reach = halfTexels;
#endif
    vec2 place = point.uv * float(mapSize);
    vec2 slope = point.gradient * (point.biasScale / float(mapSize));
    return Kernel(point.tile, 0.5 - place, point.s * point.biasScale, slope,
                  place + reach * vec2(kFirstTap), reach * kTapUnit);
}

#ifdef COMPARE_HARDWARE
// Four comparisons weighted by distance, all with one reference: the receiver's plane at that of the
// four texel centres where it is nearest to the light, so that none of them shadows a plane. Past
// the map's border the sampler finds no caster.
float litAtTap(Kernel kernel, vec2 tap) {
    vec2 at = kernel.first + kernel.reach * tap;
    vec2 most = max(kernel.slope, 0.0);
    float rise = dot(kernel.slope, floor(at - 0.5) + kernel.beside) + most.x + most.y;
    float compared = kernel.level + max(rise, 0.0);
    return texture(comparedMap, vec4(at / float(mapSize), kernel.tile, compared));
}
#else
float litAtTap(Kernel kernel, vec2 tap) {
    vec2 texel = floor(kernel.first + kernel.reach * tap);
    ivec2 index = ivec2(texel);
    bool outside = any(greaterThanEqual(uvec2(index), uvec2(mapSize)));
    float rise = dot(kernel.slope, texel + kernel.beside);
    float caster = texelFetch(shadowMap, ivec3(index, kernel.tile), 0).r;
    return outside || caster <= kernel.level + max(rise, 0.0) ? 1.0 : 0.0;
}
#endif

// Loops of constant length are unrolled, a row or four taps at a time, and software renderers take
// half as long for it.
#if defined(GRID_SIDE)
float litTaps(Kernel kernel) {
    float lit = 0.0;
    for (int j = 0; j < GRID_SIDE; ++j)
        for (int i = 0; i < GRID_SIDE; ++i) lit += litAtTap(kernel, vec2(i, j));
    return lit / float(GRID_SIDE * GRID_SIDE);
}
#elif defined(TAPS)
// On [-1, 1]^2, in units of kTapUnit, y above x: software renderers read such a list pixel by pixel
// and component by component.
layout(std140, binding = 1) uniform Taps { ivec4 taps[(TAPS + 3) / 4]; };

float litAtPacked(Kernel kernel, int tap) {
    return litAtTap(kernel, vec2(ivec2(tap << 16, tap) >> 16));
}

float litTaps(Kernel kernel) {
    float lit = 0.0;
    for (int four = 0; four < TAPS / 4; ++four)
        for (int i = 0; i < 4; ++i) lit += litAtPacked(kernel, taps[four][i]);
    for (int i = TAPS / 4 * 4; i < TAPS; ++i) lit += litAtPacked(kernel, taps[i / 4][i % 4]);
    return lit / float(TAPS);
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
#ifdef NO_KERNEL
    visibility = litAt(point, point.uv);
#else
    visibility = litTaps(kernelOf(point));
#endif
}
#endif
