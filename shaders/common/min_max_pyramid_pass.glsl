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
    for (int y = first.y; y <= last.y; y += 2)
        for (int x = first.x; x <= last.x; x += 8)
            for (int i = 0; i < 8; i += 2) {  // of constant length: unrolled
                // Four texels, (0, 1), (1, 1), (1, 0), (0, 0), for little more than one is. At the
                // map's border the last ones come again.
                vec2 corner = vec2(min(ivec2(x + i, y), last));
                vec2 next = min(corner + 1.0, vec2(last)) - centre;
                vec2 at = corner - centre;
                vec4 s = textureGather(shadowMap, vec3((corner + 1.0) / float(mapSize), layer));
                vec2 high = max(s.xy, s.wz), low = min(s.xy, s.wz);
                maxS = max(maxS, max(high.x, high.y));
                minS = min(minS, min(low.x, low.y));
                vec2 column = perTexel.x * vec2(at.x, next.x);
                vec2 above = max(s.wz - perTexel.y * at.y, s.xy - perTexel.y * next.y) - column;
                planeS = max(planeS, max(above.x, above.y));
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
