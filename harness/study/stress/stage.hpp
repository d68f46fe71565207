#pragma once

#include <memory>
#include <vector>

#include "harness/run/settings.hpp"
#include "harness/run/staged_frame.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra::stress {

/// One frame, all that a method needs to render it and all that is known to be true of it. Needs a
/// context.
class StageFrame {
  public:
    StageFrame(std::shared_ptr<const Scene> scene, int index, int size, std::uint32_t seed);

    const Frame& frame() const { return staged_.frame; }
    EffectSet calledFor() const { return staged_.analysis.calledFor(); }
    /// Pixels that a method must answer for.
    const std::vector<std::size_t>& asked() const { return asked_; }
    /// Exact visibility (harness/reference/exact.hpp); made on first use.
    const std::vector<float>& exact() const;

  private:
    StagedFrame staged_;
    std::vector<std::size_t> asked_;
    mutable std::vector<float> exact_;
};

/// A scene with all its frames, size x size pixels.
class Stage {
  public:
    Stage(std::shared_ptr<const Scene> scene, int size, std::uint32_t seed);
    const std::vector<std::unique_ptr<StageFrame>>& frames() const { return frames_; }
    int size() const { return size_; }

  private:
    int size_;
    std::vector<std::unique_ptr<StageFrame>> frames_;
};

using Image = std::vector<float>;

/// A new instance of `setting`'s method through all frames, as `compare` renders them: the target
/// is poisoned with NaN first, OpenGL errors throw. One image a frame. Throws what the method
/// throws.
std::vector<Image> render(const Setting& setting, const Stage& stage);

}  // namespace penumbra::stress
