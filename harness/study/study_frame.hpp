#pragma once

#include <memory>

#include "harness/run/cells.hpp"
#include "harness/run/staged_frame.hpp"

namespace penumbra {

/// One frame of a scene, ready for any setting, with its reference when one is needed. Needs a
/// context.
class StudyFrame {
  public:
    /// Frame `index` must be one of the scene's.
    StudyFrame(std::shared_ptr<const Scene> scene, int index, int width, int height,
               std::uint32_t seed);

    const Frame& frame() const { return staged_.frame; }
    const TextureTarget& target() const { return target_; }
    /// Makes the setting's image once, with its maps, under the plan of `effects`; what it took is
    /// in the row. Throws what the method throws.
    Row warmUp(SettingRun& run, const EffectChoice& effects = {}) const;
    /// Traced, or read from the options' cache, when first asked for.
    const Reference& reference(const TruthOptions& options) const;

  private:
    StagedFrame staged_;
    TextureTarget target_;
    mutable std::unique_ptr<const Reference> reference_;
};

}  // namespace penumbra
