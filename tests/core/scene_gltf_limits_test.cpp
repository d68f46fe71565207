#include <filesystem>
#include <functional>
#include <limits>

#include "core/scene/supported_input.hpp"
#include "tests/core/scene_samples.hpp"

/// Input that means harm, beyond what SceneGltfBadFile has: what is new in skins, morph targets,
/// sparse accessors and instances, where files may lie, and how much memory they may ask for.
namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

struct SpoiltCase {
    const char* name;
    GltfFile (*make)();
    std::function<void(GltfFile&)> spoil;
    const char* expected;  ///< part of the message
};

class SceneGltfSpoilt : public ::testing::TestWithParam<SpoiltCase> {};

TEST_P(SceneGltfSpoilt, IsRefusedInOneLine) {
    GltfFile file = GetParam().make();
    GetParam().spoil(file);
    expectRefused(file, GetParam().expected);
}

json& sparseOf(GltfFile& f) {
    return f.root["accessors"][2]["sparse"];
}
json& instancingOf(GltfFile& f) {
    return f.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
}

const SpoiltCase kCases[] = {
    {"SparseTooMany", sparseInstancedFile, [](GltfFile& f) { sparseOf(f)["count"] = 4; },
     "/accessors/2/sparse/count: 4 is not from 1"},
    {"SparseNone", sparseInstancedFile, [](GltfFile& f) { sparseOf(f)["count"] = 0; },
     "/accessors/2/sparse/count"},
    {"SparseIndexOutOfRange", sparseInstancedFile, [](GltfFile& f) { f.bytes[2] = 3; },
     "/accessors/2/sparse/indices: index 3 at position 1"},
    {"SparseIndicesDecrease", sparseInstancedFile, [](GltfFile& f) { f.bytes[0] = 2; },
     "/accessors/2/sparse/indices: index 2 at position 1"},
    {"SparseIndexType", sparseInstancedFile,
     [](GltfFile& f) { sparseOf(f)["indices"]["componentType"] = 5126; },
     "/accessors/2/sparse/indices/componentType: 5126"},
    {"SparseIndicesBeyondView", sparseInstancedFile,
     [](GltfFile& f) { sparseOf(f)["indices"]["byteOffset"] = 2; }, "do not fit"},
    {"SparseValuesBeyondView", sparseInstancedFile,
     [](GltfFile& f) { sparseOf(f)["values"]["byteOffset"] = 4; }, "do not fit"},
    {"SparseViewOutOfRange", sparseInstancedFile,
     [](GltfFile& f) { sparseOf(f)["values"]["bufferView"] = 99; }, "buffer view 99"},
    {"ViewBehindTheLast", sparseInstancedFile,
     [](GltfFile& f) { f.root["accessors"][2]["bufferView"] = f.root["bufferViews"].size(); },
     "does not exist"},
    {"AttributeWithoutData", triangleFile,
     [](GltfFile& f) { f.root["accessors"][0].erase("bufferView"); },
     "/meshes/0/primitives/0/attributes/POSITION: has no buffer view"},
    {"InstanceCounts", sparseInstancedFile,
     [](GltfFile& f) {
         instancingOf(f)["SCALE"] = f.vec3s({{1, 1, 1}});
     },
     "SCALE: has 1 elements for 3 instances"},
    {"InstanceAttributesAbsent", sparseInstancedFile,
     [](GltfFile& f) { instancingOf(f) = json::object(); },
     "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes: has none of"},
    {"InstanceRotationZero", sparseInstancedFile,
     [](GltfFile& f) {
         instancingOf(f)["ROTATION"] = f.vec4s({{0, 0, 0, 1}, {0, 0, 0, 0}, {0, 0, 0, 1}});
     },
     "ROTATION element 1: is not a rotation"},
    {"InstanceNan", sparseInstancedFile,
     [](GltfFile& f) {
         const float nan = std::numeric_limits<float>::quiet_NaN();
         instancingOf(f)["TRANSLATION"] = f.vec3s({{0, 0, 0}, {0, nan, 0}, {0, 0, 0}});
     },
     "is NaN"},
    {"InstanceAccessorIsText", sparseInstancedFile,
     [](GltfFile& f) { instancingOf(f)["SCALE"] = "1"; }, "SCALE: must be a whole number"},
    {"SkinOutOfRange", deformingFile, [](GltfFile& f) { f.root["nodes"][0]["skin"] = 1; },
     "/nodes/0/skin: skin 1 does not exist"},
    {"JointOutOfRange", deformingFile, [](GltfFile& f) { f.root["skins"][0]["joints"][0] = 77; },
     "/skins/0/joints/0: node 77"},
    {"JointOfAnotherScene", deformingFile,
     [](GltfFile& f) { f.root["skins"][0]["joints"][1] = f.add("nodes", json::object()); },
     "is not in the scene of the mesh"},
    {"NoJoints", deformingFile, [](GltfFile& f) { f.root["skins"][0]["joints"] = json::array(); },
     "/skins/0/joints: is empty"},
    {"JointsAreNoList", deformingFile, [](GltfFile& f) { f.root["skins"][0]["joints"] = 3; },
     "/skins/0/joints: must be a list of indices"},
    {"JointBeyondTheSkin", deformingFile,
     [](GltfFile& f) {
         f.root["skins"][0]["joints"] = {1};
         f.root["skins"][0].erase("inverseBindMatrices");
     },
     "/nodes/0/skin: its mesh uses joint 1; the skin has 1"},
    {"TooFewInverseBindMatrices", deformingFile,
     [](GltfFile& f) {
         f.root["skins"][0]["joints"] = {1, 2, 0};
     },
     "/skins/0/inverseBindMatrices: has 2 matrices for 3 joints"},
    {"NoWeights", deformingFile,
     [](GltfFile& f) { primitiveOf(f)["attributes"].erase("WEIGHTS_0"); }, "has no WEIGHTS_0"},
    {"SkinWithoutJoints", deformingFile,
     [](GltfFile& f) { primitiveOf(f)["attributes"].erase("JOINTS_0"); }, "has no JOINTS_0"},
    {"NegativeWeight", deformingFile,
     [](GltfFile& f) {
         primitiveOf(f)["attributes"]["WEIGHTS_0"] =
             f.vec4s(std::vector<glm::vec4>(6, {2, -1, 0, 0}));
     },
     "WEIGHTS_0: weight -1 of vertex 0 is below 0"},
    {"TargetCount", deformingFile,
     [](GltfFile& f) {
         primitiveOf(f)["targets"][0]["POSITION"] = f.vec3s({{0, 0, 0}});
     },
     "/targets/0/POSITION: has 1 elements, POSITION has 6"},
    {"TargetsDiffer", deformingFile,
     [](GltfFile& f) {
         json other = primitiveOf(f);
         other.erase("targets");
         f.root["meshes"][0]["primitives"].push_back(other);
     },
     "/meshes/0/primitives/1/targets: has 0 morph targets; the first primitive has 1"},
    {"MorphWeightCount", deformingFile,
     [](GltfFile& f) {
         f.root["nodes"][0]["weights"] = {0, 1};
     },
     "/nodes/0/weights: has 2 weights for 1 morph targets"},
    {"WeightsOfNoTarget", deformingFile,
     [](GltfFile& f) { f.root["animations"][0]["channels"][2]["target"]["node"] = 1; },
     "animates weights of a node without morph targets"},
    {"WeightKeyCount", deformingFile,
     [](GltfFile& f) {
         f.root["animations"][0]["samplers"][2]["output"] = f.floats({0, 1});
     },
     "2 output values for 3 keys"},
    {"LightOutOfRange", maskedFile,
     [](GltfFile& f) { f.root["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 4; },
     "/nodes/1/extensions/KHR_lights_punctual/light: light 4"},
    {"LightType", maskedFile,
     [](GltfFile& f) {
         f.root["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "laser";
     },
     "'laser' is not one of point, spot, directional"},
    {"TransformOfText", maskedFile,
     [](GltfFile& f) {
         f.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
               ["KHR_texture_transform"]["scale"] = {1};
     },
     "KHR_texture_transform/scale: must be a list of 2 numbers"},
    {"AccessorType", triangleFile, [](GltfFile& f) { f.root["accessors"][0]["type"] = "VEC5"; },
     "/accessors/0/type: 'VEC5' is not one of SCALAR"},
    {"ComponentType", triangleFile,
     [](GltfFile& f) { f.root["accessors"][0]["componentType"] = 5130; },
     "/accessors/0/componentType: '5130' is not one of"},
    {"Stride", triangleFile, [](GltfFile& f) { f.root["bufferViews"][0]["byteStride"] = 256; },
     "/bufferViews/0/byteStride: 256"},
    {"BufferShorterThanItSays", triangleFile,
     [](GltfFile& f) {
         f.root["buffers"] = json::array(
             {{{"byteLength", 99}, {"uri", "data:application/octet-stream;base64,AAAA"}}});
     },
     "/buffers/0: promises 99 bytes and has 3"},
    {"UriOfAnotherScheme", triangleFile,
     [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "file:///etc/hostname"}}});
     },
     "/buffers/0/uri: refers to 'file:///etc/hostname', outside"},
    {"UriOfANetwork", triangleFile,
     [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "http://a.b/c.bin"}}});
     },
     "/buffers/0/uri: refers to 'http://a.b/c.bin', outside"},
    {"UriOfADevice", triangleFile,
     [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "."}}});
     },
     "not a readable file"},
};

INSTANTIATE_TEST_SUITE_P(All, SceneGltfSpoilt, ::testing::ValuesIn(kCases),
                         [](const auto& each) { return std::string(each.param.name); });

// --- Where files may lie -------------------------------------------------------------------------

TEST(SceneGltfLimits, LinksThatLeadOutOfTheFolderAreRefused) {
    const TempFolder outside, folder;
    GltfFile file = triangleFile();
    outside.write("secret.bin", file.bytes);
    fs::create_symlink(outside.path() / "secret.bin", folder.path() / "link.bin");
    fs::create_directory_symlink(outside.path(), folder.path() / "sub");
    for (const char* uri : {"link.bin", "sub/secret.bin", "%73ub/secret.bin"}) {
        file.root["buffers"] = json::array({{{"byteLength", file.bytes.size()}, {"uri", uri}}});
        EXPECT_NE(failureOf(folder.write("asset.gltf", file.gltf()), folder.library())
                      .find("outside its own folder"),
                  std::string::npos)
            << uri;
    }
}

TEST(SceneGltfLimits, LinksInsideTheFolderAndALinkToTheFolderAreFollowed) {
    const TempFolder folder, elsewhere;
    GltfFile file = triangleFile();
    fs::create_directory(folder.path() / "data");
    folder.write("data/real.bin", file.bytes);
    fs::create_symlink("data/real.bin", folder.path() / "link.bin");
    fs::create_directory_symlink(folder.path(), elsewhere.path() / "asset");
    file.root["buffers"] = json::array({{{"byteLength", file.bytes.size()}, {"uri", "link.bin"}}});
    folder.write("asset.gltf", file.gltf());
    EXPECT_EQ(failureOf(folder.path() / "asset.gltf", folder.library()), "");
    EXPECT_EQ(failureOf(elsewhere.path() / "asset/asset.gltf", folder.library()), "");
}

TEST(SceneGltfLimits, AnImageThatNoMaterialNeedsIsNeverRead) {
    GltfFile file = triangleFile();
    file.add("images", {{"uri", "../secret.png"}});
    file.add("textures", {{"source", 0}});
    file.add("materials", {{"normalTexture", {{"index", 0}}}});
    const TempFolder folder;
    EXPECT_EQ(failureOf(folder.write("asset.gltf", file.gltf()), folder.library()), "");
}

// --- Memory --------------------------------------------------------------------------------------

std::string failureWithin(const TempFolder& folder, const std::string& content,
                          std::uint64_t maxMemoryBytes) {
    LoadOptions options;
    options.maxMemoryBytes = maxMemoryBytes;
    try {
        loadScene(folder.write("asset.gltf", content).string(), folder.library(), options);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(SceneGltfLimits, MemoryIsBoundedAndTheBoundMayBeSet) {
    const TempFolder folder;
    const std::string file = triangleFile().gltf();
    EXPECT_EQ(failureWithin(folder, file, 1 << 20), "");
    const std::string message = failureWithin(folder, file, 1 << 10);
    EXPECT_NE(message.find("--max-memory is 0.0009766 MiB"), std::string::npos) << message;
}

TEST(SceneGltfLimits, ManyReferencesToOneAccessorAreBounded) {
    // 20000 primitives of 3000 triangles each, that all lie in one accessor of a point.
    GltfFile file;
    const int position = file.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const int indices = file.u16s(std::vector<std::uint16_t>(9000, 0));
    json primitives = json::array();
    for (int i = 0; i < 20000; ++i)
        primitives.push_back({{"attributes", {{"POSITION", position}}}, {"indices", indices}});
    file.node({{"mesh", file.add("meshes", {{"primitives", primitives}})}});
    const TempFolder folder;
    const std::string message = failureWithin(folder, file.gltf(), 256 << 20);
    EXPECT_NE(message.find("--max-memory"), std::string::npos) << message;
    EXPECT_NE(message.find("/meshes/0/primitives/"), std::string::npos) << message;
}

TEST(SceneGltfLimits, AccessorsOfZerosAreBoundedBeforeTheyAreMade) {
    GltfFile file = triangleFile();
    const int zeros =
        file.add("accessors",
                 {{"componentType", GltfFile::kU32}, {"type", "SCALAR"}, {"count", 2147483646}});
    file.root["meshes"][0]["primitives"][0]["indices"] = zeros;
    const TempFolder folder;
    EXPECT_NE(failureWithin(folder, file.gltf(), kDefaultMaxMemoryBytes).find("--max-memory"),
              std::string::npos);
}

TEST(SceneGltfLimits, InstancesOfALargeMeshAreBounded) {
    GltfFile file;
    const std::vector<glm::vec3> many(30000, {0, 0, 1});
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 10000; ++i)
        corners.insert(corners.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const int mesh = file.mesh({{"attributes", {{"POSITION", file.vec3s(corners)}}}});
    const int places = file.vec3s(many);
    file.node({{"mesh", mesh},
               {"extensions",
                {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
    const TempFolder folder;
    const std::string message = failureWithin(folder, file.gltf(), kDefaultMaxMemoryBytes);
    EXPECT_NE(message.find("more than 100000000 triangles"), std::string::npos) << message;
}

TEST(SceneGltfLimits, ALongListOfEmptyObjectsIsBounded) {
    std::string text = R"({"asset":{"version":"2.0"},"materials":[{})";
    for (int i = 0; i < 100000; ++i) text += ",{}";
    const TempFolder folder;
    const std::string message = failureWithin(folder, text + "]}", 64 << 20);
    EXPECT_NE(message.find("--max-memory"), std::string::npos) << message;
}

TEST(SceneGltfLimits, HugeNumbersAreRefused) {
    const TempFolder folder;
    for (const char* text : {R"({"asset":{"version":"2.0"},"extras":1e999})",
                             R"({"asset":{"version":"2.0"},"scene":99999999999999999999999})"}) {
        EXPECT_NE(failureWithin(folder, text, kDefaultMaxMemoryBytes), "") << text;
    }
}

// --- The table -----------------------------------------------------------------------------------

TEST(SceneGltfLimits, EveryRefusedExtensionIsRefusedByNameAndEveryOtherIsRead) {
    const TempFolder folder;
    for (const SupportedInput& input : supportedInputs()) {
        if (input.kind == SupportedInput::Kind::limit) continue;
        GltfFile file = triangleFile();
        file.root["extensionsRequired"] = {input.id};
        const std::string message =
            failureOf(folder.write("asset.gltf", file.gltf()), folder.library());
        if (input.kind == SupportedInput::Kind::refused) {
            EXPECT_NE(message.find("/extensionsRequired/0: " + std::string(input.id) +
                                   " is not supported"),
                      std::string::npos)
                << message;
        } else {
            EXPECT_EQ(message, "") << input.id;
        }
    }
}

}  // namespace
}  // namespace penumbra::testing
