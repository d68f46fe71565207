#include "core/trace/alpha_mask.hpp"

#include <algorithm>
#include <array>

namespace penumbra {
namespace {

/// Filtering stays within the range of the four texels up to rounding.
constexpr float kRounding = 1e-5f;

}  // namespace

double shareCutOut(const Material& material, const std::vector<TextureImage>& images) {
    if (!material.masked || material.alphaCutoff <= 0.0f) return 0.0;
    if (material.baseColorTexture < 0)
        return material.baseColor.a >= material.alphaCutoff ? 0.0 : 1.0;
    const TextureImage& image = images[static_cast<std::size_t>(material.baseColorTexture)];
    std::array<bool, 256> cut{};
    for (std::size_t a = 0; a < cut.size(); ++a)
        cut[a] = material.baseColor.a * static_cast<float>(a) / 255.0f <
                 material.alphaCutoff + kRounding;
    const std::size_t texels = image.rgba.size() / 4;
    std::size_t count = 0;
    for (std::size_t i = 0; i < texels; ++i) count += cut[image.rgba[4 * i + 3]];
    return texels > 0 ? static_cast<double>(count) / static_cast<double>(texels) : 0.0;
}

AlphaMask::AlphaMask(const Material& material, const std::vector<TextureImage>& images)
    : material_(material), images_(images) {
    if (material.baseColorTexture < 0) return;
    image_ = &images[material.baseColorTexture];
    const int width = image_->width, height = image_->height;
    cells_.resize(static_cast<std::size_t>(std::max(0, width - 1)) * std::max(0, height - 1));
    const auto alpha = [&](int x, int y) {
        const std::size_t texel = static_cast<std::size_t>(y) * width + x;
        return material.baseColor.a * static_cast<float>(image_->rgba[4 * texel + 3]) / 255.0f;
    };
    for (int y = 0; y + 1 < height; ++y)
        for (int x = 0; x + 1 < width; ++x) {
            const auto [least, most] =
                std::minmax({alpha(x, y), alpha(x + 1, y), alpha(x, y + 1), alpha(x + 1, y + 1)});
            Cell& cell = cells_[static_cast<std::size_t>(y) * (width - 1) + x];
            cell = least >= material.alphaCutoff + kRounding ? Cell::present
                   : most < material.alphaCutoff - kRounding ? Cell::absent
                                                             : Cell::outline;
        }
}

bool AlphaMask::present(glm::vec2 uv) const {
    if (image_) {
        const float x = uv.x * static_cast<float>(image_->width) - 0.5f;
        const float y = uv.y * static_cast<float>(image_->height) - 0.5f;
        // Inside the outermost texel centres no wrapping is involved; the comparisons also fail for
        // NaN. Half a thousandth of a texel keeps rounding from picking the cell next to it.
        constexpr float kMargin = 5e-4f;
        if (x > 0.0f && y > 0.0f && x < static_cast<float>(image_->width - 1) &&
            y < static_cast<float>(image_->height - 1)) {
            const int i = static_cast<int>(x), j = static_cast<int>(y);
            const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
            const Cell cell = cells_[static_cast<std::size_t>(j) * (image_->width - 1) + i];
            if (cell != Cell::outline && std::min(fx, fy) > kMargin &&
                std::max(fx, fy) < 1.0f - kMargin)
                return cell == Cell::present;
        }
    }
    return baseColorAt(material_, images_, uv).a >= material_.alphaCutoff;
}

}  // namespace penumbra
