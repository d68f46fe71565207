#include "harness/exchange/alignment.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace penumbra {
namespace {

/// An image is displaced if elsewhere its rmse is below this share of what it is in place. Methods'
/// errors are no displacements: of 216 images of hard (maps of 128 to 1024 texels, bias 0.5 and 4),
/// pcf and ray_traced over the standard suite at 192 x 192, none went below 0.97. What is right but
/// for its place goes to nearly 0.
constexpr double kFitsElsewhere = 0.5;
/// Below one step of 8 bits there is nothing to gain by moving an image.
constexpr double kLeastRmse = 1.0 / 255;
/// Sampled pixels while searching; the result is confirmed on all of them. Coverage differs in few
/// pixels and needs more.
constexpr std::size_t kSamples = 16384, kCoverageSamples = 262144;

/// An image is turned over first and then moved by (dx, dy) pixels, right and down.
struct Move {
    bool upsideDown = false, mirrored = false;
    int dx = 0, dy = 0;

    bool inPlace() const { return !upsideDown && !mirrored && dx == 0 && dy == 0; }
    int size() const { return std::abs(dx) + std::abs(dy) + 100 * (upsideDown + mirrored); }
    /// Where in the image the pixel (x, y) of the moved image comes from; what would come from
    /// outside comes from the border.
    std::size_t from(int x, int y, int width, int height) const {
        const int u = std::clamp(x - dx, 0, width - 1), v = std::clamp(y - dy, 0, height - 1);
        return static_cast<std::size_t>(upsideDown ? height - 1 - v : v) * width +
               static_cast<std::size_t>(mirrored ? width - 1 - u : u);
    }
    /// "moved by (+2, -1) pixels (right, down)", "upside down"
    std::string words() const {
        std::string text = upsideDown && mirrored ? "turned by 180 degrees"
                           : upsideDown           ? "turned upside down"
                           : mirrored             ? "mirrored left to right"
                                                  : "";
        if (dx != 0 || dy != 0)
            text += fmt::format("{}moved by ({:+}, {:+}) pixels (right, down)",
                                text.empty() ? "" : " and ", dx, dy);
        return text;
    }
};

/// Every move that leaves most of the image in view, the identity first.
std::vector<Move> movesFor(int width, int height) {
    const int mostX = std::min(kMostShift, width / 8), mostY = std::min(kMostShift, height / 8);
    std::vector<Move> moves;
    for (const bool upsideDown : {false, true})
        for (const bool mirrored : {false, true})
            for (int dy = -mostY; dy <= mostY; ++dy)
                for (int dx = -mostX; dx <= mostX; ++dx)
                    moves.push_back({upsideDown, mirrored, dx, dy});
    std::ranges::stable_sort(moves, {}, &Move::size);
    return moves;
}

/// The move of the least cost, of equal ones the smallest.
template <class Cost>
Move best(const std::vector<Move>& moves, const Cost& cost) {
    std::vector<double> costs(moves.size());
    tbb::parallel_for(std::size_t{0}, moves.size(),
                      [&](std::size_t i) { costs[i] = cost(moves[i]); });
    return moves[static_cast<std::size_t>(std::ranges::min_element(costs) - costs.begin())];
}

std::string percent(double share) {
    return fmt::format("{:.{}f} %", 100 * share, share < 0.0095 ? 2 : 1);
}

// ---- coverage ----------------------------------------------------------------------------------

/// What the frame says of a pixel's coverage.
enum class Expected : std::uint8_t { uncovered, covered, either };

/// Unshadowed irradiance times albedo below this share of the frame's brightest may be stored as 0
/// in 8 bits or half floats.
constexpr double kDark = 1e-3;

/// Whether most pixels of a class are covered.
bool mostlyCovered(PixelClass c, const GBuffer& g, const std::vector<std::uint8_t>& covered) {
    std::size_t all = 0, shown = 0;
    for (std::size_t i = 0; i < g.size(); ++i)
        if (g.mask[i] == c) ++all, shown += covered[i];
    return 2 * shown > all;
}

/// Which pixels are lit if nothing casts. Other renderers may light by the shading normal, part of
/// the light behind a horizon or dark surfaces either way, and a backdrop or ambient light may fill
/// what the light does not reach.
std::vector<Expected> expectedLit(const GBuffer& g, const std::vector<std::uint8_t>& covered) {
    std::vector<double> brightness(g.size(), 0.0);
    for (std::size_t i = 0; i < g.size(); ++i)
        brightness[i] = static_cast<double>(g.irradianceUnshadowed[i]) *
                        std::max({g.albedo[i].r, g.albedo[i].g, g.albedo[i].b});
    const double dark = kDark * *std::ranges::max_element(brightness);
    const auto unlit = [&](PixelClass c) {
        return mostlyCovered(c, g, covered) ? Expected::either : Expected::uncovered;
    };
    const Expected background = unlit(PixelClass::background),
                   facingAway = unlit(PixelClass::facingAway);
    std::vector<Expected> expected(g.size(), Expected::either);
    for (std::size_t i = 0; i < g.size(); ++i) {
        const bool flat = g.geometricNormal[i] == g.shadingNormal[i];
        if (g.mask[i] == PixelClass::background)
            expected[i] = background;
        else if (g.mask[i] == PixelClass::facingAway && flat)
            expected[i] = facingAway;
        else if (g.mask[i] == PixelClass::scored && flat && brightness[i] > dark)
            expected[i] = Expected::covered;
    }
    return expected;
}

std::vector<Expected> expectedSurface(const GBuffer& g) {
    std::vector<Expected> expected(g.size());
    std::ranges::transform(g.mask, expected.begin(), [](PixelClass c) {
        return c == PixelClass::background ? Expected::uncovered : Expected::covered;
    });
    return expected;
}

/// Share of pixels, of every `stride`-th, in which `covered`, moved, is not as expected.
double differing(const std::vector<Expected>& expected, const std::vector<std::uint8_t>& covered,
                 int width, int height, const Move& move, std::size_t stride = 1) {
    std::size_t differ = 0, seen = 0;
    for (std::size_t i = 0; i < expected.size(); i += stride) {
        if (expected[i] == Expected::either) continue;
        const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
        ++seen;
        differ +=
            (expected[i] == Expected::covered) != (covered[move.from(x, y, width, height)] != 0);
    }
    return seen == 0 ? 0.0 : static_cast<double>(differ) / static_cast<double>(seen);
}

/// Mean share of pixels that change when the frame itself is displaced by one pixel.
double changeOfOnePixel(const std::vector<Expected>& expected, int width, int height) {
    std::vector<std::uint8_t> itself(expected.size());
    std::ranges::transform(expected, itself.begin(),
                           [](Expected e) { return e == Expected::covered; });
    double sum = 0.0;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        sum += differing(expected, itself, width, height, {false, false, dx, dy});
    return 0.25 * sum;
}

/// Whether what is not finite is how the image says where it has no surface: it then is so in most
/// of the frame's background, which a defect is not.
bool marksBackground(const OutsideImage& image, const GBuffer& gbuffer) {
    std::size_t background = 0, marked = 0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::background) continue;
        ++background;
        marked += !std::isfinite(image.visibility[i]);
    }
    return background > 0 && 2 * marked > background;
}

// ---- visibility --------------------------------------------------------------------------------

/// The pixels that are compared wherever the image is moved to, as all moves must answer for the
/// same ones.
struct Site {
    int x, y;
    float visibility;
};

std::vector<Site> sitesOf(const GBuffer& gbuffer, const Reference& reference) {
    const int marginX = std::min(kMostShift, gbuffer.width / 8);
    const int marginY = std::min(kMostShift, gbuffer.height / 8);
    std::vector<Site> sites;
    for (int y = marginY; y < gbuffer.height - marginY; ++y)
        for (int x = marginX; x < gbuffer.width - marginX; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * gbuffer.width + x;
            if (gbuffer.mask[i] == PixelClass::scored)
                sites.push_back({x, y, reference.visibility[i]});
        }
    return sites;
}

double rmseAt(const OutsideImage& image, const std::vector<Site>& sites, std::size_t stride,
              const Move& move) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t k = 0; k < sites.size(); k += stride, ++count) {
        const Site& site = sites[k];
        const float v = image.visibility[move.from(site.x, site.y, image.width, image.height)];
        // What is no visibility fits nowhere.
        const double error = std::isfinite(v) ? static_cast<double>(v) - site.visibility : 1.0;
        sum += error * error;
    }
    return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

std::optional<std::string> coverageDisplacement(const OutsideImage& image, const GBuffer& gbuffer) {
    std::vector<std::uint8_t> covered = image.covered;
    if (covered.empty()) {
        if (!marksBackground(image, gbuffer)) return std::nullopt;
        covered.resize(image.visibility.size());
        std::ranges::transform(image.visibility, covered.begin(),
                               [](float v) { return std::isfinite(v); });
    }
    const int width = gbuffer.width, height = gbuffer.height;
    const std::vector<Expected> expected =
        image.coverageIsLit ? expectedLit(gbuffer, covered) : expectedSurface(gbuffer);
    const double inPlace = differing(expected, covered, width, height, {});
    // At least four pixels: the outline may be shorter than that.
    const double allowed = std::max(0.25 * changeOfOnePixel(expected, width, height),
                                    4.0 / static_cast<double>(expected.size()));
    if (inPlace <= allowed) return std::nullopt;

    const std::size_t stride = std::max<std::size_t>(1, expected.size() / kCoverageSamples);
    const Move move = best(movesFor(width, height), [&](const Move& m) {
        return differing(expected, covered, width, height, m, stride);
    });
    const double elsewhere = differing(expected, covered, width, height, move);
    const std::string found = fmt::format(
        "{}: coverage differs from the frame's in {} of the pixels", image.name, percent(inPlace));
    // A displacement explains most of what differs, or it is none.
    if (!move.inPlace() && elsewhere <= kFitsElsewhere * inPlace)
        return fmt::format("{}; {} it would in {}", found, move.words(), percent(elsewhere));
    return fmt::format(
        "{} ({} is allowed), and no shift within {} pixels and no flip explains it: "
        "another camera, frame, size or geometry",
        found, percent(allowed), kMostShift);
}

std::optional<std::string> visibilityDisplacement(const OutsideImage& image, const GBuffer& gbuffer,
                                                  const Reference& reference) {
    const std::vector<Site> sites = sitesOf(gbuffer, reference);
    const double inPlace = rmseAt(image, sites, 1, {});
    if (inPlace <= kLeastRmse) return std::nullopt;
    const std::size_t stride = std::max<std::size_t>(1, sites.size() / kSamples);
    const Move move = best(movesFor(gbuffer.width, gbuffer.height),
                           [&](const Move& m) { return rmseAt(image, sites, stride, m); });
    const double elsewhere = rmseAt(image, sites, 1, move);
    if (move.inPlace() || elsewhere > kFitsElsewhere * inPlace) return std::nullopt;
    return fmt::format("{}: the rmse against the reference is {:.4f}; {} it would be {:.4f}",
                       image.name, inPlace, move.words(), elsewhere);
}

}  // namespace penumbra
