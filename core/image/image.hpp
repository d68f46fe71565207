#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

/// Float image with named, interleaved channels; top row first.
struct Image {
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> pixels;  ///< width * height * channels.size()
    bool integers = false;      ///< read from a file of integers: by convention sRGB-encoded
    bool furtherParts = false;  ///< the file holds more images than this one

    std::size_t channelCount() const { return channels.size(); }
    float& at(int x, int y, int c) {
        return pixels[(static_cast<std::size_t>(y) * width + x) * channels.size() + c];
    }
    float at(int x, int y, int c) const {
        return pixels[(static_cast<std::size_t>(y) * width + x) * channels.size() + c];
    }
    /// One channel by name as its own array; throws std::runtime_error if absent.
    std::vector<float> channel(const std::string& name) const;
    static Image withChannels(int width, int height, std::vector<std::string> channels);
    void setChannel(const std::string& name, std::span<const float> values);
};

/// 32-bit float EXR, zip, as the bytes of a file. Throws std::runtime_error with the reason. Equal
/// images give equal bytes. A reader may find the channels in another order: go by name.
std::string encodeExr(const Image& image);

/// encodeExr() by writeFileAtomically: a reader or a kill never sees half a file. Throws
/// std::runtime_error with the reason.
void writeExr(const std::filesystem::path& path, const Image& image);

/// Any flat image OpenImageIO reads, with its channel names: values as stored (integers as 0..1,
/// nothing linearised), of several parts the first. Throws InputError, also for a file that holds
/// only a part of its picture (an EXR whose data window is not its display window).
Image readImage(const std::filesystem::path& path);

/// 8-bit RGB PNG from linear values in [0,1] (sRGB encoded, clamped); three channels expected.
/// Atomic as writeExr.
void writePng(const std::filesystem::path& path, const Image& linearRgb);

/// The byte that writePng() has for a linear value: sRGB encoded (IEC 61966-2-1), clamped; NaN is
/// 0.
std::uint8_t srgb8(float linear);

/// 8-bit RGB PNG from bytes as they shall be shown, three a pixel. Atomic as writeExr.
void writePngBytes(const std::filesystem::path& path, int width, int height,
                   std::span<const std::uint8_t> rgb);

/// Draws `text` into three channels with its baseline starting at (x, y), `sizePx` high, in linear
/// `rgb`. Its ink lies within [x, x + textWidth()) and is clipped to the image. Throws
/// std::runtime_error where the font (Debian package fonts-dejavu-core) is not installed.
void drawText(Image& image, int x, int y, const std::string& text, int sizePx, float r, float g,
              float b);

/// Width of `text` in pixels at `sizePx`.
int textWidth(const std::string& text, int sizePx);

}  // namespace penumbra
