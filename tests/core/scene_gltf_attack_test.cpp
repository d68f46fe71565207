#include <sys/stat.h>

#include <functional>
#include <limits>

#include "tests/core/scene_samples.hpp"

/// What SceneGltfBadFile and SceneGltfSpoilt leave of an attacker's list: numbers that are no
/// sizes, URIs in disguise, the .glb container, depth, and magnitudes that overflow later on.
namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

void setBuffer(GltfFile& f, const json& byteLength, const std::string& uri) {
    f.root["buffers"] = json::array({{{"byteLength", byteLength}, {"uri", uri}}});
}

/// A second, animated value of the first node from `values` at 0 s and 1 s.
void animate(GltfFile& f, const char* path, int times, int values) {
    f.add("animations",
          {{"channels", json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}})},
           {"samplers", json::array({{{"input", times}, {"output", values}}})}});
}

void setTexture(GltfFile& f, const json& transform) {
    f.add("images", {{"uri", kRgbaPng}});
    f.add("textures", {{"source", 0}});
    f.add("materials",
          {{"pbrMetallicRoughness",
            {{"baseColorTexture",
              {{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}}}}}});
    primitiveOf(f)["material"] = 0;
    primitiveOf(f)["attributes"]["TEXCOORD_0"] =
        f.accessor<float>({0, 0, 1, 0, 0, 1}, GltfFile::kFloat, "VEC2", 3);
}

void setCamera(GltfFile& f, const char* type, const json& lens) {
    f.add("cameras", {{"type", type}, {type, lens}});
    f.root["nodes"][0]["camera"] = 0;
}

struct Attack {
    const char* name;
    std::function<void(GltfFile&)> spoil;  ///< of triangleFile()
    const char* expected;                  ///< part of the message
};

class SceneGltfAttack : public ::testing::TestWithParam<Attack> {};

TEST_P(SceneGltfAttack, IsRefusedInOneLine) {
    GltfFile file = triangleFile();
    GetParam().spoil(file);
    const TempFolder folder;
    folder.write("b.bin", file.bytes);
    const auto path = folder.write("bad.gltf", file.gltf());
    const std::string message = failureOf(path, folder.library());
    EXPECT_TRUE(message.starts_with(path.string() + ": /")) << message;
    EXPECT_NE(message.find(GetParam().expected), std::string::npos) << message;
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

const Attack kAttacks[] = {
    // --- Numbers ---
    {"CountOf32Bits", [](GltfFile& f) { f.root["accessors"][0]["count"] = 4294967295u; },
     "/accessors/0/count: must be a whole number from 0 to 2147483647"},
    {"CountNegative", [](GltfFile& f) { f.root["accessors"][0]["count"] = -3; },
     "/accessors/0/count: must be a whole number"},
    {"CountNoInteger", [](GltfFile& f) { f.root["accessors"][0]["count"] = 2.5; },
     "/accessors/0/count: must be a whole number"},
    {"CountZero", [](GltfFile& f) { f.root["accessors"][0]["count"] = 0; },
     "/accessors/0: has no elements"},
    {"LengthOf53Bits", [](GltfFile& f) { setBuffer(f, 9007199254740992u, "b.bin"); },
     "/buffers/0/byteLength: must be a whole number"},
    {"LengthOfAllIndices", [](GltfFile& f) { setBuffer(f, 2147483647, "b.bin"); },
     "/buffers/0: promises 2147483647 bytes and has 36"},
    {"OffsetNegative", [](GltfFile& f) { f.root["bufferViews"][0]["byteOffset"] = -4; },
     "/bufferViews/0/byteOffset: must be a whole number"},
    {"OffsetAndLengthOverflow",
     [](GltfFile& f) {
         f.root["bufferViews"][0]["byteOffset"] = 2147483647;
         f.root["bufferViews"][0]["byteLength"] = 2147483647;
     },
     "/bufferViews/0: bytes 2147483647 to 4294967294 lie beyond its buffer"},
    // --- Indices ---
    {"IndexOf8BitsOutOfRange",
     [](GltfFile& f) {
         primitiveOf(f)["indices"] =
             f.accessor<std::uint8_t>({0, 1, 255}, GltfFile::kU8, "SCALAR", 3);
     },
     "/indices: index 255 at position 2 is out of range"},
    {"IndexOf32BitsOutOfRange",
     [](GltfFile& f) {
         primitiveOf(f)["indices"] =
             f.accessor<std::uint32_t>({0, 4294967295u, 1}, GltfFile::kU32, "SCALAR", 3);
     },
     "/indices: index 4294967295 at position 1 is out of range"},
    {"PrimitiveRestart",
     [](GltfFile& f) {
         primitiveOf(f)["attributes"]["POSITION"] = f.vec3s(std::vector<glm::vec3>(256, {1, 2, 3}));
         primitiveOf(f)["indices"] =
             f.accessor<std::uint8_t>({0, 1, 255}, GltfFile::kU8, "SCALAR", 3);
     },
     "/indices: index 255 at position 2 is the primitive restart value"},
    {"IndicesAreSigned",
     [](GltfFile& f) {
         primitiveOf(f)["indices"] = f.accessor<std::int8_t>({0, 1, 2}, 5120, "SCALAR", 3);
     },
     "/indices: accessor 1 is SCALAR of BYTE"},
    // --- URIs ---
    {"PercentEncodedParent", [](GltfFile& f) { setBuffer(f, 36, "%2e%2e/b.bin"); },
     "/buffers/0/uri: refers to '../b.bin', outside its own folder"},
    {"PercentEncodedSlash", [](GltfFile& f) { setBuffer(f, 36, "%2fetc%2fhostname"); },
     "refers to '/etc/hostname', outside its own folder"},
    {"PercentEncodedScheme", [](GltfFile& f) { setBuffer(f, 36, "file%3a///etc/hostname"); },
     "outside its own folder"},
    {"NameWithZeroByte", [](GltfFile& f) { setBuffer(f, 36, "b.bin%00/../../x"); },
     "outside its own folder"},
    {"Backslashes", [](GltfFile& f) { setBuffer(f, 36, "..\\b.bin"); }, "outside its own folder"},
    {"BrokenBase64",
     [](GltfFile& f) { setBuffer(f, 36, "data:application/octet-stream;base64,AAAA!AAA"); },
     "/buffers/0: promises 36 bytes and has 3"},
    {"DataUriWithoutBase64", [](GltfFile& f) { setBuffer(f, 3, "data:text/plain,abc"); },
     "/buffers/0/uri: 'data:text/plain,abc' is no base64 data URI"},
    {"ImageOfNothing",
     [](GltfFile& f) {
         setTexture(f, json::object());
         f.root["images"][0] = json::object();
     },
     "/images/0: is empty"},
    // --- Nodes and meshes ---
    {"NodeIsItsOwnChild", [](GltfFile& f) { f.root["nodes"][0]["children"] = {0}; },
     "/nodes/0: is part of a cycle"},
    {"MeshWithoutPrimitives",
     [](GltfFile& f) { f.root["meshes"][0]["primitives"] = json::array(); }, "has no triangles"},
    {"TensOfInstances",
     [](GltfFile& f) {
         const int places =
             f.add("accessors",
                   {{"componentType", GltfFile::kFloat}, {"type", "VEC3"}, {"count", 1000000000}});
         f.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
             {"TRANSLATION", places}};
     },
     "/attributes/TRANSLATION: its elements would need"},
    // --- Animations ---
    {"TimeNan",
     [](GltfFile& f) {
         animate(f, "scale", f.floats({0, kNan}), f.vec3s({{1, 1, 1}, {1, 1, 1}}));
     },
     "/animations/0/samplers/0/input: element 1 of accessor"},
    {"OutputNan",
     [](GltfFile& f) {
         animate(f, "scale", f.floats({0, 1}), f.vec3s({{1, 1, 1}, {1, kNan, 1}}));
     },
     "/animations/0/samplers/0/output: element 1 of accessor"},
    {"SamplerOutOfRange",
     [](GltfFile& f) {
         animate(f, "scale", f.floats({0, 1}), f.vec3s({{1, 1, 1}, {1, 1, 1}}));
         f.root["animations"][0]["channels"][0]["sampler"] = 1;
     },
     "/animations/0/channels/0/sampler: sampler 1 does not exist"},
    // --- Magnitudes ---
    {"TextureTransformOverflows",
     [](GltfFile& f) {
         setTexture(f, {{"scale", {1e300, 1e300}}, {"offset", {1e308, 0}}});
     },
     "/meshes/0/primitives/0/attributes/TEXCOORD_0: element 0 is beyond 1e+15"},
    {"TextureCoordinateNan",
     [](GltfFile& f) {
         setTexture(f, json::object());
         primitiveOf(f)["attributes"]["TEXCOORD_0"] =
             f.accessor<float>({0, 0, kNan, 0, 0, 1}, GltfFile::kFloat, "VEC2", 3);
     },
     "/attributes/TEXCOORD_0: element 1 of accessor 2 is NaN"},
    {"AngleOfZero",
     [](GltfFile& f) {
         setCamera(f, "perspective", {{"yfov", 0}, {"znear", 1}});
     },
     "/cameras/0/perspective/yfov: 0 is not between 0 and pi"},
    {"FarBeforeNear",
     [](GltfFile& f) {
         setCamera(f, "perspective", {{"yfov", 1}, {"znear", 2}, {"zfar", 1}});
     },
     "/cameras/0: znear 2 and zfar 1 do not enclose anything"},
    {"NearNegative",
     [](GltfFile& f) {
         setCamera(f, "perspective", {{"yfov", 1}, {"znear", -1}});
     },
     "/cameras/0: znear -1"},
    {"NearBeyondAllBounds",
     [](GltfFile& f) {
         setCamera(f, "perspective", {{"yfov", 1}, {"znear", 1e300}, {"zfar", 2e300}});
     },
     "/cameras/0: znear 1e+300"},
    {"OrthographicHuge",
     [](GltfFile& f) {
         setCamera(f, "orthographic", {{"xmag", 1}, {"ymag", 1e300}, {"znear", 0}, {"zfar", 1}});
     },
     "/cameras/0/orthographic/ymag: 1e+300 is not between 0 and 1e+15"},
    {"LightWithoutEnd",  // 1e30 m wide: its rays would be infinite
     [](GltfFile& f) {
         f.add("materials", {{"emissiveFactor", {1, 1, 1}}});
         f.node({{"mesh", f.quad({0, 3, 0}, {1e30f, 0, 0}, {0, 0, 1e30f}, 0)}});
     },
     "/scenes/0: reaches further than 1e+15 m"},
};

INSTANTIATE_TEST_SUITE_P(All, SceneGltfAttack, ::testing::ValuesIn(kAttacks),
                         [](const auto& each) { return std::string(each.param.name); });

/// At 0 s the vertices are where they should be, later they leave every bound.
std::string failureLater(const GltfFile& file) {
    const TempFolder folder;
    folder.write("a.gltf", file.gltf());
    return failureOf(folder.write("s.toml",
                                  "shows = 'x'\nasset = 'a.gltf'\n[light]\nposition = [0, 9, 9]\n"
                                  "target = [0, 0, 0]\nsize = [1, 1]\n[frames]\ntimes = [0, 1]\n"),
                     folder.library());
}

TEST(SceneGltfAttack, VerticesAreBoundedInEveryFrame) {
    GltfFile growing;
    growing.node(
        {{"scale", {1e-30, 1e-30, 1e-30}},
         {"mesh", growing.mesh({{"attributes",
                                 {{"POSITION",
                                   growing.vec3s({{0, 0, 0}, {1e30f, 0, 0}, {0, 1e30f, 0}})}}}})}});
    animate(growing, "scale", growing.floats({0, 1}),
            growing.vec3s({glm::vec3(1e-30f), glm::vec3(1)}));
    EXPECT_NE(failureLater(growing).find("/scenes/0: 'nodes/0' is out of all bounds at 1 s"),
              std::string::npos)
        << failureLater(growing);

    GltfFile morphing = triangleFile();
    primitiveOf(morphing)["targets"] =
        json::array({{{"POSITION", morphing.vec3s({{0, 0, 1e30f}, {1e30f, 0, 0}, {0, 0, 0}})}}});
    EXPECT_EQ(failureLater(morphing), "");
    animate(morphing, "weights", morphing.floats({0, 1}), morphing.floats({0, 1}));
    EXPECT_NE(failureLater(morphing).find("is out of all bounds at 1 s"), std::string::npos)
        << failureLater(morphing);
}

TEST(SceneGltfAttack, OneHundredThousandNodesDeep) {
    GltfFile file = triangleFile();
    constexpr int kDepth = 100000;
    json& nodes = file.root["nodes"];
    nodes[0]["children"] = {1};
    for (int i = 1; i < kDepth; ++i) nodes.push_back({{"children", {i + 1}}});
    nodes.push_back(json::object());
    const TempFolder folder;
    const auto path = folder.write("deep.gltf", file.gltf());
    EXPECT_EQ(failureOf(path, folder.library()), "");
    nodes.back()["children"] = {0};
    EXPECT_NE(failureOf(folder.write("deep.gltf", file.gltf()), folder.library()).find("cycle"),
              std::string::npos);
}

/// Opening a pipe for reading would wait for a writer, for ever.
TEST(SceneGltfAttack, PipesAreNotOpened) {
    const TempFolder folder;
    GltfFile file = triangleFile();
    setBuffer(file, 36, "pipe.bin");
    const auto path = folder.write("a.gltf", file.gltf());
    ASSERT_EQ(mkfifo((folder.path() / "pipe.bin").c_str(), 0600), 0);
    ASSERT_EQ(mkfifo((folder.path() / "pipe.glb").c_str(), 0600), 0);
    ASSERT_EQ(mkfifo((folder.path() / "pipe.toml").c_str(), 0600), 0);
    EXPECT_NE(failureOf(path, folder.library()).find("'pipe.bin' is missing or not a readable"),
              std::string::npos);
    for (const char* name : {"pipe.glb", "pipe.toml"})
        EXPECT_NE(failureOf(folder.path() / name, folder.library()).find("is not a readable file"),
                  std::string::npos)
            << name;
}

// --- JSON ----------------------------------------------------------------------------------------

TEST(SceneGltfAttack, TextsThatAreNoPlainJson) {
    const TempFolder folder;
    const std::string good = triangleFile().gltf();
    const auto failure = [&](const std::string& text) {
        return failureOf(folder.write("a.gltf", text), folder.library());
    };
    EXPECT_EQ(failure("\xEF\xBB\xBF" + good), "");  // a byte order mark, which parsers may skip
    EXPECT_NE(failure("\xFF\xFE" + good).find("syntax error"), std::string::npos);
    std::string name = good;
    name.insert(name.find("\"asset\""), "\"extras\": \"\xC3\x28\", ");
    EXPECT_NE(failure(name).find("UTF-8"), std::string::npos) << failure(name);
    // Of a key that is there twice the last counts, for checks and reading alike.
    std::string twice = good;
    twice.insert(twice.rfind('}'), ", \"scene\": 7");
    EXPECT_NE(failure(twice).find("/scene: scene 7 does not exist"), std::string::npos);
    EXPECT_NE(failure(good + "x"), "");
}

TEST(SceneGltfAttack, WhatIsSaidHoldsNoControlCharacters) {
    GltfFile file = triangleFile();
    file.root["nodes"][0]["name"] = std::string(
                                        "a\x1B[31m\xC2\x9B"
                                        "1m\xE2\x80\xAE\xE2\x80\xA8") +
                                    std::string(200, 'x') + "\xC3\xA9";
    const TempFolder folder;
    folder.write("a.gltf", file.gltf());
    const std::string message =
        failureOf(folder.write("s.toml",
                               "shows = 'x'\nasset = 'a.gltf'\n[[track]]\ntarget = 'node:b.scale'\n"
                               "times = [0]\nvalues = [[1, 1, 1]]\n"),
                  folder.library());
    EXPECT_NE(message.find("its nodes are a [31m  1m"), std::string::npos) << message;
    for (const char* part : {"\x1B", "\xC2\x9B", "\xE2\x80\xAE", "\xE2\x80\xA8"})
        EXPECT_EQ(message.find(part), std::string::npos) << message;
}

// --- The container -------------------------------------------------------------------------------

class SceneGlbAttack : public ::testing::Test {
  protected:
    std::string failure(const std::string& bytes) const {
        return failureOf(folder.write("a.glb", bytes), folder.library());
    }
    static std::string withU32(std::string bytes, std::size_t at, std::uint32_t value) {
        std::memcpy(bytes.data() + at, &value, 4);
        return bytes;
    }
    const std::string good = triangleFile().glb();
    const std::size_t binary = good.find(std::string("BIN\0", 4)) - 4;  ///< its chunk's length
    const TempFolder folder;
};

TEST_F(SceneGlbAttack, LengthsThatLie) {
    ASSERT_EQ(failure(good), "");
    EXPECT_NE(failure(withU32(good, 4, 1)).find("binary version 1"), std::string::npos);
    EXPECT_NE(failure(withU32(good, 8, 0xFFFFFFFF)).find("its header promises 4294967295 bytes"),
              std::string::npos);
    EXPECT_NE(failure(withU32(good, 8, 12)).find("no complete JSON chunk"), std::string::npos);
    EXPECT_NE(failure(withU32(good, 12, 0xFFFFFFFF)).find("no complete JSON chunk"),
              std::string::npos);
    EXPECT_NE(failure(withU32(good, 12, 0)), "");
    EXPECT_NE(failure(withU32(good, binary, 0xFFFFFFFF)).find("reaches beyond the end"),
              std::string::npos);
    EXPECT_NE(failure(withU32(good, binary, 4)).find("/buffers/0: promises 36 bytes and has 4"),
              std::string::npos);
}

TEST_F(SceneGlbAttack, ChunksInAnotherOrder) {
    const std::string header = good.substr(0, 12), text = good.substr(12, binary - 12),
                      data = good.substr(binary);
    EXPECT_NE(failure(header + data + text).find("no complete JSON chunk first"),
              std::string::npos);
    // A second JSON chunk is one of unknown use, which is skipped; it is no buffer.
    EXPECT_NE(failure(withU32(header + text + text, 8, 12 + 2 * text.size()))
                  .find("/buffers/0: promises 36 bytes and has 0"),
              std::string::npos);
    EXPECT_EQ(failure(withU32(good + text, 8, good.size() + text.size())), "");
}

}  // namespace
}  // namespace penumbra::testing
