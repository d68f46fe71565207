#include "harness/metrics/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace penumbra {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A field of scored penumbra pixels on a noiseless reference of 1/2.
struct Field {
    int width, height;
    GBuffer gbuffer;
    Reference reference;
    std::vector<LightClass> classes;
    std::vector<float> visibility;

    Field(int w, int h) : width(w), height(h) {
        const auto size = static_cast<std::size_t>(w * h);
        gbuffer.width = w;
        gbuffer.height = h;
        gbuffer.mask.assign(size, PixelClass::scored);
        reference.visibility.assign(size, 0.5F);
        classes.assign(size, LightClass::penumbra);
        visibility.assign(size, 0.5F);
    }
    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y * width + x); }
    std::optional<double> noise() const {
        return penumbra::noise(visibility, reference, gbuffer, classes);
    }
    /// Only pixels with a whole window count.
    void keepInterior() {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (x < 2 || y < 2 || x >= width - 2 || y >= height - 2)
                    classes[at(x, y)] = LightClass::lit;
    }
};

// Values are sums of powers of two; sums over 25 and the root round: 1e-15 is a few roundings.
constexpr double kRounding = 1e-15;

TEST(Noise, ConstantErrorHasNone) {
    Field field(9, 7);
    for (float& v : field.visibility) v = 0.75F;
    EXPECT_EQ(field.noise(), 0.0);
}

TEST(Noise, ALinearErrorHasNoneAwayFromBorders) {
    Field field(12, 12);
    field.keepInterior();
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 12; ++x)
            field.visibility[field.at(x, y)] = 0.5F + float(x) / 64.0F - float(y) / 128.0F;
    EXPECT_NEAR(field.noise().value(), 0.0, kRounding);
}

TEST(Noise, CheckerboardByHand) {
    // Errors +-1/8. Of 25 checks around a pixel 13 have its sign and 12 the other: mean 1/25 of it.
    Field field(10, 8);
    field.keepInterior();
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 10; ++x)
            field.visibility[field.at(x, y)] = (x + y) % 2 ? 0.625F : 0.375F;
    EXPECT_NEAR(field.noise().value(), 0.125 * 24 / 25, kRounding);
}

TEST(Noise, OneSpeckByHand) {
    // Error 1/4 at one pixel: 24/25 of it remains there and -1/25 in its 24 neighbours.
    Field field(9, 9);
    field.keepInterior();
    field.visibility[field.at(4, 4)] = 0.75F;
    const double sumSquares = 0.0625 * (24.0 * 24 + 24) / 625;
    EXPECT_NEAR(field.noise().value(), std::sqrt(sumSquares / 25), kRounding);
}

TEST(Noise, WhiteNoiseKeepsItsSizeButForTheWindowsMean) {
    Field field(256, 256);
    field.keepInterior();
    std::mt19937 generator(1);
    std::normal_distribution<float> gaussian(0.5F, 0.05F);
    for (float& v : field.visibility) v = gaussian(generator);
    // The relative error of a standard deviation from 63,504 samples is 1/sqrt(2 n) = 0.28 %.
    EXPECT_NEAR(field.noise().value(), 0.05 * std::sqrt(24.0 / 25), 0.05 * 0.012);
}

TEST(Noise, UnscoredAndNonfiniteNeighboursAreNotInTheMean) {
    Field field(3, 1);
    field.visibility = {0.5F, 0.75F, kNan};
    // The first two see each other only: mean 1/8, so -1/8 and +1/8 remain.
    EXPECT_NEAR(field.noise().value(), 0.125, kRounding);
    field.visibility[2] = 100.0F;
    field.gbuffer.mask[2] = PixelClass::horizon;
    EXPECT_NEAR(field.noise().value(), 0.125, kRounding);
}

TEST(Noise, NeighboursOfOtherClassesEnterTheMeanButAreNoSamples) {
    Field field(3, 1);
    field.classes = {LightClass::lit, LightClass::penumbra, LightClass::umbra};
    field.visibility = {0.5F, 0.875F, 0.5F};
    EXPECT_NEAR(field.noise().value(), 0.375 * 2 / 3, kRounding);
}

TEST(Noise, WithoutPenumbraOrNeighboursThereIsNoNumber) {
    Field lit(6, 6);
    lit.classes.assign(lit.classes.size(), LightClass::lit);
    EXPECT_FALSE(lit.noise());
    Field alone(7, 1);
    alone.visibility = {0.5F, kNan, kNan, kNan, kNan, kNan, 0.5F};
    EXPECT_FALSE(alone.noise());
}

}  // namespace
}  // namespace penumbra
