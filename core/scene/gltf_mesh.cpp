#include "core/scene/gltf_mesh.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numeric>

#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr std::array<const char*, 7> kModes = {
    "POINTS", "LINES", "LINE_LOOP", "LINE_STRIP", "TRIANGLES", "TRIANGLE_STRIP", "TRIANGLE_FAN"};

/// Twice the vector area; rounding of doubles aside exact, as positions are floats.
glm::dvec3 doubledArea(const std::vector<glm::vec3>& p, const std::uint32_t* t) {
    return glm::cross(glm::dvec3(p[t[1]]) - glm::dvec3(p[t[0]]),
                      glm::dvec3(p[t[2]]) - glm::dvec3(p[t[0]]));
}

bool hasArea(const std::vector<glm::vec3>& p, const std::uint32_t* t) {
    double edge2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 edge = glm::dvec3(p[t[(i + 1) % 3]]) - glm::dvec3(p[t[i]]);
        edge2 = std::max(edge2, glm::dot(edge, edge));
    }
    // 1e-14 of the longest edge squared is what rounding of the cross product may leave.
    return glm::length(doubledArea(p, t)) > 1e-14 * edge2;
}

/// Moves the vertices that `indices` use to the front, in order of first use; drops the others.
void compact(AssetPrimitive& out) {
    constexpr std::uint32_t kUnused = ~0u;
    std::vector<std::uint32_t> newIndex(out.positions.size(), kUnused);
    std::vector<std::uint32_t> used;
    for (std::uint32_t& i : out.indices) {
        if (newIndex[i] == kUnused) {
            newIndex[i] = static_cast<std::uint32_t>(used.size());
            used.push_back(i);
        }
        i = newIndex[i];
    }
    const auto gather = [&](auto& attribute) {
        std::remove_reference_t<decltype(attribute)> gathered;
        gathered.reserve(used.size());
        for (const std::uint32_t i : used) gathered.push_back(attribute[i]);
        attribute = std::move(gathered);
    };
    gather(out.positions);
    gather(out.uvs);
    if (!out.normals.empty()) gather(out.normals);
}

/// Gives every triangle its own three vertices and its geometric normal (glTF 2.0, 3.7.2.1).
void makeFlat(AssetPrimitive& out) {
    AssetPrimitive flat;
    flat.material = out.material;
    for (std::size_t t = 0; t < out.indices.size(); t += 3) {
        const glm::vec3 normal(glm::normalize(doubledArea(out.positions, &out.indices[t])));
        for (std::size_t k = t; k < t + 3; ++k) {
            flat.positions.push_back(out.positions[out.indices[k]]);
            flat.uvs.push_back(out.uvs[out.indices[k]]);
            flat.normals.push_back(normal);
            flat.indices.push_back(static_cast<std::uint32_t>(k));
        }
    }
    out = std::move(flat);
}

bool allUsable(const std::vector<glm::vec3>& normals) {
    for (const glm::vec3& n : normals) {
        const float length = glm::length(n);
        if (!std::isfinite(length) || length < 1e-6f) return false;
    }
    return !normals.empty();
}

/// Reads the attributes of one primitive that are used.
class AttributeReader {
  public:
    AttributeReader(const tinygltf::Primitive& primitive, const AccessorReader& reader,
                    const std::filesystem::path& file, std::string pointer)
        : primitive_(primitive), reader_(reader), file_(file), pointer_(std::move(pointer)) {}

    std::vector<glm::vec3> positions() {
        if (!primitive_.attributes.contains("POSITION")) {
            failInput(file_, pointer_, "has no POSITION");
        }
        std::vector<glm::vec3> out = read<glm::vec3>("POSITION", 3, false, false);
        count_ = out.size();
        return out;
    }

    std::vector<glm::vec3> normals() {
        if (!primitive_.attributes.contains("NORMAL")) return {};
        return checked("NORMAL", read<glm::vec3>("NORMAL", 3, false, true));
    }

    std::vector<glm::vec2> uvs(int set) {
        const std::string name = fmt::format("TEXCOORD_{}", set);
        if (!primitive_.attributes.contains(name)) {
            failInput(file_, pointer_,
                      fmt::format("has no {}, which its base colour texture uses", name));
        }
        return checked(name, read<glm::vec2>(name, 2, true, false));
    }

  private:
    template <class Vector>
    std::vector<Vector> read(const std::string& name, int components, bool allowNormalised,
                             bool allowNonFinite) {
        const std::vector<glm::vec4> in =
            reader_.vectors(primitive_.attributes.at(name), components, allowNormalised,
                            pointer_ + "/attributes/" + name, allowNonFinite);
        return {in.begin(), in.end()};
    }

    template <class Vector>
    std::vector<Vector> checked(const std::string& name, std::vector<Vector> values) {
        if (values.size() != count_) {
            failInput(file_, pointer_ + "/attributes/" + name,
                      fmt::format("has {} elements, POSITION has {}", values.size(), count_));
        }
        return values;
    }

    const tinygltf::Primitive& primitive_;
    const AccessorReader& reader_;
    const std::filesystem::path& file_;
    std::string pointer_;
    std::size_t count_ = 0;
};

}  // namespace

std::optional<AssetPrimitive> readPrimitive(const tinygltf::Model& model,
                                            const AccessorReader& reader, const Asset& asset,
                                            int mesh, int primitive,
                                            std::size_t& droppedTriangles) {
    const tinygltf::Primitive& in = model.meshes[mesh].primitives[primitive];
    const std::string pointer = fmt::format("/meshes/{}/primitives/{}", mesh, primitive);
    const auto fail = [&](const std::string& what) { failInput(asset.file, pointer, what); };
    if (in.mode != TINYGLTF_MODE_TRIANGLES) {
        fail(fmt::format("mode {} is not supported; only TRIANGLES is",
                         in.mode >= 0 && in.mode < 7 ? kModes[in.mode] : std::to_string(in.mode)));
    }
    if (!in.targets.empty()) fail("morph targets are not supported yet");
    if (in.material >= static_cast<int>(model.materials.size())) {
        fail(fmt::format("material {} does not exist; the file has {}", in.material,
                         model.materials.size()));
    }

    AssetPrimitive out;
    out.material = in.material < 0 ? static_cast<int>(model.materials.size()) : in.material;
    const Material& material = asset.materials[out.material];
    if (const auto colour = in.attributes.find("COLOR_0");
        material.masked && colour != in.attributes.end() && colour->second >= 0 &&
        static_cast<std::size_t>(colour->second) < model.accessors.size() &&
        model.accessors[colour->second].type == TINYGLTF_TYPE_VEC4) {
        fail("COLOR_0 with alpha on a masked material is not supported yet");
    }

    AttributeReader attributes(in, reader, asset.file, pointer);
    out.positions = attributes.positions();
    out.normals = attributes.normals();
    out.uvs =
        material.baseColorTexture < 0
            ? std::vector<glm::vec2>(out.positions.size(), glm::vec2(0.0f))
            : attributes.uvs(
                  model.materials[out.material].pbrMetallicRoughness.baseColorTexture.texCoord);
    std::vector<std::uint32_t> indices(out.positions.size());
    if (in.indices >= 0) {
        indices = reader.indices(in.indices, out.positions.size(), pointer + "/indices");
    } else {
        std::iota(indices.begin(), indices.end(), 0u);
    }
    if (indices.size() % 3 != 0) {
        fail(fmt::format("has {} corners, which is not a multiple of 3", indices.size()));
    }
    for (std::size_t t = 0; t < indices.size(); t += 3) {
        if (hasArea(out.positions, &indices[t])) {
            out.indices.insert(out.indices.end(), &indices[t], &indices[t] + 3);
        }
    }
    droppedTriangles += (indices.size() - out.indices.size()) / 3;
    if (out.indices.empty()) return std::nullopt;
    compact(out);
    if (!allUsable(out.normals)) makeFlat(out);
    return out;
}

}  // namespace penumbra::scene_detail
