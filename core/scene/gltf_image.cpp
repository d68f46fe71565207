#include "core/scene/gltf_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/scene/image_decoder.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

/// By content, whatever the file claims; null for neither.
std::unique_ptr<ImageDecoder> decoderFor(std::span<const unsigned char> bytes) {
    static constexpr std::array<unsigned char, 4> kPng = {0x89, 'P', 'N', 'G'};
    static constexpr std::array<unsigned char, 3> kJpeg = {0xFF, 0xD8, 0xFF};
    const auto startsWith = [&](const auto& magic) {
        return bytes.size() >= magic.size() &&
               std::equal(magic.begin(), magic.end(), bytes.begin());
    };
    if (startsWith(kPng)) return pngDecoder(bytes);
    if (startsWith(kJpeg)) return jpegDecoder(bytes);
    return nullptr;
}

}  // namespace

TextureImage decodeImage(std::span<const unsigned char> encoded, const std::filesystem::path& file,
                         const std::string& pointer, MemoryBudget& budget) {
    const std::unique_ptr<ImageDecoder> decoder = decoderFor(encoded);
    if (!decoder) failInput(file, pointer, "is neither PNG nor JPEG");
    const auto failDecoding = [&] {
        failInput(file, pointer, "cannot be decoded: " + oneLine(decoder->error(), 200));
    };
    if (!decoder->readHeader()) failDecoding();
    const std::uint64_t width = decoder->width(), height = decoder->height();
    if (width * height > kMaxImageTexels) {
        failInput(file, pointer,
                  fmt::format("is an image of {} x {} texels; at most {} texels are read", width,
                              height, kMaxImageTexels));
    }
    budget.charge(decoder->workBytes(), 1, pointer, "decoding the image");
    budget.charge(width * height, 4, pointer, "decoding the image");
    TextureImage image;
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.rgba.resize(4 * static_cast<std::size_t>(width) * height);
    if (!decoder->readPixels(image.rgba.data())) failDecoding();
    return image;
}

}  // namespace penumbra::scene_detail
