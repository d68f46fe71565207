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
layout(std430, binding = 0) readonly buffer Edges { Edge edges[]; };
layout(binding = 0) uniform sampler2DArray shadowMap;  // PASS_QUADS: the map that quads fall upon
uniform vec3 lightCentre;
uniform mat3 lightAxes;   // world to light: rows u, v, normal
uniform vec4 tangents;    // of the view: tangentLo, 1 / tangentSize
uniform float nearM;
uniform float nearer;     // a surface is nearer than another where its s exceeds it by this factor
uniform int mapSize;

const uint kNone = 0xffffffffu;

vec2 placeInMap(vec3 p) { return (p.xy / p.z - tangents.xy) * tangents.zw * float(mapSize); }

bool inMap(ivec2 texel) {
    return all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(mapSize)));
}
#endif

#ifdef PASS_EDGES
// One edge each: its number and on which side its faces lie, if the light's centre sees it as a
// silhouette. Listed in any order, or (ORDERED) in the edges' own with gaps.
layout(local_size_x = 64) in;
layout(std430, binding = 1) writeonly buffer Silhouettes { uint silhouettes[]; };
layout(std430, binding = 2) buffer Draw { uint vertexCount, instanceCount, first, baseInstance; };
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

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= uint(edgeCount)) return;
    Edge edge = edges[index];
    int bits = int(edge.a.w);
    bool first = onNegativeSide(edge.planes[0], (bits & 1) != 0);
    bool second = onNegativeSide(edge.planes[1], (bits & 2) != 0);
    bool listed = first == second;
    if (listed) {
        vec3 a = lightAxes * (edge.a.xyz - lightCentre), b = lightAxes * (edge.b.xyz - lightCentre);
        vec2 normal = cross(a, b).xy;
        listed = normal != vec2(0.0) && max(a.z, b.z) > 0.0;
#ifdef INNER_SEEN
        listed = listed && !hidden(a, b, first ? normal : -normal);
#endif
    }
    uint entry = 2u * index + (first ? 1u : 0u);
#ifdef ORDERED
    silhouettes[index] = listed ? entry : kNone;
    if (index == 0u) vertexCount = 12u * uint(edgeCount);
#else
    if (listed) silhouettes[atomicAdd(vertexCount, 12u) / 12u] = entry;
#endif
}
#endif

#ifdef PASS_QUADS
// Six points an edge: its ends a and b, which stay; where the edge's own support point of the light
// takes them; and where their stretching normals' support points do, so that the quads of two edges
// meet at the vertex they share (STRETCH_AVERAGED: those alone, as in the paper).
#ifdef STAGE_VERTEX
layout(std430, binding = 1) readonly buffer Silhouettes { uint silhouettes[]; };
uniform mat4 clipFromWorld;
uniform vec2 lightHalfM;
uniform float direction;  // 1: outer quads, -1: inner ones
uniform float farM;       // depth of the farthest receiver

out float across;         // 0 at the silhouette, 1 at the moved edge
flat out float narrow;    // the lesser over both half widths of the light across the edge
flat out uint piece;
#ifdef INNER_SEEN
out vec4 beside;          // a texel and a half beyond the edge in the map: clip coordinates
#endif

const int kRoles[12] = int[](0, 2, 1, 0, 1, 4, 0, 4, 5, 5, 4, 3);  // a, b's the other way round

// Point of the light farthest along n: a corner, the middle of a side, the centre.
vec2 supportPoint(vec2 n) {
    const float kStraight = 1e-4;
    return lightHalfM * vec2(abs(n.x) > kStraight ? sign(n.x) : 0.0,
                             abs(n.y) > kStraight ? sign(n.y) : 0.0);
}

// What of a light point's offset a vertex in depth zM moves by, its penumbra falling on what is
// beside it: (1/zA - 1/zr) zA, METHODS.md 14.
float stretchTo(vec3 p, vec2 offset) {
    float s = 0.0;
#ifdef RECEIVER_VERTEX
    // One texel and a half beside the vertex, to be off the caster's own rim.
    vec2 uvOffset = offset * tangents.zw;
    ivec2 texel = ivec2(floor(placeInMap(p) + 1.5 * uvOffset / max(length(uvOffset), 1e-30)));
    if (p.z > 0.0 && inMap(texel)) s = texelFetch(shadowMap, ivec3(texel, 0), 0).r;
    // The caster itself, or what hides it: no receiver of this edge's penumbra.
    if (s * nearer > nearM / p.z) s = 0.0;
#endif
    return clamp(1.0 - p.z * max(s / nearM, 1.0 / farM), 0.0, 1.0);
}

void main() {
    uint entry = silhouettes[gl_VertexID / 12];
    gl_Position = vec4(2.0, 0.0, 0.0, 1.0);  // outside: the whole quad goes
    if (entry == kNone) return;
    Edge edge = edges[entry / 2u];
    int role = kRoles[gl_VertexID % 12];
    piece = floatBitsToUint(edge.b.w);
    vec3 a = lightAxes * (edge.a.xyz - lightCentre), b = lightAxes * (edge.b.xyz - lightCentre);
    // Of the edge as the light sees it, on any plane before it, away from the faces.
    vec2 normal = normalize(cross(a, b).xy) * ((entry & 1u) != 0u ? 1.0 : -1.0);

    vec3 from = role < 3 ? a : b;
    vec3 stretch = lightAxes * (role < 3 ? edge.stretchA.xyz : edge.stretchB.xyz);
    // What of it is across the light. Exactly the silhouette's normal where the stretching normal is
    // at right angles to the ray, as on smooth casters, and on edges parallel to the light.
    vec2 m = stretch.xy;
    float mLength = length(m);
    m = mLength > 1e-6 ? m / mLength : vec2(0.0);
    if (dot(m, normal) < 0.0) m = -m;  // a sheet's normals may point either way

#ifdef INNER_SEEN
    beside = clipFromWorld * vec4(lightCentre + from * lightAxes, 1.0);
    // The edge's normal in texels, which the tile may stretch.
    beside.xy += 3.0 / float(mapSize) * normalize(normal / tangents.zw) * beside.w;
#endif

    vec2 offset = vec2(0.0);
    int part = role < 3 ? role : 5 - role;  // 0 stays, 1 the edge's, 2 the vertex's
#ifdef STRETCH_AVERAGED
    if (part > 0) offset = dot(lightHalfM, abs(m)) * m;
#else
    // An edge along one of the light's sides has two farthest corners: the vertex's normal chooses.
    const float kStraight = 1e-4;
    vec2 own = vec2(abs(normal.x) > kStraight ? normal.x : m.x, abs(normal.y) > kStraight ? normal.y : m.y);
    if (part == 1 || (part == 2 && m == vec2(0.0))) offset = supportPoint(own);
    else if (part == 2) offset = supportPoint(m);
#endif
    across = part > 0 ? 1.0 : 0.0;
    if (part > 0) {
        from.xy += direction * stretchTo(from, direction * offset) * offset;
    }
    vec2 halves = lightHalfM * abs(normal);
    narrow = min(halves.x, halves.y) / max(halves.x + halves.y, 1e-30);
    gl_Position = clipFromWorld * vec4(lightCentre + from * lightAxes, 1.0);
}
#endif

#ifdef STAGE_FRAGMENT
layout(binding = 0) uniform sampler2DArray shadowMap;
layout(binding = 1) uniform usampler2D pieceMap;
uniform float direction;
uniform float farM;
uniform float nearM;
uniform float nearer;

in float across;
flat in float narrow;
flat in uint piece;
#ifdef INNER_SEEN
layout(binding = 2) uniform sampler2DArray firstMap;
in vec4 beside;

// Whether light that passes the edge beside this fragment may go as deep as `surface`: it may not
// where something hides the edge, nor where the caster's own lower parts lie just past it. Slopes of
// the receiver are let pass: a quarter of the way up from it to the edge.
bool edgeOpensTo(float surface) {
    ivec2 size = textureSize(firstMap, 0).xy;
    ivec2 texel = ivec2(floor((0.5 + 0.5 * beside.xy / beside.w) * vec2(size)));
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size))) return true;
    return texelFetch(firstMap, ivec3(texel, 0), 0).r <= mix(surface, gl_FragCoord.z, 0.25);
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
    float s = gl_FragCoord.z, surface = texelFetch(shadowMap, ivec3(gl_FragCoord.xy, 0), 0).r;
    // Hidden from what the map shows; or nothing there to fall upon.
    if (surface == 0.0 || s <= surface * nearer) discard;
#ifdef INNER_PIECES
    if (direction < 0.0 && texelFetch(pieceMap, ivec2(gl_FragCoord.xy), 0).r != piece) discard;
#endif
#ifdef INNER_SEEN
    if (direction < 0.0 && !edgeOpensTo(surface)) discard;
#endif
    float t = across;
#ifdef RECEIVER_TEXEL
    // Stretched to the farthest receiver, the quad holds the penumbra on every nearer one.
    t *= (s - nearM / farM) / (s - surface);
#endif
    visibility = profile(min(t, 1.0));
    if (direction < 0.0) visibility = 1.0 - visibility;
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

// Section 4.4 at one texel: (weighted visibility, weight). Nothing where the texel shows a surface
// farther from the light than the receiver's plane: its penumbra is not the receiver's.
vec2 combined(LightPoint point, ivec2 texel, float weight) {
    if (weight <= 0.0) return vec2(0.0);
    texel = clamp(texel, ivec2(0), ivec2(mapSize - 1));
    float rise = dot(point.gradient, (vec2(texel) + 0.5) / float(mapSize) - point.uv);
    float bound = (point.s + max(rise, 0.0)) * point.biasScale;
    float first = texelFetch(shadowMap, ivec3(texel, 0), 0).r;
    if (first <= bound) {
        const float kRimTexels = 4.0;
        float rim = 1.0 - kRimTexels / (float(mapSize) * min(tileTangents[0].z, tileTangents[0].w));
        if (first < (point.s + rise) * rim) return vec2(0.0);
        return vec2(texelFetch(penumbraMap, ivec3(texel, 0), 0).r, 1.0) * weight;
    }
    float second = texelFetch(secondMap, ivec3(texel, 0), 0).r;
    return vec2(second <= bound ? texelFetch(penumbraMap, ivec3(texel, 1), 0).r : 0.0, 1.0) * weight;
}

void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    visibility = 1.0;
    if (!point.inFront) return;
    vec2 place = point.uv * float(mapSize) - 0.5;
    ivec2 corner = ivec2(floor(place));
    vec2 hi = clamp((place - vec2(corner) - 0.5) / filterTexels + 0.5, 0.0, 1.0), lo = 1.0 - hi;
    vec2 sum = combined(point, corner, lo.x * lo.y) + combined(point, corner + ivec2(1, 0), hi.x * lo.y) +
               combined(point, corner + ivec2(0, 1), lo.x * hi.y) + combined(point, corner + 1, hi.x * hi.y);
    if (sum.y > 0.0) visibility = clamp(sum.x / sum.y, 0.0, 1.0);
}
#endif
#endif
