#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/scene/scene.hpp"

/// What the scene tests write their input with.
namespace penumbra::testing {

using nlohmann::json;

/// A folder of its own for one test, removed with it.
class TempFolder {
  public:
    TempFolder() {
        static std::atomic<int> count{0};
        path_ = std::filesystem::temp_directory_path() /
                ("penumbra_scene_" + std::to_string(getpid()) + "_" + std::to_string(++count));
        std::filesystem::create_directories(path_);
    }
    ~TempFolder() { std::filesystem::remove_all(path_); }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    std::filesystem::path write(const std::string& name, const std::string& content) const {
        std::ofstream(path_ / name, std::ios::binary) << content;
        return path_ / name;
    }
    const std::filesystem::path& path() const { return path_; }
    /// A library whose scripts and assets both lie in this folder.
    SceneLibrary library() const { return {path_, path_}; }

  private:
    std::filesystem::path path_;
};

inline std::string base64(const std::string& bytes) {
    static constexpr char kDigits[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            group =
                group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
        }
    }
    return out;
}

/// A glTF file in the making: JSON that a test may change at will, and one buffer.
struct GltfFile {
    json root = {{"asset", {{"version", "2.0"}}},
                 {"scene", 0},
                 {"scenes", json::array({{{"nodes", json::array()}}})},
                 {"nodes", json::array()},
                 {"meshes", json::array()},
                 {"accessors", json::array()},
                 {"bufferViews", json::array()},
                 {"materials", json::array()}};
    std::string bytes;

    static constexpr int kU8 = 5121, kU16 = 5123, kU32 = 5125, kFloat = 5126;

    template <class T>
    int accessor(const std::vector<T>& data, int componentType, const char* type, std::size_t count,
                 bool normalized = false) {
        while (bytes.size() % 4 != 0) bytes += '\0';
        const std::size_t size = data.size() * sizeof(T);
        root["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
        bytes.append(reinterpret_cast<const char*>(data.data()), size);
        json accessor = {{"bufferView", root["bufferViews"].size() - 1},
                         {"componentType", componentType},
                         {"count", count},
                         {"type", type}};
        if (normalized) accessor["normalized"] = true;
        root["accessors"].push_back(accessor);
        return static_cast<int>(root["accessors"].size()) - 1;
    }
    int floats(const std::vector<float>& data) {
        return accessor(data, kFloat, "SCALAR", data.size());
    }
    int vec3s(const std::vector<glm::vec3>& data) {
        return accessor(data, kFloat, "VEC3", data.size());
    }
    int vec4s(const std::vector<glm::vec4>& data) {
        return accessor(data, kFloat, "VEC4", data.size());
    }
    int u16s(const std::vector<std::uint16_t>& data) {
        return accessor(data, kU16, "SCALAR", data.size());
    }

    int add(const char* list, json object) {
        root[list].push_back(std::move(object));
        return static_cast<int>(root[list].size()) - 1;
    }
    int mesh(json primitive) { return add("meshes", {{"primitives", json::array({primitive})}}); }
    /// A node at the root of the scene.
    int node(json object) {
        const int index = add("nodes", std::move(object));
        root["scenes"][0]["nodes"].push_back(index);
        return index;
    }
    /// A mesh of one quad c -u -v, +u -v, +u +v, -u +v: its front is cross(u, v).
    int quad(glm::vec3 c, glm::vec3 u, glm::vec3 v, int material = -1) {
        const int position = vec3s({c - u - v, c + u - v, c + u + v, c - u + v});
        json primitive = {{"attributes", {{"POSITION", position}}},
                          {"indices", u16s({0, 1, 2, 0, 2, 3})}};
        if (material >= 0) primitive["material"] = material;
        return mesh(primitive);
    }
    /// A single triangle with corners at 0, x and y.
    int triangle() {
        return mesh({{"attributes", {{"POSITION", vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}}}});
    }

    std::string gltf() const {
        json out = root;
        if (!out.contains("buffers") && !bytes.empty()) {
            out["buffers"] =
                json::array({{{"byteLength", bytes.size()},
                              {"uri", "data:application/octet-stream;base64," + base64(bytes)}}});
        }
        return out.dump();
    }
    std::string glb() const {
        json out = root;
        out["buffers"] = json::array({{{"byteLength", bytes.size()}}});
        std::string text = out.dump();
        while (text.size() % 4 != 0) text += ' ';
        std::string binary = bytes;
        while (binary.size() % 4 != 0) binary += '\0';
        const auto u32 = [](std::size_t value) {
            const auto word = static_cast<std::uint32_t>(value);
            return std::string(reinterpret_cast<const char*>(&word), 4);
        };
        return "glTF" + u32(2) + u32(12 + 8 + text.size() + 8 + binary.size()) + u32(text.size()) +
               "JSON" + text + u32(binary.size()) + std::string("BIN\0", 4) + binary;
    }
};

/// Red, half-transparent green / transparent blue, quarter white.
inline const std::string kRgbaPng =
    "data:image/"
    "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAFUlEQVR42mP4z8DwHwgbGMD0//"
    "8OAD8YB7qSpF8lAAAAAElFTkSuQmCC";
inline GltfFile triangleFile() {
    GltfFile file;
    file.node({{"mesh", file.triangle()}});
    return file;
}

/// A floor and a lamp at height 3 that faces down.
inline GltfFile lampFile(const json& lampNode = json::object()) {
    GltfFile file;
    file.add("materials", {{"emissiveFactor", {0, 2.0 / 3, 1}}, {"doubleSided", true}});
    file.node({{"mesh", file.quad({0, 0, 0}, {2, 0, 0}, {0, 0, -2})}});
    json node = lampNode;
    node["mesh"] = file.quad({0, 0, 0}, {0.5f, 0, 0}, {0, 0, 0.25f}, 0);
    node["name"] = "lamp";
    if (!node.contains("translation")) node["translation"] = {0, 3, 0};
    file.node(node);
    return file;
}

/// Loads `file` written as NAME.gltf into `folder`.
inline std::shared_ptr<const Scene> load(const TempFolder& folder, const GltfFile& file,
                                         const std::string& name = "asset.gltf") {
    return loadScene(folder.write(name, file.gltf()).string(), folder.library());
}

/// The message with which loading fails; empty when it does not. Every such message is one line.
inline std::string failureOf(const std::filesystem::path& path, const SceneLibrary& library) {
    try {
        loadScene(path.string(), library);
    } catch (const InputError& e) {
        const std::string message = e.what();
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        return message;
    }
    return "";
}

/// That the file is refused in a line that starts with its name and holds `expected`.
inline void expectRefused(const GltfFile& file, const std::string& expected) {
    const TempFolder folder;
    const auto path = folder.write("bad.gltf", file.gltf());
    const std::string message = failureOf(path, folder.library());
    EXPECT_TRUE(message.starts_with(path.string())) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message;
}

inline json& primitiveOf(GltfFile& file) {
    return file.root["meshes"][0]["primitives"][0];
}

inline glm::dvec3 worldCorner(const Scene& scene, const Geometry& geometry, std::size_t index) {
    return glm::dvec3(geometry.positions[geometry.indices[index]]) + scene.origin;
}

/// The geometric normal of a triangle by its winding.
inline glm::vec3 windingNormal(const Geometry& geometry, std::size_t triangle) {
    const auto corner = [&](int k) {
        return geometry.positions[geometry.indices[3 * triangle + k]];
    };
    return glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
}

inline void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    EXPECT_LE(glm::distance(a, b), tolerance)
        << a.x << " " << a.y << " " << a.z << " against " << b.x << " " << b.y << " " << b.z;
}

}  // namespace penumbra::testing
