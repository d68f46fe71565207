#include <functional>
#include <limits>
#include <random>

#include "tests/core/scene_files.hpp"

namespace penumbra::testing {
namespace {

const std::string kHugePng =  // claims 100000 x 100000 texels
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgABhqAAAYagCAYAAACoUgvIAAAACElEQVR42gMAAAAAAW/"
    "dyZEAAAAA"
    "SUVORK5CYII=";

struct BadCase {
    const char* name;
    std::function<void(GltfFile&)> spoil;  ///< of triangleFile()
    const char* expected;                  ///< part of the message
};

class SceneGltfBadFile : public ::testing::TestWithParam<BadCase> {};

TEST_P(SceneGltfBadFile, IsRefusedInOneLine) {
    GltfFile file = triangleFile();
    GetParam().spoil(file);
    expectRefused(file, GetParam().expected);
}

void setMaskedTexture(GltfFile& f, const std::string& uri) {
    f.add("images", {{"uri", uri}});
    f.add("textures", {{"source", 0}});
    f.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    primitiveOf(f)["material"] = 0;
    primitiveOf(f)["attributes"]["TEXCOORD_0"] =
        f.accessor<float>({0, 0, 1, 0, 0, 1}, GltfFile::kFloat, "VEC2", 3);
}

const BadCase kBadCases[] = {
    {"NotGltf1", [](GltfFile& f) { f.root["asset"]["version"] = "1.0"; }, "/asset/version"},
    {"RequiredExtension",
     [](GltfFile& f) { f.root["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
     "/extensionsRequired/0: KHR_draco_mesh_compression is not supported"},
    {"StripTooShort",
     [](GltfFile& f) {
         primitiveOf(f)["mode"] = 5;
         primitiveOf(f)["indices"] = f.u16s({0, 1});
     },
     "/meshes/0/primitives/0: has 2 corners, fewer than 3"},
    {"UnknownMode", [](GltfFile& f) { primitiveOf(f)["mode"] = 7; }, "mode 7 is not one of 0 to 6"},
    {"Points", [](GltfFile& f) { primitiveOf(f)["mode"] = 0; }, "mode POINTS"},
    {"ImageTooLarge", [](GltfFile& f) { setMaskedTexture(f, kHugePng); }, "/images/0: "},
    {"ImageNoImage", [](GltfFile& f) { setMaskedTexture(f, "data:image/png;base64,AAAAAAAA"); },
     "/images/0: is neither PNG nor JPEG"},
    {"ImageMissing", [](GltfFile& f) { setMaskedTexture(f, "gone.png"); }, "'gone.png' is missing"},
    {"NoTexcoord",
     [](GltfFile& f) {
         setMaskedTexture(f, kRgbaPng);
         primitiveOf(f)["attributes"].erase("TEXCOORD_0");
     },
     "has no TEXCOORD_0"},
    {"MeshOutOfRange", [](GltfFile& f) { f.root["nodes"][0]["mesh"] = 3; },
     "/nodes/0/mesh: mesh 3 does not exist; the file has 1"},
    {"MeshIndexIsText", [](GltfFile& f) { f.root["nodes"][0]["mesh"] = "0"; },
     "/nodes/0/mesh: must be a whole number"},
    {"NegativeIndex", [](GltfFile& f) { f.root["nodes"][0]["mesh"] = -1; },
     "/nodes/0/mesh: must be a whole number"},
    {"AccessorOutOfRange", [](GltfFile& f) { primitiveOf(f)["attributes"]["POSITION"] = 7; },
     "POSITION: accessor 7 does not exist"},
    {"MaterialOutOfRange", [](GltfFile& f) { primitiveOf(f)["material"] = 0; },
     "material 0 does not exist"},
    {"BufferViewOutOfRange", [](GltfFile& f) { f.root["accessors"][0]["bufferView"] = 9; },
     "/accessors/0: buffer view 9"},
    {"BufferOutOfRange", [](GltfFile& f) { f.root["bufferViews"][0]["buffer"] = 1; },
     "/bufferViews/0: buffer 1"},
    {"BufferViewTooLong", [](GltfFile& f) { f.root["bufferViews"][0]["byteLength"] = 37; },
     "/bufferViews/0: bytes"},
    {"CountTooLarge", [](GltfFile& f) { f.root["accessors"][0]["count"] = 4; }, "do not fit"},
    {"CountOverflows", [](GltfFile& f) { f.root["accessors"][0]["count"] = 2147483647; },
     "do not fit"},
    {"OffsetTooLarge", [](GltfFile& f) { f.root["accessors"][0]["byteOffset"] = 2147483647; },
     "do not fit"},
    {"StrideTooSmall", [](GltfFile& f) { f.root["bufferViews"][0]["byteStride"] = 8; },
     "stride of 8"},
    {"PositionNotFloat", [](GltfFile& f) { f.root["accessors"][0]["componentType"] = 5122; },
     "VEC3 of SHORT"},
    {"IndexOutOfRange",
     [](GltfFile& f) {
         primitiveOf(f)["indices"] = f.u16s({0, 1, 3});
     },
     "/meshes/0/primitives/0/indices: index 3 at position 2"},
    {"IndicesNoMultipleOf3",
     [](GltfFile& f) {
         primitiveOf(f)["indices"] = f.u16s({0, 1, 2, 0});
     },
     "multiple of 3"},
    {"NanPosition",
     [](GltfFile& f) {
         const float nan = std::numeric_limits<float>::quiet_NaN();
         std::memcpy(f.bytes.data() + 16, &nan, 4);
     },
     "POSITION: element 1 of accessor 0 is NaN"},
    {"InfinitePosition",
     [](GltfFile& f) {
         const float infinite = std::numeric_limits<float>::infinity();
         std::memcpy(f.bytes.data() + 24, &infinite, 4);
     },
     "element 2 of accessor 0 is infinite"},
    {"NormalCount",
     [](GltfFile& f) {
         primitiveOf(f)["attributes"]["NORMAL"] = f.vec3s({{0, 0, 1}});
     },
     "NORMAL: has 1 elements, POSITION has 3"},
    {"Cycle",
     [](GltfFile& f) {
         f.root["nodes"][0]["children"] = {1};
         f.add("nodes", {{"children", {0}}});
     },
     "cycle"},
    {"TwoParents",
     [](GltfFile& f) {
         f.node({{"children", {2}}});
         f.add("nodes", json::object());
         f.node({{"children", {2}}});
     },
     "/nodes/3/children/0: node 2 already is a child of node 1"},
    {"ChildOutOfRange", [](GltfFile& f) { f.root["nodes"][0]["children"] = {5}; }, "node 5"},
    {"SceneOutOfRange", [](GltfFile& f) { f.root["scene"] = 2; }, "/scene: scene 2"},
    {"BrokenMatrix",
     [](GltfFile& f) {
         f.root["nodes"][0]["matrix"] = {1, 2, 3};
     },
     "/nodes/0/matrix: must be a list of 16 numbers"},
    {"ZeroRotation",
     [](GltfFile& f) {
         f.root["nodes"][0]["rotation"] = {0, 0, 0, 0};
     },
     "/nodes/0/rotation"},
    {"NoTriangles", [](GltfFile& f) { f.root["nodes"][0].erase("mesh"); }, "no triangles"},
    {"OnlyZeroArea",
     [](GltfFile& f) {
         primitiveOf(f)["indices"] = f.u16s({0, 0, 1});
     },
     "no triangles"},
    {"ZeroScale",
     [](GltfFile& f) {
         f.root["nodes"][0]["scale"] = {0, 0, 0};
     },
     "no extent"},
    {"BeyondAllBounds",
     [](GltfFile& f) {
         f.root["nodes"][0]["scale"] = {1e300, 1, 1};
     },
     "reaches further"},
    {"UriAbsolute",
     [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "/etc/hostname"}}});
     },
     "'/etc/hostname', outside its own folder"},
    {"UriUpwards",
     [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "a/%2e%2e/../b.bin"}}});
     },
     "outside its own folder"},
    {"UriMissing",
     [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "gone.bin"}}});
     },
     "gone.bin"},
    {"CameraAngle",
     [](GltfFile& f) {
         f.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 4}, {"znear", 1}}}});
         f.root["nodes"][0]["camera"] = 0;
     },
     "/cameras/0/perspective/yfov"},
    {"AnimationTimes",
     [](GltfFile& f) {
         const int input = f.floats({0, 1, 1});
         const int output = f.vec3s({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
         f.add(
             "animations",
             {{"channels",
               json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}})},
              {"samplers", json::array({{{"input", input}, {"output", output}}})}});
     },
     "/animations/0/samplers/0/input: time 1 at key 2"},
    {"AnimationOutputCount",
     [](GltfFile& f) {
         const int input = f.floats({0, 1});
         const int output = f.vec3s({{0, 0, 0}});
         f.add("animations",
               {{"channels",
                 json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}})},
                {"samplers", json::array({{{"input", input}, {"output", output}}})}});
     },
     "1 output values for 2 keys"},
};

INSTANTIATE_TEST_SUITE_P(All, SceneGltfBadFile, ::testing::ValuesIn(kBadCases),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(SceneGltfBad, DeepNestingIsRefused) {
    const TempFolder folder;
    std::string text = R"({"asset":{"version":"2.0"},"extras":)";
    text += std::string(200000, '[') + std::string(200000, ']') + "}";
    EXPECT_NE(failureOf(folder.write("deep.gltf", text), folder.library()).find("nested"),
              std::string::npos);
}

TEST(SceneGltfBad, MissingFileIsNamed) {
    const TempFolder folder;
    EXPECT_NE(failureOf(folder.path() / "gone.glb", folder.library()).find("gone.glb"),
              std::string::npos);
}

TEST(SceneGltfBad, FileCutOffAnywhereIsRefused) {
    const TempFolder folder;
    const std::string whole = lampFile().glb();
    for (std::size_t size = 0; size < whole.size(); size += 1 + size / 50) {
        const auto path = folder.write("cut.glb", whole.substr(0, size));
        EXPECT_NE(failureOf(path, folder.library()), "") << "cut to " << size << " bytes";
    }
}

TEST(SceneGltfBad, DamagedFilesLoadOrAreRefused) {
    const TempFolder folder;
    GltfFile file = lampFile();
    setMaskedTexture(file, kRgbaPng);
    const std::string whole = file.glb();
    std::mt19937 random(1);
    for (int round = 0; round < 1500; ++round) {
        std::string damaged = whole;
        for (int k = 0; k < 1 + round % 4; ++k) {
            damaged[random() % damaged.size()] = static_cast<char>(random());
        }
        // A crash or any other exception fails the test; failureOf checks the message.
        failureOf(folder.write("damaged.glb", damaged), folder.library());
    }
}

}  // namespace
}  // namespace penumbra::testing
