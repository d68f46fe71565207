// Casters into a shadow map; the depth written is near / z (core/frame/light_view.hpp).
#ifdef STAGE_VERTEX
layout(location = 0) in vec3 position;
uniform mat4 clipFromWorld;
uniform float rasterSteps;  // PartDraw::rasterSteps
#ifdef ALPHA_MASK
layout(location = 1) in vec2 texCoord;
out vec2 uv;
#endif

vec4 onRaster(vec4 clip) {
    float steps = 0.5 * rasterSteps;
    if (steps == 0.0) return clip;
    return vec4(round(clip.xy / clip.w * steps) / steps * clip.w, clip.zw);
}

void main() {
    gl_Position = onRaster(clipFromWorld * vec4(position, 1.0));
#ifdef ALPHA_MASK
    uv = texCoord;
#endif
}
#endif

#ifdef STAGE_FRAGMENT
#ifdef ALPHA_MASK
#include "common/alpha.glsl"
in vec2 uv;
void main() {
    if (!alphaPasses(uv)) discard;
}
#else
void main() {}
#endif
#endif
