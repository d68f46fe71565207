// Variance shadow maps: a map of the mean and mean square of depth can be filtered before anyone
// looks it up, and Chebyshev's inequality bounds from them how much of a kernel lies beyond the
// receiver (Donnelly, Lauritzen 2006). A summed-area table has the moments of any box from a few
// fetches (Lauritzen 2007, SAVSM), so the kernel may be as wide as the penumbra: the same
// inequality in a wider box tells the blockers' mean depth from which that width follows (Yang,
// Dong, Feng, Seidel, Kautz 2010, variance soft shadow mapping: kernel=pcss).
//
// The bound is exact for one caster over a receiver of one depth. Behind two casters one above the
// other it is an upper bound only and light bleeds: half each at depths 0 and 1, it leaves 0.2,
// 0.1, 0.02 of light at 1.5, 2, 4 (METHODS.md 4), the worse the wider the kernel (layers, arcade).
// `bleed` cuts such light off and darkens penumbrae for it; `subdivisions` bounds cells of the
// kernel apart, whose borders show as faint streaks where one caster's edge crosses another's
// shadow.
//
// Unoccluded planes of any slope are lit, but a steep receiver's own depths widen the variance, so
// that shadows on it are too light near their casters. Penumbrae wider than `search` are cut to it;
// behind casters of several heights one mean depth gives one width, wrong for each of them. Casters
// closer to the receiver than the stored moments resolve (min_variance) leak at contacts. A light
// narrower than a texel falls back to the hard comparison.
//
// At the sizes at which it pays, tiles of pixels before whose planes nothing is in any texel of the
// widest kernel, by a min/max pyramid of the map, are lit without a lookup, and those dark where
// casters of much the same depth fill it (prefilters by table only). Without self_shadow nothing is
// saved where there are penumbrae: what no caster hides must be in the map at its own depth, or the
// moments are no longer those of blocker and receiver. Thin and layered casters are one texel like
// any other.

#include <algorithm>

#include "core/gl/program.hpp"
#include "core/passes/blur.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/layer_pass.hpp"
#include "core/passes/min_max_pyramid.hpp"
#include "core/passes/pixel_classes.hpp"
#include "core/passes/summed_area_table.hpp"
#include "methods/map_bias.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

constexpr GLuint kMomentsUnit = 1;    // shaders/vsm.glsl, shaders/common/summed_area_table.glsl
constexpr double kWidestBlur = 33.0;  // texels; wider kernels are left to the mip levels
constexpr double kPcssBlur = 3.0;     // texels: kernels of pcss start from nothing
constexpr double kMostCellTexels = 1 << 14;  // leaves an integer table 18 bits for a depth

class Vsm : public ShadowMethod {
    IntParameter mapSize_{this, "map_size", 512, 16, 8192, "texels", "side of the shadow map"};
    ChoiceParameter kernel_{this,
                            "kernel",
                            {"pcss", "fixed"},
                            "width of the penumbra from the blockers' mean depth, or kernel_size"};
    ChoiceParameter prefilter_{
        this,
        "prefilter",
        {"sat_uint", "sat_float", "mipmap", "box", "gaussian"},
        "summed-area table of integers modulo 2^32, or of floats less their mean; mip levels, "
        "several lookups along a box; a blur as wide as the narrowest cell and mip levels of it"};
    ChoiceParameter format_{
        this, "format", {"rg32f", "rg16f", "rg16"}, "of the two moments of each texel"};
    FloatParameter kernelSize_{this,
                               "kernel_size",
                               0.25,
                               0.0,
                               4.0,
                               "light sizes",
                               "width of the fixed kernel at the receiver over the light's width, "
                               "each axis apart"};
    FloatParameter search_{
        this,
        "search",
        0.5,
        0.0,
        4.0,
        "light sizes",
        "widest box searched for blockers, and widest kernel, at the receiver: 1 "
        "fits casters halfway up to the light, 0.5 a third of the way"};
    IntParameter searches_{this,
                           "searches",
                           2,
                           1,
                           4,
                           "",
                           "boxes searched for blockers in turn, each as wide as the penumbra that "
                           "the one before it found"};
    IntParameter subdivisions_{this,
                               "subdivisions",
                               4,
                               1,
                               6,
                               "",
                               "cells along each side of a kernel that are bounded apart"};
    FloatParameter bleed_{this,
                          "bleed",
                          0.1,
                          0.0,
                          0.95,
                          "",
                          "light-bleeding reduction: visibilities below it are 0, the rest is "
                          "stretched over [0, 1]"};
    FloatParameter minVariance_{this,
                                "min_variance",
                                2.0,
                                0.0,
                                1e6,
                                "quanta",
                                "least variance, in steps of the second moment as it is stored"};
    MapBias bias_{this};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"kernel", "fixed"}, {"subdivisions", "1"}},
                {{"subdivisions", "2"}, {"searches", "1"}},
                {{"subdivisions", "4"}, {"searches", "2"}},
                {{"subdivisions", "6"}, {"searches", "2"}, {"map_size", "1024"}},
                {{"subdivisions", "6"}, {"searches", "4"}, {"map_size", "2048"}}};
    }

    void prepare(const Scene&, const Plan& plan) override {
        depth_ = DepthPass(plan, MapBias::filtered(mapPlan(plan)));
        if (!plan.has(Effect::penumbra)) return compileHard(plan);
        layerPass_ = LayerPass::create();
        std::vector<std::string> format;
        if (format_.is("rg16")) format.emplace_back("FORMAT_UNORM");
        if (format_.is("rg16f")) format.emplace_back("FORMAT_HALF");
        std::vector<std::string> momentDefines = format;
        std::vector<std::string> softDefines = MapBias::defines(mapPlan(plan), format);
        softDefines.push_back("SUBDIVISIONS " + subdivisions_.text());
        momentDefines.emplace_back("PASS_MOMENTS");
        momentsProgram_ = gl::Program::graphics("vsm.glsl", momentDefines);
        softDefines.emplace_back(kernel_.is("fixed") ? "KERNEL_FIXED" : "KERNEL_PCSS");
        if (usesTable()) softDefines.emplace_back("PREFILTER_TABLE");
        if (prefilter_.is("sat_uint")) softDefines.emplace_back("TABLE_UINT");
        softDefines_ = softDefines;
        soft_ = {};
        if (usesTable())
            table_ =
                SummedAreaTable::create(prefilter_.is("sat_uint") ? SummedAreaTable::Kind::uint32
                                                                  : SummedAreaTable::Kind::float32);
        if (blurs()) blur_ = Blur::create();
    }

    void build(const Frame& frame, const Plan& plan) override {
        const glm::dvec2 widestM = widest() * lightHalf(frame.light);
        soften_ = plan.has(Effect::penumbra) && widestM != glm::dvec2(0.0);
        depth_.render(frame, LightView::fit(frame, soften_ ? widestM : glm::dvec2(0.0), mapSize_),
                      mapSize_);
        if (!soften_ && !hard_) compileHard(plan);
        if (!soften_) return;
        if (!soft_ || tiled_ != isWorthTiles(frame, plan)) compileSoft(isWorthTiles(frame, plan));
        setRanges(frame.lightBounds);
        const double cellTexels = widestCell(frame.light);
        renderMoments(cellTexels);
        if (usesTable())
            table_.build(moments_, cellTexels);
        else
            filterMoments(frame.light);
        if (tiled_)
            minMax_.build(depth_,
                          PixelClasses::widestWindow(frame, depth_, kernelBox(frame.light)));
    }

    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        const gl::DebugGroup group("vsm: shade");
        const bool classified = soften_ && tiled_;
        if (classified)
            classes_.classify(frame, depth_, minMax_, bias_.texels(mapPlan(plan)),
                              kernelBox(frame.light));
        const gl::Program& program = soften_ ? soft_ : hard_;
        program.use();
        depth_.bind(program, 0);
        bias_.set(program, mapPlan(plan));
        if (soften_) {
            program.set(*this);
            program.set("lightHalfM", glm::vec2(lightHalf(frame.light)));
            bindMoments(program);
        }
        if (classified) {
            classes_.shade(program, frame);
            target.draw(classes_.answers(), frame.gbufferTextures);
        } else {
            target.draw(program, frame.gbufferTextures);
        }
    }

    WorkCounters counters() const override {
        return {depth_.map().layers(), depth_.texels(),
                depth_.map().mebibytes() + moments_.mebibytes() + table_.mebibytes() +
                    blur_.mebibytes() + minMax_.texture().mebibytes() + classes_.mebibytes(),
                ""};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow map, near / z", &depth_.map()},
                {"moments", &moments_},
                {"summed-area table", &table_.table()}};
    }

  private:
    /// Depths in metres of one tile.
    struct Range {
        double nearM, farM;  ///< of -1 and 1
        double casterNearM, receiverNearM;
    };

    static glm::dvec2 lightHalf(const AreaLight& light) { return {light.halfU, light.halfV}; }
    bool usesTable() const { return prefilter_.is("sat_uint") || prefilter_.is("sat_float"); }
    /// Moments are of two depths, Chebyshev's bound exact, only if what is not a blocker has the
    /// receiver's own: soft shadows want the receivers in the map, and then a bias.
    static Plan mapPlan(Plan plan) {
        if (plan.has(Effect::penumbra)) plan.simulated.add(Effect::self_shadow);
        return plan;
    }

    /// Mip levels and blurs reach beyond their box by more than a kernel is wide. What is lit
    /// leaves after the first of the boxes in any case, so that an answer spares that one's cells.
    bool isWorthTiles(const Frame& frame, const Plan& plan) const {
        const double cells =
            static_cast<double>(subdivisions_) * static_cast<double>(subdivisions_);
        return usesTable() && !plan.everyPixel && PixelClasses::areWorth(frame, mapSize_, cells);
    }

    void compileSoft(bool tiled) {
        tiled_ = tiled;
        std::vector<std::string> defines = softDefines_;
        if (tiled) {
            minMax_ = MinMaxPyramid::create();
            classes_ =
                PixelClasses::create(PixelClasses::Dark::yes, PixelClasses::Footprint::moments);
            defines.emplace_back("UNDECIDED_TILES");
        }
        soft_ = gl::Program::graphics("vsm.glsl", defines);
    }

    void compileHard(const Plan& plan) {
        hard_ =
            gl::Program::graphics("vsm.glsl", MapBias::defines(mapPlan(plan), {"KERNEL_POINT"}));
    }

    bool blurs() const { return prefilter_.is("box") || prefilter_.is("gaussian"); }
    /// Half extents that no kernel exceeds, in half extents of the light.
    double widest() const { return kernel_.is("fixed") ? kernelSize_ : search_; }

    /// The texels that the first kernel averages, which the ones after it stay inside: where all of
    /// them are behind the receiver's plane so is every mean, and Chebyshev's bound is 1.
    PixelClasses::Box kernelBox(const AreaLight& light) const {
        const auto most = static_cast<float>(widest());
        PixelClasses::Box box{.halfM = lightHalf(light),
                              .kernel = {kernel_.is("fixed") ? most : 0.0f, most}};
        for (std::size_t i = 0; i < ranges_.size(); ++i) {
            if (kernel_.is("pcss"))
                box.nearestS[i] = static_cast<float>(ranges_[i].nearM / ranges_[i].casterNearM);
            box.depthPerM[i] = static_cast<float>(2.0 / (ranges_[i].farM - ranges_[i].nearM));
        }
        box.leastVariance = static_cast<float>(leastVariance() + minTexelVariance());
        box.bleed = static_cast<float>(bleed_);
        // No kernel is narrower than a texel, and one at the map's border is moved inside.
        box.padTexels = 1.0f;
        return box;
    }

    /// From the nearest depth the map can hold to the farthest receiver: what is beyond cannot
    /// shadow anything, and holding it at the far end keeps the variance small.
    void setRanges(const LightBounds& bounds) {
        ranges_.clear();
        for (std::size_t i = 0; i < depth_.view().tiles.size(); ++i) {
            const SideBounds& side =
                depth_.view().tiles.size() == 1 ? bounds.whole : bounds.sides[i];
            const double nearM = depth_.view().tiles[i].nearM;
            // A tile without receivers, or with all of them in nearM, still needs a range.
            const double farM = std::max(side.receiverFarM, 1.001 * nearM);
            ranges_.push_back({nearM, farM, std::clamp(side.casterNearM, nearM, farM),
                               std::clamp(side.receiverNearM, nearM, farM)});
        }
    }

    /// Width in texels of the fixed kernel or the search at depth `zM` of tile `i`.
    glm::dvec2 kernelTexels(const AreaLight& light, std::size_t i, double zM) const {
        glm::dvec2 half = lightHalf(light);
        if (i > 0) half = glm::dvec2(std::max(half.x, half.y));
        return 2.0 * widest() * half / zM / depth_.view().tiles[i].tangentSize() *
               static_cast<double>(mapSize_);
    }

    /// Area of the largest cell that shading will look up, texels.
    double widestCell(const AreaLight& light) const {
        double most = 1.0;
        for (std::size_t i = 0; i < ranges_.size(); ++i) {
            const glm::dvec2 kernel = glm::min(kernelTexels(light, i, ranges_[i].receiverNearM),
                                               glm::dvec2(static_cast<double>(mapSize_)));
            // The lines between cells move by up to half a texel each.
            const glm::dvec2 cell = kernel / static_cast<double>(subdivisions_) + 1.0;
            most = std::max(most, cell.x * cell.y);
        }
        return std::min(most, kMostCellTexels);
    }

    GLenum internalFormat() const {
        return format_.is("rg32f") ? GL_RG32F : format_.is("rg16f") ? GL_RG16F : GL_RG16;
    }

    /// Step of a second moment near 1 in the format, or what arithmetic in floats leaves of it.
    double formatQuantum() const {
        return format_.is("rg32f") ? 0x1p-23 : format_.is("rg16f") ? 0x1p-11 : 0x1p-16;
    }

    void renderMoments(double cellTexels) {
        const gl::DebugGroup group("vsm: moments");
        const int layers = depth_.map().layers();
        int levels = 1;
        while (!usesTable() && (static_cast<int>(mapSize_) >> levels) > 0) ++levels;
        if (moments_.width() != mapSize_ || moments_.layers() != layers) {
            moments_ =
                gl::Texture::createArray(internalFormat(), mapSize_, mapSize_, layers, levels);
            if (!usesTable()) setTrilinear(moments_);
        }
        double step = format_.is("rg16") ? 2.0 / 65535.0 : 0.0;
        if (prefilter_.is("sat_uint")) step = std::max(step, SummedAreaTable::stepOf(cellTexels));
        momentsProgram_.set("depthStep", static_cast<float>(step));
        depth_.map().bind(0);
        for (int layer = 0; layer < layers; ++layer) {
            const Range& range = ranges_[static_cast<std::size_t>(layer)];
            momentsProgram_.set("layer", layer);
            momentsProgram_.set("nearM", static_cast<float>(range.nearM));
            momentsProgram_.set("depthRangeM", glm::vec2(range.nearM, range.farM));
            layerPass_.draw(momentsProgram_, moments_, layer);
        }
    }

    static void setTrilinear(const gl::Texture& texture) {
        glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
        glTextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }

    /// Blur, if any, and mip levels.
    void filterMoments(const AreaLight& light) {
        blurTexels_ = glm::dvec2(0.0);
        if (blurs()) {
            blurTexels_ = glm::dvec2(kernel_.is("fixed") ? kWidestBlur : kPcssBlur);
            if (kernel_.is("fixed"))
                for (std::size_t i = 0; i < ranges_.size(); ++i)
                    blurTexels_ = glm::min(blurTexels_, kernelTexels(light, i, ranges_[i].farM) /
                                                            static_cast<double>(subdivisions_));
            const BlurShape shape = prefilter_.is("box") ? BlurShape::box : BlurShape::gaussian;
            blur_.apply(moments_, blurWeights(shape, blurTexels_.x),
                        blurWeights(shape, blurTexels_.y));
        }
        glGenerateTextureMipmap(moments_.id());
    }

    double leastVariance() const { return minVariance_ * (formatQuantum() + table_.stepError()); }
    /// In addition, of a cell of one texel.
    double minTexelVariance() const { return minVariance_ * table_.sumError(); }

    void bindMoments(const gl::Program& program) const {
        if (usesTable())
            table_.bind(program, kMomentsUnit);
        else
            moments_.bind(kMomentsUnit);
        program.set("minVariance", static_cast<float>(leastVariance()));
        program.set("minTexelVariance", static_cast<float>(minTexelVariance()));
        program.set("blurTexels", glm::vec2(blurTexels_));
        for (std::size_t i = 0; i < ranges_.size(); ++i) {
            const std::string index = "[" + std::to_string(i) + "]";
            program.set(("tileDepth" + index).c_str(),
                        glm::vec2(ranges_[i].nearM, 2.0 / (ranges_[i].farM - ranges_[i].nearM)));
            program.set(("tileCasterNearM" + index).c_str(),
                        static_cast<float>(ranges_[i].casterNearM));
        }
    }

    DepthPass depth_;
    MinMaxPyramid minMax_;
    PixelClasses classes_;
    LayerPass layerPass_;
    Blur blur_;
    SummedAreaTable table_;
    gl::Program hard_, soft_, momentsProgram_;
    gl::Texture moments_;
    std::vector<Range> ranges_;  ///< of tiles
    glm::dvec2 blurTexels_{0.0};
    std::vector<std::string> softDefines_;
    bool soften_ = false;  ///< the last build made moments
    bool tiled_ = false;   ///< soft_ runs on undecided tiles
};

const Register<Vsm> entry{"vsm", "Variance shadow map", "Donnelly, Lauritzen 2006"};

}  // namespace
}  // namespace penumbra
