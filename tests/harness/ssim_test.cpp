#include "harness/metrics/ssim.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace penumbra {
namespace {

constexpr double kC1 = 1e-4, kC2 = 9e-4;

std::vector<std::uint8_t> all(std::size_t pixels) {
    return std::vector<std::uint8_t>(pixels, 1);
}

double ssimOf(int width, int height, const std::vector<float>& a, const std::vector<float>& b) {
    return ssim(prepareSsim(width, height, a), prepareSsim(width, height, b), all(a.size()))
        .value();
}

std::vector<float> randomImage(std::size_t pixels, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<float> uniform;
    std::vector<float> values(pixels);
    for (float& v : values) v = uniform(generator);
    return values;
}

/// The definition, term by term: the whole window at one pixel, variances around the mean.
double ssimByDefinition(int width, const std::vector<float>& a, const std::vector<float>& b, int x,
                        int y) {
    double weights = 0, ma = 0, mb = 0, saa = 0, sbb = 0, sab = 0;
    for (const bool moments : {false, true}) {
        for (int v = -5; v <= 5; ++v) {
            for (int u = -5; u <= 5; ++u) {
                const double w = std::exp(-(u * u + v * v) / 4.5);
                const auto i = static_cast<std::size_t>((y + v) * width + x + u);
                if (!moments) {
                    weights += w;
                    ma += w * a[i];
                    mb += w * b[i];
                } else {
                    saa += w * (a[i] - ma) * (a[i] - ma);
                    sbb += w * (b[i] - mb) * (b[i] - mb);
                    sab += w * (a[i] - ma) * (b[i] - mb);
                }
            }
        }
        if (!moments) ma /= weights, mb /= weights;
    }
    return (2 * ma * mb + kC1) * (2 * sab / weights + kC2) /
           ((ma * ma + mb * mb + kC1) * ((saa + sbb) / weights + kC2));
}

// Doubles summed in another order: 1e-12 is hundreds of roundings of values up to 1, over C2.
constexpr double kRounding = 1e-12;

TEST(Ssim, EqualImagesAreOne) {
    const std::vector<float> image = randomImage(20 * 17, 1);
    EXPECT_NEAR(ssimOf(20, 17, image, image), 1.0, kRounding);
}

TEST(Ssim, ConstantImagesByHand) {
    // No variance: only the luminance term, (2 a b + C1) / (a^2 + b^2 + C1), is left. The variance
    // of a constant cancels to some 1e-16, over C2 = 9e-4 some 1e-12.
    const std::vector<float> black(144, 0.0F), grey(144, 0.5F), white(144, 1.0F);
    EXPECT_NEAR(ssimOf(12, 12, black, white), kC1 / (1 + kC1), kRounding);
    EXPECT_NEAR(ssimOf(12, 12, grey, white), (1 + kC1) / (1.25 + kC1), kRounding);
}

TEST(Ssim, IsTheDefinition) {
    const int width = 13, height = 12;
    const std::vector<float> a = randomImage(13 * 12, 2), b = randomImage(13 * 12, 3);
    double sum = 0;
    for (int y = 5; y < height - 5; ++y)
        for (int x = 5; x < width - 5; ++x) sum += ssimByDefinition(width, a, b, x, y);
    EXPECT_NEAR(ssimOf(width, height, a, b), sum / 6, kRounding);
}

TEST(Ssim, InvertedStructureIsBelowZero) {
    std::vector<float> checks(15 * 15), inverted(15 * 15);
    for (std::size_t i = 0; i < checks.size(); ++i) {
        checks[i] = static_cast<float>(i % 2);
        inverted[i] = 1.0F - checks[i];
    }
    EXPECT_LT(ssimOf(15, 15, checks, inverted), -0.99);
}

TEST(Ssim, IsSymmetric) {
    const std::vector<float> a = randomImage(400, 4), b = randomImage(400, 5);
    EXPECT_EQ(ssimOf(20, 20, a, b), ssimOf(20, 20, b, a));
}

TEST(Ssim, OnlyWindowsOfCountedPixelsEnter) {
    const int width = 14, height = 11;
    const std::vector<float> a = randomImage(14 * 11, 6), b = randomImage(14 * 11, 7);
    std::vector<std::uint8_t> counted(a.size(), 0);
    counted[5 * 14 + 6] = 1;
    counted[5 * 14 + 4] = 1;  // four pixels from the border: no window
    const auto value = ssim(prepareSsim(width, height, a), prepareSsim(width, height, b), counted);
    EXPECT_NEAR(value.value(), ssimByDefinition(width, a, b, 6, 5), kRounding);
}

TEST(Ssim, WithoutAWindowThereIsNoNumber) {
    for (const auto& [width, height] : {std::pair{10, 30}, std::pair{30, 10}, std::pair{1, 1}}) {
        const std::vector<float> image(static_cast<std::size_t>(width * height), 0.5F);
        const SsimImage prepared = prepareSsim(width, height, image);
        EXPECT_FALSE(ssim(prepared, prepared, all(image.size()))) << width << "x" << height;
    }
    const SsimImage large = prepareSsim(11, 11, std::vector<float>(121, 0.5F));
    EXPECT_TRUE(ssim(large, large, all(121)));
    EXPECT_FALSE(ssim(large, large, std::vector<std::uint8_t>(121, 0)));
}

TEST(Ssim, SizesMustAgree) {
    const SsimImage a = prepareSsim(12, 11, std::vector<float>(132, 0.0F));
    const SsimImage b = prepareSsim(11, 12, std::vector<float>(132, 0.0F));
    EXPECT_THROW(ssim(a, b, all(132)), std::invalid_argument);
}

}  // namespace
}  // namespace penumbra
