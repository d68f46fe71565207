#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <new>

#include "core/scene/image_decoder.hpp"

namespace penumbra::scene_detail {
namespace {

/// libpng leaves by longjmp: no function between a setjmp and libpng has anything to destroy.
class PngDecoder : public ImageDecoder {
  public:
    explicit PngDecoder(std::span<const unsigned char> encoded)
        : left_(encoded),
          png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, this, onError, onWarning)),
          info_(png_ ? png_create_info_struct(png_) : nullptr) {
        if (info_) return;
        png_destroy_read_struct(&png_, nullptr, nullptr);
        throw std::bad_alloc();
    }
    ~PngDecoder() override { png_destroy_read_struct(&png_, &info_, nullptr); }
    PngDecoder(const PngDecoder&) = delete;
    PngDecoder& operator=(const PngDecoder&) = delete;

    bool readHeader() override {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_set_read_fn(png_, this, onRead);
        // What is neither pixels nor transparency is skipped: it may be compressed text of any
        // size.
        png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
        png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // the caller has its own
        png_read_info(png_, info_);
        png_set_expand(png_);  // palettes, fewer than 8 bits, transparent colours
        png_set_scale_16(png_);
        png_set_gray_to_rgb(png_);
        png_set_add_alpha(png_, 255, PNG_FILLER_AFTER);
        return true;
    }
    std::uint32_t width() const override { return png_get_image_width(png_, info_); }
    std::uint32_t height() const override { return png_get_image_height(png_, info_); }
    /// Two rows of at most four components of 16 bits, and one that is being expanded.
    std::uint64_t workBytes() const override { return std::uint64_t{3 * 8} * width(); }

    bool readPixels(unsigned char* rgba) override {
        if (setjmp(png_jmpbuf(png_))) return false;
        const int passes = png_set_interlace_handling(png_);
        const std::size_t rows = height(), rowBytes = 4 * std::size_t{width()};
        png_read_update_info(png_, info_);
        if (png_get_rowbytes(png_, info_) != rowBytes) png_error(png_, "its rows are not RGBA");
        for (int pass = 0; pass < passes; ++pass) {
            for (std::size_t y = 0; y < rows; ++y) {
                png_read_row(png_, rgba + y * rowBytes, nullptr);
            }
        }
        png_read_end(png_, nullptr);
        return true;
    }

    std::string error() const override { return error_; }

  private:
    [[noreturn]] static void onError(png_structp png, png_const_charp message) {
        auto& self = *static_cast<PngDecoder*>(png_get_error_ptr(png));
        std::strncpy(self.error_, message, sizeof self.error_ - 1);
        png_longjmp(png, 1);
    }
    static void onWarning(png_structp, png_const_charp) {}
    static void onRead(png_structp png, png_bytep out, std::size_t count) {
        auto& self = *static_cast<PngDecoder*>(png_get_io_ptr(png));
        if (count > self.left_.size()) png_error(png, "the file is cut off");
        std::memcpy(out, self.left_.data(), count);
        self.left_ = self.left_.subspan(count);
    }

    std::span<const unsigned char> left_;
    char error_[128] = {};
    png_structp png_;
    png_infop info_;
};

}  // namespace

std::unique_ptr<ImageDecoder> pngDecoder(std::span<const unsigned char> encoded) {
    return std::make_unique<PngDecoder>(encoded);
}

}  // namespace penumbra::scene_detail
