#include "harness/run/run_record.hpp"

#include <gtest/gtest.h>

#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using penumbra::testing::json;
using penumbra::testing::TempFolder;

RunRecord fullRecord() {
    RunRecord r;
    r.command = "penumbra compare --scene 'my \"scene\".glb' \xe2\x80\xa6";
    r.finished = true;
    r.width = 640;
    r.height = 360;
    r.repeats = 7;
    r.seed = 4294967295u;
    r.referenceSe = 1.0 / 1024;
    r.reference = "embree";
    r.effects = "penumbra alpha_mask";
    r.cache = "a folder";
    r.provenance = {{"renderer", "llvmpipe (LLVM 15, 256 bits)"}, {"commit", "abc+"}, {"a", ""}};
    r.scenes = {{"fence", "pickets", "", "scenes/fence.toml", 3, {}},
                {"mine", "", "fig. 6", "mine.glb", 1, {"light: placed", "camera: placed"}}};
    r.settings = {{"pcf-0a1b2c3d", "pcf", "taps=9"}, {"hard", "hard", ""}};
    r.references = {{"fence", 2, 1e9, 0.25, true, 1000, 200000, 3e9}};
    EffectsRecord effects{"fence", 2, 12.5, 0.25, {}};
    effects.findings[Effect::alpha_mask] = {false, "no material is masked"};
    r.analysis = {effects};
    r.phases = {{"reference", 1.5}, {"methods", 0.125}};
    r.skippedScenes = {{"engine", "install Debian package assimp-testmodels"}};
    r.fencedClockMs = 33.5;
    r.queryClockMs = 0.25;
    r.timerQueriesTrusted = true;
    r.fetches = {1.5e9, 6.25e8};
    r.curveMetric = "flip";
    return r;
}

std::string errorOfReading(const std::filesystem::path& path) {
    try {
        RunRecord::read(path);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(RunRecord, RoundTripKeepsEverything) {
    const TempFolder folder;
    const RunRecord r = fullRecord();
    r.write(folder.path() / "run.json");
    const RunRecord back = RunRecord::read(folder.path() / "run.json");
    EXPECT_EQ(back.command, r.command);
    EXPECT_EQ(back.finished, r.finished);
    EXPECT_EQ(back.width, r.width);
    EXPECT_EQ(back.height, r.height);
    EXPECT_EQ(back.repeats, r.repeats);
    EXPECT_EQ(back.cache, r.cache);
    EXPECT_EQ(back.seed, r.seed);
    EXPECT_EQ(back.referenceSe, r.referenceSe);
    ASSERT_EQ(back.analysis.size(), 1u);
    EXPECT_EQ(back.analysis[0].scene, "fence");
    EXPECT_EQ(back.analysis[0].frame, 2);
    EXPECT_EQ(back.analysis[0].loadMs, 12.5);
    EXPECT_EQ(back.analysis[0].analysisMs, 0.25);
    EXPECT_EQ(back.analysis[0].findings, r.analysis[0].findings);
    EXPECT_EQ(back.reference, r.reference);
    EXPECT_EQ(back.effects, r.effects);
    EXPECT_EQ(back.provenance, r.provenance) << "order included";
    ASSERT_EQ(back.scenes.size(), 2u);
    EXPECT_EQ(back.scenes[0].id, "fence");
    EXPECT_EQ(back.scenes[0].shows, "pickets");
    EXPECT_EQ(back.scenes[0].source, "scenes/fence.toml");
    EXPECT_EQ(back.scenes[0].frames, 3);
    EXPECT_EQ(back.scenes[1].figure, "fig. 6");
    EXPECT_EQ(back.scenes[1].chosen, r.scenes[1].chosen);
    ASSERT_EQ(back.settings.size(), 2u);
    EXPECT_EQ(back.settings[0].name, "pcf-0a1b2c3d");
    EXPECT_EQ(back.settings[0].method, "pcf");
    EXPECT_EQ(back.settings[0].params, "taps=9");
    ASSERT_EQ(back.references.size(), 1u);
    EXPECT_EQ(back.references[0].scene, "fence");
    EXPECT_EQ(back.references[0].frame, 2);
    EXPECT_EQ(back.references[0].rays, 1e9);
    EXPECT_EQ(back.references[0].seconds, 0.25);
    EXPECT_TRUE(back.references[0].cached);
    EXPECT_EQ(back.references[0].penumbraPixels, 1000u);
    EXPECT_EQ(back.references[0].scoredPixels, 200000u);
    EXPECT_EQ(back.references[0].uniformEquivalentRays, 3e9);
    ASSERT_EQ(back.phases.size(), 2u);
    EXPECT_EQ(back.phases[1].name, "methods");
    EXPECT_EQ(back.phases[1].seconds, 0.125);
    EXPECT_EQ(back.skippedScenes, r.skippedScenes);
    EXPECT_EQ(back.fencedClockMs, r.fencedClockMs);
    EXPECT_EQ(back.queryClockMs, r.queryClockMs);
    EXPECT_EQ(back.timerQueriesTrusted, r.timerQueriesTrusted);

    back.write(folder.path() / "again.json");
    EXPECT_EQ(test::readText(folder.path() / "again.json"),
              test::readText(folder.path() / "run.json"));
}

// A file name may hold any byte; the record of a run must not fail on it.
TEST(RunRecord, BytesThatAreNoUtf8AreReplaced) {
    const TempFolder folder;
    RunRecord r = fullRecord();
    r.command = "--out r\xff";
    r.write(folder.path() / "run.json");
    EXPECT_EQ(RunRecord::read(folder.path() / "run.json").command, "--out r\xef\xbf\xbd");
}

TEST(RunRecord, WhatIsNoRecordIsNamed) {
    const TempFolder folder;
    const std::filesystem::path path = folder.path() / "run.json";
    EXPECT_EQ(errorOfReading(path), path.string() + ": not a run folder, cannot be read");

    fullRecord().write(path);
    const std::string text = test::readText(path);
    folder.write("run.json", text.substr(0, text.size() / 2));
    EXPECT_TRUE(errorOfReading(path).starts_with(path.string() + ": ")) << errorOfReading(path);

    const json whole = json::parse(text);
    for (const auto& [key, value] : whole.items()) {
        json without = whole;
        without.erase(key);
        folder.write("run.json", without.dump());
        EXPECT_NE(errorOfReading(path).find("'" + key + "'"), std::string::npos)
            << key << ": " << errorOfReading(path);
    }

    json wrong = whole;
    wrong["width"] = "wide";
    folder.write("run.json", wrong.dump());
    EXPECT_NE(errorOfReading(path).find("must be number"), std::string::npos)
        << errorOfReading(path);
}

}  // namespace
}  // namespace penumbra
