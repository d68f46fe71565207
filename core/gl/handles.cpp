#include "core/gl/handles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace penumbra::gl {
namespace {

/// Storage per texel as laid out by the formats' definition; what a driver pads is not counted.
int bytesPerTexel(GLenum internalFormat) {
    switch (internalFormat) {
        case GL_R8:
        case GL_R8UI:
            return 1;
        case GL_R16:
        case GL_R16F:
        case GL_R16UI:
        case GL_RG8:
        case GL_DEPTH_COMPONENT16:
            return 2;
        case GL_R32F:
        case GL_R32I:
        case GL_R32UI:
        case GL_RG16:
        case GL_RG16F:
        case GL_RG16UI:
        case GL_RGBA8:
        case GL_SRGB8_ALPHA8:
        case GL_RGB10_A2:
        case GL_R11F_G11F_B10F:
        case GL_DEPTH_COMPONENT24:
        case GL_DEPTH_COMPONENT32F:
            return 4;
        case GL_RG32F:
        case GL_RG32I:
        case GL_RG32UI:
        case GL_RGBA16:
        case GL_RGBA16F:
        case GL_RGBA16UI:
            return 8;
        case GL_RGBA32F:
        case GL_RGBA32I:
        case GL_RGBA32UI:
            return 16;
        default:
            throw std::logic_error(fmt::format(
                "gl::Texture: internal format {:#x} is not in the table of sizes", internalFormat));
    }
}

void requireAtMost(GLenum limitName, const char* what, int value) {
    GLint limit = 0;
    glGetIntegerv(limitName, &limit);
    if (value > limit)
        throw std::runtime_error(
            fmt::format("a texture of {} {} is more than this renderer's {}", value, what, limit));
}

void setNearestClamped(GLuint texture) {
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

}  // namespace

Buffer Buffer::create(std::size_t bytes, const void* data, GLbitfield flags) {
    // Zero-sized storage is an error in OpenGL, and an empty scene is none.
    constexpr std::size_t kLeastBytes = 4;
    const bool tooSmall = bytes < kLeastBytes;
    GLuint id = 0;
    glCreateBuffers(1, &id);
    Buffer buffer(id);
    buffer.bytes_ = bytes;
    if (tooSmall) flags |= GL_DYNAMIC_STORAGE_BIT;  // filled below: `data` is shorter than storage
    glNamedBufferStorage(id, static_cast<GLsizeiptr>(std::max(bytes, kLeastBytes)),
                         tooSmall ? nullptr : data, flags);
    if (tooSmall && data && bytes > 0)
        glNamedBufferSubData(id, 0, static_cast<GLsizeiptr>(bytes), data);
    return buffer;
}

Texture Texture::create2D(GLenum internalFormat, int width, int height, int levels) {
    return create(internalFormat, width, height, 0, levels);
}

Texture Texture::createArray(GLenum internalFormat, int width, int height, int layers, int levels) {
    if (layers < 1) throw std::logic_error("gl::Texture: an array needs at least one layer");
    return create(internalFormat, width, height, layers, levels);
}

Texture Texture::create(GLenum internalFormat, int width, int height, int layers, int levels) {
    if (width < 1 || height < 1 || levels < 1)
        throw std::logic_error(
            fmt::format("gl::Texture: bad size {} x {}, {} levels", width, height, levels));
    bytesPerTexel(internalFormat);  // throws for a format that mebibytes() could not answer for
    requireAtMost(GL_MAX_TEXTURE_SIZE, "texels across", std::max(width, height));
    if (layers > 0) requireAtMost(GL_MAX_ARRAY_TEXTURE_LAYERS, "layers", layers);
    GLuint id = 0;
    glCreateTextures(layers > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, 1, &id);
    Texture texture(id);
    texture.width_ = width;
    texture.height_ = height;
    texture.layers_ = layers;
    texture.levels_ = levels;
    texture.format_ = internalFormat;
    if (layers > 0)
        glTextureStorage3D(id, levels, internalFormat, width, height, layers);
    else
        glTextureStorage2D(id, levels, internalFormat, width, height);
    setNearestClamped(id);
    return texture;
}

double Texture::mebibytes() const {
    if (!id()) return 0.0;
    double texels = 0.0;
    for (int level = 0; level < levels_; ++level)
        texels += static_cast<double>(std::max(1, width_ >> level)) * std::max(1, height_ >> level);
    return texels * std::max(1, layers_) * bytesPerTexel(format_) / (1024.0 * 1024.0);
}

}  // namespace penumbra::gl
