// Percentage-closer soft shadows: taps around the receiver find the casters between it and the
// light and their mean depth; one planar caster there, parallel to the light, would have a penumbra
// of known width; a box filter of that width over the hard comparison is the visibility (Fernando
// 2005; METHODS.md 3). Exact for such a caster over any receiver.
//
// Search and filter keep the light's two widths apart. The search looks into the very pyramid from
// the receiver to the light, cut at the nearest caster that a min/max pyramid of the map finds in
// it; casters outside do not count, those inside weigh as the share of the light that a texel of
// theirs covers, so that a wide search for a distant caster does not outvote a contact.
//
// Tiles of pixels ask the pyramid before any pixel does: those whose receivers are all lit or all
// dark are not shaded, the others know where in the map there are blockers and tap only there.
//
// It fails where one planar caster is not the truth: the mean over two layers gives a width that is
// wrong for both (layers), casters that the light's centre does not see are missing, so umbrae
// under several layers leak, too sparse a search steps over thin casters, and a kernel that reaches
// past a concave edge or behind a caster darkens what is lit (arcade).
//
// Without self_shadow the map holds only the parts that cast and nothing is biased. Thin and
// layered casters are one texel like any other: nothing to save.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/min_max_pyramid.hpp"
#include "core/passes/pixel_classes.hpp"
#include "methods/map_bias.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class Pcss : public ShadowMethod {
    IntParameter mapSize_{this, "map_size", 1024, 16, 16384, "texels", "side of the shadow map"};
    ChoiceParameter pattern_{this,
                             "pattern",
                             {"grid", "vogel"},
                             "taps of search and filter: a sheared k x k grid over the light's "
                             "rectangle, k^2 the greatest square not above the number of taps; or "
                             "as many on its inscribed Vogel disc"};
    IntParameter blockerTaps_{this, "blocker_taps", 64, 1, 4096, "", "casters looked at per pixel"};
    IntParameter filterTaps_{this, "filter_taps", 100, 1, 4096, "", "comparisons per pixel"};
    BoolParameter rotation_{this, "rotation", false,
                            "shift the grid within its cells, or turn the disc, at random per "
                            "pixel: noise in place of bands"};
    FloatParameter minKernel_{this,
                              "min_kernel",
                              0.0,
                              0.0,
                              1.0,
                              "light sizes",
                              "least width of the filter at the receiver over the light's width"};
    FloatParameter maxKernel_{this,
                              "max_kernel",
                              4.0,
                              0.0,
                              16.0,
                              "light sizes",
                              "greatest width of search and filter at the receiver over the "
                              "light's: 1 reaches casters half way up to the light"};
    MapBias bias_{this};
    ChoiceParameter pyramid_{this,
                             "pyramid",
                             {"early_outs", "narrow", "off"},
                             "min/max pyramid of the map: narrow the search to the nearest caster "
                             "that may matter and answer without taps where none or all of the "
                             "footprint blocks; narrow it only; or search up to the near plane"};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"blocker_taps", "9"}, {"filter_taps", "16"}, {"map_size", "512"}},
                {{"blocker_taps", "25"}, {"filter_taps", "49"}, {"map_size", "1024"}},
                {{"blocker_taps", "64"}, {"filter_taps", "100"}, {"map_size", "1024"}},
                {{"blocker_taps", "144"}, {"filter_taps", "256"}, {"map_size", "2048"}},
                {{"blocker_taps", "400"}, {"filter_taps", "900"}, {"map_size", "2048"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        depth_ = DepthPass(plan, MapBias::filtered(plan));
        if (!plan.has(Effect::penumbra)) return compileHard(plan);
        if (!pyramid_.is("off")) minMax_ = MinMaxPyramid::create();
        std::vector<std::string> defines = MapBias::defines(
            plan, {"SOFT", pattern_.is("grid") ? "PATTERN_GRID" : "PATTERN_VOGEL",
                   side("SEARCH_SIDE", blockerTaps_), side("FILTER_SIDE", filterTaps_)});
        if (rotation_) defines.emplace_back("ROTATION");
        if (!pyramid_.is("off")) defines.emplace_back("NARROW");
        if (hasEarlyOuts(plan)) {
            classes_ = PixelClasses::create(PixelClasses::Dark::yes);
            defines.emplace_back("EARLY_OUTS");
        }
        soft_ = gl::Program::graphics("pcss.glsl", defines);
    }

    void build(const Frame& frame, const Plan& plan) override {
        const bool soft = isSoft(frame, plan);
        if (!soft && !hard_) compileHard(plan);
        depth_.render(frame, soft ? softView(frame) : LightView::fit(frame, {}, mapSize_),
                      mapSize_);
        if (soft && !pyramid_.is("off")) minMax_.build(depth_);
    }

    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        const gl::DebugGroup group("pcss: search and filter");
        const bool soft = isSoft(frame, plan);
        const bool earlyOuts = soft && hasEarlyOuts(plan);
        if (earlyOuts)
            classes_.classify(frame, depth_, minMax_, bias_.texels(plan),
                              {static_cast<float>(minKernel_), static_cast<float>(maxKernel_)});
        const gl::Program& program = soft ? soft_ : hard_;
        program.use();
        depth_.bind(program, 0);
        bias_.set(program, plan);
        if (soft) {
            if (!pyramid_.is("off")) minMax_.bind(program);
            setFootprint(program, frame.light);
            program.set("seed", frame.seed);
            program.set(*this);
        }
        if (earlyOuts) {
            classes_.shade(program, frame);
            target.draw(classes_.answers(), frame.gbufferTextures);
        } else {
            target.draw(program, frame.gbufferTextures);
        }
    }

    WorkCounters counters() const override {
        return {depth_.map().layers(), depth_.texels(),
                depth_.map().mebibytes() + minMax_.texture().mebibytes() + classes_.mebibytes(),
                ""};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow map, near / z", &depth_.map()},
                {"min/max pyramid, finest level", &minMax_.texture()},
                {"classes of pixel tiles", &classes_.tiles()}};
    }

  private:
    /// Compiled in: loops of constant length are unrolled.
    static std::string side(const char* define, int taps) {
        return fmt::format("{} {}", define, static_cast<int>(std::sqrt(taps + 0.5)));
    }

    static bool isSoft(const Frame& frame, const Plan& plan) {
        return plan.has(Effect::penumbra) && !frame.light.isPoint();
    }

    bool hasEarlyOuts(const Plan& plan) const {
        return pyramid_.is("early_outs") && !plan.everyPixel;
    }

    void compileHard(const Plan& plan) {
        hard_ = gl::Program::graphics("pcss.glsl", MapBias::defines(plan));
    }

    /// The map should hold the casters beside the outermost receivers too: as far as a footprint
    /// reaches that ends at the nearest vertex, but no farther than the greatest kernel. What lies
    /// beyond all the same is taken to be as at the map's edge.
    LightView softView(const Frame& frame) const {
        const double most = std::max<double>(minKernel_, maxKernel_);
        const auto reach = [&](const SideBounds& bounds) {
            if (bounds.empty()) return 0.0;
            return std::clamp(
                bounds.receiverNearM * (1.0 / bounds.casterNearM - 1.0 / bounds.receiverFarM), 0.0,
                most);
        };
        const glm::dvec2 half(frame.light.halfU, frame.light.halfV);
        const LightView view =
            LightView::fit(frame, reach(frame.lightBounds.whole) * half, mapSize_);
        if (view.tiles.size() == 1) return view;
        // A side tile sees the light askew: both of its widths add up.
        double widest = 0.0;
        for (const SideBounds& bounds : frame.lightBounds.sides)
            widest = std::max(widest, reach(bounds));
        return LightView::fit(frame, glm::dvec2(widest * (half.x + half.y)), mapSize_);
    }

    DepthPass depth_;
    MinMaxPyramid minMax_;
    PixelClasses classes_;
    gl::Program hard_, soft_;
};

const Register<Pcss> entry{"pcss", "Percentage-closer soft shadows", "Fernando 2005"};

}  // namespace
}  // namespace penumbra
