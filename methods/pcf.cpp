// Percentage-closer filtering: the hard comparison averaged over a fixed kernel around the receiver
// (Reeves, Salesin, Cook 1987; METHODS.md 2). Every tap compares against the receiver's own plane
// followed to that tap (receiver-plane depth bias), so wide kernels do not shade slopes; the
// texture unit's four comparisons share the one reference that is right for the worst of them. The
// penumbra has one width whatever the distances, so it is too wide at contacts and too narrow far
// from the caster; kernels wider than a caster's detail step over it, and on concave or twisted
// surfaces a kernel wider than a facet finds the next one above its plane and shades it (spinner).
//
// Tiles of pixels whose taps are all lit or all dark, by a min/max pyramid of the map, are not
// filtered, where there are several taps for each texel of the map. Without self_shadow the map
// holds only the parts that cast and nothing is biased. Thin and layered casters are one texel like
// any other: nothing to save.

#include <algorithm>
#include <cmath>
#include <glm/packing.hpp>

#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/min_max_pyramid.hpp"
#include "core/passes/pixel_classes.hpp"
#include "core/sampling/sampling.hpp"
#include "methods/map_bias.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

class Pcf : public ShadowMethod {
    IntParameter mapSize_{this, "map_size", 1024, 16, 16384, "texels", "side of the shadow map"};
    ChoiceParameter pattern_{
        this,
        "pattern",
        {"grid", "vogel", "poisson"},
        "taps at the cell centres of a k x k grid, k^2 the greatest square not above taps, over "
        "the "
        "kernel's rectangle; or on its inscribed disc, along Vogel's spiral or at random with a "
        "least distance"};
    IntParameter taps_{this, "taps", 49, 1, 1024, "", "comparisons per pixel"};
    FloatParameter kernel_{this,
                           "kernel",
                           0.25,
                           0.0,
                           4.0,
                           "light sizes",
                           "kernel width at the receiver over the light's width, each axis apart: "
                           "0.25 fits casters a fifth of the way up from receiver to light"};
    BoolParameter rotation_{this, "rotation", false,
                            "turn the pattern by an angle of each pixel's own: noise for banding"};
    ChoiceParameter compare_{this,
                             "compare",
                             {"nearest", "hardware"},
                             "each tap compares the nearest texel, or four of them weighted by "
                             "distance as the texture unit does"};
    MapBias bias_{this};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"taps", "9"}, {"map_size", "512"}},
                {{"taps", "25"}, {"map_size", "1024"}},
                {{"taps", "49"}, {"map_size", "1024"}},
                {{"taps", "121"}, {"map_size", "2048"}},
                {{"taps", "289"}, {"map_size", "2048"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        depth_ = DepthPass(plan, MapBias::filtered(plan));
        if (!plan.has(Effect::penumbra)) return compilePoint(plan);
        std::vector<std::string> defines = MapBias::defines(plan);
        if (compare_.is("hardware")) defines.emplace_back("COMPARE_HARDWARE");
        if (rotation_) defines.emplace_back("ROTATION");
        if (pattern_.is("grid")) {
            defines.push_back("GRID_SIDE " + std::to_string(gridSide()));
        } else {
            defines.push_back("TAPS " + taps_.text());
            const std::vector<glm::uint> taps = packedTaps();
            tapBuffer_ = gl::Buffer::create(taps.size() * sizeof(glm::uint), taps.data());
        }
        kernelDefines_ = defines;
        kernelProgram_ = {};
        comparing_ = comparingSampler();
    }

    void build(const Frame& frame, const Plan& plan) override {
        const bool soft = isSoft(frame, plan);
        if (!soft && !point_) compilePoint(plan);
        if (soft && (!kernelProgram_ || tiled_ != isWorthTiles(frame, plan)))
            compileKernel(isWorthTiles(frame, plan));
        // A turned square reaches out by its diagonal.
        const double reach = !soft ? 0.0 : rotation_ && pattern_.is("grid") ? std::sqrt(2.0) : 1.0;
        depth_.render(frame, LightView::fit(frame, reach * kernelHalf(frame.light), mapSize_),
                      mapSize_);
        if (soft && tiled_)
            minMax_.build(depth_, PixelClasses::widestWindow(frame, depth_, tapsBox(frame.light)));
    }

    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        const gl::DebugGroup group("pcf: filter");
        const bool soft = isSoft(frame, plan);
        if (soft && tiled_)
            classes_.classify(frame, depth_, minMax_, bias_.texels(plan), tapsBox(frame.light));
        const gl::Program& program = soft ? kernelProgram_ : point_;
        program.use();
        depth_.bind(program, 0);
        bias_.set(program, plan);
        if (soft) {
            depth_.map().bind(kComparedUnit);
            glBindSampler(kComparedUnit, comparing_.id());
            glBindBufferBase(GL_UNIFORM_BUFFER, 1, tapBuffer_.id());
            program.set("kernelHalfM", glm::vec2(kernelHalf(frame.light)));
        }
        if (soft && tiled_) {
            classes_.shade(program, frame);
            target.draw(classes_.answers(), frame.gbufferTextures);
        } else {
            target.draw(program, frame.gbufferTextures);
        }
        glBindSampler(kComparedUnit, 0);
    }

    WorkCounters counters() const override {
        return {depth_.map().layers(), depth_.texels(),
                depth_.map().mebibytes() + minMax_.texture().mebibytes() + classes_.mebibytes(),
                ""};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow map, near / z", &depth_.map()}};
    }

  private:
    static bool isSoft(const Frame& frame, const Plan& plan) {
        return plan.has(Effect::penumbra) && !frame.light.isPoint();
    }

    bool isWorthTiles(const Frame& frame, const Plan& plan) const {
        return !plan.everyPixel && PixelClasses::areWorth(frame, mapSize_, taps_);
    }

    void compileKernel(bool tiled) {
        tiled_ = tiled;
        std::vector<std::string> defines = kernelDefines_;
        if (tiled) {
            minMax_ = MinMaxPyramid::create();
            classes_ = PixelClasses::create(PixelClasses::Dark::yes, PixelClasses::Footprint::box);
            defines.emplace_back("UNDECIDED_TILES");
        }
        kernelProgram_ = gl::Program::graphics("pcf.glsl", defines);
    }

    void compilePoint(const Plan& plan) {
        point_ = gl::Program::graphics("pcf.glsl", MapBias::defines(plan, {"NO_KERNEL"}));
    }

    int gridSide() const { return static_cast<int>(std::sqrt(taps_ + 0.5)); }

    /// The texels that the taps look at.
    PixelClasses::Box tapsBox(const AreaLight& light) const {
        // A grid's taps are the centres of its cells, and turn as one.
        const double reach = pattern_.is("grid")
                                 ? (1.0 - 1.0 / gridSide()) * (rotation_ ? std::sqrt(2.0) : 1.0)
                                 : 1.0;
        const auto kernel = static_cast<float>(reach * kernel_);
        return {.halfM = {light.halfU, light.halfV},
                .kernel = {kernel, kernel},
                .padTexels = compare_.is("hardware") ? 0.5f : 0.0f};
    }

    glm::dvec2 kernelHalf(const AreaLight& light) const {
        return static_cast<double>(kernel_) * glm::dvec2(light.halfU, light.halfV);
    }

    /// The taps of vogel and poisson on the unit disc, x in the low half of each, in fours.
    std::vector<glm::uint> packedTaps() const {
        std::vector<glm::vec2> taps;
        if (pattern_.is("poisson")) taps = poissonDisc(taps_);
        while (taps.size() < static_cast<std::size_t>(taps_))
            taps.push_back(vogelDisc(static_cast<int>(taps.size()), taps_, 0.0f));
        std::vector<glm::uint> packed((taps.size() + 3) / 4 * 4);
        std::ranges::transform(taps, packed.begin(),
                               [](const glm::vec2& tap) { return glm::packSnorm2x16(tap); });
        return packed;
    }

    static constexpr GLuint kComparedUnit = 1;  // shaders/pcf.glsl

    DepthPass depth_;
    MinMaxPyramid minMax_;
    PixelClasses classes_;
    gl::Program point_, kernelProgram_;
    std::vector<std::string> kernelDefines_;
    bool tiled_ = false;  ///< kernelProgram_ runs on undecided tiles
    gl::Buffer tapBuffer_;
    gl::Sampler comparing_;
};

const Register<Pcf> entry{"pcf", "Percentage-closer filtering", "Reeves, Salesin, Cook 1987"};

}  // namespace
}  // namespace penumbra
