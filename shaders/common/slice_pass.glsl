// Casters into occlusion textures (core/passes/slice_pass.hpp).
const int kLayers = (SLICES + 3) / 4;

#ifdef STAGE_VERTEX
layout(location = 0) in vec3 position;
layout(binding = 1) uniform sampler2D fillDepths;  // of vertices
uniform mat4 clipFromWorld;
uniform vec4 depthRow;  // world to depth below the light, metres
uniform float deepestM; // below it no slice is used
uniform int fill;       // 0 none, 1 down to fillDepths, 2 always
out float depthM;
flat out float fillToM;
flat out int nearSlice;  // of one corner: where the search begins
uniform float boundariesM[SLICES + 1];
#ifdef ALPHA_MASK
layout(location = 1) in vec2 texCoord;
out vec2 uv;
#endif
void main() {
    gl_Position = clipFromWorld * vec4(position, 1.0);
    depthM = dot(depthRow, vec4(position, 1.0));
    gl_ClipDistance[0] = deepestM - depthM;
    nearSlice = 0;
    for (int i = 1; i <= SLICES; ++i) nearSlice += int(depthM >= boundariesM[i]);
    fillToM = fill == 2 ? 3.402823466e38 : 0.0;
    if (fill == 1) {
        int width = textureSize(fillDepths, 0).x;
        fillToM = texelFetch(fillDepths, ivec2(gl_VertexID % width, gl_VertexID / width), 0).r;
    }
#ifdef ALPHA_MASK
    uv = texCoord;
#endif
}
#endif

#ifdef STAGE_FRAGMENT
in float depthM;
flat in float fillToM;
flat in int nearSlice;
uniform float boundariesM[SLICES + 1];
uniform int place[SLICES];  // in the textures; -1: nothing is drawn into that slice
#ifdef ALPHA_MASK
#include "common/alpha.glsl"
in vec2 uv;
#endif
#ifdef SLICES_AS_BITS
layout(location = 0) out uvec4 bits;
#else
layout(location = 0) out vec4 slices[kLayers];
#endif

// A slice has what lies between its boundaries and, where the caster is filled, what the slice
// above it has.
void main() {
#ifdef ALPHA_MASK
    if (!alphaPasses(uv)) discard;
#endif
    int slice = nearSlice;
    while (slice < SLICES && depthM >= boundariesM[slice + 1]) ++slice;
    while (slice > 0 && depthM < boundariesM[slice]) --slice;
    int filled = slice + 1 < SLICES && fillToM > boundariesM[slice + 1] ? slice + 1 : slice;
    int at = slice < SLICES ? place[slice] : -1, alsoAt = slice < SLICES ? place[filled] : -1;
#ifdef SLICES_AS_BITS
    bits = uvec4(0u);
    for (int w = 0; w < (SLICES + 31) / 32; ++w) {
        if (at >> 5 == w) bits[w] |= 1u << (at & 31);
        if (alsoAt >> 5 == w) bits[w] |= 1u << (alsoAt & 31);
    }
#else
    for (int i = 0; i < kLayers; ++i) {
        ivec4 own = 4 * i + ivec4(0, 1, 2, 3);
        slices[i] = max(vec4(equal(own, ivec4(at))), vec4(equal(own, ivec4(alsoAt))));
    }
#endif
}
#endif

#ifdef STAGE_COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform usampler2D packedSlices;
layout(binding = 0, rgba8) writeonly uniform image2DArray unpackedSlices;
void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, imageSize(unpackedSlices).xy))) return;
    uvec4 bits = texelFetch(packedSlices, at.xy, 0);
    vec4 slices;
    for (int c = 0; c < 4; ++c) {
        int i = 4 * at.z + c;
        slices[c] = float((bits[i >> 5] >> (i & 31)) & 1u);
    }
    imageStore(unpackedSlices, at, slices);
}
#endif
