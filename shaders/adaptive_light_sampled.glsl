// Comparisons of maps from several points of the light (methods/adaptive_light_sampled.cpp);
// evaluation is shaders/light_sampled.glsl's, but for PASS_SHADE_BITS.
// PASS_COMPARE: drawn in an occlusion query that counts the pixels at which the first COMPARED_MAPS
// of `compared` do not agree. COMPARE_TIGHT, _ABSOLUTE, _RELATIVE or _SYMMETRIC; LIGHT_SPACE: pixels
// are the texels of the centre's map.
// With COLLECTED the pixels are those that PASS_COLLECT found worth it.
// PASS_MARK_BITS: adds new maps' shadow tests to the bits kept per pixel and counts by atomics.
// With SKIP_LIT_TILES pixels of tiles that are lit (core/frame/lit_tiles.hpp) are not compared.
#ifdef SKIP_LIT_TILES
#include "common/pixel_classes.glsl"
#else
#include "common/receiver.glsl"
#endif

#ifdef STAGE_FRAGMENT
#include "common/light_maps.glsl"

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

#if defined(PASS_MARK_BITS) || defined(PASS_COMPARE) || defined(PASS_COLLECT)
uniform int stride;  // every so many pixels one is compared

ivec2 comparedPixel() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) * stride + stride / 2;
    return min(pixel, textureSize(gbufferPosition, 0) - 1);
}

#ifdef SKIP_LIT_TILES
uniform bool tilesDecided;

// Whether all maps are known to agree there.
bool isLit(ivec2 pixel) {
    return tilesDecided && isDecided(texelFetch(tileClasses, pixel / kTilePixels, 0));
}
#else
bool isLit(ivec2 pixel) { return false; }
#endif
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
    ivec2 pixel = comparedPixel();
    if (isLit(pixel) || !receivesAt(pixel, position, normal)) return;
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

#elif defined(PASS_COLLECT)
uniform int receiversAcross;
layout(rgba32f, binding = 0) writeonly uniform image2D receivers;
layout(std430, binding = 1) buffer Counter { uint receiverCount; };

void main() {
    vec3 position, normal;
    ivec2 pixel = comparedPixel();
    if (isLit(pixel) || !receivesAt(pixel, position, normal)) return;
    LightPoint centre = lightPoint(position, normal);
    if (!centre.inFront) return;
    // Those after one another in blocks of 4 x 4, which the processor shades at once.
    int at = int(atomicAdd(receiverCount, 1u)), block = at >> 4, blocks = receiversAcross >> 2;
    ivec2 place = 4 * ivec2(block % blocks, block / blocks) + ivec2(at & 3, at >> 2 & 3);
    imageStore(receivers, place,
               vec4(centre.uv * float(mapSize), 1.0 / centre.zM, 0.0));
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
    ivec2 pixel = comparedPixel();
    return !isLit(pixel) && receivesAt(pixel, position, normal);
}
#endif

// 1 / depth of the caster that map i, of one tile, shows at the receiver's place, 1 / metres; 0: none.
float inverseDepth(Receiver receiver, int i) {
    ivec2 texel = clamp(ivec2(placeIn(receiver, i)), ivec2(0), ivec2(mapSize - 1));
    return texelFetch(shadowMap, ivec3(texel, i), 0).r / tileNear[0];
}

// The same of any. A map of five tiles has the caster at (receiver's s) / (caster's s) of the receiver's depth.
float inverseDepth(LightPoint centre, Receiver receiver, vec3 position, vec3 normal, int i) {
    if (tileCount == 1) return inverseDepth(receiver, i);
    LightPoint point = lightPoint(position - lightSamples[i].offsetWeight.xyz, normal);
    ivec2 texel = clamp(ivec2(point.uv * float(mapSize)), ivec2(0), ivec2(mapSize - 1));
    float s = texelFetch(shadowMap, ivec3(texel, point.tile + i * tileCount), 0).r;
    return s / (point.s * centre.zM);
}

// `left` and `right` are inverse depths; where neither map shows anything they agree, for any gamma
// but 0, of which nothing is less.
bool agree(float left, float right) {
#if defined(COMPARE_ABSOLUTE)  // eq. 3
    bool near = abs(1.0 / left - 1.0 / right) < p_gamma * depthUnitM;
#elif defined(COMPARE_RELATIVE)  // eq. 7: |1 - depthLeft / depthRight| < gamma, times 1 / depthLeft
    bool near = abs(left - right) < p_gamma * left;
#else  // |depthLeft - depthRight| < gamma max(depthLeft, depthRight)
    bool near = abs(left - right) < p_gamma * max(left, right);
#endif
    return left == 0.0 || right == 0.0 ? left == right && p_gamma > 0.0 : near;
}

#ifdef COLLECTED
layout(binding = 3) uniform sampler2D receivers;
uniform int receiversAcross, receiverCount;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    Receiver receiver;
    vec4 place = texelFetch(receivers, at, 0);
    receiver.texel = place.xy;
    receiver.inverseZ = place.z;
    bool differ = false;
    float value[COMPARED_MAPS];
    for (int c = 0; c < COMPARED_MAPS; ++c) value[c] = inverseDepth(receiver, compared[c]);
    for (int a = 0; a < COMPARED_MAPS - 1; ++a)
        for (int b = a + 1; b < COMPARED_MAPS; ++b)
            differ = differ || !agree(value[a], value[b]);
    int index = (at.y >> 2) * (receiversAcross << 2) + (at.x >> 2 << 4) + (at.y & 3) * 4 + (at.x & 3);
    if (!differ || index >= receiverCount) discard;
}
#else
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
#endif
