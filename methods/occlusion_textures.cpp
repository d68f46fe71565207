// Occlusion textures: the casters between light and receivers are cut into slices parallel to the
// light and drawn in one pass into binary textures, one per slice, from behind the light. Seen from
// a receiver the light covers a rectangle of each of them, whose mean is the share of the light
// that the slice hides; whatever the light's size that is one lookup in a prefiltered texture. The
// slices' shares are combined to V (Eisemann, Decoret 2006; METHODS.md 13).
//
// One caster parallel to the light is exact. Of several slices only their means are known, not
// whether they hide the same part of the light: the maximum is right where they do, the sum where
// they do not, the product where chance rules, and it leaves (1 - 1/n)^n of the light in the umbra
// of an oblique wall cut into n slices. `cells` asks each part of the light apart, which bounds
// what any rule can get wrong by the cells that more than one slice covers in part, and
// combination=continued takes neighbouring slices for pieces of one surface.
//
// Casters lie on their slice's plane instead of where they are: light leaks between the pieces of a
// surface that crosses a boundary (thin_casters closes it), penumbrae are a little too narrow, and
// what is in the receiver's own slice does not shadow it, so that contact shadows fade out within
// one slice's thickness; contact=hard_map compares with a shadow map there, and counts the slice
// that fades in in full where that map sees another surface in it than the receiver's own. Wires
// thinner than a texel come and go, and a sheet edge-on to the centre of projection has no shadow
// at all (cop_distance moves it). Slices are parallel to the light however it is tilted; all
// receivers must fit one frustum from behind it, and where they do not the method is unsupported.
//
// What a frame does not call for: tiles of pixels for whom all slices are empty and the map shows
// no contact, or one slice is full, are answered and not shaded (not under --effects all, and only
// with the table, whose counts are exact). Without self_shadow there are no map and no comparisons
// where casters keep off the receivers by three slices; bias and fade stay, for they move what
// kernels see of casters, too. Slices without casters exist under no plan: of one caster alone in
// its slice nothing is left to save without layered_casters. Bodies are filled where they cross a
// boundary, thin or not, for a solid's surface leaks there as well; where none does nothing is
// filled.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/passes/count_table.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/fill_depths.hpp"
#include "core/passes/n_buffers.hpp"
#include "core/passes/pixel_classes.hpp"
#include "core/passes/slice_pass.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

constexpr GLuint kOcclusionUnit = 4;  // shaders/occlusion_textures.glsl

class OcclusionTextures : public ShadowMethod {
    IntParameter mapSize_{this, "map_size", 512, 16, 2048, "texels", "side of the textures"};
    IntParameter slices_{this, "slices", 16, 1, SlicePass::kMostSlices, "", "occlusion textures"};
    ChoiceParameter targets_{this,
                             "targets",
                             {"bits", "channels"},
                             "slices are bits of one render target, or, as in the paper, channels "
                             "of up to four, which hold 16; more are bits"};
    ChoiceParameter projection_{this,
                                "projection",
                                {"perspective", "orthographic"},
                                "from behind the light, or along its normal"};
    FloatParameter copDistance_{this,
                                "cop_distance",
                                1.0,
                                0.0,
                                10.0,
                                "",
                                "distance of the centre of projection over the greatest from which "
                                "the frustum through the light holds the scene"};
    ChoiceParameter placement_{
        this,
        "placement",
        {"quantile", "uniform"},
        "boundaries of the slices: half by the casters' area, half by depth; or by depth alone"};
    BoolParameter snap_{this, "snap", true,
                        "a slice's plane lies at its deepest caster instead of its boundary"};
    ChoiceParameter prefilter_{
        this,
        "prefilter",
        {"auto", "sat", "n_buffers", "mipmap"},
        "of the textures: exact boxes from a summed-area table, two levels of means over squares "
        "at "
        "every place or of mip levels; auto: N-buffers where kernels are narrow, else the table"};
    ChoiceParameter combination_{
        this,
        "combination",
        {"continued", "product", "max", "sum", "mean"},
        "of the slices' shares: sum over slices that follow each other "
        "and product of such runs; the paper's rules; mean of max and sum"};
    IntParameter cells_{this,
                        "cells",
                        2,
                        1,
                        4,
                        "",
                        "cells along each side of the light whose shares are combined apart, 1 as "
                        "in the paper"};
    ChoiceParameter thinCasters_{
        this,
        "thin_casters",
        {"crossing", "thin", "all", "none"},
        "casters that are drawn into the next slice, too: bodies that go on in it, those of them "
        "that are thinner than a slice, all"};
    ChoiceParameter contact_{this,
                             "contact",
                             {"hard_map", "none"},
                             "casters within the slices that do not count yet: by comparisons with "
                             "a shadow map from the "
                             "light's centre, or, as in the paper, not at all"};
    BoolParameter earlyOuts_{
        this, "early_outs", true,
        "slices of which a kernel sees nothing or nothing else are looked up "
        "no further; without them a pixel's cost does not depend on the light"};
    FloatParameter bias_{this,
                         "bias",
                         1.5,
                         0.0,
                         16.0,
                         "texels",
                         "how far receivers are moved along their normal, in texel footprints at "
                         "their depth, times the sine of their slope"};

  public:
    Traits traits() const override { return {EffectSet::all()}; }

    std::vector<Assignments> ladder() const override {
        return {{{"slices", "4"}, {"cells", "2"}, {"map_size", "256"}},
                {{"slices", "8"}, {"cells", "2"}},
                {{"slices", "16"}, {"cells", "2"}},
                {{"slices", "16"}, {"cells", "3"}, {"map_size", "1024"}},
                {{"slices", "32"}, {"cells", "4"}, {"map_size", "1024"}}};
    }

    void prepare(const Scene& scene, const Plan& plan) override {
        const bool alphaMask = plan.has(Effect::alpha_mask);
        depth_ = DepthPass(plan);
        hard_ = gl::Program::graphics("occlusion_textures.glsl", {"PASS_HARD"});
        if (!plan.has(Effect::penumbra)) return;
        slicePass_ = SlicePass(
            slices_, targets_.is("bits") ? SliceTargets::bits : SliceTargets::channels, alphaMask);
        answersTiles_ = earlyOuts_ && mayUse(sat) && !plan.everyPixel;
        if (mayUse(sat)) table_ = CountTable::create();
        if (mayUse(nBuffers)) buffers_ = NBuffers::create();
        if (hasContact()) soft_[true] = compile(true);
        if (!hasContact() || !plan.has(Effect::self_shadow)) soft_[false] = compile(false);
        if (fillsSome()) fill_ = FillDepths(*scene.frame(0).geometry);
    }

    void build(const Frame& frame, const Plan& plan) override {
        soften_ = plan.has(Effect::penumbra) && !frame.light.isPoint();
        if (soften_) {
            view_ = SliceView::fit(frame, {.slices = slices_,
                                           .mapSize = mapSize_,
                                           .orthographic = projection_.is("orthographic"),
                                           .copFactor = copDistance_,
                                           .quantiles = placement_.is("quantile"),
                                           .snap = snap_});
            // Kernels within a texel tell nothing that the hard map does not tell better.
            soften_ = widestKernelTexels(frame) > 1.0;
        }
        touches_ =
            soften_ && hasContact() && (plan.has(Effect::self_shadow) || castersComeNear(frame));
        if (!soften_ || touches_)
            depth_.render(frame, LightView::fit(frame, glm::dvec2(0.0), mapSize_), mapSize_);
        if (!soften_) return;
        used_ = choosePrefilter(frame);
        renderSlices(frame);
        prefilter(frame, plan);
    }

    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        const gl::DebugGroup group("occlusion textures: shade");
        Soft& soft = soft_[touches_];
        const gl::Program& shader = soften_ ? soft.shade[used_] : hard_;
        if (answersTiles()) {
            setUp(soft.tiles.test(), frame.light);
            soft.tiles.classify(frame);
            setUp(shader, frame.light);
            soft.tiles.shade(shader, frame);
            target.draw(soft.tiles.answers(), frame.gbufferTextures);
            return;
        }
        setUp(shader, frame.light);
        target.draw(shader, frame.gbufferTextures);
    }

    WorkCounters counters() const override {
        if (!soften_) return {depth_.map().layers(), depth_.texels(), depth_.map().mebibytes(), ""};
        const double texels = static_cast<double>(mapSize_) * mapSize_ * slicePass_.used();
        const int maps = touches_ ? depth_.map().layers() : 0;
        return {1 + maps, texels + (touches_ ? depth_.texels() : 0.0),
                depth_.map().mebibytes() + slicePass_.mebibytes() + table_.mebibytes() +
                    buffers_.mebibytes() + fill_.mebibytes() + soft_[touches_].tiles.mebibytes(),
                ""};
    }
    std::vector<NamedTexture> textures() const override {
        return {{"shadow map, near / z", &depth_.map()},
                {"slices", &slicePass_.channels()},
                {"slices as bits", &slicePass_.bits()},
                {"N-buffers", &buffers_.texture()},
                {"summed-area table of counts", &table_.planes()}};
    }

  private:
    enum Prefilter { sat, nBuffers, mipmap };
    /// What looks slices up.
    struct Soft {
        std::array<gl::Program, 3> shade;  ///< by Prefilter
        PixelClasses tiles;
    };

    bool mayUse(Prefilter filter) const {
        switch (filter) {
            case sat:
                return prefilter_.is("sat") || prefilter_.is("auto");
            case nBuffers:
                return prefilter_.is("n_buffers") || prefilter_.is("auto");
            case mipmap:
                return prefilter_.is("mipmap");
        }
        return false;
    }

    /// The last build's slices can answer tiles. Only the table knows which texels are covered:
    /// means of N-buffers and mip levels are rounded.
    bool answersTiles() const { return soften_ && answersTiles_ && used_ == sat; }

    Soft compile(bool contact) const {
        std::vector<std::string> defines = {"SLICES " + slices_.text(), "CELLS " + cells_.text()};
        std::string rule = combination_.text();
        std::ranges::transform(rule, rule.begin(), [](char c) { return std::toupper(c); });
        defines.push_back("COMBINE_" + rule);
        if (!thinCasters_.is("none")) defines.emplace_back("FILLED");
        if (contact) defines.emplace_back("CONTACT");
        if (earlyOuts_) defines.emplace_back("EARLY_OUTS");
        const auto program = [&](std::initializer_list<const char*> more) {
            std::vector<std::string> all = defines;
            all.insert(all.end(), more.begin(), more.end());
            return gl::Program::graphics("occlusion_textures.glsl", all);
        };
        Soft soft;
        if (answersTiles_) {
            soft.shade[sat] = program({"PREFILTER_SAT", "UNDECIDED_TILES"});
            soft.tiles = PixelClasses::create(program({"PREFILTER_SAT", "PASS_CLASSIFY"}));
        } else if (mayUse(sat)) {
            soft.shade[sat] = program({"PREFILTER_SAT"});
        }
        if (mayUse(nBuffers)) soft.shade[nBuffers] = program({"PREFILTER_N_BUFFERS"});
        if (mayUse(mipmap)) soft.shade[mipmap] = program({});
        return soft;
    }

    static int levelsOf(double texels) {
        return 1 + static_cast<int>(std::floor(std::log2(std::max(texels, 1.0))));
    }

    /// Of the light as receivers see it on any slice, each way.
    glm::dvec2 widestKernel(const Frame& frame) const {
        glm::dvec2 widest(0.0);
        for (const double planeM : view_.planesM)
            widest = glm::max(widest, view_.kernelUv(frame.light, view_.farM, planeM) *
                                          static_cast<double>(mapSize_));
        return widest;
    }
    double widestKernelTexels(const Frame& frame) const {
        const glm::dvec2 widest = widestKernel(frame);
        return std::max(widest.x, widest.y);
    }

    /// The table costs the same for any kernel, N-buffers as much as their levels: two of them are
    /// cheaper than the table.
    Prefilter choosePrefilter(const Frame& frame) const {
        if (prefilter_.is("mipmap")) return mipmap;
        if (prefilter_.is("n_buffers")) return nBuffers;
        constexpr double kNarrowTexels = 2.0;
        return prefilter_.is("auto") && widestKernelTexels(frame) <= kNarrowTexels ? nBuffers : sat;
    }

    void prefilter(const Frame& frame, const Plan& plan) {
        if (used_ == sat) {
            // Any place of a kernel touches up to two more texels each way, and all of them at
            // most.
            const glm::dvec2 box = glm::min(glm::ceil(widestKernel(frame)) + 2.0,
                                            glm::dvec2(static_cast<double>(mapSize_)));
            const double texels = box.x * box.y;
            if (plan.everyPixel) return table_.build(slicePass_, texels);
            const auto size = static_cast<double>(mapSize_);
            return table_.build(slicePass_, texels,
                                {glm::ivec2(glm::floor(drawn_.uvLo * size)),
                                 glm::ivec2(glm::ceil(drawn_.uvHi * size))});
        }
        slicePass_.unpack();
        const gl::Texture& channels = slicePass_.channels();
        if (used_ == nBuffers) {
            buffers_.build(channels,
                           std::min(levelsOf(widestKernelTexels(frame)) + 1, levelsOf(mapSize_)));
            return;
        }
        glGenerateTextureMipmap(channels.id());
        glTextureParameteri(channels.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
        glTextureParameteri(channels.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }

    /// Whether some comparison with the map may find a caster: one that lies no higher than the
    /// last slice but one above the nearest receiver, three where slices are filled (castsFrom of
    /// the shader). Parts that cast no shadow are none.
    bool castersComeNear(const Frame& frame) const {
        const glm::dvec2 texelM = 1.0 / (view_.shrink(view_.farM) * mapSize_ * view_.scale);
        const double nearestM = frame.lightBounds.whole.receiverNearM -
                                static_cast<double>(bias_) * std::max(texelM.x, texelM.y);
        const auto lower = view_.boundariesM.begin() + 1;
        const auto above = std::lower_bound(lower, view_.boundariesM.end(), nearestM) - lower;
        const int asked = thinCasters_.is("none") ? 2 : 3;
        if (above < asked) return true;
        const double clearM = lower[above - asked];
        const Geometry& geometry = *frame.geometry;
        for (std::size_t i = 0; i < geometry.parts.size(); ++i) {
            if (!frame.casterFacts.parts[i].casts) continue;
            const Part& part = geometry.parts[i];
            for (std::uint32_t v = 0; v < part.indexCount; ++v) {
                const glm::dvec3 p(geometry.positions[geometry.indices[part.firstIndex + v]]);
                if (glm::dot(view_.axisZ, p - view_.centre) >= clearM) return true;
            }
        }
        return false;
    }

    bool hasContact() const { return contact_.is("hard_map"); }
    /// Some casters, by what they are and where.
    bool fillsSome() const { return thinCasters_.is("thin") || thinCasters_.is("crossing"); }

    void renderSlices(const Frame& frame) {
        drawn_ = slicesWithCasters(view_, *frame.geometry);
        SliceFill fill{.always = thinCasters_.is("all")};
        if (fill.always) drawn_.slices |= drawn_.slices << 1;
        if (fillsSome()) {
            fill = fill_.find(*frame.geometry, view_,
                              thinCasters_.is("thin") ? FillDepths::Bodies::thinnerThanASlice
                                                      : FillDepths::Bodies::any);
            drawn_.slices |= fill_.filled();
        }
        slicePass_.render(frame, view_, fill, mapSize_, drawn_.slices);
    }

    /// Uses a program with all that it reads but the G-buffer and tiles.
    void setUp(const gl::Program& shader, const AreaLight& light) const {
        shader.use();
        shader.set(*this);
        if (!soften_ || touches_) depth_.bind(shader, 0);
        shader.set("biasTexels", 0.5f);  // method hard's default
        if (soften_) setView(shader, light);
    }

    void setView(const gl::Program& shader, const AreaLight& light) const {
        if (used_ == sat)
            table_.bind(shader, kOcclusionUnit);
        else if (used_ == nBuffers)
            buffers_.texture().bind(kOcclusionUnit);
        else
            slicePass_.channels().bind(kOcclusionUnit);
        shader.set("levels", buffers_.levels());
        shader.set("lightAxes",
                   glm::mat3(glm::transpose(glm::dmat3(view_.axisX, view_.axisY, view_.axisZ))));
        shader.set("lightCentre", glm::vec3(view_.centre));
        shader.set("lightHalfM", glm::vec2(light.halfU, light.halfV));
        shader.set("orthographic", view_.orthographic ? 1 : 0);
        shader.set("copM", static_cast<float>(view_.copM));
        shader.set("uvScale", glm::vec2(view_.scale));
        shader.set("uvOffset", glm::vec2(view_.offset));
        shader.set("mapSize", static_cast<int>(mapSize_));
        const std::size_t count = view_.planesM.size();
        int used = 0;
        for (std::size_t k = 0; k < count; ++k) {
            const double lower = view_.boundariesM[k + 1],
                         next = k + 2 <= count ? view_.boundariesM[k + 2] : view_.farM;
            shader.set(("lowerM[" + std::to_string(k) + "]").c_str(), static_cast<float>(lower));
            if (drawn_.slices >> k & 1)
                shader.set(("slices[" + std::to_string(used++) + "]").c_str(),
                           glm::vec4(view_.planesM[k], lower, 1.0 / (next - lower), k));
        }
        shader.set("used", used);
    }

    DepthPass depth_;
    SlicePass slicePass_;
    CountTable table_;
    NBuffers buffers_;
    FillDepths fill_;
    gl::Program hard_;
    std::array<Soft, 2> soft_;  ///< without and with comparisons with the map
    SliceView view_;
    DrawnSlices drawn_;  ///< what something may be drawn into
    Prefilter used_ = sat;
    bool answersTiles_ = false;  ///< where the table is used
    bool soften_ = false;        ///< the last build made slices
    bool touches_ = false;       ///< and a map that is compared with
};

const Register<OcclusionTextures> entry{"occlusion_textures", "Occlusion textures",
                                        "Eisemann, Decoret 2006"};

}  // namespace
}  // namespace penumbra
