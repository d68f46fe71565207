// Bounds of the shadow map over windows of blocks of texels: core/passes/min_max_pyramid.hpp says
// what a texel holds and why. Lengths and gradients here are in texels of the shadow map.
#ifdef STAGE_FRAGMENT
layout(binding = 1) uniform usampler2DArray pyramid;
uniform int pyramidLevels;
uniform int pyramidBlocks;        // across
uniform float pyramidBlockTexels; // side of a block

// A slope of s per texel is small beyond what half floats hold.
const float kGradientScale = 4096.0;

uint packGradient(vec2 perTexel) {
    return packHalf2x16(clamp(perTexel * kGradientScale, -6e4, 6e4));
}

vec2 unpackGradient(uint bits) {
    return unpackHalf2x16(bits) / kGradientScale;
}

struct Window {
    float maxS, minS;
    float planeS;    // height at the window's centre of a plane above all of its texels
    vec2 gradient;   // of that plane
    vec2 centre;
    float toTexel;   // from the centre to the centres of the outermost texels
};

Window unpackWindow(uvec4 texel, vec2 firstBlock, float blocks) {
    Window window;
    window.maxS = uintBitsToFloat(texel.r);
    window.minS = uintBitsToFloat(texel.g);
    window.planeS = uintBitsToFloat(texel.a);
    window.gradient = unpackGradient(texel.b);
    window.centre = (firstBlock + 0.5 * blocks) * pyramidBlockTexels;
    window.toTexel = 0.5 * blocks * pyramidBlockTexels - 0.5;
    return window;
}

// Few windows that together cover a rectangle, overlapping: 2 x 2 of a square one, at most 4 along
// a side of any; 2^finer times as many along each side.
struct Windows {
    ivec2 first, last;  // blocks
    ivec2 count;
    int level, blocks;  // of a window, across
};

// `lo` to `hi` texels of a map of `mapSize`, a part of which is inside.
Windows windowsOver(vec2 lo, vec2 hi, int mapSize, int finer) {
    Windows w;
    w.first = ivec2(max(lo, 0.0) / pyramidBlockTexels);
    w.last = ivec2(min(hi, float(mapSize) - 0.5) / pyramidBlockTexels);
    ivec2 blocks = w.last - w.first + 1;
    w.level = max(findMSB(min(blocks.x, blocks.y)), findMSB(max(blocks.x, blocks.y) - 1) - 1);
    w.level = clamp(w.level - finer, 0, pyramidLevels - 1);
    w.blocks = 1 << w.level;
    w.count = (blocks + w.blocks - 1) >> w.level;
    return w;
}

Window windowAt(Windows w, ivec2 index, int tile) {
    ivec2 first = min(w.first + index * w.blocks, w.last - w.blocks + 1);
    first = clamp(first, 0, pyramidBlocks - w.blocks);
    uvec4 texel = texelFetch(pyramid, ivec3(first, tile * pyramidLevels + w.level), 0);
    return unpackWindow(texel, vec2(first), float(w.blocks));
}
#endif
