#include "harness/report/page_image.hpp"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "harness/report/page.hpp"
#include "harness/report/shade.hpp"

namespace penumbra {
namespace {

/// A ladder's report is written half a second sooner than at level 5, with 2 % more bytes.
constexpr int kDeflateLevel = 3;
/// Of visibility: 0.2 bytes each in base64, of the standard suite and of its ladder at every other
/// pixel.
constexpr double kMostPixels = 96e6;

using Plane = std::vector<std::uint16_t>;

std::uint16_t predicted(int left, int above, int aboveLeft) {
    const auto [low, high] = std::minmax(left, above);
    if (aboveLeft >= high) return static_cast<std::uint16_t>(low);
    if (aboveLeft <= low) return static_cast<std::uint16_t>(high);
    return static_cast<std::uint16_t>(left + above - aboveLeft);
}

std::vector<unsigned char> deflated(const std::vector<unsigned char>& bytes) {
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(kDeflateLevel), &libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    std::vector<unsigned char> out(
        libdeflate_deflate_compress_bound(compressor.get(), bytes.size()));
    out.resize(libdeflate_deflate_compress(compressor.get(), bytes.data(), bytes.size(), out.data(),
                                           out.size()));
    return out;
}

/// The pixels that a page shows of one frame.
class Sampler {
  public:
    Sampler(const GBuffer& gbuffer, int stride)
        : gbuffer_(gbuffer), stride_(stride), width_((gbuffer.width + stride - 1) / stride) {}

    /// `value` takes the pixel's index.
    template <class Value>
    std::string packed(Value value) const {
        Plane plane;
        plane.reserve(gbuffer_.size() / static_cast<std::size_t>(stride_));
        for (int y = 0; y < gbuffer_.height; y += stride_)
            for (int x = 0; x < gbuffer_.width; x += stride_)
                plane.push_back(static_cast<std::uint16_t>(
                    value(static_cast<std::size_t>(y) * static_cast<std::size_t>(gbuffer_.width) +
                          static_cast<std::size_t>(x))));
        return packedPlane(plane, width_);
    }

    /// V where a method is asked for it, 0 elsewhere.
    std::string visibility(std::span<const float> v) const {
        return packed([&](std::size_t i) -> long {
            if (!isAsked(gbuffer_.mask[i])) return kPlaneZero;
            if (!std::isfinite(v[i])) return 0;
            return std::clamp(kPlaneZero + std::lround(v[i] / kPlaneVisibility), 1L, 65535L);
        });
    }

  private:
    const GBuffer& gbuffer_;
    int stride_, width_;
};

/// 0 background, 1 lit, 2 penumbra, 3 umbra, 4 horizon, 5 facing away.
std::vector<std::uint8_t> pixelClasses(const GBuffer& gbuffer, const Reference& reference) {
    const std::vector<LightClass> light = classifyLight(reference, gbuffer);
    std::vector<std::uint8_t> classes(gbuffer.size());
    for (std::size_t i = 0; i < classes.size(); ++i) {
        switch (gbuffer.mask[i]) {
            case PixelClass::background:
                classes[i] = 0;
                break;
            case PixelClass::horizon:
                classes[i] = 4;
                break;
            case PixelClass::facingAway:
                classes[i] = 5;
                break;
            case PixelClass::scored:
                classes[i] = light[i] == LightClass::lit        ? 1
                             : light[i] == LightClass::penumbra ? 2
                                                                : 3;
        }
    }
    return classes;
}

std::string element(const std::string& id, std::string text) {
    return dataElement({id, "text/plain", std::move(text)});
}

}  // namespace

std::string packedPlane(std::span<const std::uint16_t> values, int width) {
    const auto w = static_cast<std::size_t>(width);
    const std::size_t n = values.size();
    std::vector<unsigned char> bytes(2 * n);
    for (std::size_t i = 0; i < n; ++i) {
        const int left = i % w ? values[i - 1] : 0, above = i >= w ? values[i - w] : 0;
        const int aboveLeft = i % w && i >= w ? values[i - w - 1] : 0;
        // Modulo 65536, which the decoder undoes.
        const auto residual =
            static_cast<std::int16_t>(values[i] - predicted(left, above, aboveLeft));
        const auto folded =
            static_cast<std::uint16_t>(residual < 0 ? -2 * residual - 1 : 2 * residual);
        bytes[i] = static_cast<unsigned char>(folded & 0xFF);
        bytes[n + i] = static_cast<unsigned char>(folded >> 8);
    }
    return base64(deflated(bytes));
}

int pageStride(double pixels) {
    return std::max(1, static_cast<int>(std::ceil(std::sqrt(std::max(0.0, pixels) / kMostPixels))));
}

std::string pageImages(const GridFrame& frame, std::size_t sceneIndex, std::span<const Row> rows,
                       int stride) {
    const GBuffer& gbuffer = *frame.gbuffer;
    const Reference& reference = *frame.reference;
    const Sampler sampler(gbuffer, stride);
    const auto id = [&](const char* name) {
        return fmt::format("{}-{}-{}", name, sceneIndex, frame.index);
    };
    const std::vector<std::uint8_t> classes = pixelClasses(gbuffer, reference);
    const std::vector<float> lit(gbuffer.size(), 1.0F);
    const Image picture = shadeVisibility(gbuffer, lit, pictureLight(gbuffer));

    std::string out = element(id("reference"), sampler.visibility(reference.visibility));
    out += element(id("standard-error"), sampler.packed([&](std::size_t i) {
        const double se = isAsked(gbuffer.mask[i]) ? reference.standardError[i] : 0.0;
        return std::clamp(std::lround(se / kPlaneStandardError), 0L, 65535L);
    }));
    out += element(id("class"), sampler.packed([&](std::size_t i) { return classes[i]; }));
    for (std::size_t c = 0; const char* name : {"red", "green", "blue"}) {
        out += element(id(name), sampler.packed([&](std::size_t i) {
            return srgb8(picture.pixels[3 * i + c]);
        }));
        ++c;
    }
    for (const GridCell& cell : frame.cells) {
        if (cell.visibility.empty()) continue;
        out += element(fmt::format("visibility-{}", cell.row - rows.data()),
                       sampler.visibility(cell.visibility));
    }
    return out;
}

}  // namespace penumbra
