#include "harness/viewer/picture.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <vector>

namespace penumbra {

void Picture::upload(const Image& linearRgb) {
    const std::size_t pixels = linearRgb.pixels.size() / 3;
    if (pixels == 0) return clear();
    std::vector<std::uint8_t> bytes(4 * pixels);
    using Range = tbb::blocked_range<std::size_t>;
    tbb::parallel_for(Range(0, pixels, 16384), [&](const Range& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            for (std::size_t c = 0; c < 3; ++c)
                bytes[4 * i + c] = srgb8(linearRgb.pixels[3 * i + c]);
            bytes[4 * i + 3] = 255;
        }
    });
    if (texture_.width() != linearRgb.width || texture_.height() != linearRgb.height) {
        texture_ = gl::Texture::create2D(GL_RGBA8, linearRgb.width, linearRgb.height);
        glTextureParameteri(texture_.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    }
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture_.id(), 0, 0, 0, linearRgb.width, linearRgb.height, GL_RGBA,
                        GL_UNSIGNED_BYTE, bytes.data());
}

PictureLight exposed(PictureLight light, float stops) {
    const float factor = std::exp2(stops);
    light.radiance *= factor;
    light.ambientIrradiance *= factor;
    return light;
}

Image differenceMap(const GBuffer& gbuffer, std::span<const float> a, std::span<const float> b) {
    if (a.size() != gbuffer.size() || b.size() != gbuffer.size()) return {};
    Reference subtrahend;
    subtrahend.visibility.assign(b.begin(), b.end());
    return errorMap(gbuffer, a, subtrahend);
}

}  // namespace penumbra
