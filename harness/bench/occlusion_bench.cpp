// Occlusion textures as ratios of one sitting. `light`: shade_ms at 1, 10 and 100 times the light's
// area over that at 1 (the paper: independent), beside pcss and pcf. `slices`: build_ms over that
// of 4 slices. `triangles`: build_ms of 16 slices on scenes of more and more triangles over their
// depth pass. `prefilters`: mip levels, N-buffers and the summed-area table of 16 slices (the
// paper: 1 : 3 : 32 at 256^2, 1 : 11 : 139 at 512^2) and each over a plain read and write of the
// texels that it must touch. All are least times.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "core/frame/gpu_geometry.hpp"
#include "core/gl/context.hpp"
#include "core/passes/count_table.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/n_buffers.hpp"
#include "core/passes/slice_pass.hpp"
#include "harness/bench/stage.hpp"
#include "harness/run/visibility_target.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

using bench::leastMs;
using bench::needContext;
using bench::Stage;

constexpr int kPixels = 512, kMapSize = 512, kSlices = 16;

/// A method that has built one stage.
struct Prepared {
    const Stage& stage;
    std::unique_ptr<ShadowMethod> method;
    Plan plan;
    TextureTarget target{kPixels, kPixels};

    Prepared(const Stage& on, const std::string& id, const Assignments& settings)
        : stage(on), method(findMethod(id).make()) {
        for (const auto& [parameter, value] : settings) method->set(id, parameter, value);
        plan = planFor({}, stage.analysis.calledFor(), method->traits().simulates);
        method->prepare(*stage.scene, plan);
        build();
        shade();
    }
    void build() { method->build(stage.frame, plan); }
    void shade() { method->shade(stage.frame, plan, target); }
};

void lightSize(benchmark::State& state, const std::string& id, const Assignments& settings) {
    needContext();
    // From 0.1 x 0.1 metres to 1 x 1.
    const auto withArea = [](double factor) {
        return [factor](AreaLight& light) {
            light.halfU *= std::sqrt(factor);
            light.halfV *= std::sqrt(factor);
        };
    };
    const Stage small("fence", kPixels), medium("fence", kPixels, kPixels, withArea(10.0)),
        large("fence", kPixels, kPixels, withArea(100.0));
    Prepared methods[] = {{small, id, settings}, {medium, id, settings}, {large, id, settings}};
    double ms[3] = {1e9, 1e9, 1e9};
    for (auto _ : state)
        for (int i = 0; i < 3; ++i) ms[i] = leastMs(ms[i], [&] { methods[i].shade(); });
    state.counters["shade_ms"] = ms[0];
    state.counters["of_10x"] = ms[1] / ms[0];
    state.counters["of_100x"] = ms[2] / ms[0];
}

void slices(benchmark::State& state) {
    needContext();
    const Stage stage("clouds", kPixels);
    std::map<int, double> ms;
    std::map<int, std::unique_ptr<Prepared>> methods;
    SlicePass pass(kSlices, SliceTargets::bits, false), four(4, SliceTargets::bits, false),
        channels(kSlices, SliceTargets::channels, false);
    const SliceView view = SliceView::fit(stage.frame, {}),
                    viewOfFour = SliceView::fit(stage.frame, {.slices = 4});
    for (const int count : {4, 8, 16, 32, 64}) {
        ms[count] = 1e9;
        methods[count] = std::make_unique<Prepared>(stage, "occlusion_textures",
                                                    Assignments{{"slices", std::to_string(count)}});
    }
    double passMs = 1e9, fourMs = 1e9, channelsMs = 1e9;
    for (auto _ : state) {
        for (auto& [count, least] : ms) least = leastMs(least, [&] { methods[count]->build(); });
        passMs = leastMs(passMs, [&] { pass.render(stage.frame, view, {}, kMapSize); });
        fourMs = leastMs(fourMs, [&] { four.render(stage.frame, viewOfFour, {}, kMapSize); });
        channelsMs = leastMs(channelsMs, [&] { channels.render(stage.frame, view, {}, kMapSize); });
    }
    state.counters["build_ms_of_4"] = ms[4];
    for (const int count : {8, 16, 32, 64})
        state.counters["of_" + std::to_string(count)] = ms[count] / ms[4];
    state.counters["geometry_pass_of_16"] = passMs / fourMs;
    state.counters["pass_ms_of_16"] = passMs;
    state.counters["channels_of_bits"] = channelsMs / passMs;
}

void triangles(benchmark::State& state, const std::string& id) {
    needContext();
    const Stage stage(id, kPixels);
    Prepared method(stage, "occlusion_textures", {});
    DepthPass depth(Plan{});
    const LightView view = LightView::fit(stage.frame, glm::dvec2(0.0), kMapSize);
    double buildMs = 1e9, depthMs = 1e9;
    for (auto _ : state) {
        buildMs = leastMs(buildMs, [&] { method.build(); });
        depthMs = leastMs(depthMs, [&] { depth.render(stage.frame, view, kMapSize); });
    }
    state.counters["triangles"] = static_cast<double>(stage.moment.geometry->triangleCount());
    state.counters["build_ms"] = buildMs;
    state.counters["of_depth_pass"] = buildMs / depthMs;
}

void prefilters(benchmark::State& state) {
    needContext();
    const auto size = static_cast<int>(state.range(0));
    constexpr int kLayers = kSlices / 4;
    const Stage stage("clouds", kPixels);
    SlicePass slices(kSlices, SliceTargets::bits, false);
    slices.render(stage.frame, SliceView::fit(stage.frame, {.mapSize = size}), {}, size);
    slices.unpack();
    const gl::Texture& source = slices.channels();
    const int levels = 1 + static_cast<int>(std::log2(size));
    NBuffers buffers = NBuffers::create();
    CountTable table = CountTable::create(), wide = CountTable::create();
    // N-buffers of one level are a plain read and write of half floats; each further one reads the
    // last and writes anew. A table is written twice, by rows and by columns: each time 2 bytes a
    // texel of a slice where kernels have less than 65536 texels, else 4.
    NBuffers plain = NBuffers::create();
    double mipMs = 1e9, bufferMs = 1e9, tableMs = 1e9, wideMs = 1e9, plainMs = 1e9, copyMs = 1e9;
    const gl::Texture from = gl::Texture::createArray(GL_RGBA32UI, size, size, kLayers),
                      to = gl::Texture::createArray(GL_RGBA32UI, size, size, kLayers);
    const auto copy = [&] {
        glCopyImageSubData(from.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, to.id(), GL_TEXTURE_2D_ARRAY,
                           0, 0, 0, 0, size, size, kLayers);
    };
    for (auto _ : state) {
        mipMs = leastMs(mipMs, [&] { glGenerateTextureMipmap(source.id()); });
        bufferMs = leastMs(bufferMs, [&] { buffers.build(source, levels); });
        tableMs = leastMs(tableMs, [&] { table.build(slices, 65535.0); });
        wideMs = leastMs(wideMs, [&] { wide.build(slices, 1e9); });
        plainMs = leastMs(plainMs, [&] { plain.build(source, 1); });
        copyMs = leastMs(copyMs, copy);
    }
    state.counters["mip_ms"] = mipMs;
    state.counters["n_buffers_of_mip"] = bufferMs / mipMs;
    state.counters["sat_of_mip"] = tableMs / mipMs;
    state.counters["wide_sat_of_mip"] = wideMs / mipMs;
    state.counters["sat_of_n_buffers"] = tableMs / bufferMs;
    state.counters["n_buffers_of_plain"] = bufferMs / (plainMs * levels);
    state.counters["sat_of_plain"] = tableMs / (2.0 * plainMs);
    state.counters["sat_of_copies"] = tableMs / (2.0 * copyMs);
}

const auto registered = [] {
    const auto timed = [](benchmark::internal::Benchmark* b) {
        return b->Iterations(30)->Unit(benchmark::kMillisecond);
    };
    timed(benchmark::RegisterBenchmark("occlusion/light/occlusion_textures", lightSize,
                                       std::string("occlusion_textures"), Assignments{}));
    timed(benchmark::RegisterBenchmark("occlusion/light/one_cell", lightSize,
                                       std::string("occlusion_textures"),
                                       Assignments{{"cells", "1"}, {"contact", "none"}}));
    timed(benchmark::RegisterBenchmark("occlusion/light/no_early_outs", lightSize,
                                       std::string("occlusion_textures"),
                                       Assignments{{"early_outs", "false"}}));
    timed(benchmark::RegisterBenchmark(
        "occlusion/light/one_cell_no_early_outs", lightSize, std::string("occlusion_textures"),
        Assignments{{"cells", "1"}, {"contact", "none"}, {"early_outs", "false"}}));
    for (const char* id : {"pcss", "pcf"})
        timed(benchmark::RegisterBenchmark(("occlusion/light/" + std::string(id)).c_str(),
                                           lightSize, std::string(id), Assignments{}));
    timed(benchmark::RegisterBenchmark("occlusion/slices", slices));
    for (const char* id : {"butterfly", "clouds", "arcade"})
        timed(benchmark::RegisterBenchmark(("occlusion/triangles/" + std::string(id)).c_str(),
                                           triangles, std::string(id)));
    timed(benchmark::RegisterBenchmark("occlusion/prefilters", prefilters))->Arg(256)->Arg(512);
    return 0;
}();

}  // namespace
}  // namespace penumbra
