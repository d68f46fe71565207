#include "harness/report/grid.hpp"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <sstream>
#include <stdexcept>

#include "core/image/image.hpp"
#include "core/image/srgb.hpp"
#include "harness/report/shade_rows.hpp"

namespace penumbra {

namespace {

// Pixels.
constexpr int kMargin = 24;
constexpr int kGap = 12;
constexpr int kTileGap = 3;  ///< between an image and its error map
constexpr int kMinPageWidth = 720;
constexpr int kMaxColumnsPerLine = 12;
constexpr int kTitleSize = 30, kBodySize = 17, kSmallSize = 14;

// Linear RGB.
constexpr glm::vec3 kPage{0.011F};
constexpr glm::vec3 kEmptyTile{0.025F};
constexpr glm::vec3 kStrong{0.85F}, kNormal{0.52F}, kFaint{0.30F};
constexpr glm::vec3 kAlarm{0.90F, 0.22F, 0.10F};

int lineHeight(int sizePx) {
    return (sizePx * 14 + 9) / 10;
}

/// A picture that grows downwards as things are put on it.
struct Page {
    GridPicture picture;

    explicit Page(int width) { picture.width = width; }

    int bottom() const { return picture.height; }
    int innerWidth() const { return picture.width - 2 * kMargin; }

    /// `count` pixels from (x, y) on.
    std::span<std::uint8_t> bytes(int x, int y, int count) {
        const std::size_t first = static_cast<std::size_t>(y) * picture.width + x;
        return std::span(picture.rgb).subspan(3 * first, 3 * static_cast<std::size_t>(count));
    }
    /// Adds empty rows and returns where they start.
    int grow(int rows) {
        const int y = picture.height;
        picture.height += rows;
        picture.rgb.resize(static_cast<std::size_t>(picture.width) * picture.height * 3,
                           srgb8(kPage.r));
        return y;
    }
    void fill(int x, int y, int width, int height, const glm::vec3& rgb) {
        const std::array<std::uint8_t, 3> colour{srgb8(rgb.r), srgb8(rgb.g), srgb8(rgb.b)};
        for (int row = y; row < y + height; ++row) {
            const std::span<std::uint8_t> line = bytes(x, row, width);
            for (std::size_t i = 0; i < line.size(); ++i) line[i] = colour[i % 3];
        }
    }
    /// `y` is the top of the line, not the baseline.
    void text(int x, int y, const std::string& line, int sizePx, const glm::vec3& rgb) {
        const int width = std::min(textWidth(line, sizePx), picture.width - x);
        const int height = std::min(2 * sizePx, picture.height - y);
        if (width <= 0 || height <= 0) return;
        // Blended in linear values over what is there.
        Image strip = Image::withChannels(width, height, {"R", "G", "B"});
        const auto rowOf = [&](int row) {
            return std::span(strip.pixels)
                .subspan(static_cast<std::size_t>(row) * width * 3,
                         static_cast<std::size_t>(width) * 3);
        };
        for (int row = 0; row < height; ++row)
            std::ranges::transform(bytes(x, y + row, width), rowOf(row).begin(), linearOf);
        drawText(strip, 0, sizePx, line, sizePx, rgb.r, rgb.g, rgb.b);
        for (int row = 0; row < height; ++row) srgb8(rowOf(row), bytes(x, y + row, width));
    }
};

std::string ellipsized(const std::string& text, int sizePx, int maxWidth) {
    if (textWidth(text, sizePx) <= maxWidth) return text;
    std::size_t fits = 0, tooLong = text.size();
    while (fits + 1 < tooLong) {
        const std::size_t middle = (fits + tooLong) / 2;
        (textWidth(text.substr(0, middle) + "...", sizePx) <= maxWidth ? fits : tooLong) = middle;
    }
    // Never half a UTF-8 character: bytes 10xxxxxx continue the one before.
    while (fits > 0 && (static_cast<unsigned char>(text[fits]) & 0xC0U) == 0x80U) --fits;
    return text.substr(0, fits) + "...";
}

std::vector<std::string> wrapped(const std::string& text, int sizePx, int maxWidth,
                                 std::size_t maxLines) {
    std::vector<std::string> lines;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const std::string longer = lines.empty() ? word : lines.back() + ' ' + word;
        if (!lines.empty() && (lines.size() == maxLines || textWidth(longer, sizePx) <= maxWidth)) {
            lines.back() = longer;
        } else {
            lines.push_back(word);
        }
    }
    for (std::string& line : lines) line = ellipsized(line, sizePx, maxWidth);
    return lines;
}

struct TileSize {
    int width, height;
};

/// The largest size of this shape that is at most `width` wide and twice as high.
TileSize tileSize(const GBuffer& gbuffer, int width) {
    const double scale =
        std::min(static_cast<double>(width) / gbuffer.width, 2.0 * width / gbuffer.height);
    return {std::max(1, static_cast<int>(std::lround(gbuffer.width * scale))),
            std::max(1, static_cast<int>(std::lround(gbuffer.height * scale)))};
}

Image resized(Image& source, TileSize size) {
    using namespace OIIO;
    Image target = Image::withChannels(size.width, size.height, source.channels);
    const ImageBuf from(ImageSpec(source.width, source.height, 3, TypeDesc::FLOAT),
                        source.pixels.data());
    ImageBuf to(ImageSpec(size.width, size.height, 3, TypeDesc::FLOAT), target.pixels.data());
    // A box one target pixel wide weighs source pixels evenly only at whole factors.
    const bool whole = size.width % source.width == 0;
    if (!ImageBufAlgo::resize(to, from, whole ? "box" : "triangle")) {
        throw std::runtime_error("grid: cannot resize a tile: " + to.geterror());
    }
    return target;
}

/// Puts a picture of the G-buffer's size onto the page, resized; `rows(begin, end, rgb)` paints
/// some of its rows.
template <class Rows>
void pasteTile(Page& page, int x, int y, const GBuffer& gbuffer, TileSize size, Rows rows) {
    const auto width = static_cast<std::size_t>(gbuffer.width);
    const int factor = gbuffer.width / size.width;
    if (gbuffer.width != factor * size.width || gbuffer.height != factor * size.height) {
        Image whole = Image::withChannels(gbuffer.width, gbuffer.height, {"R", "G", "B"});
        rows(0, gbuffer.height, std::span(whole.pixels));
        const Image tile = resized(whole, size);
        for (int row = 0; row < size.height; ++row)
            srgb8(std::span(tile.pixels)
                      .subspan(static_cast<std::size_t>(row) * size.width * 3,
                               static_cast<std::size_t>(size.width) * 3),
                  page.bytes(x, y + row, size.width));
        return;
    }
    // Means of factor x factor pixels, a strip of the picture at a time: OpenImageIO's resize takes
    // ten times as long, and images in between cost more than painting them.
    std::vector<float> strip(3 * width * static_cast<std::size_t>(factor));
    std::vector<float> line(3 * static_cast<std::size_t>(size.width));
    const float weight = 1.0F / static_cast<float>(factor * factor);
    for (int row = 0; row < size.height; ++row) {
        rows(factor * row, factor * (row + 1), std::span(strip));
        std::ranges::fill(line, 0.0F);
        for (const float* from = strip.data(); from != strip.data() + strip.size();)
            for (float* to = line.data(); to != line.data() + line.size(); to += 3)
                for (int i = 0; i < factor; ++i, from += 3)
                    for (int c = 0; c < 3; ++c) to[c] += weight * from[c];
        srgb8(line, page.bytes(x, y + row, size.width));
    }
}

// ---- legend ----------------------------------------------------------------------------------

struct LegendFlow {
    Page& page;
    int x = kMargin;
    int y;
    static constexpr int kHeight = 46;

    explicit LegendFlow(Page& target) : page(target), y(target.grow(kHeight)) {}

    /// Room for one item `width` wide, on a new line if this one is full.
    int place(int width) {
        if (x > kMargin && x + width > page.picture.width - kMargin) {
            x = kMargin;
            y = page.grow(kHeight);
        }
        const int at = x;
        x += width + 2 * kGap;
        return at;
    }
};

/// `too dark [ -0.25 … 0 … +0.25 ] leaks light`, numbers under the bar.
void drawErrorBar(LegendFlow& flow) {
    constexpr int kBarWidth = 260, kBarHeight = 16;
    const std::string low = "too dark", high = "leaks light";
    const int lowWidth = textWidth(low, kBodySize);
    const int x = flow.place(lowWidth + kBarWidth + textWidth(high, kBodySize) + 2 * kGap);
    const int bar = x + lowWidth + kGap;
    Page& page = flow.page;
    page.text(x, flow.y, low, kBodySize, kNormal);
    page.text(bar + kBarWidth + kGap, flow.y, high, kBodySize, kNormal);
    for (int i = 0; i < kBarWidth; ++i) {
        const float t = static_cast<float>(i) / (kBarWidth - 1);
        page.fill(bar + i, flow.y + 3, 1, kBarHeight, errorColour((2 * t - 1) * kErrorScale));
    }
    for (const float tick : {-1.0F, 0.0F, 1.0F}) {
        const float value = tick * kErrorScale;
        const std::string label = tick == 0.0F ? "0" : fmt::format("{:+.2f}", value);
        const int centre = bar + static_cast<int>((tick + 1) / 2 * (kBarWidth - 1));
        page.fill(centre, flow.y + 3 + kBarHeight, 1, 3, kNormal);
        page.text(centre - textWidth(label, kSmallSize) / 2, flow.y + 5 + kBarHeight, label,
                  kSmallSize, kNormal);
    }
}

void drawSwatch(LegendFlow& flow, const std::string& label, const glm::vec3& rgb) {
    constexpr int kSwatch = 18;
    const int x = flow.place(kSwatch + 6 + textWidth(label, kBodySize));
    flow.page.fill(x, flow.y + 2, kSwatch, kSwatch, kFaint);
    flow.page.fill(x + 1, flow.y + 3, kSwatch - 2, kSwatch - 2, rgb);
    flow.page.text(x + kSwatch + 6, flow.y, label, kBodySize, kNormal);
}

void drawHeader(Page& page, const std::string& sceneId, const std::string& shows) {
    page.grow(kMargin);
    page.text(kMargin, page.grow(lineHeight(kTitleSize)),
              ellipsized(sceneId, kTitleSize, page.innerWidth()), kTitleSize, kStrong);
    for (const std::string& line : wrapped(shows, kBodySize, page.innerWidth(), 4)) {
        page.text(kMargin, page.grow(lineHeight(kBodySize)), line, kBodySize, kNormal);
    }
    page.grow(kGap);
    LegendFlow flow(page);
    drawErrorBar(flow);
    drawSwatch(flow, "not finite", errorColour(std::numeric_limits<float>::quiet_NaN()));
    for (const ClassColour& c : classColours()) {
        const bool unscored = c.name == "horizon";
        drawSwatch(flow, fmt::format("{}{}", c.name, unscored ? " (not scored)" : ""), c.rgb);
    }
}

// ---- columns ---------------------------------------------------------------------------------

/// Four significant digits at most, never an exponent.
std::string milliseconds(double ms) {
    return fmt::format("{:.{}f} ms", ms, ms >= 100 ? 0 : ms >= 10 ? 1 : 2);
}

struct Caption {
    std::string name, numbers, small;
};

constexpr std::size_t kSmallLines = 2;

int captionHeight() {
    return kGap + 2 * lineHeight(kBodySize) +
           static_cast<int>(kSmallLines) * lineHeight(kSmallSize);
}

void drawCaption(Page& page, int x, int y, int width, const Caption& caption) {
    y += 4;
    page.text(x, y, ellipsized(caption.name, kBodySize, width), kBodySize, kStrong);
    y += lineHeight(kBodySize);
    page.text(x, y, ellipsized(caption.numbers, kBodySize, width), kBodySize, kNormal);
    y += lineHeight(kBodySize);
    for (const std::string& line : wrapped(caption.small, kSmallSize, width, kSmallLines)) {
        page.text(x, y, line, kSmallSize, kFaint);
        y += lineHeight(kSmallSize);
    }
}

Caption captionOf(const Row& row) {
    Caption caption;
    caption.name = row.setting;
    if (row.metrics.rmse) caption.numbers = fmt::format("rmse {:.4f}", *row.metrics.rmse);
    if (row.frameMs) {
        if (!caption.numbers.empty()) caption.numbers += "    ";
        caption.numbers += milliseconds(*row.frameMs);
    }
    if (!row.effectsMissing.empty()) caption.small = "missing: " + row.effectsMissing + ' ';
    if (row.setting != row.method) {
        for (const char c : row.params) {
            caption.small += c;
            if (c == ';') caption.small += ' ';  // where the text may wrap
        }
    }
    return caption;
}

/// Draws the columns of one frame, which share its lighting and tile size.
class FrameColumns {
  public:
    FrameColumns(Page& page, const GridFrame& frame, int columnWidth)
        : page_(page),
          frame_(frame),
          columnWidth_(columnWidth),
          tile_(tileSize(*frame.gbuffer, columnWidth)),
          light_(pictureLight(*frame.gbuffer)) {}

    int height() const { return 2 * tile_.height + kTileGap + captionHeight(); }

    void drawReference(int x, int y) {
        const Reference& reference = *frame_.reference;
        const Image classes = classMap(*frame_.gbuffer, reference);
        pasteTiles(x, y, reference.visibility, [&](int begin, int end, std::span<float> rgb) {
            const auto row = static_cast<std::size_t>(classes.width) * 3;
            std::copy_n(&classes.pixels[row * static_cast<std::size_t>(begin)],
                        row * static_cast<std::size_t>(end - begin), rgb.begin());
        });
        Caption caption{"reference", "below: lit, penumbra, umbra", ""};
        for (const GridCell& cell : frame_.cells) {
            if (!cell.row->metrics.referenceSe) continue;
            caption.small = fmt::format("standard error {:.2g}", *cell.row->metrics.referenceSe);
            break;
        }
        drawCaption(page_, x, captionY(y), columnWidth_, caption);
    }

    void drawCell(int x, int y, const GridCell& cell) {
        if (cell.visibility.empty()) {
            drawStatus(x, y, *cell.row);
        } else {
            pasteTiles(x, y, cell.visibility, [&](int begin, int end, std::span<float> rgb) {
                errorRows(*frame_.gbuffer, cell.visibility, *frame_.reference, begin, end, rgb);
            });
        }
        drawCaption(page_, x, captionY(y), columnWidth_, captionOf(*cell.row));
    }

  private:
    int captionY(int y) const { return y + 2 * tile_.height + kTileGap; }

    /// Shaded `visibility` and what `below` paints.
    template <class Rows>
    void pasteTiles(int x, int y, const std::vector<float>& visibility, Rows below) {
        x += (columnWidth_ - tile_.width) / 2;
        pasteTile(page_, x, y, *frame_.gbuffer, tile_,
                  [&](int begin, int end, std::span<float> rgb) {
                      shadeRows(*frame_.gbuffer, visibility, light_, begin, end, rgb);
                  });
        pasteTile(page_, x, y + tile_.height + kTileGap, *frame_.gbuffer, tile_, below);
    }

    void drawStatus(int x, int y, const Row& row) {
        const int height = 2 * tile_.height + kTileGap;
        page_.fill(x, y, columnWidth_, height, kEmptyTile);
        const int textX = x + kGap;
        const int width = columnWidth_ - 2 * kGap;
        int textY = y + kGap;
        const bool ok = row.status == "ok";
        page_.text(textX, textY, ellipsized(ok ? "no image" : row.status, kTitleSize, width),
                   kTitleSize, ok ? kNormal : kAlarm);
        textY += lineHeight(kTitleSize);
        const int room = std::max(1, (y + height - textY) / lineHeight(kBodySize));
        for (const std::string& line :
             wrapped(row.message, kBodySize, width, static_cast<std::size_t>(room))) {
            page_.text(textX, textY, line, kBodySize, kNormal);
            textY += lineHeight(kBodySize);
        }
    }

    Page& page_;
    const GridFrame& frame_;
    int columnWidth_;
    TileSize tile_;
    PictureLight light_;
};

}  // namespace

GridPicture renderGrid(const std::string& sceneId, const std::string& shows,
                       const std::vector<GridFrame>& frames) {
    std::size_t most = 0;
    for (const GridFrame& frame : frames) most = std::max(most, frame.cells.size());
    const int columns = static_cast<int>(most) + 1;
    const int perLine = std::min(columns, kMaxColumnsPerLine);
    const int columnWidth = columns <= 6 ? 384 : 256;

    Page page(std::max(kMinPageWidth, 2 * kMargin + perLine * columnWidth + (perLine - 1) * kGap));
    drawHeader(page, sceneId, shows);
    for (const GridFrame& frame : frames) {
        if (frames.size() > 1) {
            page.grow(kGap);
            page.text(kMargin, page.grow(lineHeight(kBodySize) + 2),
                      fmt::format("frame {}", frame.index), kBodySize, kStrong);
        }
        FrameColumns drawing(page, frame, columnWidth);
        int y = 0;
        for (int column = 0; column <= static_cast<int>(frame.cells.size()); ++column) {
            const int place = column % perLine;
            if (place == 0) y = page.grow(drawing.height());
            const int x = kMargin + place * (columnWidth + kGap);
            if (column == 0) {
                drawing.drawReference(x, y);
            } else {
                drawing.drawCell(x, y, frame.cells[static_cast<std::size_t>(column) - 1]);
            }
        }
    }
    page.grow(kMargin - kGap);
    return std::move(page.picture);
}

}  // namespace penumbra
