#include "core/scene/scene_builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <unordered_map>

#include "core/scene/input_text.hpp"
#include "core/scene/light_and_camera.hpp"
#include "core/scene/loaded_scene.hpp"
#include "core/scene/placement.hpp"
#include "core/scene/pose.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr std::size_t kListedNames = 12;

class Builder {
  public:
    Builder(Asset asset, const std::optional<Script>& script, const LoadOptions& options)
        : asset_(std::move(asset)),
          script_(script),
          options_(options),
          scene_(std::make_shared<LoadedScene>()),
          tracks_(asset_.tracks) {
        if (script_) timesS_ = script_->timesS;
    }

    std::shared_ptr<const Scene> build() {
        addScriptTracks();
        findMovingNodes();
        LightAndCamera view(asset_, script_, options_);
        world_ = worldMatrices(asset_.nodes, tracks_, timesS_.front());
        view.takeRectangle(world_);
        measure();
        view.complete(bounds_);
        scene_->chosen = asset_.notes;
        scene_->chosen.insert(scene_->chosen.end(), view.notes().begin(), view.notes().end());
        if (script_ && script_->ground) {
            addGround(view, "as the script asks");
        } else if (view.allPlaced() && !hasFloor()) {
            addGround(view, "as the asset has none");
        }
        fillScene(view);
        return scene_;
    }

  private:
    [[noreturn]] void fail(const std::string& what) const {
        failInput(asset_.file, asset_.pointer, what);
    }

    // --- Tracks ----------------------------------------------------------------------------------

    int nodeNamed(const ScriptTrack& track) const {
        int found = -1;
        std::vector<std::string> names;
        for (std::size_t i = 0; i < asset_.nodes.size(); ++i) {
            const std::string& name = asset_.nodes[i].name;
            if (!name.empty()) names.push_back(oneLine(name, 60));
            if (name != track.node) continue;
            if (found >= 0) {
                failScript(*script_, track.where,
                           fmt::format("the asset has several nodes named '{}'", track.node));
            }
            found = static_cast<int>(i);
        }
        if (found < 0) {
            std::sort(names.begin(), names.end());
            failScript(*script_, track.where,
                       fmt::format("the asset has no node '{}'; its nodes are {}", track.node,
                                   names.empty() ? "all unnamed" : listed(names, kListedNames)));
        }
        if (asset_.nodes[found].hasMatrix) {
            failScript(*script_, track.where,
                       fmt::format("node '{}' is placed by a matrix; only nodes with translation, "
                                   "rotation and scale can move",
                                   track.node));
        }
        return found;
    }

    void addScriptTracks() {
        if (!script_) return;
        for (const ScriptTrack& track : script_->tracks) {
            switch (track.target) {
                case TrackTarget::nodeTranslation:
                    tracks_.push_back({nodeNamed(track), NodeProperty::translation, track.curve});
                    break;
                case TrackTarget::nodeRotation:
                    tracks_.push_back({nodeNamed(track), NodeProperty::eulerDegrees, track.curve});
                    break;
                case TrackTarget::nodeScale:
                    tracks_.push_back({nodeNamed(track), NodeProperty::scale, track.curve});
                    break;
                default:
                    break;
            }
        }
    }

    void findMovingNodes() {
        moves_.assign(asset_.nodes.size(), false);
        morphs_.assign(asset_.nodes.size(), false);
        if (timesS_.size() < 2) return;
        for (const NodeTrack& track : tracks_) {
            (track.property == NodeProperty::weight ? morphs_ : moves_)[track.node] = true;
        }
        for (std::size_t i = 0; i < moves_.size(); ++i) {
            const int parent = asset_.nodes[i].parent;
            if (parent >= 0 && moves_[parent]) moves_[i] = true;
        }
    }

    bool placementMoves(const Placement& placement) const {
        if (morphs_[placement.node]) return true;
        if (placement.skin < 0) return moves_[placement.node];
        const std::vector<int>& joints = asset_.skins[placement.skin].joints;
        return std::any_of(joints.begin(), joints.end(), [&](int joint) { return moves_[joint]; });
    }

    // --- Bounds and what is placed from them -----------------------------------------------------

    const std::vector<glm::dmat4>& instancesOf(const Placement& placement) const {
        static const std::vector<glm::dmat4> kOne = {glm::dmat4(1.0)};
        return placement.instances < 0 ? kOne : asset_.instances[placement.instances];
    }

    /// Calls `visit(vertices, primitive)` for every copy of everything but the light, in world
    /// space at frame 0.
    void forEachPlaced(
        const std::function<void(const VertexPlacer&, const AssetPrimitive&)>& visit) const {
        const PoseLayout layout(asset_);
        const Pose pose = layout.at(asset_, tracks_, world_, timesS_.front());
        for (std::size_t i = 0; i < asset_.placements.size(); ++i) {
            const Placement& placement = asset_.placements[i];
            const AssetPrimitive& primitive = asset_.primitives[placement.primitive];
            const PoseRange& range = layout.rangeOf(i);
            for (const glm::dmat4& instance : instancesOf(placement)) {
                const glm::dmat4 rigid = world_[placement.node] * instance;
                const auto matrices =
                    placement.skin >= 0 ? range.matricesOf(pose) : std::span(&rigid, 1);
                visit(VertexPlacer(primitive, matrices, range.weightsOf(pose), glm::dvec3(0.0)),
                      primitive);
            }
        }
    }

    void measure() {
        if (asset_.placements.empty()) fail("has no surface besides its light");
        chargeFrames();
        bool finite = true;
        forEachPlaced([&](const VertexPlacer& vertices, const AssetPrimitive& primitive) {
            for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
                const glm::dvec3 placed = vertices.position(i);
                // Bounds would not notice a NaN.
                finite = finite && glm::length(placed) < kMaxExtentM;
                bounds_.add(placed);
            }
        });
        if (!finite) fail(fmt::format("reaches further than {:g} m from the origin", kMaxExtentM));
        if (!(bounds_.radius() > 0.0)) fail("has no extent: all its vertices coincide");
        scene_->origin = bounds_.centre();
    }

    /// Geometry is made twice where something moves: for pose 0 and for the frame at hand.
    void chargeFrames() {
        std::uint64_t vertices = 0, corners = 0;
        for (const Placement& placement : asset_.placements) {
            const std::uint64_t copies = instancesOf(placement).size();
            const AssetPrimitive& primitive = asset_.primitives[placement.primitive];
            vertices += copies * primitive.positions.size();
            corners += copies * primitive.indices.size();
        }
        if (std::max(vertices, corners) > UINT32_MAX) {
            fail("has more vertices than 32-bit indices can name");
        }
        const std::size_t copies = timesS_.size() > 1 ? 2 : 1;
        asset_.memory.charge(copies * vertices, 2 * sizeof(glm::vec3) + sizeof(glm::vec2),
                             asset_.pointer, "its geometry");
        asset_.memory.charge(copies * corners, sizeof(std::uint32_t), asset_.pointer,
                             "its geometry");
        asset_.memory.charge(timesS_.size(),
                             PoseLayout(asset_).bytes() + sizeof(LoadedScene::FrameState),
                             asset_.pointer, "its frames");
        asset_.memory.charge(1, asset_.nodes.size() * (sizeof(glm::dmat4) + sizeof(Transform)),
                             asset_.pointer, "its nodes");
    }

    bool hasFloor() const {
        FloorMeter meter(bounds_);
        forEachPlaced([&](const VertexPlacer& vertices, const AssetPrimitive& primitive) {
            const bool mirrored = vertices.mirrored();
            const auto corner = [&](std::size_t index) {
                return vertices.position(primitive.indices[index]);
            };
            for (std::size_t t = 0; t < primitive.indices.size(); t += 3) {
                meter.add(corner(t), corner(t + (mirrored ? 2 : 1)),
                          corner(t + (mirrored ? 1 : 2)));
            }
        });
        return meter.hasFloor();
    }

    void addGround(const LightAndCamera& view, const char* why) {
        const GroundPlate plate = groundFor(bounds_, view.lightAt(timesS_.front(), world_));
        AssetNode node;
        node.name = "ground";
        node.transform.translation = plate.centre;
        asset_.nodes.push_back(node);
        moves_.push_back(false);
        morphs_.push_back(false);
        asset_.materials.push_back(
            Material{.name = "ground", .baseColor = glm::vec4(0.8f, 0.8f, 0.8f, 1.0f)});
        asset_.primitives.push_back(plate.primitive(static_cast<int>(asset_.materials.size()) - 1));
        asset_.placements.push_back({"ground", static_cast<int>(asset_.nodes.size()) - 1,
                                     static_cast<int>(asset_.primitives.size()) - 1});
        scene_->chosen.push_back(
            fmt::format("ground: a plate of {0:.4g} x {0:.4g} m at y = {1:.4g}, {2}", plate.widthM,
                        plate.centre.y, why));
    }

    // --- Frames ----------------------------------------------------------------------------------

    void checkPose(const PoseLayout& layout, const Pose& pose, double timeS) const {
        for (std::size_t i = 0; i < asset_.placements.size(); ++i) {
            const PoseRange& range = layout.rangeOf(i);
            bool good = true;
            for (const glm::dmat4& matrix : range.matricesOf(pose)) {
                for (int c = 0; c < 4; ++c) good = good && glm::length(matrix[c]) < kMaxExtentM;
            }
            for (const double weight : range.weightsOf(pose)) {
                good = good && std::abs(weight) < kMaxExtentM;
            }
            const double reachM = reaches_[i].in(range.matricesOf(pose), range.weightsOf(pose));
            if (good && reachM < kMaxExtentM) continue;
            fail(
                fmt::format("'{}' is out of all bounds at {} s", asset_.placements[i].name, timeS));
        }
    }

    void fillScene(const LightAndCamera& view) {
        const PoseLayout layout(asset_);
        for (const Placement& placement : asset_.placements) {
            reaches_.emplace_back(asset_.primitives[placement.primitive], instancesOf(placement));
        }
        std::vector<Pose> poses;
        std::unordered_multimap<std::size_t, std::size_t> known;  // by hash
        std::vector<LoadedScene::FrameState> frames;
        for (const double timeS : timesS_) {
            const std::vector<glm::dmat4> world = worldMatrices(asset_.nodes, tracks_, timeS);
            LoadedScene::FrameState frame{timeS, view.lightAt(timeS, world),
                                          view.cameraAt(timeS, world), poses.size()};
            frame.light.centre -= scene_->origin;
            frame.camera.position -= scene_->origin;
            Pose pose = layout.at(asset_, tracks_, world, timeS);
            checkPose(layout, pose, timeS);
            const std::size_t hash = pose.hash();
            const auto [first, last] = known.equal_range(hash);
            for (auto each = first; each != last; ++each) {
                if (poses[each->second] == pose) frame.pose = each->second;
            }
            if (frame.pose == poses.size()) {
                known.emplace(hash, poses.size());
                poses.push_back(std::move(pose));
            }
            frames.push_back(frame);
        }
        std::vector<LoadedScene::Caster> casters;
        for (std::size_t i = 0; i < asset_.placements.size(); ++i) {
            const Placement& placement = asset_.placements[i];
            const bool moves = placementMoves(placement);
            casters.push_back({placement.name, placement.primitive, moves, layout.rangeOf(i),
                               instancesOf(placement)});
            scene_->movingCasters = scene_->movingCasters || moves;
        }
        scene_->movingLight = view.lightMoves(moves_, timesS_.size());
        scene_->movingCamera = view.cameraMoves(moves_, timesS_.size());
        scene_->asset = asset_.file;
        scene_->source = script_ ? script_->file : asset_.file;
        scene_->id = scene_->source.stem().string();
        if (script_) {
            scene_->shows = script_->shows;
            scene_->figure = script_->figure;
            for (const ShadowEdge& edge : script_->edges) {
                scene_->edges.push_back(
                    {edge.from - scene_->origin, edge.to - scene_->origin, edge.halfWidthM});
            }
        }
        scene_->materials = std::move(asset_.materials);
        scene_->images = std::move(asset_.images);
        scene_->place(std::move(asset_.primitives), std::move(casters), std::move(poses),
                      std::move(frames));
        scene_->radiusM = boundsOf(scene_->frame(0).geometry->positions).radius();
    }

    Asset asset_;
    const std::optional<Script>& script_;
    const LoadOptions& options_;
    std::shared_ptr<LoadedScene> scene_;
    std::vector<NodeTrack> tracks_;  ///< the asset's, then the script's, which override them
    std::vector<double> timesS_ = {0.0};
    std::vector<bool> moves_;        ///< per node: its matrix changes between frames
    std::vector<bool> morphs_;       ///< per node: its morph weights do
    std::vector<glm::dmat4> world_;  ///< per node, at frame 0
    Bounds bounds_;                  ///< of the asset without its light and ground, at frame 0
    std::vector<PrimitiveReach> reaches_;  ///< per placement
};

}  // namespace

std::shared_ptr<const Scene> buildScene(Asset asset, const std::optional<Script>& script,
                                        const LoadOptions& options) {
    return Builder(std::move(asset), script, options).build();
}

}  // namespace penumbra::scene_detail
