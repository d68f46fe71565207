// What `penumbra_quads` costs: beside `light_sampled` with as many maps as its paper compares with
// (`times`: how much longer those take; rmse of both against the reference), beside two plain
// shadow maps on a mesh of 200,000 triangles (`of_two_maps`), and edge adjacency per edge of the
// mesh
// (`ns_per_edge`). Times are the least of one sitting.

#include <benchmark/benchmark.h>

#include <cmath>

#include "core/passes/depth_pass.hpp"
#include "core/scene/edge_adjacency.hpp"
#include "harness/bench/stage.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra {
namespace {

using namespace bench;

constexpr int kPixels = 512;

void besideLightSampled(benchmark::State& state, const std::string& id) {
    needContext();
    const Stage stage(id, kPixels);
    const TextureTarget target(kPixels, kPixels);
    ReferenceOptions options;
    options.targetStandardError = 1.0 / 256;  // far below either's error
    const Reference reference =
        traceReference(stage.tracer, stage.gbuffer, stage.moment.light, options);
    const Scorer scorer(reference, stage.gbuffer);

    Stage::Act quads = stage.act("penumbra_quads", {});
    Stage::Act sampled = stage.act(
        "light_sampled", {{"samples", std::to_string(state.range(0))}, {"map_size", "1024"}});
    const auto frame = [&](Stage::Act& act) {
        act.method->build(stage.frame, act.plan);
        act.method->shade(stage.frame, act.plan, target);
    };
    const auto rmse = [&](Stage::Act& act) {
        frame(act);
        return scorer.score(target.read()).rmse.value();
    };
    state.counters["quads_rmse"] = rmse(quads);
    state.counters["sampled_rmse"] = rmse(sampled);
    double quadsMs = HUGE_VAL, sampledMs = HUGE_VAL;
    for (auto _ : state) {
        quadsMs = leastMs(quadsMs, [&] { frame(quads); });
        sampledMs = leastMs(sampledMs, [&] { frame(sampled); });
    }
    state.counters["quads_ms"] = quadsMs;
    state.counters["sampled_ms"] = sampledMs;
    state.counters["times"] = sampledMs / quadsMs;
}

void besideTwoMaps(benchmark::State& state, const std::string& id) {
    needContext();
    const Stage stage(id, kPixels);
    const auto mapSize = static_cast<int>(state.range(0));
    Stage::Act quads = stage.act("penumbra_quads", {{"map_size", std::to_string(mapSize)}});
    DepthPass depth(Plan{});
    const LightView view = LightView::fit(stage.frame, glm::dvec2(0.0), mapSize);
    double mapsMs = HUGE_VAL, buildMs = HUGE_VAL;
    for (auto _ : state) {
        mapsMs = leastMs(mapsMs, [&] {
            for (int i = 0; i < 2; ++i) depth.render(stage.frame, view, mapSize);
        });
        buildMs = leastMs(buildMs, [&] { quads.method->build(stage.frame, quads.plan); });
    }
    state.counters["two_maps_ms"] = mapsMs;
    state.counters["build_ms"] = buildMs;
    state.counters["of_two_maps"] = buildMs / mapsMs;
}

/// A wavy sheet of n x n quads, every triangle with vertices of its own: all is left to welding.
void adjacencyOf(benchmark::State& state) {
    needContext();  // of the fenced clock
    const auto n = static_cast<int>(state.range(0));
    Geometry geometry;
    const auto at = [](int x, int y) {
        return glm::vec3(x, y, 3.0 * std::sin(0.3 * x) * std::cos(0.2 * y));
    };
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            for (const glm::vec3& p : {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y),
                                       at(x + 1, y + 1), at(x, y + 1)}) {
                geometry.indices.push_back(static_cast<std::uint32_t>(geometry.positions.size()));
                geometry.positions.push_back(p);
            }
    Part part;
    part.vertexCount = part.indexCount = static_cast<std::uint32_t>(geometry.positions.size());
    geometry.parts = {part};
    double leastMs = HUGE_VAL;
    std::size_t edges = 0;
    for (auto _ : state) {
        leastMs = bench::leastMs(leastMs, [&] {
            const EdgeAdjacency adjacency(geometry);
            std::vector<OutlineEdge> outline = adjacency.outlineEdges(geometry);
            benchmark::DoNotOptimize(outline);
            edges = adjacency.edgeCount();
        });
    }
    state.counters["edges"] = static_cast<double>(edges);
    state.counters["least_ms"] = leastMs;
    state.counters["ns_per_edge"] = 1e6 * leastMs / static_cast<double>(edges);
}
BENCHMARK(adjacencyOf)
    ->Name("penumbra_quads/adjacency")
    ->RangeMultiplier(2)
    ->Range(32, 512)
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

const auto registered = [] {
    for (const char* scene : {"gathering", "clouds"})
        benchmark::RegisterBenchmark(
            ("penumbra_quads/beside_light_sampled/" + std::string(scene)).c_str(),
            besideLightSampled, std::string(scene))
            ->Arg(128)
            ->Arg(256)
            ->Arg(512)
            ->Iterations(3)
            ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark("penumbra_quads/beside_two_maps/arcade", besideTwoMaps,
                                 std::string("arcade"))
        ->Arg(512)
        ->Arg(1024)
        ->Iterations(5)
        ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra
