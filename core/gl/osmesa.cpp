#include <GL/osmesa.h>

#include <array>
#include <cstdint>

#include "core/error.hpp"
#include "core/gl/backends.hpp"

namespace penumbra::gl {
namespace {

/// OSMesa needs a default framebuffer; nothing is drawn to it.
constexpr int kBufferSize = 16;

class OsmesaContext final : public Context {
  public:
    OsmesaContext() {
        const std::array<int, 11> attributes = {OSMESA_FORMAT,
                                                OSMESA_RGBA,
                                                OSMESA_DEPTH_BITS,
                                                0,
                                                OSMESA_PROFILE,
                                                OSMESA_CORE_PROFILE,
                                                OSMESA_CONTEXT_MAJOR_VERSION,
                                                4,
                                                OSMESA_CONTEXT_MINOR_VERSION,
                                                5,
                                                0};
        context_ = OSMesaCreateContextAttribs(attributes.data(), nullptr);
        if (!context_) throw InputError("osmesa: no OpenGL 4.5 core context");
        try {
            if (!OSMesaMakeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, kBufferSize,
                                   kBufferSize))
                throw InputError("osmesa: the context could not be made current");
            initialise(OSMesaGetProcAddress, "osmesa");
        } catch (...) {
            OSMesaDestroyContext(context_);
            throw;
        }
    }
    ~OsmesaContext() override { OSMesaDestroyContext(context_); }

    ContextKind kind() const override { return ContextKind::osmesa; }

  private:
    OSMesaContext context_ = nullptr;
    std::array<std::uint8_t, 4 * kBufferSize * kBufferSize> buffer_{};
};

}  // namespace

std::unique_ptr<Context> createOsmesa() {
    return std::make_unique<OsmesaContext>();
}

}  // namespace penumbra::gl
