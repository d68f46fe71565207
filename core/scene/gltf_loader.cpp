#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"
#include "core/scene/gltf_file.hpp"
#include "core/scene/gltf_material.hpp"
#include "core/scene/gltf_mesh.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr std::size_t kMaxTriangles = 100'000'000;

class Loader {
  public:
    explicit Loader(const std::filesystem::path& file)
        : model_(readGltf(file)), reader_(model_, file) {
        asset_.file = file;
    }

    Asset load() {
        MaterialLoader(model_, reader_, asset_).load();
        checkHierarchy();
        addNodes();
        for (std::size_t i = 0; i < nodeOf_.size(); ++i) placeContents(static_cast<int>(i));
        if (asset_.placements.empty()) fail("", "has no triangles in its scene");
        for (std::size_t i = 0; i < model_.animations.size(); ++i) addAnimation(i);
        if (dropped_ > 0) {
            asset_.notes.push_back(fmt::format("{} zero-area triangles dropped", dropped_));
        }
        return std::move(asset_);
    }

  private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
        failInput(asset_.file, pointer, what);
    }

    void require(int index, std::size_t count, const std::string& pointer, const char* what) const {
        if (index >= 0 && static_cast<std::size_t>(index) < count) return;
        fail(pointer, fmt::format("{} {} does not exist; the file has {}", what, index, count));
    }

    /// Every node has at most one parent and none is its own ancestor, in this scene or any other.
    void checkHierarchy() {
        const std::size_t count = model_.nodes.size();
        fileParent_.assign(count, -1);
        for (std::size_t i = 0; i < count; ++i) {
            const std::vector<int>& children = model_.nodes[i].children;
            for (std::size_t k = 0; k < children.size(); ++k) {
                const std::string pointer = fmt::format("/nodes/{}/children/{}", i, k);
                require(children[k], count, pointer, "node");
                if (fileParent_[children[k]] >= 0) {
                    fail(pointer, fmt::format("node {} already is a child of node {}", children[k],
                                              fileParent_[children[k]]));
                }
                fileParent_[children[k]] = static_cast<int>(i);
            }
        }
        std::vector<char> rooted(count, 0);
        std::vector<int> open;
        for (std::size_t i = 0; i < count; ++i) {
            if (fileParent_[i] < 0) open.push_back(static_cast<int>(i));
        }
        while (!open.empty()) {
            const int node = open.back();
            open.pop_back();
            rooted[node] = 1;
            open.insert(open.end(), model_.nodes[node].children.begin(),
                        model_.nodes[node].children.end());
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (!rooted[i]) fail(fmt::format("/nodes/{}", i), "is part of a cycle of nodes");
        }
    }

    std::vector<int> sceneRoots() const {
        if (model_.scenes.empty()) {
            std::vector<int> roots;
            for (std::size_t i = 0; i < model_.nodes.size(); ++i) {
                if (fileParent_[i] < 0) roots.push_back(static_cast<int>(i));
            }
            return roots;
        }
        const int scene = std::max(model_.defaultScene, 0);
        require(scene, model_.scenes.size(), "/scene", "scene");
        const std::vector<int>& roots = model_.scenes[scene].nodes;
        for (std::size_t k = 0; k < roots.size(); ++k) {
            const std::string pointer = fmt::format("/scenes/{}/nodes/{}", scene, k);
            require(roots[k], model_.nodes.size(), pointer, "node");
            if (fileParent_[roots[k]] >= 0) {
                fail(pointer, fmt::format("node {} is not a root: it is a child of node {}",
                                          roots[k], fileParent_[roots[k]]));
            }
        }
        return roots;
    }

    /// Depth first, so that "the first camera" is the first that a reader of the file meets.
    void addNodes() {
        newIndex_.assign(model_.nodes.size(), -1);
        std::vector<int> open = sceneRoots();
        std::reverse(open.begin(), open.end());
        while (!open.empty()) {
            const int index = open.back();
            open.pop_back();
            if (newIndex_[index] >= 0) {
                fail(fmt::format("/nodes/{}", index), "is listed twice in its scene");
            }
            newIndex_[index] = static_cast<int>(nodeOf_.size());
            nodeOf_.push_back(index);
            const tinygltf::Node& in = model_.nodes[index];
            AssetNode node;
            node.name = in.name;
            node.parent = fileParent_[index] < 0 ? -1 : newIndex_[fileParent_[index]];
            node.hasMatrix = !in.matrix.empty();
            for (std::size_t k = 0; k < in.matrix.size(); ++k)
                node.matrix[k / 4][k % 4] = in.matrix[k];
            const auto vec4 = [](const std::vector<double>& v) {
                return glm::dvec4(v[0], v[1], v[2], v.size() > 3 ? v[3] : 0.0);
            };
            if (!in.translation.empty()) {
                node.transform.set(NodeProperty::translation, vec4(in.translation));
            }
            if (!in.rotation.empty()) {
                requireRotation(vec4(in.rotation), fmt::format("/nodes/{}/rotation", index));
                node.transform.set(NodeProperty::rotation, vec4(in.rotation));
            }
            if (!in.scale.empty()) node.transform.set(NodeProperty::scale, vec4(in.scale));
            asset_.nodes.push_back(std::move(node));
            open.insert(open.end(), in.children.rbegin(), in.children.rend());
        }
    }

    void requireRotation(const glm::dvec4& quaternion, const std::string& pointer) const {
        if (!(glm::length(quaternion) > 1e-6)) fail(pointer, "is not a rotation: its length is 0");
    }

    void placeContents(int node) {
        const int index = nodeOf_[node];
        const tinygltf::Node& in = model_.nodes[index];
        const std::string pointer = fmt::format("/nodes/{}", index);
        if (in.skin >= 0) fail(pointer + "/skin", "skins are not supported yet");
        if (in.extensions.contains("EXT_mesh_gpu_instancing")) {
            fail(pointer, "EXT_mesh_gpu_instancing is not supported yet");
        }
        if (in.camera >= 0) {
            require(in.camera, model_.cameras.size(), pointer + "/camera", "camera");
            asset_.cameras.push_back({node, lensOf(in.camera)});
        }
        if (in.mesh < 0) return;
        require(in.mesh, model_.meshes.size(), pointer + "/mesh", "mesh");
        const std::string& meshName = model_.meshes[in.mesh].name;
        const std::string name = !in.name.empty()    ? in.name
                                 : !meshName.empty() ? meshName
                                                     : fmt::format("node {}", index);
        const std::vector<int>& primitives = primitivesOf(in.mesh);
        for (std::size_t k = 0; k < primitives.size(); ++k) {
            asset_.placements.push_back(
                {primitives.size() == 1 ? name : fmt::format("{}/{}", name, k), node,
                 primitives[k]});
            triangles_ += asset_.primitives[primitives[k]].indices.size() / 3;
        }
        if (triangles_ > kMaxTriangles) {
            fail(pointer, fmt::format("the scene has more than {} triangles", kMaxTriangles));
        }
    }

    /// Indices into asset_.primitives; a mesh is read once however many nodes place it.
    const std::vector<int>& primitivesOf(int mesh) {
        if (const auto known = primitivesOf_.find(mesh); known != primitivesOf_.end()) {
            return known->second;
        }
        std::vector<int> indices;
        for (std::size_t k = 0; k < model_.meshes[mesh].primitives.size(); ++k) {
            std::optional<AssetPrimitive> primitive =
                readPrimitive(model_, reader_, asset_, mesh, static_cast<int>(k), dropped_);
            if (!primitive) continue;
            indices.push_back(static_cast<int>(asset_.primitives.size()));
            asset_.primitives.push_back(std::move(*primitive));
        }
        return primitivesOf_.emplace(mesh, std::move(indices)).first->second;
    }

    Camera lensOf(int index) const {
        const tinygltf::Camera& in = model_.cameras[index];
        const std::string pointer = fmt::format("/cameras/{}", index);
        const bool perspective = in.type == "perspective";
        Camera lens;
        double farM = 0.0;
        if (perspective) {
            lens.fovYRad = in.perspective.yfov;
            lens.nearM = in.perspective.znear;
            farM = in.perspective.zfar;
            if (!(lens.fovYRad > 0.0 && lens.fovYRad < std::numbers::pi)) {
                fail(pointer + "/perspective/yfov",
                     fmt::format("{} is not between 0 and pi", lens.fovYRad));
            }
        } else {
            lens.kind = Camera::Kind::orthographic;
            lens.magY = in.orthographic.ymag;
            lens.nearM = in.orthographic.znear;
            farM = in.orthographic.zfar;
            if (!(lens.magY > 0.0)) {
                fail(pointer + "/orthographic/ymag", fmt::format("{} is not above 0", lens.magY));
            }
        }
        if (farM > 0.0 || !perspective) lens.farM = farM;  // a perspective may have no far plane
        if (!(lens.nearM >= 0.0 && lens.farM > lens.nearM)) {
            fail(pointer,
                 fmt::format("znear {} and zfar {} do not enclose anything", lens.nearM, farM));
        }
        return lens;
    }

    void addAnimation(std::size_t index) {
        const tinygltf::Animation& animation = model_.animations[index];
        for (std::size_t c = 0; c < animation.channels.size(); ++c) {
            const tinygltf::AnimationChannel& channel = animation.channels[c];
            const std::string pointer = fmt::format("/animations/{}/channels/{}", index, c);
            require(channel.target_node, model_.nodes.size(), pointer + "/target/node", "node");
            require(channel.sampler, animation.samplers.size(), pointer + "/sampler", "sampler");
            NodeTrack track;
            track.node = newIndex_[channel.target_node];
            if (track.node < 0) continue;  // a node of another scene
            if (channel.target_path == "translation") {
                track.property = NodeProperty::translation;
            } else if (channel.target_path == "rotation") {
                track.property = NodeProperty::rotation;
            } else if (channel.target_path == "scale") {
                track.property = NodeProperty::scale;
            } else {
                fail(pointer + "/target/path",
                     fmt::format("'{}' is not supported; translation, rotation and scale are",
                                 oneLine(channel.target_path, 40)));
            }
            if (asset_.nodes[track.node].hasMatrix) {
                fail(pointer,
                     fmt::format("animates node {}, which has a matrix", channel.target_node));
            }
            track.curve = curveOf(
                animation.samplers[channel.sampler], track.property == NodeProperty::rotation,
                fmt::format("/animations/{}/samplers/{}", index, channel.sampler));
            asset_.tracks.push_back(std::move(track));
        }
    }

    Curve curveOf(const tinygltf::AnimationSampler& sampler, bool rotation,
                  const std::string& pointer) const {
        Curve curve;
        curve.quaternion = rotation;
        if (sampler.interpolation == "STEP") {
            curve.interpolation = Interpolation::step;
        } else if (sampler.interpolation == "CUBICSPLINE") {
            curve.interpolation = Interpolation::cubicSpline;
        } else if (sampler.interpolation != "LINEAR") {
            fail(pointer + "/interpolation", fmt::format("'{}' is not LINEAR, STEP or CUBICSPLINE",
                                                         oneLine(sampler.interpolation, 40)));
        }
        for (const glm::vec4& time : reader_.vectors(sampler.input, 1, false, pointer + "/input")) {
            if (!curve.times.empty() && time.x <= curve.times.back()) {
                fail(pointer + "/input", fmt::format("time {} at key {} does not increase", time.x,
                                                     curve.times.size()));
            }
            curve.times.push_back(time.x);
        }
        const int components = rotation ? 4 : 3;
        for (const glm::vec4& value :
             reader_.vectors(sampler.output, components, rotation, pointer + "/output")) {
            curve.values.emplace_back(value);
        }
        const std::size_t perKey = curve.interpolation == Interpolation::cubicSpline ? 3 : 1;
        if (curve.values.size() != perKey * curve.times.size()) {
            fail(pointer, fmt::format("has {} output values for {} keys", curve.values.size(),
                                      curve.times.size()));
        }
        for (std::size_t k = perKey / 2; rotation && k < curve.values.size(); k += perKey) {
            requireRotation(curve.values[k], fmt::format("{}/output key {}", pointer, k / perKey));
        }
        return curve;
    }

    tinygltf::Model model_;
    AccessorReader reader_;
    Asset asset_;
    std::vector<int> fileParent_;  ///< per node of the file
    std::vector<int> newIndex_;    ///< node of the file -> asset_.nodes, -1 outside the scene
    std::vector<int> nodeOf_;      ///< the inverse
    std::map<int, std::vector<int>> primitivesOf_;
    std::size_t dropped_ = 0, triangles_ = 0;
};

}  // namespace

Asset loadAsset(const std::filesystem::path& file) {
    return Loader(file).load();
}

}  // namespace penumbra::scene_detail
