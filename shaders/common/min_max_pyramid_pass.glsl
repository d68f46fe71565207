// The min/max pyramid, level by level: core/passes/min_max_pyramid.hpp.
#include "common/fullscreen.glsl"
#include "common/min_max_pyramid.glsl"

#ifdef STAGE_FRAGMENT
uniform int layer;  // of the map, or of the pyramid's level below
layout(location = 0) out uvec4 bounds;

uvec4 packWindow(float maxS, float minS, uint gradient, float planeS) {
    return uvec4(floatBitsToUint(vec2(maxS, minS)), gradient, floatBitsToUint(planeS));
}

#ifdef PASS_BASE
layout(binding = 0) uniform sampler2DArray shadowMap;
uniform int mapSize;

float mapS(ivec2 texel) {
    return texelFetch(shadowMap, ivec3(texel, layer), 0).r;
}

void main() {
    int side = int(pyramidBlockTexels);
    ivec2 first = ivec2(gl_FragCoord.xy) * side;
    ivec2 last = min(first + side, ivec2(mapSize)) - 1;
    // The mean slope between the corners: exact where the block is one plane.
    float s00 = mapS(first), s11 = mapS(last);
    float s10 = mapS(ivec2(last.x, first.y)), s01 = mapS(ivec2(first.x, last.y));
    vec2 difference = 0.5 * vec2(s10 + s11 - s00 - s01, s01 + s11 - s00 - s10);
    uint gradient = packGradient(difference / max(vec2(last - first), 1.0));
    vec2 perTexel = unpackGradient(gradient);

    vec2 centre = vec2(first) + 0.5 * pyramidBlockTexels - 0.5;
    float maxS = s00, minS = s00, planeS = -1.0;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; x += 8)
            for (int i = 0; i < 8; ++i) {  // of constant length: unrolled
                ivec2 texel = ivec2(min(x + i, last.x), y);
                float s = mapS(texel);
                maxS = max(maxS, s);
                minS = min(minS, s);
                planeS = max(planeS, s - dot(perTexel, vec2(texel) - centre));
            }
    bounds = packWindow(maxS, minS, gradient, planeS);
}
#else
uniform int childBlocks;  // across a window of the level below

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy);
    Window children[4];
    uint gradients[4];
    float maxS = 0.0, minS = 1.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 block = first + ivec2(i & 1, i >> 1) * childBlocks;
        uvec4 texel = texelFetch(pyramid, ivec3(block, layer), 0);
        children[i] = unpackWindow(texel, vec2(block), float(childBlocks));
        gradients[i] = texel.b;
        maxS = max(maxS, children[i].maxS);
        minS = min(minS, children[i].minS);
    }
    // Of the children's own slopes the one under which the plane is lowest: a child across an edge
    // has a slope that fits nobody. Child and plane are affine, so their distance is greatest at a
    // corner of the child's texels.
    vec2 centre = (vec2(first) + float(childBlocks)) * pyramidBlockTexels;
    float planeS = 1e30;
    uint gradient = 0u;
    for (int g = 0; g < 4; ++g) {
        vec2 slope = children[g].gradient;
        float height = -1e30;
        for (int i = 0; i < 4; ++i) {
            Window child = children[i];
            vec2 tilt = abs(child.gradient - slope);
            height = max(height, child.planeS + child.toTexel * (tilt.x + tilt.y) -
                                     dot(slope, child.centre - centre));
        }
        if (height < planeS) {
            planeS = height;
            gradient = gradients[g];
        }
    }
    bounds = packWindow(maxS, minS, gradient, planeS);
}
#endif
#endif
