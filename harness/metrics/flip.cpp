#include "harness/metrics/flip.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "harness/metrics/convolution.hpp"

namespace penumbra {

namespace {

using Taps = std::vector<float>;

constexpr float kColourExponent = 0.7F;     ///< qc
constexpr float kColourKnee = 0.4F;         ///< pc, of the largest difference
constexpr float kColourAtKnee = 0.95F;      ///< pt
constexpr double kFeatureWidthDeg = 0.082;  ///< w

// ---- filters -----------------------------------------------------------------------------------

/// Weight at distances 0..radius, both sides together summing to 1.
Taps normalised(const std::vector<double>& weights) {
    double sum = -weights[0];
    for (const double w : weights) sum += 2.0 * w;
    Taps taps;
    for (const double w : weights) taps.push_back(static_cast<float>(w / sum));
    return taps;
}

/// The eye's contrast sensitivity as kernels. Each channel's is a Gaussian exp(-pi^2 d^2 / b), the
/// blue-yellow one a sum of two, so that all are separable.
struct ContrastFilters {
    Taps achromatic, redGreen, blueYellow1, blueYellow2;
    float share1 = 0, share2 = 0;  ///< weights of the two blue-yellow Gaussians
    int radius = 0;

    ContrastFilters() {
        constexpr double kPi2 = std::numbers::pi * std::numbers::pi;
        constexpr double kA1 = 34.1, kB1 = 0.04, kA2 = 13.5, kB2 = 0.025;
        radius =
            static_cast<int>(std::ceil(3.0 * std::sqrt(kB1 / (2.0 * kPi2)) * kFlipPixelsPerDegree));
        double sum = 0;
        const auto gaussian = [&](double b) {
            std::vector<double> weights;
            sum = 0;
            for (int k = 0; k <= radius; ++k) {
                const double distanceDeg = k / kFlipPixelsPerDegree;
                const double weight = std::exp(-kPi2 * distanceDeg * distanceDeg / b);
                // Narrow kernels in the window of the widest: what no float sum would notice.
                if (weight < 1e-9) break;
                weights.push_back(weight);
                sum += (k ? 2.0 : 1.0) * weight;
            }
            return normalised(weights);
        };
        achromatic = gaussian(0.0047);
        redGreen = gaussian(0.0053);
        blueYellow1 = gaussian(kB1);
        const double mass1 = kA1 * std::sqrt(std::numbers::pi / kB1) * sum * sum;
        blueYellow2 = gaussian(kB2);
        const double mass2 = kA2 * std::sqrt(std::numbers::pi / kB2) * sum * sum;
        share1 = static_cast<float>(mass1 / (mass1 + mass2));
        share2 = static_cast<float>(mass2 / (mass1 + mass2));
    }
};

/// Edges and points of luminance: derivatives of a Gaussian along one axis, the Gaussian itself
/// along the other. Positive and negative lobes each sum to 1.
struct FeatureFilters {
    Taps smooth, edge, point;
    int radius = 0;

    FeatureFilters() {
        const double sigma = 0.5 * kFeatureWidthDeg * kFlipPixelsPerDegree;
        radius = static_cast<int>(std::ceil(3.0 * sigma));
        std::vector<double> gaussian, first, second;
        double firstSum = 0, positive = 0, negative = 0;
        for (int k = 0; k <= radius; ++k) {
            const double e = std::exp(-k * k / (2.0 * sigma * sigma));
            gaussian.push_back(e);
            first.push_back(k * e);
            firstSum += first.back();
            second.push_back((k * k / (sigma * sigma) - 1.0) * e);
            (second.back() > 0 ? positive : negative) += (k ? 2.0 : 1.0) * std::abs(second.back());
        }
        smooth = normalised(gaussian);
        for (const double w : first) edge.push_back(static_cast<float>(w / firstSum));
        for (const double w : second)
            point.push_back(static_cast<float>(w / (w > 0 ? positive : negative)));
    }
};

const ContrastFilters& contrastFilters() {
    static const ContrastFilters kFilters;
    return kFilters;
}

const FeatureFilters& featureFilters() {
    static const FeatureFilters kFilters;
    return kFilters;
}

// ---- colour ------------------------------------------------------------------------------------

/// Linear sRGB to XYZ over the white point, as rows: (1, 1, 1) is white.
glm::dmat3 relativeXyzFromRgb() {
    const glm::dmat3 xyz = glm::transpose(
        glm::dmat3(10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,  //
                   2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897,    //
                   1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382));
    const glm::dvec3 white = xyz * glm::dvec3(1.0);
    return glm::dmat3(xyz[0] / white, xyz[1] / white, xyz[2] / white);
}

const glm::mat3& toRelativeXyz() {
    static const glm::mat3 kMatrix(relativeXyzFromRgb());
    return kMatrix;
}

const glm::mat3& toRgb() {
    static const glm::mat3 kMatrix(glm::inverse(relativeXyzFromRgb()));
    return kMatrix;
}

/// Cube root of t in [0.008, 1] to float precision: from a guess in the exponent (Kahan), within 4
/// %, two of Halley's steps, each of which cubes the relative error. Unlike std::cbrt it
/// vectorises, and there are three a pixel.
float fastCbrt(float t) {
    float root = std::bit_cast<float>(std::bit_cast<std::uint32_t>(t) / 3 + 0x2a5119f2U);
    for (int step = 0; step < 2; ++step) {
        const float cube = root * root * root;
        root *= (cube + 2.0F * t) / (2.0F * cube + t);
    }
    return root;
}

float labCurve(float t) {
    constexpr float kDelta = 6.0F / 29.0F;
    return t > kDelta * kDelta * kDelta ? fastCbrt(t) : t / (3.0F * kDelta * kDelta) + 4.0F / 29.0F;
}

/// CIELAB of linear RGB; a and b shrink with lightness (Hunt effect).
glm::vec3 huntLab(const glm::vec3& rgb) {
    const glm::vec3 xyz = toRelativeXyz() * rgb;
    const glm::vec3 f(labCurve(xyz.x), labCurve(xyz.y), labCurve(xyz.z));
    const float lightness = 116.0F * f.y - 16.0F;
    return {lightness, 0.01F * lightness * 500.0F * (f.x - f.y),
            0.01F * lightness * 200.0F * (f.y - f.z)};
}

/// HyAB distance raised to qc.
float colourDistance(const glm::vec3& a, const glm::vec3& b) {
    const glm::vec3 d = a - b;
    const float hyab = std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
    return hyab > 0.0F ? std::pow(hyab, kColourExponent) : 0.0F;
}

/// To [0,1]: steep and linear up to the knee, where differences are plain to see anyway.
float remapColourDistance(float distance) {
    static const float kLargest = colourDistance(huntLab({0, 1, 0}), huntLab({0, 0, 1}));
    static const float kKnee = kColourKnee * kLargest;
    if (distance < kKnee) return kColourAtKnee / kKnee * distance;
    return kColourAtKnee + (distance - kKnee) / (kLargest - kKnee) * (1.0F - kColourAtKnee);
}

// ---- one image ---------------------------------------------------------------------------------

/// Rows of opponent colours with `pad` replicated samples on either side. FLIP's YCxCz are affine
/// in these (Y = 116 y - 16, Cx = 500 (x - y), Cz = 200 (y - z)) and its kernels sum to 1, so that
/// filtering these is filtering those; and y is what the features are found in.
struct OpponentRow {
    std::vector<float> y, cx, cz;

    void fill(const float* rgb, int width, int pad) {
        const auto padding = static_cast<std::size_t>(pad);
        const auto count = static_cast<std::size_t>(width);
        for (auto* channel : {&y, &cx, &cz}) channel->resize(count + 2 * padding);
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3 pixel(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
            const glm::vec3 xyz = toRelativeXyz() * glm::clamp(pixel, 0.0F, 1.0F);
            y[padding + i] = xyz.y;
            cx[padding + i] = xyz.x - xyz.y;
            cz[padding + i] = xyz.y - xyz.z;
        }
        for (auto* channel : {&y, &cx, &cz}) {
            std::fill_n(channel->begin(), padding, (*channel)[padding]);
            std::fill_n(channel->end() - pad, padding, (*channel)[padding + count - 1]);
        }
    }
};

/// The image after the horizontal passes: the inputs of the vertical ones.
struct HalfFiltered {
    int width, height;
    std::vector<float> achromatic, redGreen, blueYellow1, blueYellow2, smooth, edge, point;

    explicit HalfFiltered(const Image& image) : width(image.width), height(image.height) {
        const std::size_t size = image.pixels.size() / 3;
        for (auto* plane :
             {&achromatic, &redGreen, &blueYellow1, &blueYellow2, &smooth, &edge, &point})
            plane->resize(size);
        const auto& csf = contrastFilters();
        const auto& features = featureFilters();
        const int pad = std::max(csf.radius, features.radius);
        const auto count = static_cast<std::size_t>(width);
        tbb::parallel_for(0, height, [&](int row) {
            thread_local OpponentRow opponent;
            const std::size_t first = static_cast<std::size_t>(row) * count;
            opponent.fill(&image.pixels[3 * first], width, pad);
            const auto from = [pad](const std::vector<float>& channel) {
                return [start = channel.data() + pad](int k) { return start + k; };
            };
            filterEven(csf.achromatic, from(opponent.y), count, &achromatic[first]);
            filterEven(csf.redGreen, from(opponent.cx), count, &redGreen[first]);
            filterEven(csf.blueYellow1, from(opponent.cz), count, &blueYellow1[first]);
            filterEven(csf.blueYellow2, from(opponent.cz), count, &blueYellow2[first]);
            filterEven(features.smooth, from(opponent.y), count, &smooth[first]);
            filterOdd(features.edge, from(opponent.y), count, &edge[first]);
            filterSecondDifference(features.point, from(opponent.y), count, &point[first]);
        });
    }

    /// For the vertical passes at `row`: the plane's row k below it, the last one beyond the
    /// border.
    auto rowsAround(const std::vector<float>& plane, int row) const {
        return [&plane, row, this](int k) {
            const int y = std::clamp(row + k, 0, height - 1);
            return plane.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        };
    }
};

}  // namespace

FlipImage prepareFlip(const Image& linearRgb) {
    if (linearRgb.channelCount() != 3) {
        throw std::invalid_argument(
            fmt::format("flip: {} channels, three are needed", linearRgb.channelCount()));
    }
    const std::size_t size = linearRgb.pixels.size() / 3;
    FlipImage out{linearRgb.width, linearRgb.height, std::vector<glm::vec3>(size),
                  std::vector<float>(size), std::vector<float>(size)};
    if (size == 0) return out;
    const HalfFiltered half(linearRgb);
    const auto& csf = contrastFilters();
    const auto& features = featureFilters();
    const auto count = static_cast<std::size_t>(out.width);

    tbb::parallel_for(0, out.height, [&](int row) {
        thread_local std::vector<float> y, cx, cz1, cz2, edgeX, edgeY, pointX, pointY;
        for (auto* line : {&y, &cx, &cz1, &cz2, &edgeX, &edgeY, &pointX, &pointY})
            line->resize(count);
        const auto around = [&](const std::vector<float>& plane) {
            return half.rowsAround(plane, row);
        };
        filterEven(csf.achromatic, around(half.achromatic), count, y.data());
        filterEven(csf.redGreen, around(half.redGreen), count, cx.data());
        filterEven(csf.blueYellow1, around(half.blueYellow1), count, cz1.data());
        filterEven(csf.blueYellow2, around(half.blueYellow2), count, cz2.data());
        filterEven(features.smooth, around(half.edge), count, edgeX.data());
        filterOdd(features.edge, around(half.smooth), count, edgeY.data());
        filterEven(features.smooth, around(half.point), count, pointX.data());
        filterSecondDifference(features.point, around(half.smooth), count, pointY.data());

        const std::size_t first = static_cast<std::size_t>(row) * count;
        for (std::size_t i = 0; i < count; ++i) {
            const float cz = csf.share1 * cz1[i] + csf.share2 * cz2[i];
            const glm::vec3 rgb = toRgb() * glm::vec3(cx[i] + y[i], y[i], y[i] - cz);
            out.colour[first + i] = huntLab(glm::clamp(rgb, 0.0F, 1.0F));
            out.edges[first + i] = std::sqrt(edgeX[i] * edgeX[i] + edgeY[i] * edgeY[i]);
            out.points[first + i] = std::sqrt(pointX[i] * pointX[i] + pointY[i] * pointY[i]);
        }
    });
    return out;
}

float combineFlip(float colour, float feature) {
    return colour > 0.0F ? std::pow(colour, 1.0F - feature) : 0.0F;
}

std::vector<float> flipErrors(const FlipImage& a, const FlipImage& b) {
    if (a.width != b.width || a.height != b.height) {
        throw std::invalid_argument(
            fmt::format("flip: {} x {} and {} x {} pixels", a.width, a.height, b.width, b.height));
    }
    std::vector<float> errors(a.colour.size());
    tbb::parallel_for(0, a.height, [&](int row) {
        const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(a.width);
        for (std::size_t i = first; i < first + static_cast<std::size_t>(a.width); ++i) {
            const float colour = remapColourDistance(colourDistance(a.colour[i], b.colour[i]));
            const float feature =
                std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
            // The square root is the exponent qf = 0.5.
            errors[i] = combineFlip(
                colour, std::min(std::sqrt(feature / std::numbers::sqrt2_v<float>), 1.0F));
        }
    });
    return errors;
}

}  // namespace penumbra
