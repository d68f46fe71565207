// Adaptive light sampling against regular, by the protocol of Schwaerzler 2009, section 5: frames
// of 1024 x 768, maps of 512 x 512, 2 x 2 comparisons; epsilon is set so that as many maps result
// as in the paper's figures. `paper` is its own algorithm (fig. 1: texture array, eqs 4, 6 and 7;
// fig. 7: linear light, accumulation buffer, eqs 3 and 4, equal weights), `ours` the method's
// defaults. Counters: `maps` reached at `epsilon`; `speed`, the regular frame's time over the
// adaptive one's, medians of turns taken in one sitting; `rmse` and `rmse_regular` against the
// traced reference in every fourth pixel of a row and column; `compare`, the share of the adaptive
// frame that is neither its maps (as `light_sampled` renders as many) nor evaluation.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "core/frame/gpu_geometry.hpp"
#include "core/gl/context.hpp"
#include "harness/bench/stage.hpp"
#include "harness/reference/reference.hpp"
#include "harness/run/visibility_target.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

using bench::needContext;
using bench::Stage;

constexpr int kWidth = 1024, kHeight = 768;

/// Of a linear light only the rectangle's greater extent is left.
void makeLinear(AreaLight& light) {
    (light.halfU < light.halfV ? light.halfU : light.halfV) = 0.0;
}

/// A method set up for a stage, and its last frame's times.
class Player {
  public:
    Player(const Stage& stage, const std::string& id, const Assignments& settings)
        : stage_(stage), method_(findMethod(id).make()), target_(kWidth, kHeight) {
        for (const auto& [parameter, value] : settings) method_->set(id, parameter, value);
        plan_ = planFor({}, stage.calledFor, method_->traits().simulates);
        method_->prepare(*stage.scene, plan_);
    }

    void play() {
        const gl::FencedTimer build;
        method_->build(stage_.frame, plan_);
        buildMs.push_back(build.stop());
        const gl::FencedTimer shade;
        method_->shade(stage_.frame, plan_, target_);
        frameMs.push_back(buildMs.back() + shade.stop());
    }
    std::vector<float> image() const { return target_.read(); }
    /// Rendered by the last frame.
    int maps() const { return method_->counters().maps; }

    std::vector<double> buildMs, frameMs;

  private:
    const Stage& stage_;
    std::unique_ptr<ShadowMethod> method_;
    Plan plan_;
    TextureTarget target_;
};

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
}

Assignments with(Assignments settings, const std::string& parameter, const std::string& value) {
    settings.emplace_back(parameter, value);
    return settings;
}

/// Reference and rmse in every fourth pixel of a row and column.
class Sparse {
  public:
    explicit Sparse(const Stage& stage) : gbuffer_(stage.gbuffer) {
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                if (x % 4 != 0 || y % 4 != 0)
                    gbuffer_.mask[static_cast<std::size_t>(y * kWidth + x)] =
                        PixelClass::background;
        ReferenceOptions options;
        options.targetStandardError = 1.0 / 256;
        reference_ = traceReference(stage.tracer, gbuffer_, stage.moment.light, options);
    }

    double rmse(const std::vector<float>& image) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < image.size(); ++i)
            if (gbuffer_.mask[i] == PixelClass::scored)
                sum += std::pow(static_cast<double>(image[i]) - reference_.visibility[i], 2.0);
        return std::sqrt(sum / static_cast<double>(
                                   std::max<std::size_t>(1, gbuffer_.count(PixelClass::scored))));
    }

  private:
    GBuffer gbuffer_;
    Reference reference_;
};

/// The greatest epsilon, to one per cent, that still gives `maps` of them or more.
double epsilonFor(const Stage& stage, const Assignments& settings, int maps) {
    double low = 1e-3, high = 4.0;
    for (int step = 0; step < 10; ++step) {
        const double middle = std::sqrt(low * high);
        Player player(stage, "adaptive_light_sampled",
                      with(settings, "epsilon", std::to_string(middle)));
        player.play();
        (player.maps() >= maps ? low : high) = middle;
    }
    return low;
}

struct Case {
    std::string name, scene;
    bool linear;
    int maps, regularMaps;
};

void adaptiveAgainstRegular(benchmark::State& state, const Case& c, bool paper) {
    needContext();
    const Stage stage(c.scene, kWidth, kHeight, c.linear ? makeLinear : nullptr);
    Assignments adaptive = {
        {"pcf", "2x2"}, {"max_depth", c.linear ? "7" : "3"}, {"max_maps", c.linear ? "129" : "81"}};
    Assignments regular = {{"pcf", "true"}, {"pattern", "lattice"}};
    if (paper) {
        for (const auto& [parameter, value] : Assignments{{"count_by", "queries"},
                                                          {"criterion", "map_texels"},
                                                          {"pairs", "diagonals"},
                                                          {"centre_test", "false"},
                                                          {"stride", "1"}})
            adaptive = with(adaptive, parameter, value);
        adaptive = with(adaptive, "compare", c.linear ? "absolute" : "relative");
        adaptive = with(adaptive, "weights", c.linear ? "equal" : "local_depth");
        adaptive = with(adaptive, "evaluation", c.linear ? "buffer" : "array");
        if (c.linear) regular = with(regular, "accumulation", "buffer");
    } else {
        adaptive = with(adaptive, "skip_decided", "true");
    }
    const double epsilon = c.maps > c.regularMaps ? 0.0 : epsilonFor(stage, adaptive, c.maps);
    Player sparse(stage, "adaptive_light_sampled",
                  with(adaptive, "epsilon", std::to_string(epsilon)));
    Player all(stage, "light_sampled", with(regular, "samples", std::to_string(c.regularMaps)));
    sparse.play();
    Player mapsOnly(stage, "light_sampled",
                    {{"pattern", "owen"}, {"samples", std::to_string(sparse.maps())}});
    for (auto _ : state) {
        sparse.play();
        all.play();
        mapsOnly.play();
    }
    const Sparse truth(stage);
    const double frameMs = median(sparse.frameMs);
    state.counters["maps"] = sparse.maps();
    state.counters["epsilon"] = epsilon;
    state.counters["speed"] = median(all.frameMs) / frameMs;
    state.counters["rmse"] = truth.rmse(sparse.image());
    state.counters["rmse_regular"] = truth.rmse(all.image());
    state.counters["compare"] = (median(sparse.buildMs) - median(mapsOnly.buildMs)) / frameMs;
}

const auto registered = [] {
    for (const Case& c : {Case{"14_of_81", "sphere_plate", false, 14, 81},
                          Case{"7_of_128", "sphere_plate", true, 7, 128},
                          Case{"44_of_128", "sphere_plate", true, 44, 128},
                          Case{"worst_case", "sphere_plate", true, 129, 128}})
        for (const bool paper : {true, false})
            benchmark::RegisterBenchmark(
                ("adaptive_light_sampled/" + c.name + (paper ? "/paper" : "/ours")).c_str(),
                adaptiveAgainstRegular, c, paper)
                ->Iterations(3)
                ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra
