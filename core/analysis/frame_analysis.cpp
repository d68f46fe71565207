#include "core/analysis/frame_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/analysis/sampled_rays.hpp"
#include "core/analysis/shaft_survey.hpp"
#include "core/trace/alpha_mask.hpp"

namespace penumbra {
namespace {

/// Casters must keep from receivers what a map without bias may be wrong by: some texels, here a
/// sixteenth of the light view's width, which is four texels of a map of 64.
constexpr double kClearance = 1.0 / 16;

/// How far beside a receiver comparisons find a caster: half a texel of a map of 128, one and a
/// half of one of 512 that is a third wider.
constexpr double kBeside = 1.0 / 256;

/// Parts that no sample met are looked for, only to leave them out, up to so many triangles.
constexpr std::size_t kFewTriangles = 4096;

constexpr const char* kNothingBetween =
    "nothing lies between the light and the points that are asked about";

std::string percent(std::size_t count, std::size_t all) {
    const double share = 100.0 * static_cast<double>(count) / static_cast<double>(all);
    return fmt::format("{:.{}f} %", share, share < 1.0 ? 2 : 0);
}

/// The work of analyseFrame, and what its steps share.
class Analysis {
  public:
    Analysis(const Scene& scene, const Tracer& tracer, const Receivers& receivers,
             const LightBounds& bounds)
        : scene_(scene),
          geometry_(tracer.geometry()),
          tracer_(tracer),
          receivers_(receivers),
          bounds_(bounds),
          solid_(scene.materials) {
        for (Material& material : solid_) {
            cutOut_.push_back(shareCutOut(material, scene.images));
            material.masked = cutOut_.back() > 0.0;
        }
        bodies_ = Casters::find(geometry_);
        facts_ = CasterFacts::find(geometry_, solid_, bodies_);
    }

    FrameAnalysis run(const Movement& movement) {
        if (!std::isfinite(boundsOf(geometry_.positions).radius())) {
            for (const EffectInfo& info : allEffects())
                say(info.effect, true, "could not be excluded: a vertex is not finite");
            movement.tell(findings_);
            return {findings_, facts_};
        }
        sampled_ = SampledRays::trace(tracer_, receivers_, bodies_);
        survey();
        tellPenumbra();
        tellSelfShadow();
        tellThin();
        tellLayered();
        tellAlpha();
        movement.tell(findings_);
        return {findings_, facts_};
    }

  private:
    bool cuts(std::size_t part) const {
        return solid_[static_cast<std::size_t>(geometry_.parts[part].material)].masked;
    }
    template <class Predicate>
    bool anyPart(const Predicate& holds) const {
        for (std::size_t p = 0; p < geometry_.parts.size(); ++p)
            if (holds(p)) return true;
        return false;
    }

    /// What samples did not show is looked for where rays may pass.
    void survey() {
        ShaftSurvey::Questions questions;
        questions.casts = sampled_.blocks;
        questions.near = sampled_.onCasters == 0;
        questions.layered = sampled_.layered == 0;
        questions.clearance = kClearance * viewWidth();
        questions.beside = kBeside * viewWidth();
        questions.toleranceM = glm::length(tracer_.shadowOrigin(glm::vec3(0), glm::vec3(1, 0, 0)));
        // A part that no sample met matters where it would be the first of its kind.
        const auto first = [&](const auto& isSuch) {
            return anyPart([&](std::size_t p) { return isSuch(p) && !sampled_.blocks[p]; }) &&
                   !anyPart([&](std::size_t p) { return isSuch(p) && sampled_.blocks[p]; });
        };
        const bool matters = questions.near || questions.layered ||
                             first([&](std::size_t p) { return facts_.parts[p].thin; }) ||
                             first([&](std::size_t p) { return cuts(p); });
        if (!matters && unmetTriangles() > kFewTriangles) {
            return;  // what was not asked about was shown
        }
        survey_ = ShaftSurvey::make(geometry_, receivers_, bodies_, questions);
        facts_.besideTangent = questions.beside;
        for (std::size_t p = 0; p < facts_.parts.size(); ++p) {
            facts_.parts[p].casts = survey_.casts[p];
            facts_.parts[p].inTheWay = survey_.inTheWay[p];
        }
        nothingBetween_ = sampled_.blocked == 0 && !anyPart([&](std::size_t p) {
                              return facts_.parts[p].casts || survey_.rises[p];
                          });
    }

    /// Of the parts that no sample met.
    std::size_t unmetTriangles() const {
        std::size_t count = 0;
        for (std::size_t p = 0; p < geometry_.parts.size(); ++p)
            if (!sampled_.blocks[p]) count += geometry_.parts[p].indexCount / 3;
        return count;
    }

    /// Of the light's view of the receivers, over the distance from its plane.
    double viewWidth() const {
        if (bounds_.whole.empty()) return 0.0;
        const glm::dvec2 size = bounds_.whole.tangentHi - bounds_.whole.tangentLo;
        return std::max(size.x, size.y);
    }

    void say(Effect effect, bool calledFor, std::string evidence) {
        findings_[effect] = {calledFor, std::move(evidence)};
    }

    void tellPenumbra() {
        const Effect e = Effect::penumbra;
        if (receivers_.light().isPoint()) return say(e, false, "the light is a point");
        if (receivers_.sawHorizon())
            return say(e, true,
                       "the light has extent, and some points see only part of it above "
                       "their horizon");
        if (nothingBetween_) return say(e, false, kNothingBetween);
        say(e, true,
            sampled_.blocked > 0
                ? fmt::format("the light has extent, and {} of {} sampled light rays are blocked",
                              percent(sampled_.blocked, sampled_.rays), sampled_.rays)
                : fmt::format("could not be excluded: none of {} sampled light rays is blocked, "
                              "but something may lie between",
                              sampled_.rays));
    }

    void tellSelfShadow() {
        const Effect e = Effect::self_shadow;
        if (nothingBetween_) return say(e, false, kNothingBetween);
        if (sampled_.onCasters > 0)
            return say(
                e, true,
                fmt::format("{} of {} sampled points lie on casters",
                            percent(sampled_.onCasters, sampled_.followed), sampled_.followed));
        const auto closeCaster = [&](std::size_t p) {
            return (facts_.parts[p].casts && survey_.near[p]) || survey_.risesClose[p];
        };
        if (anyPart(closeCaster))
            return say(e, true,
                       "could not be excluded: something may touch a receiver or rise above it "
                       "within a sixteenth of the light view's width");
        say(e, false, "nothing comes near a point that is asked about");
    }

    void tellThin() {
        const Effect e = Effect::thin_casters;
        if (nothingBetween_) return say(e, false, kNothingBetween);
        std::size_t thin = 0, all = 0;
        bool shown = false;
        for (std::size_t p = 0; p < facts_.parts.size(); ++p) {
            if (!facts_.parts[p].casts) continue;
            all += geometry_.parts[p].indexCount / 3;
            if (!facts_.parts[p].thin) continue;
            thin += geometry_.parts[p].indexCount / 3;
            shown = shown || sampled_.blocks[p];
        }
        if (all == 0) return say(e, false, "no part blocks a light ray");
        if (thin == 0)
            return say(e, false,
                       fmt::format("all {} caster triangles belong to closed surfaces", all));
        say(e, true,
            fmt::format("{}{} of {} caster triangles belong to open surfaces or such that alpha "
                        "cuts out",
                        shown ? "" : "could not be excluded: no sampled light ray meets them, but ",
                        thin, all));
    }

    void tellLayered() {
        const Effect e = Effect::layered_casters;
        if (nothingBetween_) return say(e, false, kNothingBetween);
        if (sampled_.layered > 0)
            return say(
                e, true,
                fmt::format("{} of {} sampled light rays meet two or more casters",
                            percent(sampled_.layered, sampled_.followed), sampled_.followed));
        if (survey_.layered)
            return say(e, true,
                       fmt::format("could not be excluded: none of {} sampled light rays meets two "
                                   "casters, but their shafts overlap or they are not convex",
                                   sampled_.followed));
        say(e, false, "casters are convex or flat, and no light ray meets two of them");
    }

    void tellAlpha() {
        const Effect e = Effect::alpha_mask;
        if (nothingBetween_) return say(e, false, kNothingBetween);
        const auto masked = [&](const Material& material) { return material.masked; };
        if (std::ranges::none_of(scene_.materials, masked))
            return say(e, false, "no material is masked");
        if (std::ranges::none_of(solid_, masked))
            return say(e, false, "no masked texture has a texel below its cutoff");
        for (std::size_t p = 0; p < facts_.parts.size(); ++p) {
            if (!facts_.parts[p].casts || !cuts(p)) continue;
            const auto m = static_cast<std::size_t>(geometry_.parts[p].material);
            return say(
                e, true,
                fmt::format("{}{:.0f} % of the texels of a caster's material '{}' are below "
                            "its cutoff",
                            sampled_.blocks[p]
                                ? ""
                                : "could not be excluded: no sampled light ray meets it, but ",
                            100.0 * cutOut_[m], scene_.materials[m].name));
        }
        say(e, false,
            "nothing that alpha cuts out lies between the light and the points asked about");
    }

    const Scene& scene_;
    const Geometry& geometry_;
    const Tracer& tracer_;
    const Receivers& receivers_;
    const LightBounds& bounds_;
    std::vector<Material> solid_;  ///< masked only where alpha cuts something out
    std::vector<double> cutOut_;   ///< of each material, the share of its texels
    Casters bodies_;
    CasterFacts facts_;
    SampledRays sampled_;
    ShaftSurvey survey_;
    bool nothingBetween_ = false;
    EffectFindings findings_;
};

}  // namespace

FrameAnalysis analyseFrame(const Scene& scene, const Movement& movement, const Tracer& tracer,
                           const Receivers& receivers, const LightBounds& bounds) {
    return Analysis(scene, tracer, receivers, bounds).run(movement);
}

FrameAnalysis analyseFrame(const Scene& scene, const Tracer& tracer, const AreaLight& light,
                           const GBuffer& gbuffer, const LightBounds& bounds) {
    Receivers receivers(light);
    receivers.add(gbuffer);
    return analyseFrame(scene, Movement::of(scene), tracer, receivers, bounds);
}

}  // namespace penumbra
