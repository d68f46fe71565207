// Bad input is one line on stderr that says what, where and what would be valid; exit code 2; and
// no run folder.
#include "tests/cli/in_process.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using Texts = std::vector<std::string>;

class BadInput : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (folder.path() / name).string(); }

    /// `run` starts penumbra with `arguments`, which it must refuse saying every part of `said`.
    template <class Run>
    void expectRefusal(const Texts& arguments, const Texts& said, const Run& run) const {
        const auto before = test::filesBelow(folder.path());
        const test::Finished done = run(arguments);
        std::string command;
        for (const std::string& argument : arguments) command += argument + " ";
        EXPECT_EQ(done.exitCode, 2) << command << "\n" << done.err;
        EXPECT_EQ(done.out, "") << command;
        EXPECT_EQ(test::lines(done.err).size(), 1u) << command << "\n" << done.err;
        EXPECT_TRUE(done.err.starts_with("penumbra: ") && done.err.ends_with("\n"))
            << command << "\n"
            << done.err;
        for (const std::string& part : said)
            EXPECT_NE(done.err.find(part), std::string::npos)
                << command << "\nsaid " << done.err << "without " << part;
        EXPECT_TRUE(test::filesBelow(folder.path()) == before) << command << "wrote something";
        EXPECT_FALSE(std::filesystem::exists(path("run"))) << command;
    }
    void expectRefused(const Texts& arguments, const Texts& said,
                       const Texts& environment = {}) const {
        expectRefusal(arguments, said,
                      [&](const Texts& all) { return test::penumbra(all, environment); });
    }
    /// `compare --out RUN ARGUMENTS...`, where RUN must not come to be.
    Texts compareInto(Texts arguments) const {
        const Texts always = {"compare", "--out", path("run"), "--cache", path("cache")};
        arguments.insert(arguments.begin(), always.begin(), always.end());
        return arguments;
    }
    void expectCompareRefused(const Texts& arguments, const Texts& said,
                              const Texts& environment = {}) const {
        expectRefused(compareInto(arguments), said, environment);
    }
    /// The same without a process of its own.
    void expectVariantRefused(const Texts& arguments, const Texts& said) const {
        expectRefusal(compareInto(arguments), said, test::penumbraInProcess);
    }

    testing::TempFolder folder;
};

TEST_F(BadInput, UnknownNamesListTheKnownOnes) {
    expectCompareRefused({"--scene", "nope"}, {"'nope'", "half_plane", "two_layers"});
    expectVariantRefused({"--scene", "half_plane", "nope"}, {"'nope'", "half_plane"});
    expectCompareRefused({"--suite", "nope"}, {"'nope'", "standard"});
    expectCompareRefused({"--method", "nope"},
                         {"'nope'", "hard", "pcf", "ray_traced", "separation"});
    expectVariantRefused({"--set", "separation.x=1"}, {"separation has no parameters"});
    expectVariantRefused({"--set", "nope.taps=1"}, {"'nope'", "hard", "pcf"});
    expectVariantRefused({"--set", "pcf.nope=1"}, {"'nope'", "taps", "map_size"});
    expectVariantRefused({"--sweep", "pcf.nope=1,2"}, {"'nope'", "taps", "map_size"});
    expectCompareRefused({"--effects", "nope"}, {"'nope'", "auto", "none", "penumbra"});
    expectVariantRefused({"--effects", "penumbra,"}, {"''", "auto", "none", "penumbra"});
    expectCompareRefused({"--context", "nope"}, {"'nope'", "osmesa", "egl", "glfw", "auto"});
    expectVariantRefused({"--reference", "nope"}, {"nope", "embree"});
    expectRefused({"list", "nope"}, {"nope", "methods", "scenes", "suites", "metrics", "effects"});
    expectRefused({"nope"}, {"'nope'", "compare", "list", "report", "merge"});
    expectRefused({}, {"subcommand", "compare", "list", "report", "merge"});
}

TEST_F(BadInput, ValuesOutOfRangeNameTheRange) {
    expectCompareRefused({"--set", "pcf.taps=0"}, {"pcf.taps", "'0'", "1..1024"});
    expectVariantRefused({"--set", "pcf.kernel=wide"}, {"pcf.kernel", "'wide'", "0..4"});
    expectVariantRefused({"--set", "pcf.pattern=round"}, {"'round'", "grid|vogel"});
    expectVariantRefused({"--sweep", "pcf.taps=9,nine"}, {"'nine'", "1..1024"});
    expectVariantRefused({"--set", "pcf.taps"}, {"METHOD.PARAMETER=VALUE"});
    expectVariantRefused({"--method", "hard", "--set", "pcf.taps=9"}, {"pcf", "not among"});
    for (const char* size : {"64", "64x", "x64", "0x64", "64x-1", "64x64x64", "64X64", "64x64 ",
                             "1e2x64", "99999999999x64"})
        expectVariantRefused({"--size", size}, {"--size", size, "512x512"});
    expectCompareRefused({"--size", "16385x1"}, {"--size", "16384x16384"});
    for (const char* shard : {"0/2", "1/0", "1", "1/2/3", "a/b"})
        expectVariantRefused({"--shard", shard}, {"--shard", shard, "1/4"});
    expectCompareRefused({"--shard", "3/2"}, {"--shard 3/2", "1 <= I <= N"});
    for (const char* se : {"0", "nan", "1", "-0.1", "inf"})
        expectVariantRefused({"--reference-se", se}, {"--reference-se", "0.5"});
    for (const char* number : {"0", "-1", "many", "1.5"}) {
        expectVariantRefused({"--repeats", number}, {"--repeats"});
        expectVariantRefused({"--threads", number}, {"--threads"});
    }
    for (const char* seed : {"-1", "1.5", "x", "4294967296"})
        expectVariantRefused({"--seed", seed}, {"--seed"});
}

TEST_F(BadInput, OptionsThatDoNotFitTogether) {
    expectCompareRefused({"--nope"}, {"--nope"});
    expectCompareRefused({"stray"}, {"stray"});
    expectCompareRefused({"--scene"}, {"--scene"});
    expectRefused({"compare", "--resume"}, {"--resume", "--out"});
    expectRefused({"list", "methods", "--json", "--markdown"}, {"--json", "--markdown"});
    expectRefused({"list"}, {"kind"});
}

// Permission bits stop nobody who is root, a file where a folder should be stops everybody.
TEST_F(BadInput, AFolderThatCannotBe) {
    folder.write("file", "in the way");
    const Texts compare = {"compare", "--scene", "half_plane", "--cache", path("cache"), "--out"};
    for (const std::string& out : {path("file"), path("file/run"), std::string("/proc/run")}) {
        Texts arguments = compare;
        arguments.push_back(out);
        expectRefused(arguments, {"--out " + out + ": "});
    }
    std::filesystem::create_directories(folder.path() / "used");
    folder.write("used/results.csv", "scene\n");
    Texts arguments = compare;
    arguments.push_back(path("used"));
    expectRefused(arguments, {path("used"), "--resume"});
    arguments.push_back("--resume");
    expectRefused(arguments, {path("used")});
}

TEST_F(BadInput, AWindowWithoutADisplay) {
    expectCompareRefused({"--context", "glfw", "--scene", "half_plane"}, {"glfw"},
                         {"DISPLAY=", "WAYLAND_DISPLAY="});
}

TEST_F(BadInput, FilesThatAreNoScene) {
    expectCompareRefused({"--scene", path("absent.glb")}, {path("absent.glb"), "does not exist"});
    expectCompareRefused({"--scene", path("absent.toml")}, {path("absent.toml"), "does not exist"});
    folder.write("notes.txt", "no scene");
    expectCompareRefused({"--scene", path("notes.txt")}, {"notes.txt", ".toml", ".glb", ".gltf"});
    std::filesystem::create_directories(folder.path() / "folder.glb");
    expectCompareRefused({"--scene", path("folder.glb")}, {"folder.glb"});

    const std::string whole = testing::triangleFile().glb();
    folder.write("empty.glb", "");
    folder.write("cut.glb", whole.substr(0, whole.size() / 2));
    folder.write("noise.glb", "glTF" + std::string(200, '\x7f'));
    folder.write("broken.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"meshes\": [");
    testing::GltfFile beyond = testing::triangleFile();
    beyond.root["accessors"][0]["count"] = 1000000;
    folder.write("beyond.glb", beyond.glb());
    for (const char* name : {"empty.glb", "cut.glb", "noise.glb", "broken.gltf", "beyond.glb"}) {
        expectCompareRefused({"--scene", path(name)}, {path(name)});
        expectVariantRefused({"--scene", "half_plane", path(name)}, {path(name)});
    }
}

TEST_F(BadInput, ScriptsNameTheLineAndTheValidKeys) {
    const std::string good = R"(shows = "a test"
asset = "generated:half_plane.glb"
[camera]
position = [-1.7, 2.6, 0.0]
target = [0.15, 0.0, 0.0]
fov_y = 45.0
)";
    const auto refused = [&](const std::string& more, const Texts& said) {
        folder.write("bad.toml", good + more);
        expectVariantRefused({"--scene", path("bad.toml")}, said);
    };
    const std::string at = path("bad.toml") + ":";
    refused("fov_x = 1.0\n", {at + "7:", "'fov_x'", "position, target, up, fov_y"});
    refused("[lamp]\n", {at + "7:", "'lamp'", "camera", "light", "frames"});
    refused("up = [0, 0]\n", {at + "7:", "up", "3 numbers"});
    refused("[light]\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\nsize = [1, -1]\n",
            {at + "10:", "size"});
    refused("[frames]\ntimes = [1.0, 0.5]\n", {at + "8:", "times must increase"});
    refused("[frames]\ntimes = \"all\"\n", {at + "8:", "times must be a list"});
    refused("[[track]]\ntarget = \"light.colour\"\n", {at + "8:", "light.position", "light.size"});
    refused("[light\n", {at + "7:"});
    refused("fov_y = 46.0\n", {at + "7:"});

    folder.write("bad.toml", "shows = \"a test\"\nasset = \"absent.glb\"\n");
    expectCompareRefused({"--scene", path("bad.toml")}, {at + "2:", "absent.glb"});
}

TEST_F(BadInput, FoldersThatAreNoRun) {
    std::filesystem::create_directories(folder.path() / "empty");
    folder.write("empty/run.json", "{\"command\": 1}");
    for (const std::string& run : {path("absent"), path("empty")}) {
        expectRefused({"report", run}, {run + "/run.json"});
        expectRefused({"merge", path("run"), run}, {run + "/run.json"});
    }
    expectRefused({"report"}, {"run"});
    expectRefused({"merge", path("run")}, {"runs"});
}

TEST_F(BadInput, PairsAreTwoSettingsAndNothingElse) {
    expectVariantRefused({"--paired", "pcf", "nope"}, {"'nope'", "hard", "pcf"});
    expectVariantRefused({"--paired", "pcf", "pcf:taps"}, {"METHOD:PARAMETER=VALUE"});
    expectVariantRefused({"--paired", "pcf", "pcf:taps=0"}, {"pcf.taps", "1..1024"});
    expectVariantRefused({"--paired", "pcf"}, {"--paired"});
    expectVariantRefused({"--paired", "pcf", "hard", "--repeats", "5"}, {"--repeats 5", "6"});
    expectVariantRefused({"--paired", "pcf", "hard", "--method", "pcf"}, {"--paired", "--method"});
    expectVariantRefused({"--paired", "pcf", "hard", "--shard", "1/2"}, {"--paired", "--shard"});
}

TEST_F(BadInput, TuneNeedsOneLimitThatMakesSense) {
    const auto expectTuneRefused = [&](Texts arguments, const Texts& said) {
        const Texts always = {"tune", "--scene", "half_plane", "--cache", path("cache")};
        arguments.insert(arguments.begin(), always.begin(), always.end());
        expectRefusal(arguments, said, test::penumbraInProcess);
    };
    expectTuneRefused({}, {"--max-rmse", "--max-ms"});
    expectTuneRefused({"--max-rmse", "0.1", "--max-ms", "5"}, {"--max-rmse", "--max-ms"});
    expectTuneRefused({"--max-rmse", "-0.1"}, {"--max-rmse -0.1", "above 0"});
    expectTuneRefused({"--max-rmse", "nan"}, {"--max-rmse", "above 0"});
    expectTuneRefused({"--max-ms", "-3"}, {"--max-ms -3", "above 0"});
    expectTuneRefused({"--max-ms", "inf"}, {"--max-ms", "above 0"});
    expectTuneRefused({"--max-ms", "5", "--method", "nope"}, {"'nope'", "hard", "pcf"});
    expectTuneRefused({"--max-ms", "5", "--frame", "9"}, {"--frame 9", "only frame 0"});
}

}  // namespace
}  // namespace penumbra
