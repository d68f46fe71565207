#include "harness/run/fetch_throughput.hpp"

#include <algorithm>

#include "core/gl/context.hpp"
#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra {
namespace {

constexpr int kPixels = 256, kMapSize = 1024, kSide = 8;  // kSide^2 fetches per pixel
constexpr double kLeastMs = 5.0;                          ///< far above what a fence costs anywhere
constexpr int kMostDraws = 1 << 16;
constexpr int kSamples = 5;

double fetchesPerS(const TextureTarget& target, const std::vector<std::string>& defines) {
    const gl::Program program = gl::Program::graphics("common/bare_fetches.glsl", defines);
    program.use();
    program.set("mapSize", kMapSize);
    program.set("texelsPerPixel", static_cast<float>(kMapSize - 2 * kSide) / kPixels);
    const auto drawsMs = [&](int draws) {
        const gl::FencedTimer timer;
        for (int i = 0; i < draws; ++i) target.draw(program, GBufferTextures{});
        return timer.stop();
    };
    drawsMs(1);  // pays for compilation
    int draws = 1;
    double bestMs = drawsMs(draws);
    while (bestMs < kLeastMs && draws < kMostDraws) bestMs = drawsMs(draws *= 2);
    // Neighbours on the machine only ever add.
    for (int i = 1; i < kSamples; ++i) bestMs = std::min(bestMs, drawsMs(draws));
    constexpr double kFetches = 1.0 * kPixels * kPixels * kSide * kSide;
    return 1e3 * draws * kFetches / bestMs;
}

}  // namespace

FetchThroughput measureFetchThroughput() {
    const gl::DebugGroup group("fetch throughput");
    const TextureTarget target(kPixels, kPixels);
    const gl::Texture map = gl::Texture::createArray(GL_DEPTH_COMPONENT32F, kMapSize, kMapSize, 1);
    const float depth = 0.5f;
    glClearTexImage(map.id(), 0, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
    const gl::Sampler comparing = comparingSampler();
    const std::vector<std::string> nearest = {"ROOFLINE", "SIDE " + std::to_string(kSide)};
    std::vector<std::string> compare = nearest;
    compare.emplace_back("FETCH_COMPARE");

    FetchThroughput measured;
    map.bind(0);
    measured.nearestPerS = fetchesPerS(target, nearest);
    map.bind(1);
    glBindSampler(1, comparing.id());
    measured.comparePerS = fetchesPerS(target, compare);
    glBindSampler(1, 0);
    gl::checkErrors("fetch throughput");
    return measured;
}

std::optional<double> shadeFetchesPerPixel(const Row& row, const FetchThroughput& throughput) {
    const auto pixels = static_cast<double>(row.metrics.scoredPixels + row.metrics.horizonPixels);
    if (!row.shadeMs || pixels == 0.0 || throughput.nearestPerS == 0.0) return std::nullopt;
    return 1e-3 * *row.shadeMs * throughput.nearestPerS / pixels;
}

}  // namespace penumbra
