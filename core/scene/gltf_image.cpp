#include "core/scene/gltf_image.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

/// The name by which OpenImageIO picks its reader: the content decides, not what the file claims.
const char* readerFor(std::span<const unsigned char> bytes) {
    static constexpr std::array<unsigned char, 4> kPng = {0x89, 'P', 'N', 'G'};
    static constexpr std::array<unsigned char, 3> kJpeg = {0xFF, 0xD8, 0xFF};
    const auto startsWith = [&](const auto& magic) {
        return bytes.size() >= magic.size() &&
               std::equal(magic.begin(), magic.end(), bytes.begin());
    };
    return startsWith(kPng) ? "image.png" : startsWith(kJpeg) ? "image.jpg" : nullptr;
}

/// Grey, grey + alpha, RGB or RGBA to RGBA.
std::vector<std::uint8_t> expanded(const std::vector<std::uint8_t>& pixels, int channels) {
    const std::size_t count = pixels.size() / channels;
    const bool grey = channels < 3, alpha = channels % 2 == 0;
    std::vector<std::uint8_t> rgba(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* in = &pixels[i * channels];
        for (int c = 0; c < 3; ++c) rgba[4 * i + c] = in[grey ? 0 : c];
        rgba[4 * i + 3] = alpha ? in[channels - 1] : 255;
    }
    return rgba;
}

}  // namespace

TextureImage decodeImage(std::span<const unsigned char> encoded, const std::filesystem::path& file,
                         const std::string& pointer, MemoryBudget& budget) {
    const char* const reader = readerFor(encoded);
    if (!reader) failInput(file, pointer, "is neither PNG nor JPEG");
    OIIO::ImageSpec config;
    // Alpha masks need the colour that was stored, not colour times alpha.
    config.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::Filesystem::IOMemReader bytes(const_cast<unsigned char*>(encoded.data()), encoded.size());
    // As an argument of open() the proxy is lost again where there is a configuration too.
    OIIO::Filesystem::IOProxy* proxy = &bytes;
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const auto input = OIIO::ImageInput::open(reader, &config);
    if (!input) failInput(file, pointer, "cannot be decoded: " + oneLine(OIIO::geterror(), 200));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width < 1 || spec.height < 1 ||
        static_cast<long long>(spec.width) * spec.height > kMaxImageTexels || spec.nchannels < 1 ||
        spec.nchannels > 4) {
        failInput(file, pointer,
                  fmt::format("is an image of {} x {} texels with {} channels; at most {} texels "
                              "with 4 channels are read",
                              spec.width, spec.height, spec.nchannels, kMaxImageTexels));
    }
    // The decoder's own copy may be of 16 bits; then its 8 bits and the RGBA that is kept.
    const auto texels = static_cast<std::uint64_t>(spec.width) * spec.height;
    budget.charge(texels, 3 * static_cast<std::uint64_t>(spec.nchannels) + 4, pointer,
                  "decoding the image");
    TextureImage image;
    image.width = spec.width;
    image.height = spec.height;
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(spec.nchannels) * spec.width *
                                     spec.height);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, pixels.data())) {
        failInput(file, pointer, "cannot be decoded: " + oneLine(input->geterror(), 200));
    }
    image.rgba = spec.nchannels == 4 ? std::move(pixels) : expanded(pixels, spec.nchannels);
    return image;
}

}  // namespace penumbra::scene_detail
