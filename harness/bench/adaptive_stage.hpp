#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "core/frame/gpu_geometry.hpp"
#include "harness/bench/stage.hpp"
#include "harness/reference/reference.hpp"
#include "harness/run/visibility_target.hpp"
#include "methods/shadow_method.hpp"

/// What the benchmarks and the figures of `adaptive_light_sampled` share: the protocol of
/// Schwaerzler 2009, section 5.
namespace penumbra::bench {

constexpr int kWidth = 1024, kHeight = 768;  // of the paper's frames

/// Of a linear light only the rectangle's greater extent is left.
inline void makeLinear(AreaLight& light) {
    (light.halfU < light.halfV ? light.halfU : light.halfV) = 0.0;
}

/// What all threads of this process have worked. Where the processor is the renderer that is what a
/// frame costs whatever else the machine does.
inline double processMs() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// A method set up for a stage, and its last frame's times.
class Player {
  public:
    Player(const Stage& stage, const std::string& id, const Assignments& settings)
        : stage_(stage),
          method_(findMethod(id).make()),
          target_(stage.gbuffer.width, stage.gbuffer.height) {
        for (const auto& [parameter, value] : settings) method_->set(id, parameter, value);
        plan_ = planFor({}, stage.analysis.calledFor(), method_->traits().simulates);
        method_->prepare(*stage.scene, plan_);
    }

    void play() {
        const double before = processMs();
        const gl::FencedTimer build;
        method_->build(stage_.frame, plan_);
        buildMs.push_back(build.stop());
        buildWorkMs = std::min(buildWorkMs, processMs() - before);
        const gl::FencedTimer shade;
        method_->shade(stage_.frame, plan_, target_);
        frameMs.push_back(buildMs.back() + shade.stop());
        workMs = std::min(workMs, processMs() - before);
    }
    /// A parameter that prepare does not read.
    void set(const std::string& parameter, const std::string& value) {
        method_->set("adaptive_light_sampled", parameter, value);
    }
    std::vector<float> image() const { return target_.read(); }
    std::string message() const { return method_->counters().message; }
    /// Points of the light that the last frame had maps from.
    int maps() const { return std::stoi(message()); }

    std::vector<double> buildMs, frameMs;
    double workMs = 1e300, buildWorkMs = 1e300;  ///< least of all frames

  private:
    const Stage& stage_;
    std::unique_ptr<ShadowMethod> method_;
    Plan plan_;
    TextureTarget target_;
};

inline double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
}

inline Assignments with(Assignments settings, const std::string& parameter,
                        const std::string& value) {
    settings.emplace_back(parameter, value);
    return settings;
}

/// Reference and rmse in every fourth pixel of a row and column.
class Sparse {
  public:
    explicit Sparse(const Stage& stage) : gbuffer_(stage.gbuffer) {
        const int width = gbuffer_.width;
        for (int y = 0; y < gbuffer_.height; ++y)
            for (int x = 0; x < width; ++x)
                if (x % 4 != 0 || y % 4 != 0)
                    gbuffer_.mask[static_cast<std::size_t>(y * width + x)] = PixelClass::background;
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

    /// The share of pixels that see some of the light and not all.
    double penumbra() const {
        double between = 0.0;
        for (std::size_t i = 0; i < gbuffer_.mask.size(); ++i)
            if (gbuffer_.mask[i] == PixelClass::scored)
                between += reference_.visibility[i] > 0.0f && reference_.visibility[i] < 1.0f;
        return between /
               static_cast<double>(std::max<std::size_t>(1, gbuffer_.count(PixelClass::scored)));
    }

  private:
    GBuffer gbuffer_;
    Reference reference_;
};

/// The greatest epsilon, to one per cent, that still gives `maps` of them or more.
inline double epsilonFor(const Stage& stage, const Assignments& settings, int maps) {
    double low = 1e-3, high = 4.0;
    Player player(stage, "adaptive_light_sampled", settings);
    for (int step = 0; step < 10; ++step) {
        const double middle = std::sqrt(low * high);
        player.set("epsilon", std::to_string(middle));
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

/// Of both sides of a case, without epsilon and samples.
struct Settings {
    Assignments adaptive, regular;
};

/// `paper`: its own algorithm (fig. 1: texture array, eqs 4, 6 and 7; fig. 7: linear light,
/// accumulation buffer, eqs 3 and 4, equal weights); else the method's defaults.
inline Settings settingsOf(const Case& c, bool paper) {
    Assignments adaptive = {
        {"pcf", "2x2"}, {"max_depth", c.linear ? "7" : "3"}, {"max_maps", c.linear ? "129" : "81"}};
    Assignments regular = {{"pcf", "true"}, {"pattern", "lattice"}};
    if (paper) {
        for (const auto& [parameter, value] : Assignments{{"count_by", "queries"},
                                                          {"criterion", "map_texels"},
                                                          {"pairs", "diagonals"},
                                                          {"centre_test", "false"},
                                                          {"rim_depth", "-1"},
                                                          {"stride", "1"}})
            adaptive = with(adaptive, parameter, value);
        adaptive = with(adaptive, "compare", c.linear ? "absolute" : "relative");
        adaptive = with(adaptive, "weights", c.linear ? "equal" : "local_depth");
        adaptive = with(adaptive, "evaluation", c.linear ? "buffer" : "array");
        if (c.linear) regular = with(regular, "accumulation", "buffer");
    }
    return {adaptive, regular};
}

inline std::vector<Case> paperCases() {
    return {{"14_of_81", "sphere_plate", false, 14, 81},
            {"7_of_128", "sphere_plate", true, 7, 128},
            {"44_of_128", "sphere_plate", true, 44, 128},
            {"worst_case", "sphere_plate", true, 129, 128}};
}

}  // namespace penumbra::bench
