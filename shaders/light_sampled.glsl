#ifdef UNDECIDED_TILES  // PASS_ALL, in tiles that are not lit
#include "common/pixel_classes.glsl"
#else
#include "common/receiver.glsl"
#endif

#ifdef STAGE_FRAGMENT
#ifdef PASS_RESOLVE
layout(binding = 0) uniform sampler2D sum;
uniform float totalWeight;
#else
#include "common/light_maps.glsl"
#endif

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
#if defined(PASS_ONE_MAP)  // the method `hard`
    LightPoint point = lightPoint(position, normal);
    visibility = point.inFront ? litAt(point, point.uv) : 1.0;
#elif defined(PASS_ALL)  // the maps in the array are all there are
    visibility = litSum(position, normal) / lightSampleWeight;
#elif defined(PASS_ADD)  // blended onto the sum
    visibility = litSum(position, normal);
#elif defined(PASS_RESOLVE)
    visibility = texelFetch(sum, ivec2(gl_FragCoord.xy), 0).r / totalWeight;
#endif
}
#endif
