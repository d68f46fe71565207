// What shade passes are measured against: per pixel one bare compare fetch from each of the first
// `fetches` layers of the map, a few texels apart.
#include "common/receiver.glsl"
#include "common/light_view.glsl"
#ifdef STAGE_FRAGMENT
uniform int fetches;

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    vec2 place = point.uv * float(mapSize);
    float lit = 0.0;
    for (int i = 0; i < fetches; ++i) {
        ivec3 texel = ivec3(place + vec2(i & 7, i >> 3), i);
        lit += texelFetch(shadowMap, texel, 0).r <= point.s ? 1.0 : 0.0;
    }
    visibility = lit / float(fetches);
}
#endif
