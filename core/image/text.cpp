#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "core/image/image.hpp"

namespace penumbra {
namespace {

constexpr const char* kFont = "DejaVuSans";

/// A character as it stands on the baseline at x = 0; y is downwards.
struct Glyph {
    int left = 0, top = 0, width = 0, height = 0;  ///< of its ink, in pixels
    int advance = 0;                               ///< to the next character
    std::vector<float> coverage;                   ///< width * height
};

OIIO::ROI extent(const std::string& text, int sizePx) {
    const OIIO::ROI roi = OIIO::ImageBufAlgo::text_size(text, sizePx, kFont);
    if (!roi.defined())
        throw std::runtime_error(fmt::format(
            "the font {} is not to be found (Debian package fonts-dejavu-core)", kFont));
    return roi;
}

Glyph renderGlyph(const std::string& character, int sizePx) {
    const OIIO::ROI roi = extent(character, sizePx);
    Glyph glyph{roi.xbegin, roi.ybegin, roi.width(), roi.height(), 0, {}};
    glyph.advance = extent(character + character, sizePx).xend - roi.xend;
    glyph.coverage.resize(static_cast<std::size_t>(glyph.width) *
                          static_cast<std::size_t>(glyph.height));
    OIIO::ImageBuf target(OIIO::ImageSpec(glyph.width, glyph.height, 1, OIIO::TypeDesc::FLOAT),
                          glyph.coverage.data());
    if (!OIIO::ImageBufAlgo::render_text(target, -glyph.left, -glyph.top, character, sizePx, kFont,
                                         {1.0F}))
        throw std::runtime_error("text cannot be drawn: " + target.geterror());
    return glyph;
}

/// The font is rasterised once per character and size: a run's grids have the same captions over
/// and over, and hinting a line takes longer than shading a tile.
const Glyph& glyphOf(const std::string& character, int sizePx) {
    thread_local std::map<std::pair<int, std::string>, Glyph> glyphs;
    const auto key = std::pair(sizePx, character);
    auto at = glyphs.find(key);
    if (at == glyphs.end()) at = glyphs.emplace(key, renderGlyph(character, sizePx)).first;
    return at->second;
}

/// Calls `place` with each glyph of `text` and where it stands behind the start of the baseline.
template <class Place>
void forEachGlyph(const std::string& text, int sizePx, Place place) {
    int x = 0;
    for (std::size_t begin = 0; begin < text.size();) {
        std::size_t end = begin + 1;
        // The bytes 10xxxxxx of UTF-8 continue a character.
        while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) ++end;
        const std::string character = text.substr(begin, end - begin);
        const bool control = character.size() == 1 && static_cast<unsigned char>(text[begin]) < ' ';
        const Glyph& glyph = glyphOf(control ? " " : character, sizePx);
        place(glyph, x);
        x += glyph.advance;
        begin = end;
    }
}

struct Span {
    int begin = 0, end = 0;
};

/// Pixels relative to the start of the baseline. A letter such as j may begin left of it.
Span inkSpan(const std::string& text, int sizePx) {
    Span span{std::numeric_limits<int>::max(), 0};
    forEachGlyph(text, sizePx, [&](const Glyph& glyph, int x) {
        span.begin = std::min(span.begin, x + glyph.left);
        span.end = std::max(span.end, x + glyph.left + glyph.width);
    });
    return span;
}

int leftOverhang(const Span& span) {
    return std::max(0, -span.begin);
}

}  // namespace

void drawText(Image& image, int x, int y, const std::string& text, int sizePx, float r, float g,
              float b) {
    if (text.empty()) return;
    if (image.channelCount() != 3) throw std::logic_error("drawText: three channels are needed");
    const int start = x + leftOverhang(inkSpan(text, sizePx));
    const std::array<float, 3> rgb = {r, g, b};
    forEachGlyph(text, sizePx, [&](const Glyph& glyph, int offset) {
        const int left = start + offset + glyph.left, top = y + glyph.top;
        for (int row = std::max(0, -top); row < std::min(glyph.height, image.height - top); ++row) {
            for (int col = std::max(0, -left); col < std::min(glyph.width, image.width - left);
                 ++col) {
                const float coverage =
                    glyph.coverage[static_cast<std::size_t>(row * glyph.width + col)];
                for (int c = 0; c < 3; ++c) {
                    float& value = image.at(left + col, top + row, c);
                    value += (rgb[static_cast<std::size_t>(c)] - value) * coverage;
                }
            }
        }
    });
}

int textWidth(const std::string& text, int sizePx) {
    if (text.empty()) return 0;
    const Span span = inkSpan(text, sizePx);
    return leftOverhang(span) + span.end;
}

}  // namespace penumbra
