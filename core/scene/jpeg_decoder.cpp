// jpeglib.h needs FILE.
#include <cstdio>
// This order is libjpeg's.
#include <jpeglib.h>

#include <jerror.h>

#include <csetjmp>

#include "core/scene/image_decoder.hpp"

namespace penumbra::scene_detail {
namespace {

/// Scans of a progressive file: encoders write some ten. libjpeg decodes all of the image once for
/// each, and one takes a few bytes.
constexpr int kMaxScans = 100;

/// libjpeg leaves by longjmp: no function between a setjmp and libjpeg has anything to destroy.
class JpegDecoder : public ImageDecoder {
  public:
    explicit JpegDecoder(std::span<const unsigned char> encoded) : encoded_(encoded) {
        file_.err = jpeg_std_error(&errors_);
        errors_.error_exit = onError;
        errors_.emit_message = onMessage;
        progress_.progress_monitor = onProgress;
        file_.client_data = this;
    }
    ~JpegDecoder() override { jpeg_destroy_decompress(&file_); }
    JpegDecoder(const JpegDecoder&) = delete;
    JpegDecoder& operator=(const JpegDecoder&) = delete;

    bool readHeader() override {
        if (setjmp(back_)) return false;
        jpeg_create_decompress(&file_);
        file_.progress = &progress_;
        jpeg_mem_src(&file_, encoded_.data(), encoded_.size());
        jpeg_read_header(&file_, TRUE);
        file_.out_color_space = JCS_EXT_RGBA;
        return true;
    }
    std::uint32_t width() const override { return file_.image_width; }
    std::uint32_t height() const override { return file_.image_height; }
    /// Coefficients of 16 bits of all components in whole blocks, at most 4 x 4 of 8 x 8 texels;
    /// and as much again for rows on their way.
    std::uint64_t workBytes() const override {
        const auto whole = [](std::uint64_t texels) { return (texels + 31) / 32 * 32; };
        const auto components = static_cast<std::uint64_t>(file_.num_components);
        const std::uint64_t rows = 4 * 32;
        return components * whole(width()) * (2 * whole(height()) + 2 * rows);
    }

    bool readPixels(unsigned char* rgba) override {
        if (setjmp(back_)) return false;
        jpeg_start_decompress(&file_);
        const std::size_t rowBytes = 4 * std::size_t{width()};
        while (file_.output_scanline < file_.output_height) {
            JSAMPROW row = rgba + file_.output_scanline * rowBytes;
            jpeg_read_scanlines(&file_, &row, 1);
        }
        jpeg_finish_decompress(&file_);
        return true;
    }

    std::string error() const override { return error_; }

  private:
    template <class Common>
    static JpegDecoder& of(Common file) {
        return *static_cast<JpegDecoder*>(file->client_data);
    }
    [[noreturn]] static void onError(j_common_ptr file) {
        JpegDecoder& self = of(file);
        self.errors_.format_message(file, self.error_);
        std::longjmp(self.back_, 1);
    }
    /// Warnings of lost pixels are errors; others, as of bytes too many, are let pass.
    static void onMessage(j_common_ptr file, int level) {
        const int code = of(file).errors_.msg_code;
        if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER ||
                          code == JWRN_HUFF_BAD_CODE || code == JWRN_MUST_RESYNC)) {
            onError(file);
        }
    }
    static void onProgress(j_common_ptr file) {
        JpegDecoder& self = of(file);
        if (self.file_.input_scan_number <= kMaxScans) return;
        std::snprintf(self.error_, sizeof self.error_, "it has more than %d scans", kMaxScans);
        std::longjmp(self.back_, 1);
    }

    std::span<const unsigned char> encoded_;
    jpeg_decompress_struct file_{};
    jpeg_error_mgr errors_{};
    jpeg_progress_mgr progress_{};
    std::jmp_buf back_{};
    char error_[JMSG_LENGTH_MAX] = {};
};

}  // namespace

std::unique_ptr<ImageDecoder> jpegDecoder(std::span<const unsigned char> encoded) {
    return std::make_unique<JpegDecoder>(encoded);
}

}  // namespace penumbra::scene_detail
