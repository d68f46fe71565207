#include "core/scene/gltf_json.hpp"

#include <fmt/format.h>

#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/scene/input_text.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

using nlohmann::json;

/// What one JSON value may cost: a member of nlohmann's tree here and in tinygltf, and a
/// tinygltf::Value where it lies in an extension. Members of tinygltf's structs are charged in
/// gltf_file.
constexpr std::uint64_t kBytesPerValue = 512;

/// Measures a text before its tree is built.
class Measure : public nlohmann::json_sax<json> {
  public:
    std::uint64_t values = 0;
    bool tooDeep = false;
    std::string syntaxError;

    bool null() override { return count(); }
    bool boolean(bool) override { return count(); }
    bool number_integer(number_integer_t) override { return count(); }
    bool number_unsigned(number_unsigned_t) override { return count(); }
    bool number_float(number_float_t, const string_t&) override { return count(); }
    bool string(string_t&) override { return count(); }
    bool binary(binary_t&) override { return count(); }
    bool key(string_t&) override { return true; }
    bool start_object(std::size_t) override { return open(); }
    bool end_object() override { return close(); }
    bool start_array(std::size_t) override { return open(); }
    bool end_array() override { return close(); }
    bool parse_error(std::size_t, const std::string&, const json::exception& e) override {
        syntaxError = e.what();
        return false;
    }

  private:
    bool count() {
        ++values;
        return true;
    }
    bool open() {
        count();
        tooDeep = ++depth_ > kMaxJsonDepth;
        return !tooDeep;
    }
    bool close() {
        --depth_;
        return true;
    }
    int depth_ = 0;
};

enum class Type { index, indices, number, numbers, text, boolean, object, objects, texts };

struct Rule {
    const char* path;  ///< of the owner, list indices left out
    const char* key;   ///< "*": every member
    Type type;
    bool required = false;
    std::size_t count = 0;   ///< of `numbers`; 0: any
    const char* oneOf = "";  ///< the valid values of a text or index, separated by ", "; "": any
};

constexpr bool kRequired = true;

/// glTF 2.0 specification, section 5 (properties reference), as far as it is read here or by
/// tinygltf.
constexpr Rule kRules[] = {
    {"", "asset", Type::object, kRequired},
    {"", "scene", Type::index},
    {"", "extensionsRequired", Type::texts},
    {"", "extensionsUsed", Type::texts},
    {"", "extensions", Type::object},
    {"", "accessors", Type::objects},
    {"", "animations", Type::objects},
    {"", "buffers", Type::objects},
    {"", "bufferViews", Type::objects},
    {"", "cameras", Type::objects},
    {"", "images", Type::objects},
    {"", "materials", Type::objects},
    {"", "meshes", Type::objects},
    {"", "nodes", Type::objects},
    {"", "samplers", Type::objects},
    {"", "scenes", Type::objects},
    {"", "skins", Type::objects},
    {"", "textures", Type::objects},
    {"/accessors", "bufferView", Type::index},
    {"/accessors", "byteOffset", Type::index},
    {"/accessors", "componentType", Type::index, kRequired, 0,
     "5120, 5121, 5122, 5123, 5125, 5126"},
    {"/accessors", "count", Type::index, kRequired},
    {"/accessors", "normalized", Type::boolean},
    {"/accessors", "type", Type::text, kRequired, 0, "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4"},
    {"/accessors", "min", Type::numbers},
    {"/accessors", "max", Type::numbers},
    {"/accessors", "sparse", Type::object},
    {"/accessors/sparse", "count", Type::index, kRequired},
    {"/accessors/sparse", "indices", Type::object, kRequired},
    {"/accessors/sparse", "values", Type::object, kRequired},
    {"/accessors/sparse/indices", "bufferView", Type::index, kRequired},
    {"/accessors/sparse/indices", "byteOffset", Type::index},
    {"/accessors/sparse/indices", "componentType", Type::index, kRequired},
    {"/accessors/sparse/values", "bufferView", Type::index, kRequired},
    {"/accessors/sparse/values", "byteOffset", Type::index},
    {"/animations", "channels", Type::objects, kRequired},
    {"/animations", "samplers", Type::objects, kRequired},
    {"/animations/channels", "sampler", Type::index, kRequired},
    {"/animations/channels", "target", Type::object, kRequired},
    {"/animations/channels/target", "node", Type::index},
    {"/animations/channels/target", "path", Type::text, kRequired},
    {"/animations/samplers", "input", Type::index, kRequired},
    {"/animations/samplers", "output", Type::index, kRequired},
    {"/animations/samplers", "interpolation", Type::text},
    {"/buffers", "byteLength", Type::index, kRequired},
    {"/buffers", "uri", Type::text},
    {"/bufferViews", "buffer", Type::index, kRequired},
    {"/bufferViews", "byteLength", Type::index, kRequired},
    {"/bufferViews", "byteOffset", Type::index},
    {"/bufferViews", "byteStride", Type::index},
    {"/bufferViews", "target", Type::index},
    {"/cameras", "type", Type::text, kRequired, 0, "perspective, orthographic"},
    {"/cameras", "perspective", Type::object},
    {"/cameras", "orthographic", Type::object},
    {"/cameras/perspective", "yfov", Type::number, kRequired},
    {"/cameras/perspective", "znear", Type::number, kRequired},
    {"/cameras/perspective", "zfar", Type::number},
    {"/cameras/perspective", "aspectRatio", Type::number},
    {"/cameras/orthographic", "xmag", Type::number, kRequired},
    {"/cameras/orthographic", "ymag", Type::number, kRequired},
    {"/cameras/orthographic", "znear", Type::number, kRequired},
    {"/cameras/orthographic", "zfar", Type::number, kRequired},
    {"/images", "uri", Type::text},
    {"/images", "bufferView", Type::index},
    {"/materials", "pbrMetallicRoughness", Type::object},
    {"/materials", "normalTexture", Type::object},
    {"/materials", "occlusionTexture", Type::object},
    {"/materials", "emissiveTexture", Type::object},
    {"/materials", "emissiveFactor", Type::numbers, false, 3},
    {"/materials", "alphaMode", Type::text},
    {"/materials", "alphaCutoff", Type::number},
    {"/materials", "doubleSided", Type::boolean},
    {"/materials", "extensions", Type::object},
    {"/materials/normalTexture", "index", Type::index, kRequired},
    {"/materials/occlusionTexture", "index", Type::index, kRequired},
    {"/materials/emissiveTexture", "index", Type::index, kRequired},
    {"/materials/normalTexture", "texCoord", Type::index},
    {"/materials/occlusionTexture", "texCoord", Type::index},
    {"/materials/emissiveTexture", "texCoord", Type::index},
    {"/materials/extensions", "KHR_materials_emissive_strength", Type::object},
    {"/materials/extensions/KHR_materials_emissive_strength", "emissiveStrength", Type::number},
    {"/materials/pbrMetallicRoughness", "baseColorFactor", Type::numbers, false, 4},
    {"/materials/pbrMetallicRoughness", "metallicFactor", Type::number},
    {"/materials/pbrMetallicRoughness", "roughnessFactor", Type::number},
    {"/materials/pbrMetallicRoughness", "baseColorTexture", Type::object},
    {"/materials/pbrMetallicRoughness", "metallicRoughnessTexture", Type::object},
    {"/materials/pbrMetallicRoughness/metallicRoughnessTexture", "index", Type::index, kRequired},
    {"/materials/pbrMetallicRoughness/metallicRoughnessTexture", "texCoord", Type::index},
    {"/materials/pbrMetallicRoughness/baseColorTexture", "index", Type::index, kRequired},
    {"/materials/pbrMetallicRoughness/baseColorTexture", "texCoord", Type::index},
    {"/materials/pbrMetallicRoughness/baseColorTexture", "extensions", Type::object},
    {"/materials/pbrMetallicRoughness/baseColorTexture/extensions", "KHR_texture_transform",
     Type::object},
    {"/materials/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform", "offset",
     Type::numbers, false, 2},
    {"/materials/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform",
     "rotation", Type::number},
    {"/materials/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform", "scale",
     Type::numbers, false, 2},
    {"/materials/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform",
     "texCoord", Type::index},
    {"/meshes", "primitives", Type::objects, kRequired},
    {"/meshes", "weights", Type::numbers},
    {"/meshes/primitives", "attributes", Type::object, kRequired},
    {"/meshes/primitives", "indices", Type::index},
    {"/meshes/primitives", "material", Type::index},
    {"/meshes/primitives", "mode", Type::index},
    {"/meshes/primitives", "targets", Type::objects},
    {"/meshes/primitives/attributes", "*", Type::index},
    {"/meshes/primitives/targets", "*", Type::index},
    {"/nodes", "camera", Type::index},
    {"/nodes", "children", Type::indices},
    {"/nodes", "matrix", Type::numbers, false, 16},
    {"/nodes", "mesh", Type::index},
    {"/nodes", "rotation", Type::numbers, false, 4},
    {"/nodes", "scale", Type::numbers, false, 3},
    {"/nodes", "skin", Type::index},
    {"/nodes", "translation", Type::numbers, false, 3},
    {"/nodes", "weights", Type::numbers},
    {"/nodes", "extensions", Type::object},
    {"/nodes/extensions", "KHR_lights_punctual", Type::object},
    {"/nodes/extensions/KHR_lights_punctual", "light", Type::index, kRequired},
    {"/nodes/extensions", "EXT_mesh_gpu_instancing", Type::object},
    {"/nodes/extensions/EXT_mesh_gpu_instancing", "attributes", Type::object, kRequired},
    {"/nodes/extensions/EXT_mesh_gpu_instancing/attributes", "*", Type::index},
    {"/samplers", "magFilter", Type::index},
    {"/samplers", "minFilter", Type::index},
    {"/samplers", "wrapS", Type::index},
    {"/samplers", "wrapT", Type::index},
    {"/scenes", "nodes", Type::indices},
    {"/skins", "inverseBindMatrices", Type::index},
    {"/skins", "skeleton", Type::index},
    {"/skins", "joints", Type::indices, kRequired},
    {"/textures", "sampler", Type::index},
    {"/textures", "source", Type::index},
    {"/extensions", "KHR_lights_punctual", Type::object},
    {"/extensions/KHR_lights_punctual", "lights", Type::objects, kRequired},
    {"/extensions/KHR_lights_punctual/lights", "type", Type::text, kRequired, 0,
     "point, spot, directional"},
    {"/extensions/KHR_lights_punctual/lights", "color", Type::numbers, false, 3},
    {"/extensions/KHR_lights_punctual/lights", "intensity", Type::number},
    {"/extensions/KHR_lights_punctual/lights", "range", Type::number},
    {"/extensions/KHR_lights_punctual/lights", "spot", Type::object},
};

/// The rules of each owner, by its path.
const std::multimap<std::string, Rule>& rulesByPath() {
    static const std::multimap<std::string, Rule> rules = [] {
        std::multimap<std::string, Rule> map;
        for (const Rule& rule : kRules) map.emplace(rule.path, rule);
        return map;
    }();
    return rules;
}

class SchemaCheck {
  public:
    explicit SchemaCheck(const std::filesystem::path& file) : file_(file) {}

    /// `path` is `pointer` without indices of lists.
    void object(const json& owner, const std::string& path, const std::string& pointer) const {
        const auto [first, last] = rulesByPath().equal_range(path);
        for (auto each = first; each != last; ++each) {
            const Rule& rule = each->second;
            if (std::string_view(rule.key) == "*") {
                for (const auto& [key, member] : owner.items()) {
                    check(member, rule, path + "/*", pointer + "/" + key);
                }
            } else if (const auto member = owner.find(rule.key); member != owner.end()) {
                check(*member, rule, path + "/" + rule.key, pointer + "/" + rule.key);
            } else if (rule.required) {
                fail(pointer, fmt::format("has no '{}'", rule.key));
            }
        }
    }

  private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
        failInput(file_, pointer, what);
    }

    void check(const json& value, const Rule& rule, const std::string& path,
               const std::string& pointer) const {
        switch (rule.type) {
            case Type::index:
                index(value, pointer);
                return oneOf(value.dump(), rule.oneOf, pointer);
            case Type::indices:
                if (!value.is_array()) fail(pointer, "must be a list of indices");
                for (std::size_t i = 0; i < value.size(); ++i) {
                    index(value[i], fmt::format("{}/{}", pointer, i));
                }
                return;
            case Type::number:
                if (!value.is_number()) fail(pointer, "must be a number");
                return;
            case Type::numbers:
                return numbers(value, rule.count, pointer);
            case Type::text:
                if (!value.is_string()) fail(pointer, "must be a string");
                return oneOf(value.get<std::string>(), rule.oneOf, pointer);
            case Type::boolean:
                if (!value.is_boolean()) fail(pointer, "must be true or false");
                return;
            case Type::object:
                if (!value.is_object()) fail(pointer, "must be an object");
                return object(value, path, pointer);
            case Type::objects:
                if (!value.is_array()) fail(pointer, "must be a list");
                for (std::size_t i = 0; i < value.size(); ++i) {
                    const std::string at = fmt::format("{}/{}", pointer, i);
                    if (!value[i].is_object()) fail(at, "must be an object");
                    object(value[i], path, at);
                }
                return;
            case Type::texts:
                if (!value.is_array()) fail(pointer, "must be a list");
                for (std::size_t i = 0; i < value.size(); ++i) {
                    if (!value[i].is_string()) {
                        fail(fmt::format("{}/{}", pointer, i), "must be a string");
                    }
                }
                return;
        }
    }

    void index(const json& value, const std::string& pointer) const {
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() > kMaxIndex) {
            fail(pointer, fmt::format("must be a whole number from 0 to {}", kMaxIndex));
        }
    }

    void oneOf(const std::string& word, const std::string& valid,
               const std::string& pointer) const {
        if (valid.empty() || (", " + valid + ",").find(" " + word + ",") != std::string::npos)
            return;
        fail(pointer, fmt::format("'{}' is not one of {}", oneLine(word, 40), valid));
    }

    void numbers(const json& value, std::size_t count, const std::string& pointer) const {
        bool good = value.is_array() && (count == 0 || value.size() == count);
        for (const json& number : value) good = good && number.is_number();
        if (good) return;
        fail(pointer, count == 0 ? "must be a list of numbers"
                                 : fmt::format("must be a list of {} numbers", count));
    }

    std::filesystem::path file_;
};

void checkVersion(const json& root, const std::filesystem::path& file) {
    const json version = root.value(json::json_pointer("/asset/version"), json());
    if (version.is_string() && version.get<std::string>().starts_with("2.")) return;
    failInput(file, "/asset/version",
              version.is_null() ? "is missing; only glTF 2.x is read"
                                : oneLine(version.dump(), 80) + " is not read; only glTF 2.x is");
}

/// What depends on two members at once.
void checkPairs(const json& root, const std::filesystem::path& file) {
    for (std::size_t i = 0; root.contains("cameras") && i < root["cameras"].size(); ++i) {
        const json& camera = root["cameras"][i];
        const std::string type = camera["type"].get<std::string>();
        if (!camera.contains(type)) {
            failInput(file, fmt::format("/cameras/{}", i), fmt::format("has no '{}'", type));
        }
    }
    for (std::size_t i = 0; root.contains("bufferViews") && i < root["bufferViews"].size(); ++i) {
        const auto stride = root["bufferViews"][i].value("byteStride", std::uint64_t{0});
        if (stride > 252 || stride % 4 != 0) {
            failInput(file, fmt::format("/bufferViews/{}/byteStride", i),
                      fmt::format("{} is not a multiple of 4 up to 252", stride));
        }
    }
}

void checkRequiredExtensions(const json& root, const std::filesystem::path& file) {
    const auto required = root.find("extensionsRequired");
    if (required == root.end()) return;
    for (std::size_t i = 0; i < required->size(); ++i) {
        const std::string name = (*required)[i].get<std::string>();
        const SupportedInput* known = findExtension(name);
        if (known && known->kind != SupportedInput::Kind::refused) continue;
        failInput(file, fmt::format("/extensionsRequired/{}", i),
                  fmt::format("{} is not supported{}{}", oneLine(name, 80), known ? ": " : "",
                              known ? known->doc : ""));
    }
}

}  // namespace

json parseGltfJson(std::string_view text, const std::filesystem::path& file, MemoryBudget& budget) {
    Measure measure;
    json::sax_parse(text.begin(), text.end(), &measure);
    if (measure.tooDeep) {
        failInput(file, "", fmt::format("is nested more than {} levels deep", kMaxJsonDepth));
    }
    if (!measure.syntaxError.empty()) failInput(file, "", oneLine(measure.syntaxError, 300));
    budget.charge(2 * text.size(), 1, "", "parsing its JSON");  // strings, here and in tinygltf
    budget.charge(measure.values, kBytesPerValue, "", "parsing its JSON");
    json root = json::parse(text);
    if (!root.is_object()) failInput(file, "", "is not a JSON object");
    checkVersion(root, file);
    checkRequiredExtensions(root, file);
    SchemaCheck(file).object(root, "", "");
    checkPairs(root, file);
    return root;
}

}  // namespace penumbra::scene_detail
