#include "harness/exchange/outside_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace penumbra {
namespace {

constexpr float kCovered = 0.5F;  ///< an antialiased edge belongs to what fills most of the pixel
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
/// Largest difference between the channels of a grey picture: one step of 8 bits.
constexpr float kGreyStep = 1.0F / 255;

std::string differenceOf(int theirs, int ours, const char* what) {
    if (theirs == ours) return "";
    return fmt::format("{} {}{} too {}", std::abs(theirs - ours), what,
                       std::abs(theirs - ours) == 1 ? "" : "s", theirs > ours ? "many" : "few");
}

/// ": 12 columns too few, 3 rows too many"
std::string byHowMuch(int width, int height, int wantedWidth, int wantedHeight) {
    const std::string columns = differenceOf(width, wantedWidth, "column");
    const std::string rows = differenceOf(height, wantedHeight, "row");
    return columns + (columns.empty() || rows.empty() ? "" : ", ") + rows;
}

/// What the files of an image have in common: size, coverage and what was assumed.
void describe(const DiffImage& file, OutsideImage& out) {
    out.width = file.image.width;
    out.height = file.image.height;
    if (file.decoded)
        out.notes.push_back(fmt::format(
            "{}: its numbers are read as sRGB-encoded (--linear takes them as they are)",
            file.name));
    // An alpha channel that is full everywhere says nothing: most writers fill it so.
    if (std::ranges::any_of(file.coverage, [](float c) { return !(c >= kCovered); })) {
        out.notes.push_back(fmt::format("{}: {} says which pixels show a surface", file.name,
                                        file.coverageChannel));
        out.covered.resize(file.coverage.size());
        std::ranges::transform(file.coverage, out.covered.begin(),
                               [](float c) { return c >= kCovered; });
    } else if (!file.note.empty()) {
        out.notes.push_back(file.note);
    }
}

/// Rec. 709 luminance of linear values, or the only channel.
std::vector<float> luminance(const DiffImage& file) {
    if (!file.colour()) return file.image.pixels;
    std::vector<float> out(file.image.pixels.size() / 3);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float* rgb = &file.image.pixels[3 * i];
        out[i] = 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2];
    }
    return out;
}

/// The one channel of a picture whose colours are all grey.
std::vector<float> greyOf(const DiffImage& file) {
    if (!file.colour()) return file.image.pixels;
    std::vector<float> grey(file.image.pixels.size() / 3);
    std::size_t coloured = 0;
    float most = 0.0F;
    for (std::size_t i = 0; i < grey.size(); ++i) {
        const auto [lo, hi] = std::minmax(
            {file.image.pixels[3 * i], file.image.pixels[3 * i + 1], file.image.pixels[3 * i + 2]});
        coloured += hi - lo > kGreyStep;
        most = std::max(most, hi - lo);
        grey[i] = file.image.pixels[3 * i + 1];
    }
    if (coloured > 0)
        throw InputError(fmt::format(
            "{}: R, G and B differ in {} of {} pixels, by up to {:.3g}: a visibility image is "
            "grey; for rendered pictures use --shadowed and --unshadowed",
            file.name, coloured, grey.size(), most));
    return grey;
}

/// Refuses an image that shows nothing.
void requireContent(const OutsideImage& image) {
    if (!image.covered.empty() && std::ranges::count(image.covered, 1) == 0)
        throw InputError(fmt::format("{}: no pixel is covered", image.name));
    if (std::ranges::none_of(image.visibility, [](float v) { return std::isfinite(v); }))
        throw InputError(fmt::format("{}: no pixel is finite", image.name));
}

}  // namespace

OutsideImage readVisibility(const std::filesystem::path& path, Transfer transfer) {
    const DiffImage file = readForDiff(path, transfer);
    OutsideImage out;
    out.name = file.name;
    describe(file, out);
    out.visibility = greyOf(file);
    requireContent(out);
    return out;
}

OutsideImage readRatio(const std::filesystem::path& shadowedPath,
                       const std::filesystem::path& unshadowedPath, Transfer transfer) {
    const DiffImage shadowed = readForDiff(shadowedPath, transfer);
    const DiffImage unshadowed = readForDiff(unshadowedPath, transfer);
    const Image &a = shadowed.image, &b = unshadowed.image;
    if (a.width != b.width || a.height != b.height)
        throw InputError(fmt::format("{} is {}x{}, {} {}x{}: {}", shadowed.name, a.width, a.height,
                                     unshadowed.name, b.width, b.height,
                                     byHowMuch(a.width, a.height, b.width, b.height)));
    OutsideImage out;
    out.name = fmt::format("{} / {}", shadowed.name, unshadowed.name);
    describe(shadowed, out);
    describe(unshadowed, out);
    const std::vector<float> lit = luminance(unshadowed);
    out.visibility = luminance(shadowed);
    out.masked.resize(lit.size());
    for (std::size_t i = 0; i < lit.size(); ++i) {
        out.masked[i] = !(lit[i] > 0.0F && std::isfinite(lit[i]));
        out.visibility[i] = out.masked[i] ? kNone : out.visibility[i] / lit[i];
    }
    if (out.covered.empty()) {
        out.coverageIsLit = true;
        out.covered.resize(lit.size());
        std::ranges::transform(out.masked, out.covered.begin(),
                               [](std::uint8_t masked) { return masked == 0; });
    }
    requireContent(out);
    return out;
}

void requireSize(const OutsideImage& image, int width, int height) {
    if (image.width == width && image.height == height) return;
    throw InputError(fmt::format("{}: the image is {}x{}, the frame {}x{}: {}", image.name,
                                 image.width, image.height, width, height,
                                 byHowMuch(image.width, image.height, width, height)));
}

}  // namespace penumbra
