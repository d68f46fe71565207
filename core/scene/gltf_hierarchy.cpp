#include "core/scene/gltf_hierarchy.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/choice.hpp"
#include "core/scene/gltf_animation.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

class HierarchyReader {
  public:
    HierarchyReader(const tinygltf::Model& model, Asset& asset) : model_(model), asset_(asset) {}

    NodeHierarchy read(const std::string& wanted) {
        findParents();
        refuseCycles();
        out_.newIndex.assign(model_.nodes.size(), -1);
        std::vector<int> open = sceneRoots(wanted);
        std::reverse(open.begin(), open.end());
        while (!open.empty()) {
            const int index = open.back();
            open.pop_back();
            add(index);
            const std::vector<int>& children = model_.nodes[index].children;
            open.insert(open.end(), children.rbegin(), children.rend());
        }
        return std::move(out_);
    }

  private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
        failInput(asset_.file, pointer, what);
    }

    void requireNode(int index, const std::string& pointer) const {
        if (index >= 0 && static_cast<std::size_t>(index) < model_.nodes.size()) return;
        fail(pointer,
             fmt::format("node {} does not exist; the file has {}", index, model_.nodes.size()));
    }

    void findParents() {
        parents_.assign(model_.nodes.size(), -1);
        for (std::size_t i = 0; i < model_.nodes.size(); ++i) {
            const std::vector<int>& children = model_.nodes[i].children;
            for (std::size_t k = 0; k < children.size(); ++k) {
                const std::string pointer = fmt::format("/nodes/{}/children/{}", i, k);
                requireNode(children[k], pointer);
                if (parents_[children[k]] >= 0) {
                    fail(pointer, fmt::format("node {} already is a child of node {}", children[k],
                                              parents_[children[k]]));
                }
                parents_[children[k]] = static_cast<int>(i);
            }
        }
    }

    void refuseCycles() const {
        std::vector<char> rooted(model_.nodes.size(), 0);
        std::vector<int> open;
        for (std::size_t i = 0; i < parents_.size(); ++i) {
            if (parents_[i] < 0) open.push_back(static_cast<int>(i));
        }
        while (!open.empty()) {
            const int node = open.back();
            open.pop_back();
            rooted[node] = 1;
            const std::vector<int>& children = model_.nodes[node].children;
            open.insert(open.end(), children.begin(), children.end());
        }
        for (std::size_t i = 0; i < rooted.size(); ++i) {
            if (!rooted[i]) fail(fmt::format("/nodes/{}", i), "is part of a cycle of nodes");
        }
    }

    std::vector<int> sceneRoots(const std::string& wanted) {
        const int scene = chosenScene(wanted);
        if (scene < 0) {  // without scenes all roots are read
            asset_.pointer = "/nodes";
            std::vector<int> roots;
            for (std::size_t i = 0; i < parents_.size(); ++i) {
                if (parents_[i] < 0) roots.push_back(static_cast<int>(i));
            }
            return roots;
        }
        asset_.pointer = fmt::format("/scenes/{}", scene);
        const std::vector<int>& roots = model_.scenes[scene].nodes;
        for (std::size_t k = 0; k < roots.size(); ++k) {
            const std::string pointer = fmt::format("{}/nodes/{}", asset_.pointer, k);
            requireNode(roots[k], pointer);
            if (parents_[roots[k]] >= 0) {
                fail(pointer, fmt::format("node {} is not a root: it is a child of node {}",
                                          roots[k], parents_[roots[k]]));
            }
        }
        return roots;
    }

    int chosenScene(const std::string& wanted) const {
        std::vector<std::string> names;
        for (const tinygltf::Scene& scene : model_.scenes) names.push_back(scene.name);
        if (!wanted.empty()) {
            const auto chosen = chosenByIndexOrName(wanted, names);
            if (!chosen) {
                fail("/scenes",
                     fmt::format("--asset-scene {}: {}", oneLine(wanted, 60),
                                 names.empty() ? "the file has no scenes"
                                               : "the scenes are " + indexedNames(names)));
            }
            return static_cast<int>(*chosen);
        }
        if (names.empty()) return -1;
        const int scene = std::max(model_.defaultScene, 0);
        if (static_cast<std::size_t>(scene) >= names.size()) {
            fail("/scene",
                 fmt::format("scene {} does not exist; the file has {}", scene, names.size()));
        }
        return scene;
    }

    void add(int index) {
        if (out_.newIndex[index] >= 0) {
            fail(fmt::format("/nodes/{}", index), "is listed twice in its scene");
        }
        out_.newIndex[index] = static_cast<int>(out_.fileNodes.size());
        out_.fileNodes.push_back(index);
        const tinygltf::Node& in = model_.nodes[index];
        asset_.memory.charge(1, sizeof(AssetNode), fmt::format("/nodes/{}", index), "the node");
        AssetNode node;
        node.name = in.name;
        node.parent = parents_[index] < 0 ? -1 : out_.newIndex[parents_[index]];
        node.hasMatrix = !in.matrix.empty();
        for (std::size_t k = 0; k < in.matrix.size(); ++k) node.matrix[k / 4][k % 4] = in.matrix[k];
        const auto vec4 = [](const std::vector<double>& v) {
            return glm::dvec4(v[0], v[1], v[2], v.size() > 3 ? v[3] : 0.0);
        };
        if (!in.translation.empty()) {
            node.transform.set(NodeProperty::translation, vec4(in.translation));
        }
        if (!in.rotation.empty()) {
            requireRotation(vec4(in.rotation), asset_.file,
                            fmt::format("/nodes/{}/rotation", index));
            node.transform.set(NodeProperty::rotation, vec4(in.rotation));
        }
        if (!in.scale.empty()) node.transform.set(NodeProperty::scale, vec4(in.scale));
        asset_.nodes.push_back(std::move(node));
    }

    const tinygltf::Model& model_;
    Asset& asset_;
    std::vector<int> parents_;  ///< per node of the file
    NodeHierarchy out_;
};

}  // namespace

NodeHierarchy readHierarchy(const tinygltf::Model& model, const std::string& wanted, Asset& asset) {
    return HierarchyReader(model, asset).read(wanted);
}

}  // namespace penumbra::scene_detail
