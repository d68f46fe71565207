// What Dear ImGui draws: triangles in pixels from the top left corner, coloured and textured.
#ifdef STAGE_VERTEX
layout(location = 0) in vec2 at;
layout(location = 1) in vec2 textureAt;
layout(location = 2) in vec4 colour;
uniform vec4 toClip;  // scale and offset
out vec2 uv;
out vec4 tint;
void main() {
    uv = textureAt;
    tint = colour;
    gl_Position = vec4(at * toClip.xy + toClip.zw, 0.0, 1.0);
}
#endif

#ifdef STAGE_FRAGMENT
layout(binding = 0) uniform sampler2D image;
in vec2 uv;
in vec4 tint;
layout(location = 0) out vec4 pixel;
void main() {
    pixel = tint * texture(image, uv);
}
#endif
