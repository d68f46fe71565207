#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>

#include "core/scene/asset.hpp"
#include "core/scene/gltf_accessor.hpp"
#include "core/scene/gltf_animation.hpp"
#include "core/scene/gltf_file.hpp"
#include "core/scene/gltf_hierarchy.hpp"
#include "core/scene/gltf_instances.hpp"
#include "core/scene/gltf_material.hpp"
#include "core/scene/gltf_mesh.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/procedural_asset.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

class Loader {
  public:
    Loader(const std::filesystem::path& file, const LoadOptions& options)
        : options_(options),
          asset_(emptyAsset(file, options)),
          model_(readGltf(file, asset_.memory)),
          reader_(model_, file, asset_.memory),
          meshes_(model_, reader_, asset_) {}

    Asset load() {
        MaterialLoader(model_, reader_, asset_).load();
        hierarchy_ = readHierarchy(model_, options_.assetScene, asset_);
        for (std::size_t i = 0; i < hierarchy_.fileNodes.size(); ++i) {
            placeContents(static_cast<int>(i));
        }
        if (asset_.placements.empty()) {
            if (meshes_.firstSkipped().empty()) fail(asset_.pointer, "has no triangles");
            failInput(asset_.file, meshes_.firstSkipped(),
                      "casts no shadow, and the scene has no triangles");
        }
        readAnimations(model_, reader_, hierarchy_.newIndex, asset_);
        for (std::string& note : meshes_.notes()) asset_.notes.push_back(std::move(note));
        return std::move(asset_);
    }

  private:
    static Asset emptyAsset(const std::filesystem::path& file, const LoadOptions& options) {
        Asset asset;
        asset.file = file;
        asset.memory = MemoryBudget(file, options.maxMemoryBytes);
        return asset;
    }

    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
        failInput(asset_.file, pointer, what);
    }

    void require(int index, std::size_t count, const std::string& pointer, const char* what) const {
        if (index >= 0 && static_cast<std::size_t>(index) < count) return;
        fail(pointer, fmt::format("{} {} does not exist; the file has {}", what, index, count));
    }

    void placeContents(int node) {
        const int index = hierarchy_.fileNodes[node];
        const tinygltf::Node& in = model_.nodes[index];
        const std::string pointer = fmt::format("/nodes/{}", index);
        if (in.camera >= 0) {
            require(in.camera, model_.cameras.size(), pointer + "/camera", "camera");
            asset_.cameras.push_back({node, lensOf(in.camera),
                                      in.name.empty() ? model_.cameras[in.camera].name : in.name});
        }
        if (const auto light = in.extensions.find("KHR_lights_punctual");
            light != in.extensions.end()) {
            addLight(node, light->second.Get("light").GetNumberAsInt(),
                     pointer + "/extensions/KHR_lights_punctual/light");
        }
        if (in.mesh < 0) return;
        require(in.mesh, model_.meshes.size(), pointer + "/mesh", "mesh");
        addPlacements(node, in, pointer);
    }

    void addPlacements(int node, const tinygltf::Node& in, const std::string& pointer) {
        const int skin = in.skin < 0 ? -1 : skinOf(in.skin, pointer + "/skin");
        const int instances = instancesOf(in, pointer);
        if (skin >= 0 && instances >= 0) {
            fail(pointer, "has a skin and EXT_mesh_gpu_instancing, which is not defined");
        }
        readWeights(node, in, pointer);
        const std::string& meshName = model_.meshes[in.mesh].name;
        const std::string name = !in.name.empty()    ? in.name
                                 : !meshName.empty() ? meshName
                                                     : pointer.substr(1);
        const std::vector<int>& primitives = primitivesOf(in.mesh, skin >= 0);
        const std::size_t copies = instances < 0 ? 1 : asset_.instances[instances].size();
        for (std::size_t k = 0; k < primitives.size(); ++k) {
            const AssetPrimitive& primitive = asset_.primitives[primitives[k]];
            if (skin >= 0) requireJoints(primitive, asset_.skins[skin], pointer + "/skin");
            asset_.memory.charge(1, sizeof(Placement) + name.size(), pointer, "its parts");
            asset_.placements.push_back(
                {primitives.size() == 1 ? name : fmt::format("{}/{}", name, k), node, primitives[k],
                 skin, instances});
            triangles_ += copies * (primitive.indices.size() / 3);
            if (triangles_ > kMaxTriangles) {
                fail(pointer, fmt::format("the scene has more than {} triangles", kMaxTriangles));
            }
        }
    }

    /// Indices into asset_.primitives; a mesh is read once however many nodes place it.
    const std::vector<int>& primitivesOf(int mesh, bool skinned) {
        const auto key = std::pair(mesh, skinned);
        if (const auto known = primitivesOf_.find(key); known != primitivesOf_.end()) {
            return known->second;
        }
        std::vector<int> indices;
        for (std::size_t k = 0; k < model_.meshes[mesh].primitives.size(); ++k) {
            std::optional<AssetPrimitive> primitive =
                meshes_.read(mesh, static_cast<int>(k), skinned);
            if (!primitive) continue;
            indices.push_back(static_cast<int>(asset_.primitives.size()));
            asset_.primitives.push_back(std::move(*primitive));
        }
        return primitivesOf_.emplace(key, std::move(indices)).first->second;
    }

    // --- Deformation -----------------------------------------------------------------------------

    /// The node's own weights, else its mesh's, else zeros (glTF 2.0, section 3.7.2.2).
    void readWeights(int node, const tinygltf::Node& in, const std::string& pointer) {
        const tinygltf::Mesh& mesh = model_.meshes[in.mesh];
        if (mesh.primitives.empty()) return;
        const std::size_t targets = mesh.primitives.front().targets.size();
        for (std::size_t k = 0; k < mesh.primitives.size(); ++k) {
            if (mesh.primitives[k].targets.size() == targets) continue;
            fail(fmt::format("/meshes/{}/primitives/{}/targets", in.mesh, k),
                 fmt::format("has {} morph targets; the first primitive has {}",
                             mesh.primitives[k].targets.size(), targets));
        }
        const bool own = !in.weights.empty();
        std::vector<double> weights = own ? in.weights : mesh.weights;
        if (weights.empty()) weights.assign(targets, 0.0);
        if (weights.size() != targets) {
            fail(own ? pointer + "/weights" : fmt::format("/meshes/{}/weights", in.mesh),
                 fmt::format("has {} weights for {} morph targets", weights.size(), targets));
        }
        asset_.memory.charge(targets, sizeof(double), pointer, "its weights");
        asset_.nodes[node].weights = std::move(weights);
    }

    int skinOf(int index, const std::string& user) {
        require(index, model_.skins.size(), user, "skin");
        if (const auto known = skinOf_.find(index); known != skinOf_.end()) return known->second;
        const tinygltf::Skin& in = model_.skins[index];
        const std::string pointer = fmt::format("/skins/{}", index);
        if (in.joints.empty()) fail(pointer + "/joints", "is empty");
        asset_.memory.charge(in.joints.size(), sizeof(glm::dmat4) + sizeof(int), pointer,
                             "its joints");
        AssetSkin skin;
        for (std::size_t k = 0; k < in.joints.size(); ++k) {
            const std::string at = fmt::format("{}/joints/{}", pointer, k);
            require(in.joints[k], model_.nodes.size(), at, "node");
            const int joint = hierarchy_.newIndex[in.joints[k]];
            if (joint < 0) {
                fail(at, fmt::format("node {} is not in the scene of the mesh", in.joints[k]));
            }
            skin.joints.push_back(joint);
        }
        skin.inverseBind.assign(skin.joints.size(), glm::dmat4(1.0));
        if (in.inverseBindMatrices >= 0) {
            const std::string at = pointer + "/inverseBindMatrices";
            std::vector<glm::dmat4> matrices = reader_.matrices(in.inverseBindMatrices, at);
            if (matrices.size() < skin.joints.size()) {
                fail(at, fmt::format("has {} matrices for {} joints", matrices.size(),
                                     skin.joints.size()));
            }
            std::copy_n(matrices.begin(), skin.joints.size(), skin.inverseBind.begin());
        }
        asset_.skins.push_back(std::move(skin));
        return skinOf_.emplace(index, static_cast<int>(asset_.skins.size()) - 1).first->second;
    }

    void requireJoints(const AssetPrimitive& primitive, const AssetSkin& skin,
                       const std::string& pointer) const {
        if (primitive.joints.empty()) return;
        const auto last = *std::max_element(primitive.joints.begin(), primitive.joints.end());
        if (last < skin.joints.size()) return;
        fail(pointer,
             fmt::format("its mesh uses joint {}; the skin has {}", last, skin.joints.size()));
    }

    int instancesOf(const tinygltf::Node& in, const std::string& pointer) {
        const auto extension = in.extensions.find("EXT_mesh_gpu_instancing");
        if (extension == in.extensions.end()) return -1;
        asset_.instances.push_back(
            readInstances(extension->second.Get("attributes"), reader_, asset_,
                          pointer + "/extensions/EXT_mesh_gpu_instancing/attributes"));
        return static_cast<int>(asset_.instances.size()) - 1;
    }

    // --- Cameras and lights ----------------------------------------------------------------------

    void addLight(int node, int index, const std::string& pointer) {
        require(index, model_.lights.size(), pointer, "light");
        const tinygltf::Light& in = model_.lights[index];
        double brightest = in.color.empty() ? 1.0 : 0.0;
        for (const double component : in.color) brightest = std::max(brightest, component);
        AssetLight light;
        light.node = node;
        light.kind = in.type == "point"  ? AssetLight::Kind::point
                     : in.type == "spot" ? AssetLight::Kind::spot
                                         : AssetLight::Kind::directional;
        light.intensity = in.intensity * brightest;
        light.name = model_.nodes[hierarchy_.fileNodes[node]].name;
        if (light.name.empty()) light.name = in.name;
        if (light.intensity > 0.0) asset_.lights.push_back(std::move(light));
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
            if (!(lens.magY > 0.0 && lens.magY < kMaxExtentM)) {
                fail(pointer + "/orthographic/ymag",
                     fmt::format("{} is not between 0 and {:g}", lens.magY, kMaxExtentM));
            }
        }
        if (farM > 0.0 || !perspective) lens.farM = farM;  // a perspective may have no far plane
        if (!(lens.nearM >= 0.0 && lens.nearM < kMaxExtentM && lens.farM > lens.nearM)) {
            fail(pointer,
                 fmt::format("znear {} and zfar {} do not enclose anything", lens.nearM, farM));
        }
        return lens;
    }

    const LoadOptions& options_;
    Asset asset_;
    tinygltf::Model model_;
    AccessorReader reader_;
    MeshReader meshes_;
    NodeHierarchy hierarchy_;
    std::map<std::pair<int, bool>, std::vector<int>> primitivesOf_;  ///< by mesh and skinned
    std::map<int, int> skinOf_;                                      ///< the file's -> asset_.skins
    std::size_t triangles_ = 0;
};

}  // namespace

Asset loadAsset(const std::filesystem::path& file, const LoadOptions& options) {
    if (const auto procedural = ProceduralAsset::parsed(file.string()))
        return procedural->make(file, options);
    return Loader(file, options).load();
}

}  // namespace penumbra::scene_detail
