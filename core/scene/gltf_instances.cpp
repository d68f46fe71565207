#include "core/scene/gltf_instances.hpp"

#include <fmt/format.h>

#include "core/scene/gltf_animation.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

struct InstanceAttribute {
    const char* name;
    NodeProperty property;
    int components;
};
constexpr InstanceAttribute kAttributes[] = {{"TRANSLATION", NodeProperty::translation, 3},
                                             {"ROTATION", NodeProperty::rotation, 4},
                                             {"SCALE", NodeProperty::scale, 3}};

}  // namespace

std::vector<glm::dmat4> readInstances(const tinygltf::Value& attributes, AccessorReader& reader,
                                      Asset& asset, const std::string& pointer) {
    std::vector<Transform> transforms;
    for (const InstanceAttribute& each : kAttributes) {
        if (!attributes.Has(each.name)) continue;
        const std::string user = pointer + "/" + each.name;
        const std::vector<glm::vec4> values =
            reader.vectors(attributes.Get(each.name).GetNumberAsInt(),
                           {each.components, Integers::normalised, false}, user);
        if (transforms.empty()) {
            asset.memory.charge(values.size(), sizeof(Transform) + sizeof(glm::dmat4), user,
                                "its instances");
            transforms.resize(values.size());
        }
        if (values.size() != transforms.size()) {
            failInput(
                asset.file, user,
                fmt::format("has {} elements for {} instances", values.size(), transforms.size()));
        }
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (each.property == NodeProperty::rotation) {
                requireRotation(values[i], asset.file, fmt::format("{} element {}", user, i));
            }
            transforms[i].set(each.property, values[i]);
        }
    }
    if (transforms.empty()) {
        failInput(asset.file, pointer, "has none of TRANSLATION, ROTATION, SCALE");
    }
    std::vector<glm::dmat4> matrices;
    matrices.reserve(transforms.size());
    for (const Transform& transform : transforms) matrices.push_back(transform.matrix());
    return matrices;
}

}  // namespace penumbra::scene_detail
