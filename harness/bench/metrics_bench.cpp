#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "harness/metrics/flip.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/metrics/ssim.hpp"

namespace penumbra {
namespace {

/// A textured floor under rings of shadow, half of the pixels noisy: work everywhere, no flat areas
/// that a metric could be quick on.
struct Picture {
    static constexpr int kSize = 512;
    GBuffer gbuffer;
    Reference reference;
    std::vector<float> visibility;

    Picture() {
        constexpr std::size_t kPixels = std::size_t{kSize} * kSize;
        gbuffer.width = gbuffer.height = reference.width = reference.height = kSize;
        std::mt19937 generator(1);
        std::normal_distribution<float> noise(0.0F, 0.05F);
        for (std::size_t i = 0; i < kPixels; ++i) {
            const float x = static_cast<float>(i % kSize) / kSize - 0.5F;
            const float y = static_cast<float>(i / kSize) / kSize - 0.5F;
            const float rings = 0.5F + 0.5F * std::sin(40.0F * std::sqrt(x * x + y * y));
            const float checks = (i / 16 % 2 + i / (16 * kSize) % 2) == 1 ? 0.2F : 0.6F;
            gbuffer.position.emplace_back(x, 0.0F, y);
            gbuffer.albedo.emplace_back(checks, 0.5F * checks, 0.4F);
            gbuffer.irradianceUnshadowed.push_back(1.0F - x * x - y * y);
            reference.visibility.push_back(rings);
            visibility.push_back(
                std::clamp(rings + (x > 0 ? noise(generator) : 0.02F), 0.0F, 1.0F));
        }
        gbuffer.geometricNormal.assign(kPixels, {0, 1, 0});
        gbuffer.shadingNormal = gbuffer.geometricNormal;
        gbuffer.mask.assign(kPixels, PixelClass::scored);
        reference.standardError.assign(kPixels, 1.0F / 1024);
        reference.rays.assign(kPixels, 256.0F);
        reference.irradianceUnshadowed = gbuffer.irradianceUnshadowed;
        reference.irradiance = reference.irradianceUnshadowed;
    }
};

const Picture& picture() {
    static const Picture kPicture;
    return kPicture;
}

/// Two images from scratch. A run prepares the reference's half once per frame.
void flipOf512(benchmark::State& state) {
    const Picture& p = picture();
    const PictureLight light = pictureLight(p.gbuffer);
    const Image reference = shadeVisibility(p.gbuffer, p.reference.visibility, light);
    const Image image = shadeVisibility(p.gbuffer, p.visibility, light);
    for (auto _ : state)
        benchmark::DoNotOptimize(flipErrors(prepareFlip(reference), prepareFlip(image)));
}
BENCHMARK(flipOf512)->Unit(benchmark::kMillisecond)->UseRealTime();

void ssimOf512(benchmark::State& state) {
    const Picture& p = picture();
    const int size = Picture::kSize;
    const std::vector<std::uint8_t> counted(p.visibility.size(), 1);
    for (auto _ : state)
        benchmark::DoNotOptimize(ssim(prepareSsim(size, size, p.reference.visibility),
                                      prepareSsim(size, size, p.visibility), counted));
}
BENCHMARK(ssimOf512)->Unit(benchmark::kMillisecond)->UseRealTime();

/// What a frame costs once ...
void prepareScorer512(benchmark::State& state) {
    const Picture& p = picture();
    for (auto _ : state) benchmark::DoNotOptimize(Scorer(p.reference, p.gbuffer));
}
BENCHMARK(prepareScorer512)->Unit(benchmark::kMillisecond)->UseRealTime();

/// ... and what each of its cells costs: every metric.
void scoreAll512(benchmark::State& state) {
    const Picture& p = picture();
    const Scorer scorer(p.reference, p.gbuffer);
    for (auto _ : state) benchmark::DoNotOptimize(scorer.score(p.visibility));
}
BENCHMARK(scoreAll512)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace penumbra
