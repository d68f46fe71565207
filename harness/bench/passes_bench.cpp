// Shared passes on the default context: what a summed-area table costs in blurs.

#include <benchmark/benchmark.h>

#include <cmath>
#include <map>

#include "core/passes/blur.hpp"
#include "core/passes/summed_area_table.hpp"
#include "harness/bench/stage.hpp"

namespace penumbra::bench {
namespace {

/// Two-channel moments of `size` squared texels, uneven enough to be no special case.
gl::Texture moments(int size) {
    std::vector<glm::vec2> texels;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const float d = std::sin(0.37f * static_cast<float>(x) + 0.11f * static_cast<float>(y));
            texels.emplace_back(d, d * d);
        }
    gl::Texture texture = gl::Texture::createArray(GL_RG32F, size, size, 1);
    glTextureSubImage3D(texture.id(), 0, 0, 0, 0, size, size, 1, GL_RG, GL_FLOAT, texels.data());
    return texture;
}

std::map<int, double>& blurMs() {
    static std::map<int, double> ms;
    return ms;
}

/// Least of the iterations' fenced times: neighbours on the machine only ever add.
template <class Work>
double leastMs(benchmark::State& state, const Work& work) {
    work();
    double least = HUGE_VAL;
    for (auto _ : state) {
        const gl::FencedTimer timer;
        work();
        const double ms = timer.stop();
        state.SetIterationTime(1e-3 * ms);
        least = std::min(least, ms);
    }
    state.counters["least_ms"] = least;
    return least;
}

void blurNineTaps(benchmark::State& state) {
    needContext();
    const int size = static_cast<int>(state.range(0));
    const gl::Texture texture = moments(size);
    Blur blur = Blur::create();
    const std::vector<float> weights = blurWeights(BlurShape::box, 9.0);
    blurMs()[size] = leastMs(state, [&] { blur.apply(texture, weights, weights); });
}

void summedAreaTable(benchmark::State& state, SummedAreaTable::Kind kind) {
    needContext();
    const int size = static_cast<int>(state.range(0));
    const gl::Texture texture = moments(size);
    SummedAreaTable table = SummedAreaTable::create(kind);
    const double ms = leastMs(state, [&] { table.build(texture, 64.0 * 64.0); });
    state.counters["of_blur"] = ms / blurMs()[size];
}

const auto registered = [] {
    const auto sized = [](benchmark::internal::Benchmark* b) {
        b->Arg(256)->Arg(512)->Arg(1024)->UseManualTime()->Unit(benchmark::kMillisecond);
    };
    sized(benchmark::RegisterBenchmark("passes/blur_9_taps", blurNineTaps));
    sized(benchmark::RegisterBenchmark("passes/summed_area_table_uint32", summedAreaTable,
                                       SummedAreaTable::Kind::uint32));
    sized(benchmark::RegisterBenchmark("passes/summed_area_table_float32", summedAreaTable,
                                       SummedAreaTable::Kind::float32));
    return 0;
}();

}  // namespace
}  // namespace penumbra::bench
