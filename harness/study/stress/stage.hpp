#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/frame/frame.hpp"
#include "harness/run/settings.hpp"
#include "harness/run/visibility_target.hpp"

namespace penumbra::stress {

/// One frame, all that a method needs to render it and all that is known to be true of it. Needs a
/// context.
class StageFrame {
  public:
    StageFrame(const Scene& scene, int index, int size, std::uint32_t seed,
               const GpuMaterials& materials);
    StageFrame(const StageFrame&) = delete;
    StageFrame& operator=(const StageFrame&) = delete;

    const Frame& frame() const { return frame_; }
    EffectSet calledFor() const { return calledFor_; }
    /// Pixels that a method must answer for.
    const std::vector<std::size_t>& asked() const { return asked_; }
    /// Exact visibility (harness/reference/exact.hpp); made on first use.
    const std::vector<float>& exact() const;
    /// Whether the light's centre is seen from pixel `i`; nothing where the answer changes, or is
    /// ill-defined, within `edgeM` sideways as the light sees it.
    std::optional<bool> centreSeen(std::size_t i, double edgeM) const;

  private:
    SceneFrame sceneFrame_;
    Tracer tracer_;
    GBuffer gbuffer_;
    GBufferTextures textures_;
    GpuGeometry gpuGeometry_;
    EffectSet calledFor_;
    Frame frame_;
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
    std::shared_ptr<const Scene> scene_;
    int size_;
    GpuMaterials materials_;
    std::vector<std::unique_ptr<StageFrame>> frames_;
};

using Image = std::vector<float>;

/// A new instance of `setting`'s method through all frames, as `compare` renders them: the target
/// is poisoned with NaN first, OpenGL errors throw. One image a frame. Throws what the method
/// throws.
std::vector<Image> render(const Setting& setting, const Stage& stage);

}  // namespace penumbra::stress
