#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/analysis/frame_analysis.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/gpu_geometry.hpp"
#include "core/scene/scene.hpp"

namespace penumbra {

/// The frames of one scene as plans have them. The camera and the points that are asked about are
/// always the frame's own. Light and casters are too where they move and the plan has that effect;
/// where it has not, they stay as they are in frame 0. Where neither changes from frame to frame,
/// light views are fitted to the receivers of all frames and analysis is of all of them, so that
/// light-space maps serve the whole scene.
///
/// All of that is a fact of scene and plan, not of which frames were entered before: resumed and
/// sharded runs get the same. Needs a context.
class SceneStage {
  public:
    /// `scene` must outlive it.
    SceneStage(const Scene& scene, int width, int height, std::uint32_t seed);
    ~SceneStage();
    SceneStage(const SceneStage&) = delete;
    SceneStage& operator=(const SceneStage&) = delete;

    /// Goes to frame `index`; frames referred to before are gone.
    void enter(int index);
    /// The frame as the scene has it: what is true of it.
    const Frame& frame() { return view({}).frame; }
    const FrameAnalysis& analysis() { return view({}).analysis; }
    /// The frame as a method under `plan` gets it.
    const Frame& frameFor(const Plan& plan);

    const Movement& movement() const { return movement_; }
    /// Spent on analysis since the last enter(), milliseconds; that of all frames' receivers counts
    /// where it was made.
    double analysisMs() const { return analysisMs_; }

  private:
    /// What stays as it is in frame 0.
    struct Held {
        bool light = false, casters = false;
    };
    /// A geometry where methods find it.
    struct Placed {
        std::shared_ptr<const Geometry> geometry;
        Tracer tracer;
        GpuGeometry gpu;
        Placed(std::shared_ptr<const Geometry> shape, const Scene& scene,
               const GpuMaterials& materials);
    };
    /// What analysis and light views rest on.
    struct LightSpaceFacts {
        LightBounds bounds;
        FrameAnalysis analysis;
    };
    struct View {
        FrameAnalysis analysis;
        Frame frame;
    };

    const View& view(Held held);
    const Placed& first();
    LightSpaceFacts factsOf(const AreaLight& light, const Placed& placed, bool ofAllFrames);

    const Scene& scene_;
    const int width_, height_;
    const std::uint32_t seed_;
    const Movement movement_;
    const SceneFrame firstMoment_;
    GpuMaterials materials_;
    std::unique_ptr<Placed> first_;
    std::optional<LightSpaceFacts> still_;  ///< of frame 0's light and casters, all receivers

    int index_ = 0;
    SceneFrame now_;
    std::unique_ptr<Placed> current_;  ///< empty where first_ is it
    GBuffer gbuffer_;
    GBufferTextures textures_;
    std::array<std::optional<View>, 4> views_;  ///< by what is held
    double analysisMs_ = 0.0;
};

}  // namespace penumbra
