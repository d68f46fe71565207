#include "core/scene/gltf_file.hpp"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/scene/gltf_json.hpp"
#include "core/scene/gltf_uri.hpp"
#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Bytes = std::vector<unsigned char>;

struct Container {
    std::string_view json;
    std::span<const unsigned char> binary;  ///< of a .glb's BIN chunk, empty where there is none
};

/// The chunks of a file, after their lengths have been checked.
Container chunksOf(const fs::path& file, const Bytes& bytes) {
    const char* const text = reinterpret_cast<const char*>(bytes.data());
    if (bytes.size() < 4 || std::memcmp(text, "glTF", 4) != 0) return {{text, bytes.size()}, {}};
    const auto u32 = [&](std::uint64_t offset) -> std::uint64_t {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes.data() + offset, sizeof value);
        return value;
    };
    const std::uint64_t size = bytes.size();
    if (size < 20) failInput(file, "", "is cut off: shorter than a glTF binary header");
    if (u32(4) != 2) {
        failInput(file, "", fmt::format("is glTF binary version {}; only 2 is read", u32(4)));
    }
    const std::uint64_t length = u32(8), jsonLength = u32(12);
    if (length > size) {
        failInput(file, "",
                  fmt::format("is cut off: its header promises {} bytes, it has {}", length, size));
    }
    if (u32(16) != 0x4E4F534A || 20 + jsonLength > length) {
        failInput(file, "", "has no complete JSON chunk first");
    }
    Container out{{text + 20, static_cast<std::size_t>(jsonLength)}, {}};
    const std::uint64_t binaryChunk = 20 + jsonLength;
    if (binaryChunk + 8 > length) return out;
    const std::uint64_t binaryLength = u32(binaryChunk);
    if (binaryChunk + 8 + binaryLength > length) {
        failInput(file, "", "has a binary chunk that reaches beyond the end of the file");
    }
    if (u32(binaryChunk + 4) == 0x004E4942) {
        out.binary = std::span(bytes).subspan(binaryChunk + 8, binaryLength);
    }
    return out;
}

/// Takes `key` out of `root`; an empty list where it is absent.
json taken(json& root, const char* key) {
    const auto found = root.find(key);
    if (found == root.end()) return json::array();
    json out = std::move(*found);
    root.erase(found);
    return out;
}

/// tinygltf's structs, many times the size of the JSON they are made of.
void chargeStructs(const json& root, MemoryBudget& budget) {
    const auto charge = [&](const json& owner, const char* key, std::size_t bytesEach,
                            const std::string& pointer) {
        const auto list = owner.find(key);
        if (list != owner.end()) budget.charge(list->size(), bytesEach, pointer, "its elements");
    };
    charge(root, "accessors", sizeof(tinygltf::Accessor), "/accessors");
    charge(root, "animations", sizeof(tinygltf::Animation), "/animations");
    charge(root, "bufferViews", sizeof(tinygltf::BufferView), "/bufferViews");
    charge(root, "cameras", sizeof(tinygltf::Camera), "/cameras");
    charge(root, "images", sizeof(tinygltf::Image), "/images");
    charge(root, "materials", sizeof(tinygltf::Material), "/materials");
    charge(root, "meshes", sizeof(tinygltf::Mesh), "/meshes");
    charge(root, "nodes", sizeof(tinygltf::Node), "/nodes");
    charge(root, "samplers", sizeof(tinygltf::Sampler), "/samplers");
    charge(root, "scenes", sizeof(tinygltf::Scene), "/scenes");
    charge(root, "skins", sizeof(tinygltf::Skin), "/skins");
    charge(root, "textures", sizeof(tinygltf::Texture), "/textures");
    for (const json& mesh : root.value("meshes", json::array())) {
        charge(mesh, "primitives", sizeof(tinygltf::Primitive), "/meshes");
    }
    for (const json& animation : root.value("animations", json::array())) {
        charge(animation, "channels", sizeof(tinygltf::AnimationChannel), "/animations");
        charge(animation, "samplers", sizeof(tinygltf::AnimationSampler), "/animations");
    }
}

/// Lets accessors without a buffer view, which are zeros and legal for indices too, refer to a view
/// behind the last one: tinygltf refuses indices without. Undone by detachZeros().
void attachZeros(json& root) {
    if (!root.contains("accessors")) return;
    json& views = root["bufferViews"];
    if (views.is_null()) views = json::array();
    const std::size_t zeros = views.size();
    views.push_back({{"buffer", 0}, {"byteLength", 1}});
    for (json& accessor : root["accessors"]) {
        if (accessor.contains("bufferView")) {
            // An index of that very number must not become valid by this.
            if (accessor["bufferView"] == zeros) accessor["bufferView"] = kMaxIndex;
        } else {
            accessor["bufferView"] = zeros;
        }
    }
}

void detachZeros(tinygltf::Model& model) {
    if (model.accessors.empty()) return;
    model.bufferViews.pop_back();
    const int zeros = static_cast<int>(model.bufferViews.size());
    for (tinygltf::Accessor& accessor : model.accessors) {
        if (accessor.bufferView == zeros) accessor.bufferView = -1;
    }
}

void readBuffers(const json& buffers, const fs::path& file, std::span<const unsigned char> binary,
                 tinygltf::Model& model, MemoryBudget& budget) {
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const json& in = buffers[i];
        const std::string pointer = fmt::format("/buffers/{}", i);
        tinygltf::Buffer buffer;
        if (in.contains("uri")) {
            buffer.data = readUri(in["uri"].get<std::string>(), file, pointer + "/uri", budget);
        } else if (i == 0) {
            budget.charge(binary.size(), 1, pointer, "the binary chunk");
            buffer.data.assign(binary.begin(), binary.end());
        }
        const auto promised = in["byteLength"].get<std::size_t>();
        if (buffer.data.size() < promised) {
            failInput(file, pointer,
                      fmt::format("promises {} bytes and has {}", promised, buffer.data.size()));
        }
        buffer.data.resize(promised);
        model.buffers.push_back(std::move(buffer));
    }
}

void readImages(const json& images, tinygltf::Model& model) {
    for (const json& in : images) {
        tinygltf::Image image;
        image.uri = in.value("uri", "");
        image.bufferView = in.value("bufferView", -1);
        if (in.contains("name") && in["name"].is_string()) image.name = in["name"];
        model.images.push_back(std::move(image));
    }
}

void readSkins(const json& skins, tinygltf::Model& model) {
    for (const json& in : skins) {
        tinygltf::Skin skin;
        skin.inverseBindMatrices = in.value("inverseBindMatrices", -1);
        skin.joints = in["joints"].get<std::vector<int>>();
        model.skins.push_back(std::move(skin));
    }
}

void checkBufferViews(const fs::path& file, const tinygltf::Model& model) {
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
        const tinygltf::BufferView& view = model.bufferViews[i];
        const std::string pointer = fmt::format("/bufferViews/{}", i);
        if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size()) {
            failInput(file, pointer,
                      fmt::format("buffer {} does not exist; the file has {}", view.buffer,
                                  model.buffers.size()));
        }
        const std::size_t size = model.buffers[view.buffer].data.size();
        if (view.byteOffset > size || view.byteLength > size - view.byteOffset) {
            failInput(file, pointer,
                      fmt::format("bytes {} to {} lie beyond its buffer of {} bytes",
                                  view.byteOffset, view.byteOffset + view.byteLength, size));
        }
    }
}

}  // namespace

tinygltf::Model readGltf(const fs::path& file, MemoryBudget& budget) {
    std::error_code error;
    if (!fs::exists(file, error)) failInput(file, "", "does not exist");
    const Bytes bytes = readBytes(file, "", file, "", budget);
    const Container chunks = chunksOf(file, bytes);
    tinygltf::Model model;
    std::string complaint, warning;
    try {
        json root = parseGltfJson(chunks.json, file, budget);
        chargeStructs(root, budget);
        const json buffers = taken(root, "buffers"), images = taken(root, "images"),
                   skins = taken(root, "skins");
        attachZeros(root);
        const std::string text = root.dump();
        tinygltf::TinyGLTF parser;
        parser.SetFsCallbacks({});  // nothing is left that it would read
        parser.LoadASCIIFromString(&model, &complaint, &warning, text.data(),
                                   static_cast<unsigned>(text.size()), "");
        // tinygltf drops what it complains about and may still report success.
        if (!complaint.empty()) {
            failInput(file, "", oneLine(complaint.substr(0, complaint.find('\n')), 300));
        }
        detachZeros(model);
        readBuffers(buffers, file, chunks.binary, model, budget);
        readImages(images, model);
        readSkins(skins, model);
    } catch (const json::exception& e) {
        failInput(file, "", oneLine(e.what(), 300));
    }
    checkBufferViews(file, model);
    return model;
}

}  // namespace penumbra::scene_detail
