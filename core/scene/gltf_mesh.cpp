#include "core/scene/gltf_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/scene/gltf_material.hpp"
#include "core/scene/gltf_vertices.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr std::array<const char*, 7> kModes = {
    "POINTS", "LINES", "LINE_LOOP", "LINE_STRIP", "TRIANGLES", "TRIANGLE_STRIP", "TRIANGLE_FAN"};
constexpr std::uint32_t kUnused = ~0u;

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

bool namesThree(const std::uint32_t* t) {
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

/// Makes vertex i of the primitive what was vertex `vertices[i]`.
void gatherVertices(AssetPrimitive& out, const std::vector<std::uint32_t>& vertices) {
    const auto gather = [&](auto& attribute, std::size_t each) {
        if (attribute.empty()) return;
        std::remove_reference_t<decltype(attribute)> gathered;
        gathered.reserve(each * vertices.size());
        for (const std::uint32_t i : vertices) {
            for (std::size_t k = 0; k < each; ++k) gathered.push_back(attribute[each * i + k]);
        }
        attribute = std::move(gathered);
    };
    gather(out.positions, 1);
    gather(out.normals, 1);
    gather(out.uvs, 1);
    for (MorphTarget& target : out.targets) {
        gather(target.positions, 1);
        gather(target.normals, 1);
    }
    const auto influences = static_cast<std::size_t>(out.influences);
    gather(out.joints, influences);
    gather(out.jointWeights, influences);
}

/// Moves the vertices that the indices use to the front, in order of first use; drops the others.
void compact(AssetPrimitive& out) {
    std::vector<std::uint32_t> newIndex(out.positions.size(), kUnused);
    std::vector<std::uint32_t> used;
    for (std::uint32_t& i : out.indices) {
        if (newIndex[i] == kUnused) {
            newIndex[i] = static_cast<std::uint32_t>(used.size());
            used.push_back(i);
        }
        i = newIndex[i];
    }
    gatherVertices(out, used);
}

/// Gives every triangle its own three vertices and its geometric normal (glTF 2.0, 3.7.2.1).
void makeFlat(AssetPrimitive& out) {
    gatherVertices(out, out.indices);
    std::iota(out.indices.begin(), out.indices.end(), 0u);
    out.flat = true;
    out.normals.clear();
    for (std::size_t t = 0; t < out.indices.size(); t += 3) {
        const glm::dvec3 area = doubledArea(out.positions, &out.indices[t]);
        // A triangle that deforms may have no area at rest.
        out.normals.insert(
            out.normals.end(), 3,
            glm::length(area) > 0.0 ? glm::vec3(glm::normalize(area)) : glm::vec3(0, 1, 0));
    }
    for (MorphTarget& target : out.targets) target.normals.clear();
}

bool allUsable(const std::vector<glm::vec3>& normals) {
    for (const glm::vec3& n : normals) {
        const float length = glm::length(n);
        if (!std::isfinite(length) || length < 1e-6f) return false;
    }
    return !normals.empty();
}

}  // namespace

MeshReader::MeshReader(const tinygltf::Model& model, AccessorReader& reader, Asset& asset)
    : model_(model), reader_(reader), asset_(asset) {
    const auto& used = model.extensionsUsed;
    const bool quantised =
        std::find(used.begin(), used.end(), "KHR_mesh_quantization") != used.end();
    geometryIntegers_ = quantised ? Integers::any : Integers::none;
}

std::optional<AssetPrimitive> MeshReader::read(int mesh, int primitive, bool skinned) {
    const tinygltf::Primitive& in = model_.meshes[mesh].primitives[primitive];
    const std::string pointer = fmt::format("/meshes/{}/primitives/{}", mesh, primitive);
    const auto fail = [&](const std::string& what) { failInput(asset_.file, pointer, what); };
    if (in.mode < 0 || in.mode > 6) fail(fmt::format("mode {} is not one of 0 to 6", in.mode));
    if (in.mode < TINYGLTF_MODE_TRIANGLES) {
        if (skipped_++ == 0) firstSkipped_ = fmt::format("{}: mode {}", pointer, kModes[in.mode]);
        return std::nullopt;
    }
    if (in.material >= static_cast<int>(model_.materials.size())) {
        fail(fmt::format("material {} does not exist; the file has {}", in.material,
                         model_.materials.size()));
    }
    AssetPrimitive out;
    out.material = in.material < 0 ? static_cast<int>(model_.materials.size()) : in.material;

    VertexReader vertices(in, reader_, asset_.file, pointer, geometryIntegers_);
    out.indices = corners(in, vertices.count(), pointer);
    triangles_ += out.indices.size() / 3;
    if (triangles_ > kMaxTriangles) {
        fail(fmt::format("the meshes have more than {} triangles", kMaxTriangles));
    }
    vertices.select(takeVertices(out.indices, vertices.count(), pointer));
    out.positions = vertices.positions();
    out.normals = vertices.normals();
    vertices.readTargets(out);
    if (skinned) vertices.readInfluences(out);
    const Material& material = asset_.materials[out.material];
    if (material.masked) vertices.requireOpaqueColours();
    out.uvs = material.baseColorTexture < 0
                  ? std::vector<glm::vec2>(out.positions.size(), glm::vec2(0.0f))
                  : vertices.uvs(baseColorMapping(model_.materials[out.material]));
    dropDegenerate(out);
    if (out.indices.empty()) return std::nullopt;
    compact(out);
    if (!allUsable(out.normals)) {
        const std::size_t perVertex = sizeof(glm::vec3) * (3 + out.targets.size()) +
                                      6 * static_cast<std::size_t>(out.influences);
        asset_.memory.charge(out.indices.size(), perVertex, pointer, "flat normals");
        makeFlat(out);
    }
    return out;
}

/// Three per triangle, whatever the mode.
std::vector<std::uint32_t> MeshReader::corners(const tinygltf::Primitive& in,
                                               std::size_t vertexCount,
                                               const std::string& pointer) {
    std::vector<std::uint32_t> line;
    if (in.indices >= 0) {
        line = reader_.indices(in.indices, vertexCount, pointer + "/indices");
    } else {
        asset_.memory.charge(vertexCount, sizeof(std::uint32_t), pointer, "its triangles");
        line.resize(vertexCount);
        std::iota(line.begin(), line.end(), 0u);
    }
    if (in.mode == TINYGLTF_MODE_TRIANGLES) {
        if (line.size() % 3 != 0) {
            failInput(asset_.file, pointer,
                      fmt::format("has {} corners, which is not a multiple of 3", line.size()));
        }
        return line;
    }
    if (line.size() < 3) {
        failInput(asset_.file, pointer, fmt::format("has {} corners, fewer than 3", line.size()));
    }
    asset_.memory.charge(line.size(), 3 * sizeof(std::uint32_t), pointer, "its triangles");
    std::vector<std::uint32_t> out;
    out.reserve(3 * (line.size() - 2));
    for (std::size_t i = 0; i + 2 < line.size(); ++i) {  // glTF 2.0, section 3.7.2.1
        if (in.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
            out.insert(out.end(), {line[i], line[i + 1 + i % 2], line[i + 2 - i % 2]});
        } else {
            out.insert(out.end(), {line[i + 1], line[i + 2], line[0]});
        }
    }
    return out;
}

/// Renumbers `indices` by first use; which vertices those are.
std::vector<std::uint32_t> MeshReader::takeVertices(std::vector<std::uint32_t>& indices,
                                                    std::size_t vertexCount,
                                                    const std::string& pointer) {
    if (vertexCount > newIndex_.size()) {
        asset_.memory.charge(vertexCount - newIndex_.size(), sizeof(std::uint32_t), pointer,
                             "its vertices");
        newIndex_.resize(vertexCount, kUnused);
    }
    asset_.memory.charge(std::min(indices.size(), vertexCount), sizeof(std::uint32_t), pointer,
                         "its vertices");
    std::vector<std::uint32_t> used;
    for (std::uint32_t& i : indices) {
        if (newIndex_[i] == kUnused) {
            newIndex_[i] = static_cast<std::uint32_t>(used.size());
            used.push_back(i);
        }
        i = newIndex_[i];
    }
    for (const std::uint32_t i : used) newIndex_[i] = kUnused;
    return used;
}

void MeshReader::dropDegenerate(AssetPrimitive& out) {
    const bool deforms = out.deforms();
    std::size_t kept = 0;
    for (std::size_t t = 0; t < out.indices.size(); t += 3) {
        const std::uint32_t* const corner = &out.indices[t];
        if (!namesThree(corner) || (!deforms && !hasArea(out.positions, corner))) continue;
        std::copy_n(corner, 3, &out.indices[kept]);
        kept += 3;
    }
    dropped_ += (out.indices.size() - kept) / 3;
    out.indices.resize(kept);
}

std::vector<std::string> MeshReader::notes() const {
    std::vector<std::string> out;
    if (dropped_ > 0) out.push_back(fmt::format("{} zero-area triangles dropped", dropped_));
    if (skipped_ > 0) {
        out.push_back(
            fmt::format("{} primitives of points or lines cast no shadow, left out", skipped_));
    }
    return out;
}

}  // namespace penumbra::scene_detail
