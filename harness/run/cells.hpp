#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frame/frame.hpp"
#include "harness/run/row.hpp"
#include "harness/run/settings.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra {

/// What light-space work depends on.
struct LightInputs {
    std::shared_ptr<const Geometry> geometry;
    AreaLight light;
    LightBounds bounds;
    CasterFacts facts;
    bool operator==(const LightInputs&) const = default;
};

/// One setting's method through the frames of one scene, with what its light-space maps were built
/// for.
class SettingRun {
  public:
    explicit SettingRun(const Setting& setting) : setting_(setting) {}
    /// Under `effects`, whatever its neighbours are run with.
    SettingRun(const Setting& setting, const EffectChoice& effects)
        : setting_(setting), effects_(effects) {}

    const Setting& setting() const { return setting_; }
    const std::optional<EffectChoice>& effects() const { return effects_; }
    /// Makes the frame's image once, counting the work, before any timing: prepares the method if
    /// its plan changed, builds unless the maps are kept. Throws what the method throws.
    void warmUp(const Frame& frame, const Plan& plan, bool keepMaps, const TextureTarget& target,
                Row& row);
    /// One timed frame; milliseconds of build (0 when kept) and shade.
    struct Sample {
        double buildMs = 0.0, shadeMs = 0.0;
    };
    Sample timed(const Frame& frame, const TextureTarget& target);
    /// Before another timed frame of the same camera: one that moves would find another, and what
    /// the method kept for this one is no saving.
    void forgetCamera();
    /// One timed frame where anything may have changed since the last: prepares the method if its
    /// plan did, keeps the maps where the light inputs did not. Throws what the method throws.
    Sample live(const Frame& frame, const Plan& plan, const TextureTarget& target);
    /// Null before the first frame and after forget().
    const ShadowMethod* method() const { return method_.get(); }
    const std::vector<float>& visibility() const { return visibility_; }
    bool kept() const { return kept_; }
    /// Drops the method, which a failure may have left in any state.
    void forget() { method_.reset(); }

  private:
    void prepareFor(const Frame& frame, const Plan& plan);

    const Setting& setting_;
    std::optional<EffectChoice> effects_;
    std::unique_ptr<ShadowMethod> method_;
    std::optional<LightInputs> builtFor_;
    Plan plan_;
    double prepareMs_ = 0.0;
    bool kept_ = false;
    std::vector<float> visibility_;
};

/// Timed frames that a cell gets however long they take. The interval around the median of three is
/// from the fastest to the slowest; it contains the true one in 75 % of cases (of five: in 94 %).
inline constexpr std::size_t kFewestRepeats = 3;
/// What a run spends on the timed frames of one cell before it counts as measured: nothing to
/// cells below 0.4 s a frame at 5 repeats; a costly rung does not take half of the run.
inline constexpr double kEnoughMs = 2000.0;

/// Whether building is no part of what frame `index` costs under `plan`: light-space maps are kept
/// from the frame before where neither light nor casters move by the plan. That is a fact of scene
/// and plan, not of what this process did before, so that resumed and sharded runs report the same
/// as whole ones.
bool keepsMaps(const Plan& plan, int index);

/// What a frame's cells are run with.
struct CellOptions {
    EffectChoice effects;
    EffectSet calledFor;
    /// The frame as a method under a plan gets it, valid as long as `frame` of runCells; `frame`
    /// itself where this is empty.
    std::function<const Frame&(const Plan&)> frameFor{};
    int repeats = 5;  ///< rounds of timed frames
    /// A cell that has kFewestRepeats timed frames which took this long together, milliseconds,
    /// leaves the rounds that follow.
    double enoughMs = std::numeric_limits<double>::infinity();
    /// Asked before each warm-up; once true, no further cell is begun.
    std::function<bool()> stop{};
    /// Told every timed frame as it is measured, round by round: which of the runs, and its times.
    std::function<void(std::size_t, const SettingRun::Sample&)> sampled{};
};

/// Runs every setting in `runs` on one frame: an untimed warm-up each, then the repeats in rounds
/// whose order is drawn anew for each, so that drift of the machine hits all alike. Cells that have
/// taken `enoughMs` leave early; Row::repeats says how many times each was timed. A setting that
/// throws, be it in a task of its own on another thread, gets a failed or unsupported row and drops
/// out; the others go on. `done` is called once per run that was begun with its index, its row
/// (metrics still empty) and its image (empty if failed).
void runCells(const Frame& frame, const CellOptions& options, const std::vector<SettingRun*>& runs,
              const TextureTarget& target,
              const std::function<void(std::size_t, Row&&, const std::vector<float>&)>& done);

}  // namespace penumbra
