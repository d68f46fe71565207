#include "core/scene/gltf_vertices.hpp"

#include <fmt/format.h>

#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {

VertexReader::VertexReader(const tinygltf::Primitive& primitive, AccessorReader& reader,
                           const std::filesystem::path& file, std::string pointer,
                           Integers integers)
    : primitive_(primitive),
      reader_(reader),
      file_(file),
      pointer_(std::move(pointer)),
      integers_(integers) {
    if (!has("POSITION")) fail(pointer_, "has no POSITION");
    const std::string user = pointer_ + "/attributes/POSITION";
    const int positions = primitive_.attributes.at("POSITION");
    count_ = reader_.count(positions, user);
    // Compressed primitives have accessors without data.
    if (!reader_.hasData(positions, user)) fail(user, "has no buffer view to read positions from");
}

void VertexReader::fail(const std::string& pointer, const std::string& what) const {
    failInput(file_, pointer, what);
}

void VertexReader::requireCount(int accessor, const std::string& user) {
    const std::size_t elements = reader_.count(accessor, user);
    if (elements != count_) {
        fail(user, fmt::format("has {} elements, POSITION has {}", elements, count_));
    }
}

int VertexReader::accessor(const std::string& name) {
    const int index = primitive_.attributes.at(name);
    requireCount(index, pointer_ + "/attributes/" + name);
    return index;
}

template <class Vector>
std::vector<Vector> VertexReader::read(const std::string& name,
                                       const AccessorReader::Wanted& wanted) {
    const std::vector<glm::vec4> in =
        reader_.vectors(accessor(name), wanted, pointer_ + "/attributes/" + name, vertices_);
    return {in.begin(), in.end()};
}

std::vector<glm::vec3> VertexReader::positions() {
    return read<glm::vec3>("POSITION", {3, integers_, false});
}

std::vector<glm::vec3> VertexReader::normals() {
    if (!has("NORMAL")) return {};
    return read<glm::vec3>("NORMAL", {3, integers_, true});
}

std::vector<glm::vec2> VertexReader::uvs(const TextureMapping& mapping) {
    const std::string name = fmt::format("TEXCOORD_{}", mapping.set);
    if (!has(name)) {
        fail(pointer_, fmt::format("has no {}, which its base colour texture uses", name));
    }
    std::vector<glm::vec2> out = read<glm::vec2>(
        name, {2, integers_ == Integers::none ? Integers::normalised : integers_, false});
    for (std::size_t i = 0; i < out.size(); ++i) {
        const glm::dvec2 mapped(mapping.matrix * glm::dvec3(out[i], 1.0));
        if (!(glm::length(mapped) < kMaxExtentM)) {
            fail(pointer_ + "/attributes/" + name,
                 fmt::format("element {} is beyond {:g} after its texture's transform",
                             vertices_[i], kMaxExtentM));
        }
        out[i] = glm::vec2(mapped);
    }
    return out;
}

void VertexReader::readTargets(AssetPrimitive& out) {
    for (std::size_t k = 0; k < primitive_.targets.size(); ++k) {
        MorphTarget target;
        const auto deltas = [&](const char* name, bool wanted) -> std::vector<glm::vec3> {
            const auto found = primitive_.targets[k].find(name);
            if (!wanted || found == primitive_.targets[k].end()) return {};
            const std::string user = fmt::format("{}/targets/{}/{}", pointer_, k, name);
            requireCount(found->second, user);
            const std::vector<glm::vec4> in =
                reader_.vectors(found->second, {3, integers_, false}, user, vertices_);
            return {in.begin(), in.end()};
        };
        target.positions = deltas("POSITION", true);
        target.normals = deltas("NORMAL", !out.normals.empty());
        out.targets.push_back(std::move(target));
    }
}

void VertexReader::readInfluences(AssetPrimitive& out) {
    int sets = 0;
    while (has(fmt::format("JOINTS_{}", sets))) ++sets;
    if (sets == 0) fail(pointer_, "has no JOINTS_0, but its node has a skin");
    out.influences = 4 * sets;
    const auto influences = static_cast<std::size_t>(out.influences);
    out.joints.resize(influences * vertices_.size());
    out.jointWeights.resize(influences * vertices_.size());
    for (int set = 0; set < sets; ++set) {
        const std::string weightName = fmt::format("WEIGHTS_{}", set);
        const std::string jointName = fmt::format("JOINTS_{}", set);
        if (!has(weightName)) fail(pointer_, fmt::format("has no {}", weightName));
        const auto weights = read<glm::vec4>(weightName, {4, Integers::normalised, false});
        const auto joints =
            reader_.joints(accessor(jointName), pointer_ + "/attributes/" + jointName, vertices_);
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            for (int c = 0; c < 4; ++c) {
                if (weights[i][c] < 0.0f) {
                    fail(pointer_ + "/attributes/" + weightName,
                         fmt::format("weight {} of vertex {} is below 0", weights[i][c],
                                     vertices_[i]));
                }
                const std::size_t at = influences * i + static_cast<std::size_t>(4 * set + c);
                out.joints[at] = static_cast<std::uint16_t>(joints[i][c]);
                out.jointWeights[at] = weights[i][c];
            }
        }
    }
    for (std::size_t i = 0; i < out.jointWeights.size(); i += influences) {
        double sum = 0.0;
        for (std::size_t k = 0; k < influences; ++k) sum += out.jointWeights[i + k];
        if (sum == 0.0) out.jointWeights[i] = 1.0f, sum = 1.0;
        for (std::size_t k = 0; k < influences; ++k) {
            out.jointWeights[i + k] = static_cast<float>(out.jointWeights[i + k] / sum);
        }
    }
}

void VertexReader::requireOpaqueColours() {
    if (!has("COLOR_0")) return;
    const std::string user = pointer_ + "/attributes/COLOR_0";
    const int index = accessor("COLOR_0");
    if (reader_.components(index, user) != 4) return;
    for (const glm::vec4& colour :
         reader_.vectors(index, {4, Integers::normalised, false}, user, vertices_)) {
        if (colour.a != 1.0f)
            fail(user, "alpha other than 1 on a masked material is not supported");
    }
}

}  // namespace penumbra::scene_detail
