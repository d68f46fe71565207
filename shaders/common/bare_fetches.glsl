// What shade passes are measured against: fetches, their places and their sum, and nothing else.
#include "common/receiver.glsl"
#include "common/light_view.glsl"
#ifdef STAGE_FRAGMENT
#ifdef SIDE
// SIDE^2 fetches spread evenly over the pyramid from the receiver to the light, cut at the nearest
// caster: of the map's nearest texel, of the texture unit's comparison (FETCH_COMPARE) or of an
// integer summed-area table (FETCH_TABLE). Where the method's own answer is below 1, as many again
// up to LOOKS times, and FILTER_SIDE^2 more; each time half as far, for penumbrae are narrower than
// what is searched for them, and the same fetches again would be optimized away. With ROOFLINE there
// are no receivers: neighbouring pixels look at neighbouring texels, all over the map.
uniform vec2 lightHalfM;
uniform float casterNearM, widest;  // in no case more than so many sizes of the light

#if defined(FETCH_TABLE)
#define SUM uvec2
layout(binding = 1) uniform usampler2DArray summedAreas;
SUM fetched(vec2 texel, LightPoint point) {
    return texelFetch(summedAreas, ivec3(texel, point.tile), 0).rg;
}
#elif defined(FETCH_COMPARE)
#define SUM float
layout(binding = 1) uniform sampler2DArrayShadow comparedMap;
SUM fetched(vec2 texel, LightPoint point) {
    return texture(comparedMap, vec4(texel / float(mapSize), point.tile, point.s));
}
#else
#define SUM float
SUM fetched(vec2 texel, LightPoint point) {
    return texelFetch(shadowMap, ivec3(texel, point.tile), 0).r;
}
#endif

void look(inout SUM sum, LightPoint point, vec2 middle, vec2 halfTexels, const int side) {
    vec2 apart = 2.0 / float(side) * halfTexels;
    vec2 first = middle - halfTexels + 0.5 * apart;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) sum += fetched(first + apart * vec2(i, j), point);
}

#ifdef ROOFLINE
uniform float texelsPerPixel;

void main() {
    LightPoint point;
    point.tile = 0;
    point.s = 0.5;
    const vec2 halfTexels = vec2(SIDE);
    SUM sum = SUM(0);
    look(sum, point, halfTexels + texelsPerPixel * gl_FragCoord.xy, halfTexels, SIDE);
    visibility = dot(vec2(sum), vec2(1.0));
}
#else
layout(binding = 3) uniform sampler2D answer;

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    vec2 middle = point.uv * float(mapSize);
    float lights = min(point.zM / casterNearM - 1.0, widest);
    vec2 halfTexels =
        lights * lightHalfM / point.zM * tileTangents[point.tile].zw * float(mapSize);
    SUM sum = SUM(0);
    bool dimmed = texelFetch(answer, ivec2(gl_FragCoord.xy), 0).r < 1.0;
    // The way out is at the end: software renderers run a loop's body once for nobody, too.
    for (int looks = 1;; ++looks) {
        look(sum, point, middle, halfTexels, SIDE);
        if (!dimmed || looks == LOOKS) break;
        halfTexels *= 0.5;
    }
#ifdef FILTER_SIDE
    if (dimmed) look(sum, point, middle, 0.5 * halfTexels, FILTER_SIDE);
#endif
    visibility = dot(vec2(sum), vec2(1.0));
}
#endif
#else
// One compare fetch from each of the first `fetches` layers of the map, a few texels apart.
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
#endif
