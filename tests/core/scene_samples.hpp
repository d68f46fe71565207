#pragma once

#include "tests/core/scene_files.hpp"

/// Good assets that use much of glTF 2.0 at once: what is damaged in tests and what fuzzers start
/// from.
namespace penumbra::testing {

/// A bar of two joints with a morph target, all animated: rotation by CUBICSPLINE, translation by
/// STEP, weights by LINEAR. Two scenes, two cameras.
inline GltfFile deformingFile() {
    GltfFile file;
    const int position =
        file.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}, {1, 2, 0}});
    const int normal = file.vec3s(std::vector<glm::vec3>(6, {0, 0, 1}));
    const int joints = file.accessor<std::uint8_t>(
        {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, GltfFile::kU8,
        "VEC4", 6);
    const int weights = file.vec4s({{1, 0, 0, 0},
                                    {1, 0, 0, 0},
                                    {0.5f, 0.5f, 0, 0},
                                    {0.5f, 0.5f, 0, 0},
                                    {1, 0, 0, 0},
                                    {1, 0, 0, 0}});
    const int bulge = file.vec3s(std::vector<glm::vec3>(6, {0, 0, 0.25f}));
    const json primitive = {{"attributes",
                             {{"POSITION", position},
                              {"NORMAL", normal},
                              {"JOINTS_0", joints},
                              {"WEIGHTS_0", weights}}},
                            {"targets", json::array({{{"POSITION", bulge}}})},
                            {"mode", 5},
                            {"indices", file.u16s({0, 1, 2, 3, 4, 5})}};
    const int inverseBind = file.accessor<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                                                 GltfFile::kFloat, "MAT4", 2);
    file.node({{"mesh", file.mesh(primitive)}, {"skin", 0}, {"weights", {0.5}}, {"name", "bar"}});
    const int tip = file.add("nodes", {{"name", "tip"}, {"translation", {0, 1, 0}}});
    const int root = file.node({{"name", "root"}, {"children", {tip}}});
    file.add("skins", {{"joints", {root, tip}}, {"inverseBindMatrices", inverseBind}});
    const int times = file.floats({0, 1, 2});
    const glm::vec4 still(0), none(0, 0, 0, 1), turned(0, 0, std::sqrt(0.5f), std::sqrt(0.5f));
    const int rotations =
        file.vec4s({still, none, still, still, turned, still, still, none, still});
    const int translations = file.vec3s({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}});
    const int amounts = file.floats({0, 1, 0});
    const auto channel = [](int sampler, int node, const char* path) {
        return json{{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}};
    };
    file.add(
        "animations",
        {{"samplers",
          json::array({{{"input", times}, {"output", rotations}, {"interpolation", "CUBICSPLINE"}},
                       {{"input", times}, {"output", translations}, {"interpolation", "STEP"}},
                       {{"input", times}, {"output", amounts}}})},
         {"channels", json::array({channel(0, tip, "rotation"), channel(1, root, "translation"),
                                   channel(2, 0, "weights")})}});
    file.add("cameras",
             {{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.25}}}});
    file.node({{"camera", 0}, {"name", "front"}, {"translation", {0, 1, 5}}});
    file.node({{"camera", 0}, {"name", "left"}, {"translation", {-5, 1, 0}}});
    file.root["scenes"][0]["name"] = "day";
    file.root["scenes"].push_back({{"name", "night"}, {"nodes", {0, root}}});
    return file;
}

/// A masked quad whose coordinates are transformed, of quantised attributes, and a point light.
inline GltfFile maskedFile() {
    GltfFile file;
    file.root["extensionsUsed"] = {"KHR_mesh_quantization", "KHR_texture_transform",
                                   "KHR_lights_punctual"};
    file.root["extensionsRequired"] = {"KHR_mesh_quantization"};
    file.add("images", {{"uri", kRgbaPng}});
    file.add("samplers", {{"magFilter", 9728}});
    file.add("textures", {{"source", 0}, {"sampler", 0}});
    file.add(
        "materials",
        {{"alphaMode", "MASK"},
         {"pbrMetallicRoughness",
          {{"baseColorTexture",
            {{"index", 0},
             {"extensions",
              {{"KHR_texture_transform", {{"offset", {0.5, 0}}, {"scale", {0.5, 0.25}}}}}}}}}}});
    // Elements of 8 bytes: three shorts and padding.
    const int position = file.accessor<std::int16_t>(
        {0, 0, 0, 0, 200, 0, 0, 0, 200, 100, 0, 0, 0, 100, 0, 0}, 5122, "VEC3", 4);
    file.root["bufferViews"][0]["byteStride"] = 8;
    const int normal = file.accessor<std::int8_t>(
        {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, 5120, "VEC3", 4, true);
    file.root["bufferViews"][1]["byteStride"] = 4;
    const int uv =
        file.accessor<std::uint8_t>({0, 0, 1, 0, 1, 1, 0, 1, 0, 0}, GltfFile::kU8, "VEC2", 4);
    const int mesh =
        file.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}},
                   {"material", 0},
                   {"mode", 6}});
    file.node({{"mesh", mesh}, {"scale", {0.01, 0.01, 0.01}}});
    file.root["extensions"]["KHR_lights_punctual"]["lights"] =
        json::array({{{"type", "point"}, {"intensity", 3}}});
    file.node({{"name", "lamp"},
               {"translation", {1, 4, 2}},
               {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return file;
}

/// Three instances of a triangle whose accessor has no buffer view, only sparse values.
inline GltfFile sparseInstancedFile() {
    GltfFile file;
    const int which = file.accessor<std::uint16_t>({1, 2}, GltfFile::kU16, "SCALAR", 2);
    const int values = file.vec3s({{1, 0, 0}, {0, 1, 0}});
    const int position = file.add(
        "accessors", {{"componentType", GltfFile::kFloat},
                      {"type", "VEC3"},
                      {"count", 3},
                      {"sparse",
                       {{"count", 2},
                        {"indices", {{"bufferView", which}, {"componentType", GltfFile::kU16}}},
                        {"values", {{"bufferView", values}}}}}});
    const int translation = file.vec3s({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}});
    const int rotation = file.vec4s({{0, 0, 0, 1}, {0, 0, 1, 0}, {0, 0, 0, 1}});
    const int scale = file.vec3s({{1, 1, 1}, {1, 1, 1}, {2, 3, 1}});
    file.root["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", position}}}})},
               {"translation", {5, 0, 0}},
               {"extensions",
                {{"EXT_mesh_gpu_instancing",
                  {{"attributes",
                    {{"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}}}}}}}});
    return file;
}

}  // namespace penumbra::testing
