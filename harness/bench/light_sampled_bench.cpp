// What `light_sampled` costs beside the least that n maps can cost: n depth passes of one map, and
// a bare shader's n compare fetches per pixel, one from each of n maps. Counters: `depth_ms` of one
// map, `fetch_ms` of one fetch per pixel, `build_ms` and `shade_ms` of the method, and `of_bare`,
// its frame over n (depth_ms + fetch_ms); all are least times of one sitting.

#include <benchmark/benchmark.h>

#include <map>
#include <string>

#include "core/passes/depth_pass.hpp"
#include "harness/bench/stage.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra::bench {
namespace {

constexpr int kPixels = 512, kMapSize = 512;

void overBareMaps(benchmark::State& state, const std::string& id, const Assignments& settings) {
    needContext();
    const Stage stage(id, kPixels);
    const auto count = static_cast<int>(state.range(0));
    const TextureTarget target(kPixels, kPixels);

    Assignments all = {{"samples", std::to_string(count)}, {"map_size", std::to_string(kMapSize)}};
    all.insert(all.end(), settings.begin(), settings.end());
    const auto [method, plan] = stage.act("light_sampled", all);

    DepthPass depth(plan), maps(plan);
    const LightView view = LightView::fit(stage.frame, glm::dvec2(0.0), kMapSize);
    maps.render(stage.frame, std::vector<LightView>(static_cast<std::size_t>(count), view),
                kMapSize);
    const gl::Program fetches = gl::Program::graphics("common/bare_fetches.glsl");

    double depthMs = 1e9, fetchMs = 1e9, buildMs = 1e9, shadeMs = 1e9;
    for (auto _ : state) {
        depthMs = leastMs(depthMs, [&] {
            for (int i = 0; i < count; ++i) depth.render(stage.frame, view, kMapSize);
        });
        fetches.use();
        maps.bind(fetches, 0);
        fetches.set("fetches", count);
        fetchMs = leastMs(fetchMs, [&] { target.draw(fetches, stage.textures); });
        buildMs = leastMs(buildMs, [&] { method->build(stage.frame, plan); });
        shadeMs = leastMs(shadeMs, [&] { method->shade(stage.frame, plan, target); });
    }
    state.counters["depth_ms"] = depthMs / count;
    state.counters["fetch_ms"] = fetchMs / count;
    state.counters["build_ms"] = buildMs;
    state.counters["shade_ms"] = shadeMs;
    state.counters["of_bare"] = (buildMs + shadeMs) / (depthMs + fetchMs);
}

const auto registered = [] {
    const std::map<std::string, Assignments> settings = {
        {"array", {}}, {"array_pcf", {{"pcf", "true"}}}, {"buffer", {{"accumulation", "buffer"}}}};
    for (const char* scene : {"contact", "sphere_plate", "bunny"})
        for (const auto& [name, assignments] : settings)
            benchmark::RegisterBenchmark(
                ("light_sampled/" + std::string(scene) + '/' + name).c_str(), overBareMaps,
                std::string(scene), assignments)
                ->Arg(64)
                ->Iterations(7)
                ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra::bench
