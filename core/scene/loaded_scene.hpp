#pragma once

#include <mutex>

#include "core/scene/asset.hpp"
#include "core/scene/pose.hpp"
#include "core/scene/scene.hpp"

namespace penumbra::scene_detail {

/// A scene whose light and camera are known for every frame; only geometry is made on demand.
class LoadedScene final : public Scene {
  public:
    struct FrameState {
        double timeS = 0.0;
        AreaLight light;
        Camera camera;
        std::size_t pose = 0;  ///< frames of equal pose share one Geometry
    };
    struct Caster {
        std::string name;
        int primitive = 0;
        bool moves = false;
        PoseRange range;
        std::vector<glm::dmat4> instances;  ///< below the matrix of the pose; at least one
    };

    /// Call after `origin` is set, once: makes the geometry of pose 0.
    void place(std::vector<AssetPrimitive> primitives, std::vector<Caster> casters,
               std::vector<Pose> poses, std::vector<FrameState> frames);

    int frameCount() const override { return static_cast<int>(frames_.size()); }
    SceneFrame frame(int index) const override;

  private:
    std::shared_ptr<const Geometry> geometryOf(std::size_t pose) const;
    void write(std::size_t caster, const Pose& pose, Geometry& out) const;

    std::vector<AssetPrimitive> primitives_;
    std::vector<Caster> casters_;
    std::vector<Pose> poses_;
    std::vector<FrameState> frames_;
    std::shared_ptr<const Geometry> first_;  ///< of pose 0
    mutable std::mutex mutex_;
    mutable std::vector<std::weak_ptr<const Geometry>> others_;  ///< per pose, guarded by mutex_
};

}  // namespace penumbra::scene_detail
