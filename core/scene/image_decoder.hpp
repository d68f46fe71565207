#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace penumbra::scene_detail {

/// One encoded image that nobody vouches for. The image libraries are used directly, not through
/// OpenImageIO: that decodes all scans of a progressive JPEG before its size can be asked, and
/// libpng's complaints go to stderr.
class ImageDecoder {
  public:
    virtual ~ImageDecoder() = default;

    /// Nothing of the image's size is allocated. False: see error().
    virtual bool readHeader() = 0;
    /// Texels, both from 1 to 2^31 - 1; after readHeader().
    virtual std::uint32_t width() const = 0;
    virtual std::uint32_t height() const = 0;
    /// What readPixels() will allocate at most.
    virtual std::uint64_t workBytes() const = 0;
    /// Writes 4 * width() * height() bytes, top row first. False: see error().
    virtual bool readPixels(unsigned char* rgba) = 0;

    /// Why reading failed.
    virtual std::string error() const = 0;
};

/// `encoded` outlives them.
std::unique_ptr<ImageDecoder> pngDecoder(std::span<const unsigned char> encoded);
std::unique_ptr<ImageDecoder> jpegDecoder(std::span<const unsigned char> encoded);

}  // namespace penumbra::scene_detail
