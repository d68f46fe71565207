// Penumbra quads (Arvo, Westerholm 2004). Passes: PASS_SECOND peels the second front-facing shadow
// map, PASS_PIECES numbers the pieces that back faces belong to, PASS_EDGES lists the silhouettes,
// PASS_QUADS draws one penumbra map of them, PASS_SHADE combines the four maps (section 4.4). Depths are s = nearM / z everywhere.

#if defined(PASS_SECOND) || defined(PASS_PIECES)
#ifdef STAGE_VERTEX
layout(location = 0) in vec3 position;
uniform mat4 clipFromWorld;
void main() { gl_Position = clipFromWorld * vec4(position, 1.0); }
#endif

#ifdef STAGE_FRAGMENT
#ifdef PASS_SECOND
layout(binding = 0) uniform sampler2DArray shadowMap;
uniform float behind;  // a surface is another one where its s is below this share of the first's
void main() {
    float first = texelFetch(shadowMap, ivec3(gl_FragCoord.xy, 0), 0).r;
    if (gl_FragCoord.z >= first * behind) discard;
}
#else
layout(std430, binding = 1) readonly buffer Pieces { uint pieces[]; };  // of faces
uniform int firstFace;
layout(location = 0) out uint piece;
void main() { piece = pieces[firstFace + gl_PrimitiveID]; }
#endif
#endif
#endif

#if defined(PASS_EDGES) || (defined(PASS_QUADS) && defined(STAGE_VERTEX))
// OutlineEdge of core/scene/edge_adjacency.hpp.
struct Edge {
    vec4 a, b;                // position; a.w: 2 bits, the faces run from a to b; b.w: piece
    vec4 stretchA, stretchB;  // stretching normals
    vec4 planes[2];           // (n, n.p) of the faces
};
struct Silhouette {
    uint entry;         // twice the edge's number, 1 more where its faces lie on the other side
    float farS[2];      // RECEIVER_TEXEL: no receiver that its outer, its inner quad may reach is farther
};
layout(std430, binding = 0) readonly buffer Edges { Edge edges[]; };
layout(binding = 0) uniform sampler2DArray shadowMap;  // PASS_QUADS: the map that quads fall upon
uniform vec3 lightCentre;
uniform mat3 lightAxes;   // world to light: rows u, v, normal
uniform vec4 tangents;    // of the view: tangentLo, 1 / tangentSize
uniform float nearM;
uniform float nearer;     // a surface is nearer than another where its s exceeds it by this factor
uniform int mapSize;
uniform vec2 lightHalfM;
uniform float farS;       // of the farthest receiver

const uint kNone = 0xffffffffu;

vec2 placeInMap(vec3 p) { return (p.xy / p.z - tangents.xy) * tangents.zw * float(mapSize); }

bool inMap(ivec2 texel) {
    return all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(mapSize)));
}

// A stretching normal across the light: exactly the silhouette's normal where it is at right angles
// to the ray, as on smooth casters, and on edges parallel to the light. 0 where it has no such part.
vec2 acrossLight(vec3 stretch, vec2 normal) {
    vec2 m = (lightAxes * stretch).xy;
    float mLength = length(m);
    m = mLength > 1e-6 ? m / mLength : vec2(0.0);
    return dot(m, normal) < 0.0 ? -m : m;  // a sheet's normals may point either way
}

const float kStraight = 1e-4;

// Point of the light farthest along n: a corner, the middle of a side, the centre.
vec2 supportPoint(vec2 n) {
    return lightHalfM * mix(vec2(0.0), sign(n), greaterThan(abs(n), vec2(kStraight)));
}

// Offset of the light point towards which a vertex moves: the edge's own one (part 1) or its
// stretching normal's (2).
vec2 lightOffset(int part, vec2 normal, vec2 m) {
#ifdef STRETCH_AVERAGED
    return dot(lightHalfM, abs(m)) * m;
#else
    // An edge along one of the light's sides has two farthest corners: the vertex's normal chooses.
    vec2 own = mix(m, normal, greaterThan(abs(normal), vec2(kStraight)));
    return supportPoint(part == 1 || m == vec2(0.0) ? own : m);
#endif
}
#endif

#ifdef PASS_EDGES
// One edge each: its number and on which side its faces lie, if the light's centre sees it as a
// silhouette. Listed in any order, or (ORDERED) in the edges' own with gaps.
layout(local_size_x = 64) in;
layout(std430, binding = 1) writeonly buffer Silhouettes { Silhouette silhouettes[]; };
layout(std430, binding = 2) buffer Draw { uint indexCount, instanceCount, firstIndex, baseVertex, baseInstance; };
uniform int edgeCount;

// Whether the face lies on the side that cross(a - C, b - C) points away from.
bool onNegativeSide(vec4 plane, bool forward) {
    return (dot(plane.xyz, lightCentre) > plane.w) == forward;
}

// Whether nearer surfaces hide the whole edge, a texel and a half beyond it and no farther than two
// texels from place to place. Long edges are not asked.
bool hidden(vec3 a, vec3 b, vec2 outward) {
    const int kMostPlaces = 17;
    if (min(a.z, b.z) <= 0.0) return false;
    float texels = length(placeInMap(b) - placeInMap(a));
    int steps = int(ceil(0.5 * texels)) + 1;
    if (steps >= kMostPlaces) return false;
    vec2 beyond = 1.5 * normalize(outward / tangents.zw);
    for (int i = 0; i <= steps; ++i) {
        // Even in the map, that is, in 1/z.
        float t = float(i) / float(steps);
        float inverseZ = mix(1.0 / a.z, 1.0 / b.z, t);
        ivec2 texel = ivec2(floor(mix(placeInMap(a), placeInMap(b), t) + beyond));
        if (!inMap(texel)) return false;
        if (texelFetch(shadowMap, ivec3(texel, 0), 0).r <= nearM * inverseZ * nearer) return false;
    }
    return true;
}

#ifdef RECEIVER_TEXEL
layout(binding = 1) uniform sampler2DArray farthestPyramid;  // core/passes/farthest_pyramid.hpp
uniform bool boundQuads;

// Least s of receivers in a box of the map, from four texels or fewer of the pyramid a side.
float farthestIn(vec2 lo, vec2 hi, int layer) {
    const float kBlockTexels = 8.0;
    ivec2 first = ivec2(max(lo, 0.0) / kBlockTexels);
    ivec2 last = ivec2(clamp(hi, vec2(-1.0), vec2(float(mapSize - 1))) / kBlockTexels);
    float least = 2.0;
    if (any(lessThan(hi, vec2(0.0)))) return least;
    int level = max(findMSB(max(last.x - first.x, last.y - first.y)) - 1, 0);
    first >>= level;
    last >>= level;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            least = min(least, texelFetch(farthestPyramid, ivec3(x, y, layer), level).r);
    return least;
}

// Least s of receivers that a quad may fall upon, `direction` 1 for outer, -1 for inner ones: of
// boxes along the edge, each as wide as the quad stretched to the farthest receiver of all.
float farthestReceiver(vec3 a, vec3 b, vec2 offsets[4], float direction) {
    vec2 widest[2] = vec2[](vec2(0.0), vec2(0.0));  // in texels
    for (int i = 0; i < 4; ++i) {
        float inverseZ = 1.0 / (i < 2 ? a.z : b.z);
        vec2 moved = direction * offsets[i] * max(inverseZ - farS / nearM, 0.0) * tangents.zw * float(mapSize);
        widest[0] = min(widest[0], moved);
        widest[1] = max(widest[1], moved);
    }
    vec2 from = placeInMap(a), along = placeInMap(b) - from;
    vec2 size = widest[1] - widest[0];
    const float kLeastTexels = 16.0;
    int boxes = clamp(int(length(along) / max(max(size.x, size.y), kLeastTexels)) + 1, 1, 16);
    float least = 2.0;
    for (int i = 0; i < boxes; ++i) {
        vec2 p = from + along * (float(i) / float(boxes)), q = from + along * (float(i + 1) / float(boxes));
        least = min(least, farthestIn(min(p, q) + widest[0] - 1.0, max(p, q) + widest[1] + 1.0,
                                      direction > 0.0 ? 0 : 1));
    }
    return least;
}
#endif

void main() {
    uint across = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    uint index = gl_GlobalInvocationID.y * across + gl_GlobalInvocationID.x;
    if (index >= uint(edgeCount)) return;
    Edge edge = edges[index];
    int bits = int(edge.a.w);
    bool first = onNegativeSide(edge.planes[0], (bits & 1) != 0);
    bool second = onNegativeSide(edge.planes[1], (bits & 2) != 0);
    bool listed = first == second;
    Silhouette silhouette;
    silhouette.entry = 2u * index + (first ? 1u : 0u);
    silhouette.farS[0] = silhouette.farS[1] = farS;
    if (listed) {
        vec3 a = lightAxes * (edge.a.xyz - lightCentre), b = lightAxes * (edge.b.xyz - lightCentre);
        vec2 normal = cross(a, b).xy;
        normal = first ? normal : -normal;
        listed = normal != vec2(0.0) && max(a.z, b.z) > 0.0;
#ifdef INNER_SEEN
        listed = listed && !hidden(a, b, normal);
#endif
#ifdef RECEIVER_TEXEL
        if (boundQuads && listed && min(a.z, b.z) > nearM) {
            normal = normalize(normal);
            vec2 ma = acrossLight(edge.stretchA.xyz, normal), mb = acrossLight(edge.stretchB.xyz, normal);
            vec2 offsets[4] = vec2[](lightOffset(1, normal, ma), lightOffset(2, normal, ma),
                                     lightOffset(1, normal, mb), lightOffset(2, normal, mb));
            float nearestS = nearM / min(a.z, b.z);
            listed = false;
            for (int i = 0; i < 2; ++i) {
                float receiverS = farthestReceiver(a, b, offsets, i == 0 ? 1.0 : -1.0);
                listed = listed || receiverS * nearer < nearestS;
                silhouette.farS[i] = max(receiverS, farS);
            }
        }
#endif
    }
#ifdef ORDERED
    if (!listed) silhouette.entry = kNone;
    silhouettes[index] = silhouette;
    if (index == 0u) indexCount = 12u * uint(edgeCount);
#else
    if (listed) silhouettes[atomicAdd(indexCount, 12u) / 12u] = silhouette;
#endif
}
#endif

#ifdef PASS_QUADS
// Six points an edge: its ends a and b, which stay; where the edge's own support point of the light
// takes them; and where their stretching normals' support points do, so that the quads of two edges
// meet at the vertex they share (STRETCH_AVERAGED: those alone, as in the paper).
#ifdef OUTER
const int kMap = 0;
const float kDirection = 1.0;
#else
const int kMap = 1;
const float kDirection = -1.0;
#endif

#ifdef STAGE_VERTEX
layout(std430, binding = 1) readonly buffer Silhouettes { Silhouette silhouettes[]; };
uniform mat4 clipFromWorld;
uniform float texelTangent;  // width of a texel over its depth

out float across;         // 0 at the silhouette; at the moved edge 1, RECEIVER_TEXEL: stretchTo
flat out float narrow;    // the lesser over both half widths of the light across the edge
#ifdef INNER
flat out uint piece;
#ifdef INNER_SEEN
out vec4 beside;          // a texel and a half beyond the edge in the map: clip coordinates
#endif
#endif

// What of a light point's offset a vertex moves by, its penumbra falling on what is in depth s:
// (1/zA - 1/zr) zA, METHODS.md 14.
float stretchTo(vec3 p, vec2 offset, float s) {
#ifdef RECEIVER_VERTEX
    // One texel and a half beside the vertex, to be off the caster's own rim.
    vec2 uvOffset = offset * tangents.zw;
    ivec2 texel = ivec2(floor(placeInMap(p) + 1.5 * uvOffset / max(length(uvOffset), 1e-30)));
    float beside = p.z > 0.0 && inMap(texel) ? texelFetch(shadowMap, ivec3(texel, 0), 0).r : 0.0;
    // Not the caster itself, or what hides it: no receiver of this edge's penumbra.
    if (beside * nearer <= nearM / p.z) s = max(s, beside);
#endif
    return clamp(1.0 - p.z * s / nearM, 0.0, 1.0);
}

void main() {
    Silhouette silhouette = silhouettes[gl_VertexID / 6];
    uint entry = silhouette.entry;
    gl_Position = vec4(2.0, 0.0, 0.0, 1.0);  // outside: the whole quad goes
    if (entry == kNone) return;
    Edge edge = edges[entry / 2u];
    int role = gl_VertexID % 6;
    vec3 a = lightAxes * (edge.a.xyz - lightCentre), b = lightAxes * (edge.b.xyz - lightCentre);
    // Of the edge as the light sees it, on any plane before it, away from the faces.
    vec2 fromAToB = normalize(cross(a, b).xy).yx * vec2(1.0, -1.0);
    vec2 normal = vec2(-fromAToB.y, fromAToB.x) * ((entry & 1u) != 0u ? 1.0 : -1.0);

    vec3 from = role < 3 ? a : b;
    vec2 m = acrossLight(role < 3 ? edge.stretchA.xyz : edge.stretchB.xyz, normal);

#ifdef INNER
    piece = floatBitsToUint(edge.b.w);
#ifdef INNER_SEEN
    beside = clipFromWorld * vec4(lightCentre + from * lightAxes, 1.0);
    // The edge's normal in texels, which the tile may stretch.
    beside.xy += 3.0 / float(mapSize) * normalize(normal / tangents.zw) * beside.w;
#endif
#endif

    int part = role < 3 ? role : 5 - role;  // 0 stays, 1 the edge's, 2 the vertex's
    vec2 offset = part > 0 ? lightOffset(part, normal, m) : vec2(0.0);
    float receiverS = silhouette.farS[kMap];
    float stretch = stretchTo(from, kDirection * offset, receiverS);
    across = part > 0 ? 1.0 : 0.0;
#ifdef RECEIVER_TEXEL
    across *= stretch;
    // Neighbours are stretched to other receivers: their sides lie on one line but end elsewhere,
    // and would round apart in places. They overlap instead.
    const float kOverlapTexels = 1.0 / 128.0;
    from.xy += (role < 3 ? -1.0 : 1.0) * kOverlapTexels * texelTangent * max(from.z, 0.0) * fromAToB;
#endif
    from.xy += kDirection * stretch * offset;
    vec2 halves = lightHalfM * abs(normal);
    narrow = min(halves.x, halves.y) / max(halves.x + halves.y, 1e-30);
    gl_Position = clipFromWorld * vec4(lightCentre + from * lightAxes, 1.0);
}
#endif

#ifdef STAGE_FRAGMENT
layout(binding = 0) uniform sampler2DArray shadowMap;
layout(binding = 1) uniform usampler2D pieceMap;
uniform float nearer;

in float across;
flat in float narrow;
#ifdef INNER
flat in uint piece;
#endif
#if defined(INNER) && defined(INNER_SEEN)
layout(binding = 2) uniform sampler2DArray firstMap;
in vec4 beside;

// Whether light that passes the edge beside this fragment may go as deep as `surface`: it may not
// where something hides the edge, nor where the caster's own lower parts lie just past it. Slopes of
// the receiver are let pass: a quarter of the way up from it to the edge.
bool edgeOpensTo(float surface, float s) {
    ivec2 size = textureSize(firstMap, 0).xy;
    ivec2 texel = ivec2(floor((0.5 + 0.5 * beside.xy / beside.w) * vec2(size)));
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size))) return true;
    return texelFetch(firstMap, ivec3(texel, 0), 0).r <= mix(surface, s, 0.25);
}
#endif
layout(location = 0) out float visibility;

// Share of a rectangular light beyond a line at `t` half widths from its centre: a linear ramp with
// rounded ends, `narrow` of the whole width each (0 for a line along a side).
float profile(float t) {
#ifdef PROFILE_LINEAR
    return 0.5 + 0.5 * t;
#else
    // Density 1 / (2 - 2 narrow) in the middle, falling to 0 over 2 narrow at each end.
    float bend = 1.0 - 2.0 * narrow, whole = 2.0 * (1.0 - narrow);
    if (t <= bend) return 0.5 + t / whole;
    float rest = 1.0 - t;
    return 1.0 - rest * rest / (4.0 * narrow * whole);
#endif
}

void main() {
    float s = gl_FragCoord.z * nearer, surface = texelFetch(shadowMap, ivec3(gl_FragCoord.xy, 0), 0).r;
    float t = across;
#ifdef RECEIVER_TEXEL
    // Stretched to the farthest receiver, the quad holds the penumbra on every nearer one. What it
    // moved by is affine over it, what this receiver's penumbra would have is stretchTo.
    t *= s / (s - surface);
#endif
    if (surface == 0.0 || t >= 1.0) discard;  // nothing to fall upon; the maps are cleared to this
#ifdef INNER
#ifdef INNER_PIECES
    if (texelFetch(pieceMap, ivec2(gl_FragCoord.xy), 0).r != piece) discard;
#endif
#ifdef INNER_SEEN
    if (!edgeOpensTo(surface, s)) discard;
#endif
    visibility = 1.0 - profile(t);
#else
    visibility = profile(t);
#endif
}
#endif
#endif

#ifdef PASS_SHADE
#include "common/receiver.glsl"
#include "common/light_view.glsl"
#ifdef STAGE_FRAGMENT
layout(binding = 1) uniform sampler2DArray secondMap;
layout(binding = 2) uniform sampler2DArray penumbraMap;  // outer, inner
uniform float filterTexels;                              // width of the box filter, at most 1

// Section 4.4 at the four texels around the receiver. Texels that show a surface farther from the
// light than the receiver's plane have no weight: their penumbra is not the receiver's.
void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    visibility = 1.0;
    if (!point.inFront) return;
    float size = float(mapSize);
    vec2 place = point.uv * size - 0.5;
    vec2 corner = clamp(floor(place), vec2(-1.0), vec2(size - 1.0));
    vec2 hi = clamp((place - corner - 0.5) / filterTexels + 0.5, 0.0, 1.0), lo = 1.0 - hi;
    // As textureGather orders them. Past the map's border its outermost texels stand for others.
    vec4 weight = vec4(lo.x * hi.y, hi.x * hi.y, hi.x * lo.y, lo.x * lo.y);
    vec3 between = vec3((corner + 1.0) / size, 0.0);
    vec4 first = textureGather(shadowMap, between);
    vec4 second = textureGather(secondMap, between);
    vec4 outer = textureGather(penumbraMap, between);
    vec4 inner = textureGather(penumbraMap, between + vec3(0.0, 0.0, 1.0));

    vec2 from = corner + 0.5 - point.uv * size, slope = point.gradient / size;
    vec4 rise = slope.x * (from.x + vec4(0.0, 1.0, 1.0, 0.0)) + slope.y * (from.y + vec4(1.0, 1.0, 0.0, 0.0));
    vec4 bound = (point.s + max(rise, 0.0)) * point.biasScale;
    const float kRimTexels = 4.0;
    float rim = 1.0 - kRimTexels / (size * min(tileTangents[0].z, tileTangents[0].w));
    weight *= vec4(greaterThanEqual(first, (point.s + rise) * rim));
    vec4 v = mix(mix(vec4(0.0), inner, lessThanEqual(second, bound)), outer, lessThanEqual(first, bound));
    float sum = dot(weight, vec4(1.0));
    if (sum > 0.0) visibility = clamp(dot(weight, v) / sum, 0.0, 1.0);
}
#endif
#endif
