// Casters into a shadow map; the depth written is near / z (core/frame/light_view.hpp).
#ifdef STAGE_VERTEX
layout(location = 0) in vec3 position;
uniform mat4 clipFromWorld;
#ifdef ALPHA_MASK
layout(location = 1) in vec2 texCoord;
out vec2 uv;
#endif
void main() {
    gl_Position = clipFromWorld * vec4(position, 1.0);
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
