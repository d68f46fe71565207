#pragma once

#include <glad/gl.h>

#include <string>
#include <utility>

namespace penumbra::gl {

/// A move-only owner of one OpenGL object name. Default-constructed it owns nothing (id 0).
/// `Traits::destroy(GLuint)` deletes the object. The context that made it must be current when it
/// dies.
template <class Traits>
class Handle {
  public:
    Handle() = default;
    explicit Handle(GLuint id) : id_(id) {}
    Handle(Handle&& o) noexcept : id_(std::exchange(o.id_, 0)) {}
    Handle& operator=(Handle&& o) noexcept {
        std::swap(id_, o.id_);
        return *this;
    }
    ~Handle() {
        if (id_) Traits::destroy(id_);
    }
    GLuint id() const { return id_; }
    explicit operator bool() const { return id_ != 0; }

  private:
    GLuint id_ = 0;
};

struct BufferTraits {
    static void destroy(GLuint id) { glDeleteBuffers(1, &id); }
};
struct VertexArrayTraits {
    static void destroy(GLuint id) { glDeleteVertexArrays(1, &id); }
};
struct TextureTraits {
    static void destroy(GLuint id) { glDeleteTextures(1, &id); }
};
struct SamplerTraits {
    static void destroy(GLuint id) { glDeleteSamplers(1, &id); }
};
struct FramebufferTraits {
    static void destroy(GLuint id) { glDeleteFramebuffers(1, &id); }
};
struct QueryTraits {
    static void destroy(GLuint id) { glDeleteQueries(1, &id); }
};

using Sampler = Handle<SamplerTraits>;
using VertexArray = Handle<VertexArrayTraits>;
using Framebuffer = Handle<FramebufferTraits>;
using Query = Handle<QueryTraits>;

/// An immutable-size buffer object.
class Buffer : public Handle<BufferTraits> {
  public:
    Buffer() = default;
    /// Storage of `bytes` bytes (at least 4 are allocated) filled from `data`, or undefined if
    /// null.
    static Buffer create(std::size_t bytes, const void* data, GLbitfield flags = 0);
    std::size_t bytes() const { return bytes_; }

  private:
    using Handle::Handle;
    std::size_t bytes_ = 0;
};

/// A 2D texture (layers == 0) or 2D array texture of immutable format.
class Texture : public Handle<TextureTraits> {
  public:
    Texture() = default;
    /// Nearest filtering, clamped to edge. `levels` mip levels are allocated.
    static Texture create2D(GLenum internalFormat, int width, int height, int levels = 1);
    static Texture createArray(GLenum internalFormat, int width, int height, int layers,
                               int levels = 1);
    int width() const { return width_; }
    int height() const { return height_; }
    int layers() const { return layers_; }  ///< 0: not an array
    GLenum format() const { return format_; }
    double mebibytes() const;  ///< memory of all levels and layers, MiB
    void bind(GLuint unit) const { glBindTextureUnit(unit, id()); }

  private:
    using Handle::Handle;
    static Texture create(GLenum internalFormat, int width, int height, int layers, int levels);
    int width_ = 0, height_ = 0, layers_ = 0, levels_ = 0;
    GLenum format_ = 0;
};

/// A named group in a frame debugger's list, open while the object lives.
class DebugGroup {
  public:
    explicit DebugGroup(const std::string& name) {
        glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, name.c_str());
    }
    ~DebugGroup() { glPopDebugGroup(); }
    DebugGroup(const DebugGroup&) = delete;
    DebugGroup& operator=(const DebugGroup&) = delete;
};

}  // namespace penumbra::gl
