#include "core/scene/gltf_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/scene/gltf_image.hpp"
#include "core/scene/gltf_uri.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

std::string quoted(const std::string& name, std::size_t index) {
    return name.empty() ? fmt::format("material {}", index)
                        : fmt::format("material '{}'", oneLine(name, 80));
}

double emissionOf(const tinygltf::Material& material) {
    double emission = 0.0;
    for (const double component : material.emissiveFactor) emission = std::max(emission, component);
    const auto extension = material.extensions.find("KHR_materials_emissive_strength");
    if (extension != material.extensions.end() && extension->second.Has("emissiveStrength")) {
        emission *= extension->second.Get("emissiveStrength").GetNumberAsDouble();
    }
    return emission;
}

double numberOr(const tinygltf::Value& object, const char* key, double otherwise) {
    return object.Has(key) ? object.Get(key).GetNumberAsDouble() : otherwise;
}

glm::dvec2 pairOr(const tinygltf::Value& object, const char* key, const glm::dvec2& otherwise) {
    if (!object.Has(key)) return otherwise;
    const tinygltf::Value& pair = object.Get(key);
    return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
}

}  // namespace

TextureMapping baseColorMapping(const tinygltf::Material& material) {
    const tinygltf::TextureInfo& info = material.pbrMetallicRoughness.baseColorTexture;
    TextureMapping mapping;
    mapping.set = info.texCoord;
    const auto extension = info.extensions.find("KHR_texture_transform");
    if (extension == info.extensions.end()) return mapping;
    const tinygltf::Value& in = extension->second;
    mapping.set = static_cast<int>(numberOr(in, "texCoord", mapping.set));
    const glm::dvec2 offset = pairOr(in, "offset", glm::dvec2(0.0));
    const glm::dvec2 scale = pairOr(in, "scale", glm::dvec2(1.0));
    const double angle = numberOr(in, "rotation", 0.0);
    // The extension's matrix: translation times rotation times scale; v points down, so that a
    // positive angle turns counter-clockwise in the image.
    const double c = std::cos(angle), s = std::sin(angle);
    mapping.matrix = glm::dmat3(glm::dvec3(c, -s, 0) * scale.x, glm::dvec3(s, c, 0) * scale.y,
                                glm::dvec3(offset, 1));
    return mapping;
}

void MaterialLoader::load() {
    for (std::size_t i = 0; i < model_.materials.size(); ++i) add(i);
    asset_.materials.push_back(Material{.name = "default"});
    asset_.emissions.push_back(0.0);
}

void MaterialLoader::add(std::size_t index) {
    const tinygltf::Material& in = model_.materials[index];
    const std::string pointer = fmt::format("/materials/{}", index);
    Material material;
    material.name = in.name;
    const std::vector<double>& factor = in.pbrMetallicRoughness.baseColorFactor;
    for (int c = 0; c < 4; ++c) {
        if (!(factor[c] >= 0.0 && factor[c] <= 1.0)) {
            failInput(asset_.file, pointer + "/pbrMetallicRoughness/baseColorFactor",
                      fmt::format("component {} is {}; it must be from 0 to 1", c, factor[c]));
        }
        material.baseColor[c] = static_cast<float>(factor[c]);
    }
    if (in.alphaMode == "MASK") {
        material.masked = true;
        material.alphaCutoff = static_cast<float>(in.alphaCutoff);
    } else if (in.alphaMode == "BLEND") {
        asset_.notes.push_back(quoted(in.name, index) +
                               ": alphaMode BLEND is not supported, treated as opaque");
    } else if (in.alphaMode != "OPAQUE") {
        failInput(asset_.file, pointer + "/alphaMode",
                  fmt::format("'{}' is not one of OPAQUE, MASK, BLEND", oneLine(in.alphaMode, 40)));
    }
    if (in.pbrMetallicRoughness.baseColorTexture.index >= 0) {
        material.baseColorTexture = textureFor(in.pbrMetallicRoughness.baseColorTexture,
                                               pointer + "/pbrMetallicRoughness/baseColorTexture");
    } else if (material.masked && material.baseColor.a >= material.alphaCutoff) {
        material.masked = false;  // opaque everywhere: nothing to test per ray
    }
    asset_.materials.push_back(std::move(material));
    asset_.emissions.push_back(emissionOf(in));
}

int MaterialLoader::textureFor(const tinygltf::TextureInfo& info, const std::string& pointer) {
    const auto require = [&](int index, std::size_t count, const std::string& at,
                             const char* what) {
        if (index < 0 || static_cast<std::size_t>(index) >= count) {
            failInput(asset_.file, at,
                      fmt::format("{} {} does not exist; the file has {}", what, index, count));
        }
    };
    require(info.index, model_.textures.size(), pointer + "/index", "texture");
    const tinygltf::Texture& texture = model_.textures[info.index];
    const std::string texturePointer = fmt::format("/textures/{}", info.index);
    require(texture.source, model_.images.size(), texturePointer + "/source", "image");

    TextureImage sampling;
    if (texture.sampler >= 0) {
        require(texture.sampler, model_.samplers.size(), texturePointer + "/sampler", "sampler");
        const tinygltf::Sampler& sampler = model_.samplers[texture.sampler];
        const auto wrap = [&](int mode) {
            switch (mode) {
                case TINYGLTF_TEXTURE_WRAP_REPEAT:
                    return Wrap::repeat;
                case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
                    return Wrap::mirroredRepeat;
                case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
                    return Wrap::clampToEdge;
                default:
                    failInput(asset_.file, fmt::format("/samplers/{}", texture.sampler),
                              fmt::format("wrap mode {} is not one of 10497, 33071, 33648", mode));
            }
        };
        sampling.wrapS = wrap(sampler.wrapS);
        sampling.wrapT = wrap(sampler.wrapT);
        sampling.linear = sampler.magFilter != TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    const auto key = std::tuple(texture.source, sampling.wrapS, sampling.wrapT, sampling.linear);
    if (const auto known = loaded_.find(key); known != loaded_.end()) return known->second;

    TextureImage image = decoded(texture.source);
    image.wrapS = sampling.wrapS;
    image.wrapT = sampling.wrapT;
    image.linear = sampling.linear;
    asset_.images.push_back(std::move(image));
    const int index = static_cast<int>(asset_.images.size()) - 1;
    loaded_.emplace(key, index);
    return index;
}

TextureImage MaterialLoader::decoded(int index) {
    const tinygltf::Image& image = model_.images[index];
    const std::string pointer = fmt::format("/images/{}", index);
    std::vector<unsigned char> file;
    std::span<const unsigned char> encoded;
    if (image.bufferView >= 0) {
        encoded = reader_.bufferView(image.bufferView, pointer + "/bufferView");
    } else if (!image.uri.empty()) {
        file = readUri(image.uri, asset_.file, pointer + "/uri", asset_.memory);
        encoded = file;
    }
    if (encoded.empty()) failInput(asset_.file, pointer, "is empty");
    TextureImage out = decodeImage(encoded, asset_.file, pointer, asset_.memory);
    out.name = image.name.empty() ? oneLine(image.uri, 200) : image.name;
    return out;
}

}  // namespace penumbra::scene_detail
