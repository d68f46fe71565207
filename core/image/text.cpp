#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/image/image.hpp"

namespace penumbra {
namespace {

constexpr const char* kFont = "DejaVuSans";

/// Pixels relative to the start of the baseline. A letter such as j may begin left of it.
OIIO::ROI extent(const std::string& text, int sizePx) {
    const OIIO::ROI roi = OIIO::ImageBufAlgo::text_size(text, sizePx, kFont);
    if (!roi.defined())
        throw std::runtime_error(fmt::format(
            "the font {} is not to be found (Debian package fonts-dejavu-core)", kFont));
    return roi;
}

int leftOverhang(const OIIO::ROI& roi) {
    return std::max(0, -roi.xbegin);
}

}  // namespace

void drawText(Image& image, int x, int y, const std::string& text, int sizePx, float r, float g,
              float b) {
    if (text.empty()) return;
    if (image.channelCount() != 3) throw std::logic_error("drawText: three channels are needed");
    const int left = x + leftOverhang(extent(text, sizePx));
    const std::array<float, 3> rgb = {r, g, b};
    OIIO::ImageBuf target(OIIO::ImageSpec(image.width, image.height, 3, OIIO::TypeDesc::FLOAT),
                          image.pixels.data());
    if (!OIIO::ImageBufAlgo::render_text(target, left, y, text, sizePx, kFont, rgb))
        throw std::runtime_error("text cannot be drawn: " + target.geterror());
}

int textWidth(const std::string& text, int sizePx) {
    if (text.empty()) return 0;
    const OIIO::ROI roi = extent(text, sizePx);
    return leftOverhang(roi) + roi.xend;
}

}  // namespace penumbra
