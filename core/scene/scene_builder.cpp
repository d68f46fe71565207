#include "core/scene/scene_builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <unordered_map>

#include "core/scene/choice.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/light_rectangle.hpp"
#include "core/scene/loaded_scene.hpp"
#include "core/scene/placement.hpp"
#include "core/scene/pose.hpp"
#include "core/scene/punctual_light.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr std::size_t kListedNames = 12;

std::string words(const glm::dvec3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x, p.y, p.z);
}

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
        chooseCamera();
        world_ = worldMatrices(asset_.nodes, tracks_, timesS_.front());
        scene_->chosen = asset_.notes;
        if (!script_ || !script_->light) chooseRectangle();
        measure();
        if (!rectangle_ && !(script_ && script_->light)) choosePunctual();
        const bool assetIsBare = !script_ && !rectangle_ && !punctual_ && asset_.cameras.empty();
        placeLight();
        placeCamera();
        if (script_ && script_->ground) {
            addGround("as the script asks");
        } else if (assetIsBare && !hasFloor()) {
            addGround("as the asset has none");
        }
        fillScene();
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

    bool scriptMoves(std::initializer_list<TrackTarget> targets) const {
        if (!script_ || timesS_.size() < 2) return false;
        return std::any_of(script_->tracks.begin(), script_->tracks.end(), [&](const auto& track) {
            return std::find(targets.begin(), targets.end(), track.target) != targets.end();
        });
    }

    // --- The asset's own camera and light --------------------------------------------------------

    void chooseCamera() {
        const bool scripted = script_ && script_->camera;
        if (options_.camera.empty()) {
            if (!scripted && !asset_.cameras.empty()) assetCamera_ = asset_.cameras.front();
            return;
        }
        std::vector<std::string> names;
        for (const AssetCamera& camera : asset_.cameras) names.push_back(camera.name);
        const auto chosen = chosenByIndexOrName(options_.camera, names);
        if (!chosen) {
            fail(fmt::format("--camera {}: {}", oneLine(options_.camera, 60),
                             names.empty() ? "the scene has no cameras"
                                           : "the cameras are " + indexedNames(names)));
        }
        assetCamera_ = asset_.cameras[*chosen];
    }

    /// Takes the emissive rectangle of the greatest flux out of the placements.
    void chooseRectangle() {
        struct Candidate {
            std::size_t placement;
            LocalRectangle rectangle;
            double flux;
        };
        std::vector<Candidate> candidates;
        bool otherEmission = false;
        for (std::size_t i = 0; i < asset_.placements.size(); ++i) {
            const Placement& placement = asset_.placements[i];
            const AssetPrimitive& primitive = asset_.primitives[placement.primitive];
            const double emission = asset_.emissions[primitive.material];
            if (!(emission > 0.0)) continue;
            const glm::dmat4& world = world_[placement.node];
            const bool plain = !primitive.deforms() && placement.instances < 0;
            if (const auto rectangle = plain ? rectangleOf(primitive, world) : std::nullopt) {
                candidates.push_back({i, *rectangle, rectangle->placedBy(world).area() * emission});
            } else {
                otherEmission = true;
            }
        }
        if (otherEmission) {
            scene_->chosen.push_back("emissive surfaces that are not one rectangle do not emit");
        }
        if (candidates.empty()) return;
        const auto light =
            std::max_element(candidates.begin(), candidates.end(),
                             [](const auto& a, const auto& b) { return a.flux < b.flux; });
        const Placement chosen = asset_.placements[light->placement];
        if (candidates.size() > 1) {
            std::vector<std::string> others;
            for (const Candidate& c : candidates) {
                if (c.placement != light->placement) {
                    others.push_back("'" + asset_.placements[c.placement].name + "'");
                }
            }
            scene_->chosen.push_back(oneLine(fmt::format(
                "light: '{}', the emissive rectangle of the greatest flux; {} remain ordinary "
                "surfaces",
                chosen.name, listed(others, kListedNames))));
        }
        rectangle_ = light->rectangle;
        rectangleNode_ = chosen.node;
        asset_.placements.erase(asset_.placements.begin() +
                                static_cast<std::ptrdiff_t>(light->placement));
    }

    void choosePunctual() {
        const auto chosen = brightest(asset_.lights);
        if (!chosen) return;
        punctual_ = asset_.lights[*chosen];
        scene_->chosen.push_back(describe(*punctual_, asset_.lights.size()));
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

    void placeLight() {
        if (rectangle_ || punctual_ || (script_ && script_->light)) return;
        fixedLight_ = lightForBounds(bounds_);
        scene_->chosen.push_back(fmt::format(
            "light: none given, placed a square of {0:.4g} x {0:.4g} m at {1} facing "
            "the centre {2} of the asset",
            2.0 * fixedLight_->halfU, words(fixedLight_->centre), words(bounds_.centre())));
    }

    void placeCamera() {
        if (assetCamera_ || (script_ && script_->camera)) return;
        fixedCamera_ = cameraForBounds(bounds_);
        scene_->chosen.push_back(
            fmt::format("camera: none given, placed at {} looking at {}, {:.4g} degrees high",
                        words(fixedCamera_->position), words(bounds_.centre()),
                        glm::degrees(fixedCamera_->fovYRad)));
    }

    void addGround(const char* why) {
        const GroundPlate plate = groundFor(bounds_, lightAt(timesS_.front(), world_));
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

    AreaLight lightAt(double timeS, const std::vector<glm::dmat4>& world) const {
        if (fixedLight_) return *fixedLight_;
        if (rectangle_) {
            const AreaLight light = rectangle_->placedBy(world[rectangleNode_]);
            if (!(light.area() > 0.0 && glm::length(light.centre) < kMaxExtentM)) {
                fail(fmt::format("its light is no rectangle at {} s", timeS));
            }
            return light;
        }
        if (punctual_) {
            const auto light = placedPunctual(*punctual_, world[punctual_->node], bounds_);
            if (!light)
                fail(fmt::format("its light '{}' is nowhere at {} s", punctual_->name, timeS));
            return *light;
        }
        ScriptLight light = *script_->light;
        for (const ScriptTrack& track : script_->tracks) {
            const glm::dvec4 value = track.curve.at(timeS);
            if (track.target == TrackTarget::lightPosition) light.position = glm::dvec3(value);
            if (track.target == TrackTarget::lightTarget) light.target = glm::dvec3(value);
            if (track.target == TrackTarget::lightSize) light.size = glm::dvec2(value);
        }
        const auto placed = lightFacing(light.position, light.target, light.up, light.size);
        if (!placed) failPose(light.where, "light", timeS);
        return *placed;
    }

    Camera cameraAt(double timeS, const std::vector<glm::dmat4>& world) const {
        if (fixedCamera_) return *fixedCamera_;
        if (assetCamera_) {
            const Camera placed = cameraOfNode(assetCamera_->lens, world[assetCamera_->node]);
            const double check = glm::length(placed.position) + glm::length(placed.right) +
                                 glm::length(placed.up) + glm::length(placed.back);
            if (!(check < kMaxExtentM)) {
                fail(fmt::format("its camera has no direction at {} s", timeS));
            }
            return placed;
        }
        ScriptCamera camera = *script_->camera;
        for (const ScriptTrack& track : script_->tracks) {
            const glm::dvec4 value = track.curve.at(timeS);
            if (track.target == TrackTarget::cameraPosition) camera.position = glm::dvec3(value);
            if (track.target == TrackTarget::cameraTarget) camera.target = glm::dvec3(value);
            if (track.target == TrackTarget::cameraFovY) camera.fovYDegrees = value.x;
        }
        const auto placed = cameraFacing(camera.position, camera.target, camera.up,
                                         glm::radians(camera.fovYDegrees));
        if (!placed) failPose(camera.where, "camera", timeS);
        return *placed;
    }

    [[noreturn]] void failPose(const std::string& where, const char* what, double timeS) const {
        failScript(*script_, where,
                   fmt::format("at {} s the {} has no direction: target must differ from position "
                               "and up must not lie along the line between them",
                               timeS, what));
    }

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
            if (good) continue;
            fail(
                fmt::format("'{}' is out of all bounds at {} s", asset_.placements[i].name, timeS));
        }
    }

    void fillScene() {
        const PoseLayout layout(asset_);
        std::vector<Pose> poses;
        std::unordered_multimap<std::size_t, std::size_t> known;  // by hash
        std::vector<LoadedScene::FrameState> frames;
        for (const double timeS : timesS_) {
            const std::vector<glm::dmat4> world = worldMatrices(asset_.nodes, tracks_, timeS);
            LoadedScene::FrameState frame{timeS, lightAt(timeS, world), cameraAt(timeS, world),
                                          poses.size()};
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
        scene_->movingLight = (rectangle_ && moves_[rectangleNode_]) ||
                              (punctual_ && moves_[punctual_->node]) ||
                              scriptMoves({TrackTarget::lightPosition, TrackTarget::lightTarget,
                                           TrackTarget::lightSize});
        scene_->movingCamera =
            assetCamera_ ? bool{moves_[assetCamera_->node]}
                         : scriptMoves({TrackTarget::cameraPosition, TrackTarget::cameraTarget,
                                        TrackTarget::cameraFovY});
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
    std::optional<LocalRectangle> rectangle_;
    int rectangleNode_ = -1;
    std::optional<AssetLight> punctual_;
    std::optional<AssetCamera> assetCamera_;
    std::optional<AreaLight> fixedLight_;
    std::optional<Camera> fixedCamera_;
};

}  // namespace

std::shared_ptr<const Scene> buildScene(Asset asset, const std::optional<Script>& script,
                                        const LoadOptions& options) {
    return Builder(std::move(asset), script, options).build();
}

}  // namespace penumbra::scene_detail
