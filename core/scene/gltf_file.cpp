#include "core/scene/gltf_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"

namespace penumbra::scene_detail {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMaxFileBytes = (std::uintmax_t{1} << 31) - 1;  // tinygltf counts in int
constexpr int kMaxJsonDepth = 100;  // tinygltf recurses through `extras`
const std::string kFolderToken = "asset:";

std::optional<std::vector<unsigned char>> readBytes(const fs::path& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return std::nullopt;
    const std::uintmax_t size = fs::file_size(path, error);
    if (error || size > kMaxFileBytes) return std::nullopt;
    std::vector<unsigned char> bytes(size);
    std::ifstream in(path, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
        return std::nullopt;
    }
    return bytes;
}

// --- What tinygltf asks of the file system -------------------------------------------------------

struct Folder {
    fs::path path;
    std::string refusedUri;

    /// tinygltf looks for a URI in the folder it was given and in the working directory. The
    /// folder is a token, so that the second kind is told apart and refused.
    std::optional<fs::path> resolve(const std::string& asked) {
        const std::string prefix = kFolderToken + "/";
        if (!asked.starts_with(prefix)) return std::nullopt;
        const fs::path uri = asked.substr(prefix.size());
        bool inside = !uri.is_absolute();
        for (const fs::path& step : uri) inside = inside && step != "..";
        if (!inside) {
            refusedUri = uri.string();
            return std::nullopt;
        }
        return path / uri;
    }
};

bool fileExists(const std::string& asked, void* folder) {
    const std::optional<fs::path> path = static_cast<Folder*>(folder)->resolve(asked);
    std::error_code error;
    return path && fs::is_regular_file(*path, error);
}

std::string unexpanded(const std::string& path, void*) {
    return path;
}

bool readWholeFile(std::vector<unsigned char>* out, std::string* error, const std::string& asked,
                   void* folder) {
    const std::optional<fs::path> path = static_cast<Folder*>(folder)->resolve(asked);
    std::optional<std::vector<unsigned char>> bytes;
    if (path) bytes = readBytes(*path);
    if (!bytes) {
        *error += "cannot be read";
        return false;
    }
    *out = std::move(*bytes);
    return true;
}

bool writeNothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
}

/// An image in a buffer view is found again through the view once that has been checked.
bool keepEncoded(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                 const unsigned char* bytes, int size, void*) {
    image->as_is = true;
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

// --- Checks before tinygltf ----------------------------------------------------------------------

/// The JSON text of a file, after the binary container has been checked if it is one.
std::string_view jsonText(const fs::path& file, std::span<const unsigned char> bytes, bool binary) {
    const char* const text = reinterpret_cast<const char*>(bytes.data());
    if (!binary) return {text, bytes.size()};
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
    const std::uint64_t binaryChunk = 20 + jsonLength;
    if (binaryChunk + 8 <= length && binaryChunk + 8 + u32(binaryChunk) > length) {
        failInput(file, "", "has a binary chunk that reaches beyond the end of the file");
    }
    return {text + 20, static_cast<std::size_t>(jsonLength)};
}

const std::set<std::string_view> kIndexKeys = {
    "buffer", "bufferView", "byteLength", "byteOffset", "byteStride", "camera",  "componentType",
    "count",  "index",      "input",      "material",   "mesh",       "mode",    "node",
    "output", "sampler",    "skin",       "skeleton",   "source",     "texCoord"};
const std::set<std::string_view> kIndexListKeys = {"children", "joints"};

/// Extensions that change nothing a shadow depends on, and KHR_texture_transform, which
/// gltf_material refuses where it matters.
const std::set<std::string_view> kReadableExtensions = {
    "KHR_materials_anisotropy", "KHR_materials_clearcoat",   "KHR_materials_emissive_strength",
    "KHR_materials_ior",        "KHR_materials_iridescence", "KHR_materials_sheen",
    "KHR_materials_specular",   "KHR_materials_unlit",       "KHR_texture_transform"};

const std::set<std::string_view> kLists = {
    "accessors", "animations", "buffers",  "bufferViews", "cameras", "images",  "materials",
    "meshes",    "nodes",      "samplers", "scenes",      "skins",   "textures"};

class JsonCheck {
  public:
    explicit JsonCheck(const fs::path& file) : file_(file) {}

    void run(const json& root) {
        if (!root.is_object()) failInput(file_, "", "is not a JSON object");
        const json version = root.value(json::json_pointer("/asset/version"), json());
        if (!version.is_string() || !version.get<std::string>().starts_with("2.")) {
            failInput(file_, "/asset/version",
                      version.is_null() ? "is missing; only glTF 2.x is read"
                                        : version.dump() + " is not read; only glTF 2.x is");
        }
        extensions(root);
        if (root.contains("scene")) requireIndex(root["scene"], "/scene");
        for (const auto& [key, member] : root.items()) {
            if (member.is_structured()) walk(member, "/" + key, 1, kLists.contains(key));
        }
        lists(root);
        nodeTransforms(root);
    }

  private:
    /// `ours` is false below extras, extensions and what glTF does not know, whose keys mean
    /// whatever their author likes.
    void walk(const json& value, const std::string& pointer, int depth, bool ours) {
        if (depth > kMaxJsonDepth) failInput(file_, pointer.substr(0, 100), "is nested too deeply");
        if (value.is_array()) {
            for (std::size_t i = 0; i < value.size(); ++i) {
                if (value[i].is_structured()) {
                    walk(value[i], fmt::format("{}/{}", pointer, i), depth + 1, ours);
                }
            }
            return;
        }
        const bool attributes = pointer.ends_with("/attributes");
        for (const auto& [key, member] : value.items()) {
            const std::string at = pointer + "/" + key;
            if (ours && (attributes || kIndexKeys.contains(key) ||
                         (key == "indices" && !member.is_object()))) {
                requireIndex(member, at);
            }
            if (ours && kIndexListKeys.contains(key)) requireIndexList(member, at);
            if (member.is_structured()) {
                walk(member, at, depth + 1, ours && key != "extras" && key != "extensions");
            }
        }
    }

    void extensions(const json& root) {
        const json required = root.value("extensionsRequired", json::array());
        for (std::size_t i = 0; i < required.size(); ++i) {
            const std::string name = required[i].get<std::string>();
            if (!kReadableExtensions.contains(name)) {
                failInput(file_, fmt::format("/extensionsRequired/{}", i),
                          oneLine(name, 80) + " is not supported");
            }
        }
    }

    void requireIndex(const json& value, const std::string& pointer) {
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() > kMaxFileBytes) {
            failInput(file_, pointer, "must be a whole number from 0 to 2147483647");
        }
    }

    void requireIndexList(const json& value, const std::string& pointer) {
        if (!value.is_array()) failInput(file_, pointer, "must be a list of indices");
        for (std::size_t i = 0; i < value.size(); ++i) {
            requireIndex(value[i], fmt::format("{}/{}", pointer, i));
        }
    }

    void lists(const json& root) {
        for (const std::string_view name : kLists) {
            const std::string key(name);
            const std::string pointer = "/" + key;
            if (!root.contains(key)) continue;
            if (!root[key].is_array()) failInput(file_, pointer, "must be a list");
            for (std::size_t i = 0; i < root[key].size(); ++i) {
                if (!root[key][i].is_object()) {
                    failInput(file_, fmt::format("{}/{}", pointer, i), "must be an object");
                }
            }
        }
        if (!root.contains("scenes")) return;
        for (std::size_t i = 0; i < root["scenes"].size(); ++i) {
            const json& scene = root["scenes"][i];
            if (scene.contains("nodes")) {
                requireIndexList(scene["nodes"], fmt::format("/scenes/{}/nodes", i));
            }
        }
    }

    void nodeTransforms(const json& root) {
        static constexpr std::array<std::pair<const char*, std::size_t>, 4> kShapes = {
            {{"matrix", 16}, {"rotation", 4}, {"scale", 3}, {"translation", 3}}};
        if (!root.contains("nodes")) return;
        for (std::size_t i = 0; i < root["nodes"].size(); ++i) {
            const json& node = root["nodes"][i];
            for (const auto& [key, count] : kShapes) {
                if (!node.contains(key)) continue;
                bool good = node[key].is_array() && node[key].size() == count;
                for (const json& number : node[key]) good = good && number.is_number();
                if (!good) {
                    failInput(file_, fmt::format("/nodes/{}/{}", i, key),
                              fmt::format("must be a list of {} numbers", count));
                }
            }
        }
    }

    fs::path file_;
};

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

tinygltf::Model readGltf(const fs::path& file) {
    std::error_code error;
    if (!fs::exists(file, error)) failInput(file, "", "does not exist");
    const std::optional<std::vector<unsigned char>> bytes = readBytes(file);
    if (!bytes) {
        failInput(file, "",
                  fmt::format("is not a readable file of at most {} bytes", kMaxFileBytes));
    }
    const bool binary = bytes->size() >= 4 && std::memcmp(bytes->data(), "glTF", 4) == 0;

    Folder folder{file.parent_path(), ""};
    tinygltf::TinyGLTF parser;
    parser.SetImageLoader(keepEncoded, nullptr);
    parser.SetFsCallbacks({fileExists, unexpanded, readWholeFile, writeNothing, &folder});
    tinygltf::Model model;
    std::string complaint, warning;
    const unsigned size = static_cast<unsigned>(bytes->size());
    try {
        JsonCheck(file).run(json::parse(jsonText(file, *bytes, binary)));
        if (binary) {
            parser.LoadBinaryFromMemory(&model, &complaint, &warning, bytes->data(), size,
                                        kFolderToken);
        } else {
            parser.LoadASCIIFromString(&model, &complaint, &warning,
                                       reinterpret_cast<const char*>(bytes->data()), size,
                                       kFolderToken);
        }
    } catch (const InputError&) {
        throw;
    } catch (const std::exception& e) {
        failInput(file, "", oneLine(e.what(), 300));
    }
    if (!folder.refusedUri.empty()) {
        failInput(file, "",
                  fmt::format("refers to '{}', outside its own folder", folder.refusedUri));
    }
    // tinygltf drops what it complains about and may still report success.
    if (!complaint.empty()) {
        failInput(file, "", oneLine(complaint.substr(0, complaint.find('\n')), 300));
    }
    checkBufferViews(file, model);
    return model;
}

}  // namespace penumbra::scene_detail
