#include "core/image/zipped_exr.hpp"

#include <OpenEXR/openexr.h>
#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <numeric>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace penumbra {
namespace {

constexpr std::int64_t kMostValues = std::int64_t{1} << 28;  // as readImage() has it

using Bytes = std::vector<std::uint8_t>;

struct CloseFile {
    void operator()(exr_context_t file) const { exr_finish(&file); }
};
using File = std::unique_ptr<std::remove_pointer_t<exr_context_t>, CloseFile>;

File openFile(const std::filesystem::path& path) {
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = [](exr_const_context_t, exr_result_t, const char*) {};
    exr_context_t file = nullptr;
    return File(exr_start_read(&file, path.c_str(), &settings) == EXR_ERR_SUCCESS ? file : nullptr);
}

/// Lines of `channels` values each, one channel after the other.
struct Layout {
    int width = 0, height = 0, firstLine = 0, linesPerBlock = 0;
    std::size_t channels = 0;
    std::vector<std::size_t> asked;  ///< indices of channels

    std::size_t channelBytes() const { return sizeof(float) * static_cast<std::size_t>(width); }
    std::size_t lineBytes() const { return channels * channelBytes(); }
};

bool isZippedLines(exr_const_context_t file) {
    int parts = 0;
    exr_storage_t storage{};
    exr_compression_t compression{};
    return exr_get_count(file, &parts) == EXR_ERR_SUCCESS && parts == 1 &&
           exr_get_storage(file, 0, &storage) == EXR_ERR_SUCCESS &&
           storage == EXR_STORAGE_SCANLINE &&
           exr_get_compression(file, 0, &compression) == EXR_ERR_SUCCESS &&
           (compression == EXR_COMPRESSION_ZIP || compression == EXR_COMPRESSION_ZIPS);
}

std::optional<Layout> layoutOf(exr_const_context_t file, const std::vector<std::string>& names) {
    exr_attr_box2i_t data{}, display{};
    const exr_attr_chlist_t* channels = nullptr;
    Layout layout;
    if (!isZippedLines(file) || exr_get_data_window(file, 0, &data) != EXR_ERR_SUCCESS ||
        exr_get_display_window(file, 0, &display) != EXR_ERR_SUCCESS ||
        std::memcmp(&data, &display, sizeof data) != 0 ||
        exr_get_channels(file, 0, &channels) != EXR_ERR_SUCCESS ||
        exr_get_scanlines_per_chunk(file, 0, &layout.linesPerBlock) != EXR_ERR_SUCCESS)
        return std::nullopt;
    const std::int64_t width = std::int64_t{data.max.x} - data.min.x + 1;
    const std::int64_t height = std::int64_t{data.max.y} - data.min.y + 1;
    if (width < 1 || height < 1 || channels->num_channels < 1 ||
        width > kMostValues / height / channels->num_channels)
        return std::nullopt;
    layout.width = static_cast<int>(width);
    layout.height = static_cast<int>(height);
    layout.firstLine = data.min.y;
    layout.channels = static_cast<std::size_t>(channels->num_channels);
    const std::span entries(channels->entries, layout.channels);
    for (const exr_attr_chlist_entry_t& channel : entries)
        if (channel.pixel_type != EXR_PIXEL_FLOAT || channel.x_sampling != 1 ||
            channel.y_sampling != 1)
            return std::nullopt;
    for (const std::string& name : names) {
        const auto at =
            std::ranges::find(entries, name, [](const exr_attr_chlist_entry_t& channel) {
                return std::string_view(channel.name.str);
            });
        if (at == entries.end()) return std::nullopt;
        layout.asked.push_back(static_cast<std::size_t>(at - entries.begin()));
    }
    return layout;
}

/// Adds the eight bytes of each, none carrying into the next.
std::uint64_t addBytes(std::uint64_t a, std::uint64_t b) {
    constexpr std::uint64_t kHigh = 0x8080808080808080;
    return ((a & ~kHigh) + (b & ~kHigh)) ^ ((a ^ b) & kHigh);
}

/// EXR's ZIP has of each byte the difference from the one before it, plus 128. What `bytes` come to
/// after a byte of `last`; returns the last of them. Eight at a time.
std::uint8_t sumDifferences(std::span<std::uint8_t> bytes, std::uint8_t last) {
    static_assert(std::endian::native == std::endian::little);
    constexpr std::uint64_t kBias = 0x8080808080808080;
    constexpr std::uint64_t kEveryByte = 0x0101010101010101;
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, &bytes[i], 8);
        eight ^= kBias;
        eight = addBytes(eight, eight << 8);
        eight = addBytes(eight, eight << 16);
        eight = addBytes(eight, eight << 32);
        const std::uint64_t summed = addBytes(eight, last * kEveryByte);
        last = static_cast<std::uint8_t>(last + (eight >> 56));
        std::memcpy(&bytes[i], &summed, 8);
    }
    for (; i < bytes.size(); ++i)
        bytes[i] = last = static_cast<std::uint8_t>(last + bytes[i] - 128);
    return last;
}

/// The last of them alone.
std::uint8_t lastOfDifferences(std::span<const std::uint8_t> bytes, std::uint8_t last) {
    const auto bias = static_cast<std::uint8_t>(128 * bytes.size());
    return std::accumulate(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(last - bias),
                           [](std::uint8_t a, std::uint8_t b) -> std::uint8_t { return a + b; });
}

class BlockReader {
  public:
    BlockReader(exr_const_context_t file, const Layout& layout)
        : file_(file),
          layout_(layout),
          inflate_(libdeflate_alloc_decompressor()),
          isAsked_(layout.channels) {
        if (!inflate_) throw std::bad_alloc();
        for (const std::size_t channel : layout.asked) isAsked_[channel] = true;
    }

    /// Puts the block from line `y` on into `image`.
    bool read(int y, ImageChannels& image) {
        const int lines = std::min(layout_.linesPerBlock, layout_.height - y);
        const std::size_t size = static_cast<std::size_t>(lines) * layout_.lineBytes();
        exr_chunk_info_t block{};
        if (exr_read_scanline_chunk_info(file_, 0, layout_.firstLine + y, &block) !=
                EXR_ERR_SUCCESS ||
            block.unpacked_size != size || block.packed_size > size)
            return false;
        packed_.resize(block.packed_size);
        if (exr_read_chunk(file_, 0, &block, packed_.data()) != EXR_ERR_SUCCESS) return false;
        if (block.packed_size == size) {  // zipping did not make it smaller
            copyLines(y, lines, image, [&](std::size_t first, std::span<std::uint8_t> to) {
                std::memcpy(to.data(), &packed_[first], to.size());
            });
            return true;
        }
        bytes_.resize(size);
        if (libdeflate_zlib_decompress(inflate_.get(), packed_.data(), packed_.size(),
                                       bytes_.data(), size, nullptr) != LIBDEFLATE_SUCCESS)
            return false;
        undoPredictor(lines);
        // Bytes with even indices come first, then those with odd ones.
        copyLines(y, lines, image, [&](std::size_t first, std::span<std::uint8_t> to) {
            const std::uint8_t* even = &bytes_[first / 2];
            const std::uint8_t* odd = even + size / 2;
            for (std::size_t i = 0; i < to.size() / 2; ++i) {
                to[2 * i] = even[i];
                to[2 * i + 1] = odd[i];
            }
        });
        return true;
    }

  private:
    /// In the channels that are asked for; of the others only what comes after them is wanted.
    void undoPredictor(int lines) {
        bytes_[0] ^= 0x80;  // as if it were a difference from 0
        const std::size_t run = layout_.channelBytes() / 2;
        std::uint8_t last = 0;
        for (std::size_t i = 0; i < 2 * static_cast<std::size_t>(lines) * layout_.channels; ++i) {
            const auto bytes = std::span(bytes_).subspan(i * run, run);
            last = isAsked_[i % layout_.channels] ? sumDifferences(bytes, last)
                                                  : lastOfDifferences(bytes, last);
        }
    }

    /// `copy(first, to)` has the bytes of the block from `first` on.
    template <class Copy>
    void copyLines(int y, int lines, ImageChannels& image, Copy copy) {
        const std::size_t bytes = layout_.channelBytes();
        for (std::size_t i = 0; i < layout_.asked.size(); ++i) {
            auto* to = reinterpret_cast<std::uint8_t*>(image.values[i].data()) +
                       bytes * static_cast<std::size_t>(y);
            for (std::size_t line = 0; line < static_cast<std::size_t>(lines); ++line, to += bytes)
                copy(line * layout_.lineBytes() + bytes * layout_.asked[i], std::span(to, bytes));
        }
    }

    struct FreeInflate {
        void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
    };

    exr_const_context_t file_;
    const Layout& layout_;
    std::unique_ptr<libdeflate_decompressor, FreeInflate> inflate_;
    std::vector<bool> isAsked_;  ///< of each channel
    Bytes packed_, bytes_;
};

}  // namespace

std::optional<ImageChannels> readZippedChannels(const std::filesystem::path& path,
                                                const std::vector<std::string>& names) {
    const File file = openFile(path);
    if (!file) return std::nullopt;
    const std::optional<Layout> layout = layoutOf(file.get(), names);
    if (!layout) return std::nullopt;
    ImageChannels image{layout->width, layout->height, {}};
    image.values.resize(names.size());
    for (std::vector<float>& values : image.values)
        values.resize(static_cast<std::size_t>(layout->width) *
                      static_cast<std::size_t>(layout->height));
    BlockReader blocks(file.get(), *layout);
    for (int y = 0; y < layout->height; y += layout->linesPerBlock)
        if (!blocks.read(y, image)) return std::nullopt;
    return image;
}

}  // namespace penumbra
