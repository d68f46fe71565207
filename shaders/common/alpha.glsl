// The alpha test of a masked material, as baseColorAt in core/scene/material.cpp states it for the
// CPU: opaque where texture alpha times factor reaches the cutoff, absent elsewhere. Base level
// only, so that no renderer minifies. GpuGeometry::draw sets the uniforms and texture unit 0.

layout(binding = 0) uniform sampler2D alphaTexture;
uniform int alphaMasked;
uniform float alphaCutoff;
uniform float alphaFactor;

bool alphaPasses(vec2 uv) {
    if (alphaMasked == 0) return true;
    return textureLod(alphaTexture, uv, 0.0).a * alphaFactor >= alphaCutoff;
}
