#include "core/image/image.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>

#include "core/error.hpp"
#include "core/file/atomic_file.hpp"
#include "core/image/image_channels.hpp"
#include "core/image/srgb.hpp"
#include "core/image/zipped_exr.hpp"

namespace penumbra {
namespace {

/// An image read from outside may not ask for more than this many values (1 GiB of floats).
constexpr std::uint64_t kMostValues = 1ull << 28;
constexpr int kPngFilterNone = 0x08;  ///< PNG_FILTER_NONE of libpng

std::size_t channelIndex(const Image& image, const std::string& name) {
    const auto at = std::ranges::find(image.channels, name);
    if (at == image.channels.end())
        throw std::runtime_error(fmt::format("the image has no channel '{}'; it has {}", name,
                                             fmt::join(image.channels, ", ")));
    return static_cast<std::size_t>(at - image.channels.begin());
}

std::uint8_t srgbByte(float x) {
    const float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
    return static_cast<std::uint8_t>(std::lround(255.0f * encoded));
}

/// srgbByte of [0,1] as the values at which it steps.
class SrgbSteps {
  public:
    SrgbSteps() {
        for (int i = 0; i <= kCells; ++i)
            first_[static_cast<std::size_t>(i)] = srgbByte(static_cast<float>(i) / kCells);
        for (std::size_t byte = 1; byte < 256; ++byte) {
            float below = 0.0f, from = 1.0f;  // adjacent floats once nothing is between them
            for (float x = 0.5f; x > below && x < from; x = 0.5f * (below + from))
                (srgbByte(x) < byte ? below : from) = x;
            least_[byte] = from;
        }
        least_[256] = 2.0f;
    }
    std::uint8_t byteOf(float x) const {
        const std::uint8_t byte = first_[static_cast<std::size_t>(x * kCells)];
        return static_cast<std::uint8_t>(byte + (x >= least_[byte + 1u]));
    }

  private:
    /// 255 * 12.92, the steepest the curve is, is less: at most one step in each.
    static constexpr int kCells = 4096;
    std::array<std::uint8_t, kCells + 1> first_{};
    std::array<float, 257> least_{};  ///< value from which on it is this byte
};

/// The file in memory, because OpenImageIO does not report what fails when a file is closed; throws
/// std::runtime_error.
std::string encode(const char* format, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
                   const void* pixels) {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput sink(bytes);
    const auto output = OIIO::ImageOutput::create(format);
    if (!output) throw std::runtime_error(fmt::format("OpenImageIO has no {} writer", format));
    if (!output->set_ioproxy(&sink) || !output->open(format, spec) ||
        !output->write_image(type, pixels) || !output->close())
        throw std::runtime_error(fmt::format("{}: {}", format, output->geterror()));
    return {bytes.begin(), bytes.end()};
}

[[noreturn]] void refuse(const std::filesystem::path& path, std::string why) {
    std::ranges::replace(why, '\n', ' ');
    throw InputError(fmt::format("{}: {}", path.string(), why));
}

/// What readImage() takes, ready to be read.
std::unique_ptr<OIIO::ImageInput> openImage(const std::filesystem::path& path) {
    // OpenImageIO's older reader of EXR takes twice as long and has each image once more in memory.
    static const bool kCoreReader = OIIO::attribute("openexr:core", 1);
    if (!kCoreReader) throw std::runtime_error("OpenImageIO has no reader on OpenEXRCore");
    if (!std::filesystem::is_regular_file(path))
        refuse(path, std::filesystem::exists(path) ? "not a file" : "no such file");
    OIIO::ImageSpec asStored;
    asStored.attribute("oiio:UnassociatedAlpha", 1);  // values as they are in the file
    auto input = OIIO::ImageInput::open(path.string(), &asStored);
    if (!input) refuse(path, OIIO::geterror());
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.deep || spec.depth > 1) refuse(path, "a deep or volume image, a flat one is needed");
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 ||
        spec.image_pixels() > kMostValues / static_cast<std::uint64_t>(spec.nchannels))
        refuse(path, fmt::format("{} x {} pixels with {} channels are not supported", spec.width,
                                 spec.height, spec.nchannels));
    if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
        spec.height != spec.full_height)
        refuse(path, fmt::format("holds {} x {} pixels from ({}, {}) of a picture of {} x {} from "
                                 "({}, {}): a whole picture is needed",
                                 spec.width, spec.height, spec.x, spec.y, spec.full_width,
                                 spec.full_height, spec.full_x, spec.full_y));
    return input;
}

}  // namespace

Image Image::withChannels(int width, int height, std::vector<std::string> channels) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = std::move(channels);
    image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                        image.channels.size());
    return image;
}

std::vector<float> Image::channel(const std::string& name) const {
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = channelIndex(*this, name); i < pixels.size(); i += channelCount())
        values.push_back(pixels[i]);
    return values;
}

void Image::setChannel(const std::string& name, std::span<const float> values) {
    const std::size_t first = channelIndex(*this, name);
    if (values.size() * channelCount() != pixels.size())
        throw std::logic_error(fmt::format("Image::setChannel {}: {} values for {} pixels", name,
                                           values.size(), pixels.size() / channelCount()));
    for (std::size_t i = 0; i < values.size(); ++i) pixels[i * channelCount() + first] = values[i];
}

std::string encodeExr(const Image& image) {
    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channelCount()),
                         OIIO::TypeDesc::FLOAT);
    spec.channelnames = image.channels;
    spec.attribute("compression", "zip");
    spec.attribute("DateTime", "");  // else the time of writing: equal images are equal files
    return encode("exr", spec, OIIO::TypeDesc::FLOAT, image.pixels.data());
}

void writeExr(const std::filesystem::path& path, const Image& image) {
    writeFileAtomically(path, encodeExr(image));
}

std::uint8_t srgb8(float linear) {
    std::uint8_t byte = 0;
    srgb8({&linear, 1}, {&byte, 1});
    return byte;
}

void srgb8(std::span<const float> linear, std::span<std::uint8_t> bytes) {
    // A run's grids have some hundred million of them: looked up, for pow takes ten times as long.
    static const SrgbSteps steps;
    for (std::size_t i = 0; i < linear.size(); ++i)
        bytes[i] = steps.byteOf(linear[i] > 0.0f ? std::min(linear[i], 1.0f) : 0.0f);
}

float linearOf(std::uint8_t srgb) {
    static const auto kLinear = [] {
        std::array<float, 256> table{};
        for (std::size_t i = 0; i < table.size(); ++i) {
            const float encoded = static_cast<float>(i) / 255.0f;
            table[i] = encoded <= 0.04045f ? encoded / 12.92f
                                           : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
        }
        return table;
    }();
    return kLinear[srgb];
}

void writePng(const std::filesystem::path& path, const Image& linearRgb) {
    if (linearRgb.channelCount() != 3)
        throw std::logic_error("writePng: three channels are needed");
    std::vector<std::uint8_t> encoded(linearRgb.pixels.size());
    srgb8(linearRgb.pixels, encoded);
    writePngBytes(path, linearRgb.width, linearRgb.height, encoded);
}

void writePngBytes(const std::filesystem::path& path, int width, int height,
                   std::span<const std::uint8_t> rgb) {
    if (rgb.size() != 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        throw std::logic_error("writePngBytes: three bytes a pixel are needed");
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    // Flat colours and noise gain little from PNG's filters: a quarter of the time of the defaults
    // for an eighth more bytes of a run's grids.
    spec.attribute("png:compressionLevel", 1);
    spec.attribute("png:filter", kPngFilterNone);
    writeFileAtomically(path, encode("png", spec, OIIO::TypeDesc::UINT8, rgb.data()));
}

Image readImage(const std::filesystem::path& path) {
    const auto input = openImage(path);
    const OIIO::ImageSpec& spec = input->spec();
    Image image = Image::withChannels(spec.width, spec.height, spec.channelnames);
    image.integers = !spec.format.is_floating_point();
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.pixels.data()))
        refuse(path, input->geterror());
    image.furtherParts = input->seek_subimage(1, 0);
    return image;
}

ImageChannels readChannels(const std::filesystem::path& path,
                           const std::vector<std::string>& names) {
    if (auto zipped = readZippedChannels(path, names)) return std::move(*zipped);
    const Image image = readImage(path);
    ImageChannels channels{image.width, image.height, {}};
    for (const std::string& name : names) {
        if (std::ranges::find(image.channels, name) == image.channels.end())
            refuse(path, fmt::format("no channel '{}'; it has {}", name,
                                     fmt::join(image.channels, ", ")));
        channels.values.push_back(image.channel(name));
    }
    return channels;
}

}  // namespace penumbra
