#include "harness/metrics/ssim.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "harness/metrics/convolution.hpp"
#include "harness/metrics/error_sums.hpp"

namespace penumbra {

namespace {

constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;
constexpr double kC2 = 0.03 * 0.03;

/// The window is the outer product of these with themselves; they sum to 1.
std::vector<double> windowTaps() {
    std::vector<double> taps;
    double sum = 0.0;
    for (int k = 0; k <= kSsimRadius; ++k) {
        taps.push_back(std::exp(-k * k / (2.0 * kSigma * kSigma)));
        sum += (k ? 2.0 : 1.0) * taps.back();
    }
    for (double& tap : taps) tap /= sum;
    return taps;
}

/// Means under the window of what `fillRow(y, row)` says the rows hold, for pixels with a whole
/// window.
template <class FillRow>
std::vector<double> windowMeans(int width, int height, const FillRow& fillRow) {
    static const std::vector<double> kTaps = windowTaps();
    const int innerWidth = width - 2 * kSsimRadius, innerHeight = height - 2 * kSsimRadius;
    if (innerWidth < 1 || innerHeight < 1) return {};
    const auto rowSize = static_cast<std::size_t>(innerWidth);

    std::vector<double> acrossRows(rowSize * static_cast<std::size_t>(height));
    tbb::parallel_for(0, height, [&](int y) {
        thread_local std::vector<double> row;
        row.resize(static_cast<std::size_t>(width));
        fillRow(y, row.data());
        filterEven(
            kTaps, [](int k) { return row.data() + kSsimRadius + k; }, rowSize,
            &acrossRows[static_cast<std::size_t>(y) * rowSize]);
    });

    std::vector<double> means(rowSize * static_cast<std::size_t>(innerHeight));
    tbb::parallel_for(0, innerHeight, [&](int y) {
        filterEven(
            kTaps,
            [&](int k) {
                return &acrossRows[static_cast<std::size_t>(y + kSsimRadius + k) * rowSize];
            },
            rowSize, &means[static_cast<std::size_t>(y) * rowSize]);
    });
    return means;
}

}  // namespace

SsimImage prepareSsim(int width, int height, std::vector<float> values) {
    SsimImage image{width, height, std::move(values), {}, {}};
    const auto rowAt = [&](int y) {
        return image.values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    };
    image.mean =
        windowMeans(width, height, [&](int y, double* row) { std::copy_n(rowAt(y), width, row); });
    image.meanOfSquares = windowMeans(width, height, [&](int y, double* row) {
        std::transform(rowAt(y), rowAt(y) + width, row,
                       [](float v) { return static_cast<double>(v) * v; });
    });
    return image;
}

std::optional<double> ssim(const SsimImage& a, const SsimImage& b,
                           std::span<const std::uint8_t> counted) {
    if (a.width != b.width || a.height != b.height || counted.size() != a.values.size()) {
        throw std::invalid_argument(fmt::format("ssim: {} x {} and {} x {} pixels, {} counted",
                                                a.width, a.height, b.width, b.height,
                                                counted.size()));
    }
    const auto width = static_cast<std::size_t>(a.width);
    const std::vector<double> meanOfProducts =
        windowMeans(a.width, a.height, [&](int y, double* row) {
            const std::size_t first = static_cast<std::size_t>(y) * width;
            for (std::size_t x = 0; x < width; ++x) {
                row[x] = static_cast<double>(a.values[first + x]) * b.values[first + x];
            }
        });

    ErrorSums sums;
    const std::size_t innerWidth = width - std::min(width, std::size_t{2 * kSsimRadius});
    for (std::size_t i = 0; i < meanOfProducts.size(); ++i) {
        const std::size_t x = i % innerWidth + kSsimRadius, y = i / innerWidth + kSsimRadius;
        if (!counted[y * width + x]) continue;
        const double ma = a.mean[i], mb = b.mean[i];
        const double varianceA = a.meanOfSquares[i] - ma * ma;
        const double varianceB = b.meanOfSquares[i] - mb * mb;
        const double covariance = meanOfProducts[i] - ma * mb;
        sums.add((2.0 * ma * mb + kC1) * (2.0 * covariance + kC2) /
                 ((ma * ma + mb * mb + kC1) * (varianceA + varianceB + kC2)));
    }
    return sums.mean(sums.sum);
}

}  // namespace penumbra
