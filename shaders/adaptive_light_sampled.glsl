// Comparisons of maps from several points of the light (methods/adaptive_light_sampled.cpp);
// evaluation is shaders/light_sampled.glsl's, but for PASS_SHADE_BITS and PASS_SHADE_UNDECIDED.
// PASS_COMPARE: drawn in an occlusion query that counts the pixels at which the first COMPARED_MAPS
// of `compared` do not agree. COMPARE_TIGHT, _ABSOLUTE, _RELATIVE or _SYMMETRIC; LIGHT_SPACE: pixels
// are the texels of the centre's map.
// PASS_MARK_BITS: adds new maps' shadow tests to the bits kept per pixel and counts by atomics.
// PASS_SPREAD_STATES: what the pixels compared around each of them saw in all maps.
// PASS_SHADE_UNDECIDED: reads all maps only where those around saw light and dark.
#include "common/receiver.glsl"

#ifdef STAGE_FRAGMENT
#include "common/light_maps.glsl"

#if defined(PASS_MARK_BITS) || defined(PASS_SPREAD_STATES) || defined(PASS_SHADE_UNDECIDED)
// Of the pixels compared: whether any map was lit, and any dark; kNothing for what no light reaches.
const uint kNothing = 0u, kLit = 1u, kDark = 2u;
#ifndef PASS_SHADE_UNDECIDED
layout(r8ui, binding = 1) uniform uimage2D pixelStates;
#endif
#ifndef PASS_MARK_BITS
layout(r8ui, binding = 2) uniform uimage2D spreadStates;
#endif
#endif

#if defined(PASS_MARK_BITS) || defined(PASS_SHADE_BITS)
const int kMaxWords = kMaxLightSamples / 32;
layout(r32ui, binding = 0) uniform uimage2DArray shadowBits;  // 1: lit; bit i % 32 of layer i / 32
uint words[kMaxWords];

bool bitOf(int i) { return (words[i >> 5] >> (i & 31) & 1u) != 0u; }

// The bits of word `word` that `count` samples fill.
uint filled(int word, int count) {
    int bits = count - 32 * word;
    return bits >= 32 ? ~0u : (1u << bits) - 1u;
}
#endif

#if defined(PASS_MARK_BITS) || defined(PASS_COMPARE)
uniform int stride;  // every so many pixels one is compared

ivec2 comparedPixel() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) * stride + stride / 2;
    return min(pixel, textureSize(gbufferPosition, 0) - 1);
}
#endif

#ifdef PASS_MARK_BITS
uniform int pixelTileSide;      // compared pixels
uniform int pixelTileColumns;
uniform int pixelTileCount;
uniform int comparisonCount;
layout(std430, binding = 0) readonly buffer Comparisons { ivec4 comparisons[]; };
layout(std430, binding = 1) buffer Counts { uint counts[]; };  // of a comparison's tiles in turn

void main() {
    vec3 position, normal;
    ivec2 texel = ivec2(gl_FragCoord.xy);
    if (!receivesAt(comparedPixel(), position, normal)) {
        imageStore(pixelStates, texel, uvec4(kNothing));
        return;
    }
    int end = firstLightSample + lightSampleCount;
    LightPoint centre = lightPoint(position, normal);
    Receiver receiver = receiverOf(centre, position, normal);
    bool allLit = true, noneLit = true;
    for (int w = 0; 32 * w < end; ++w) {
        int first = max(32 * w, firstLightSample), last = min(32 * w + 32, end);
        uint word = 32 * w < firstLightSample ? imageLoad(shadowBits, ivec3(texel, w)).r : 0u;
        for (int i = first; i < last; ++i) {
            float lit = centre.inFront ? litFromMap(receiver, position, normal, i) : 1.0;
            word |= uint(lit) << (i & 31);
        }
        if (first < last) imageStore(shadowBits, ivec3(texel, w), uvec4(word));
        allLit = allLit && word == filled(w, end);
        noneLit = noneLit && word == 0u;
        words[w] = word;
    }
    imageStore(pixelStates, texel, uvec4((noneLit ? kNothing : kLit) | (allLit ? kNothing : kDark)));
    if (allLit || noneLit) return;
    ivec2 tile = texel / pixelTileSide;
    int at = tile.y * pixelTileColumns + tile.x;
    for (int c = 0; c < comparisonCount; ++c) {
        ivec4 maps = comparisons[c];
        bool first = bitOf(maps.x);
        if (bitOf(maps.y) != first || bitOf(maps.z) != first || bitOf(maps.w) != first)
            atomicAdd(counts[c * pixelTileCount + at], 1u);
    }
}

#elif defined(PASS_SPREAD_STATES)
void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy), last = imageSize(pixelStates) - 1;
    uint seen = kNothing;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            seen |= imageLoad(pixelStates, clamp(texel + ivec2(x, y), ivec2(0), last)).r;
    imageStore(spreadStates, texel, uvec4(seen));
}

#elif defined(PASS_SHADE_UNDECIDED)
uniform int p_stride;
uniform int p_checks;

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    uint seen = imageLoad(spreadStates, ivec2(gl_FragCoord.xy) / p_stride).r;
    if (seen == kLit || seen == kDark) {
        float all = seen == kLit ? 1.0 : 0.0;
        LightPoint centre = lightPoint(position, normal);
        bool agree = true;
        if (p_checks > 0 && centre.inFront) {
            Receiver receiver = receiverOf(centre, position, normal);
            for (int i = 0; i < min(p_checks, lightSampleCount); ++i)
                agree = agree && litFromMap(receiver, position, normal, i) == all;
        }
        visibility = all;
        if (agree) return;
    }
    visibility = litSum(position, normal) / lightSampleWeight;
}

#elif defined(PASS_SHADE_BITS)
void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int wordCount = (lightSampleCount + 31) >> 5;
    bool allLit = true, noneLit = true;
    for (int w = 0; w < wordCount; ++w) {
        words[w] = imageLoad(shadowBits, ivec3(pixel, w)).r;
        allLit = allLit && words[w] == filled(w, lightSampleCount);
        noneLit = noneLit && words[w] == 0u;
    }
    visibility = allLit ? 1.0 : 0.0;
    if (allLit || noneLit) return;
#if defined(LIGHT_MAPS_PCF) || defined(LIGHT_MAPS_KERNEL)
    visibility = litSum(position, normal) / lightSampleWeight;
#else
    float sum = 0.0;
    for (int i = 0; i < lightSampleCount; ++i)
        if (bitOf(i)) sum += lightSamples[i].offsetWeight.w;
    visibility = sum / lightSampleWeight;
#endif
}

#elif defined(PASS_COMPARE)
uniform ivec4 compared;     // maps
uniform float p_gamma;
uniform float depthUnitM;   // what the absolute form's gamma is a part of

#ifdef LIGHT_SPACE
layout(binding = 2) uniform sampler2DArray centreMap;
uniform int centreTile;

float smaller(float a, float b) { return abs(a) < abs(b) ? a : b; }

// The nearest surface in a texel of the centre's map. Its plane follows from the neighbours that
// differ less, as 1/z is affine over a plane.
bool surface(out vec3 position, out vec3 normal) {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float s = texelFetch(centreMap, ivec3(texel, centreTile), 0).r;
    if (s == 0.0) return false;
    float near = tileNear[centreTile];
    vec2 tangentStep = 1.0 / (tileTangents[centreTile].zw * float(mapSize));
    vec2 t = tileTangents[centreTile].xy + gl_FragCoord.xy * tangentStep;
    mat3 fromTile = transpose(tileAxes[centreTile]);
    position = lightCentre + fromTile * (vec3(t, 1.0) * (near / s));
    vec2 slope;
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 beside = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        ivec2 before = max(texel - beside, 0), after = min(texel + beside, mapSize - 1);
        float down = s - texelFetch(centreMap, ivec3(before, centreTile), 0).r;
        float up = texelFetch(centreMap, ivec3(after, centreTile), 0).r - s;
        slope[axis] = (before == texel ? up : after == texel ? down : smaller(down, up)) /
                      tangentStep[axis];
    }
    normal = -normalize(fromTile * vec3(slope, s - dot(slope, t)));
    return true;
}
#else
bool surface(out vec3 position, out vec3 normal) {
    return receivesAt(comparedPixel(), position, normal);
}
#endif

// 1 / depth of the caster that map i shows at the receiver's place, 1 / metres; 0: none. A map of
// five tiles has the caster at (receiver's s) / (caster's s) of the receiver's depth.
float inverseDepth(LightPoint centre, Receiver receiver, vec3 position, vec3 normal, int i) {
    if (tileCount == 1) {
        ivec2 texel = clamp(ivec2(placeIn(receiver, i)), ivec2(0), ivec2(mapSize - 1));
        return texelFetch(shadowMap, ivec3(texel, i), 0).r / tileNear[0];
    }
    LightPoint point = lightPoint(position - lightSamples[i].offsetWeight.xyz, normal);
    ivec2 texel = clamp(ivec2(point.uv * float(mapSize)), ivec2(0), ivec2(mapSize - 1));
    float s = texelFetch(shadowMap, ivec3(texel, point.tile + i * tileCount), 0).r;
    return s / (point.s * centre.zM);
}

// `left` and `right` are inverse depths; where neither map shows anything they agree, for any gamma
// but 0, of which nothing is less.
bool agree(float left, float right) {
    if (left == 0.0 || right == 0.0) return left == right && p_gamma > 0.0;
#if defined(COMPARE_ABSOLUTE)  // eq. 3
    return abs(1.0 / left - 1.0 / right) < p_gamma * depthUnitM;
#elif defined(COMPARE_RELATIVE)  // eq. 7: |1 - depthLeft / depthRight|
    return abs(1.0 - right / left) < p_gamma;
#else  // |depthLeft - depthRight| < gamma max(depthLeft, depthRight)
    return abs(left - right) < p_gamma * max(left, right);
#endif
}

void main() {
    vec3 position, normal;
    if (!surface(position, normal)) discard;
    LightPoint centre = lightPoint(position, normal);
    if (!centre.inFront) discard;
    Receiver receiver = receiverOf(centre, position, normal);
#ifdef LIGHT_SPACE
    // What other points of the light see beside their maps is nothing that the camera sees.
    if (tileCount == 1)
        for (int c = 0; c < COMPARED_MAPS; ++c) {
            vec2 place = placeIn(receiver, compared[c]);
            if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, vec2(mapSize))))
                discard;
        }
#endif
    float value[COMPARED_MAPS];
    for (int c = 0; c < COMPARED_MAPS; ++c) {
#ifdef COMPARE_TIGHT
        value[c] = litFromMap(receiver, position, normal, compared[c]);
#else
        value[c] = inverseDepth(centre, receiver, position, normal, compared[c]);
#endif
    }
    for (int a = 0; a < COMPARED_MAPS - 1; ++a)
        for (int b = a + 1; b < COMPARED_MAPS; ++b) {
#ifdef COMPARE_TIGHT
            if (value[a] != value[b]) return;
#else
            if (!agree(value[a], value[b])) return;
#endif
        }
    discard;
}
#endif
#endif
