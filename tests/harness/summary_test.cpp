#include "harness/report/summary.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace penumbra {
namespace {

Row okRow(const std::string& scene, const std::string& setting, double frameMs, double rmse) {
    Row row;
    row.scene = scene;
    row.method = row.setting = setting;
    row.frameMs = frameMs;
    row.frameMsLow = 0.9 * frameMs;
    row.frameMsHigh = 1.1 * frameMs;
    row.buildMs = 0.25 * frameMs;
    row.shadeMs = 0.75 * frameMs;
    row.metrics.rmse = rmse;
    row.metrics.rmsePenumbra = 2 * rmse;
    row.metrics.bias = -rmse;
    row.metrics.leakRate = 0.125;
    row.metrics.referenceSe = 0.000976;
    row.shadeFetchesPerPixel = 3 * frameMs;
    row.renderer = "llvmpipe";
    return row;
}

/// The first line that starts with `start`, or "".
std::string lineStarting(const std::string& text, const std::string& start) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with(start)) return line;
    }
    return {};
}
std::size_t pipes(const std::string& line) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < line.size(); ++i)
        n += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    return n;
}
bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(Summary, EmptyRunSaysThatNothingIsWrong) {
    const std::string text = summaryMarkdown({});
    EXPECT_TRUE(text.starts_with("# Penumbra run\n"));
    EXPECT_TRUE(contains(text, "## Warnings\n\nNone."));
}

TEST(Summary, ProvenanceComesFirst) {
    SummaryInput input;
    input.title = "standard suite";
    input.provenance = {{"renderer", "llvmpipe"}, {"command", "penumbra compare --suite standard"}};
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(
        text.starts_with("# standard suite\n\n- renderer: llvmpipe\n"
                         "- command: penumbra compare --suite standard\n"));
}

TEST(Summary, WarningsNameWhatWentWrongBeforeAnyTable) {
    SummaryInput input;
    Row failed = okRow("fence", "hard", 1, 0.1);
    failed.status = "failed";
    failed.message = "GL_OUT_OF_MEMORY";
    Row unsupported = okRow("fence", "pcf", 1, 0.1);
    unsupported.status = "unsupported";
    unsupported.message = "the light view would be 151 degrees wide";
    Row unstable = okRow("fence", "a", 20, 0.1);
    unstable.unstable = true;
    unstable.effectsMissing = "layered_casters";
    unstable.metrics.nonfinite = 17;
    input.rows = {failed, unsupported, unstable};
    input.skippedScenes = {{"bunny", "glmark2-data is not installed"}};
    const std::string text = summaryMarkdown(input);
    const std::string head = text.substr(0, text.find("## Settings"));
    ASSERT_LT(head.size(), text.size());
    EXPECT_TRUE(contains(head,
                         "**Failed cells: 1**\n\n- fence, frame 0, hard: failed "
                         "GL_OUT_OF_MEMORY\n"));
    EXPECT_TRUE(contains(head, "- fence, frame 0, pcf: the light view would be 151 degrees wide"));
    EXPECT_TRUE(contains(head, "- bunny: glmark2-data is not installed"));
    EXPECT_TRUE(contains(head, "- fence, frame 0, a: 20.0 ms [18.0, 22.0]"));
    EXPECT_TRUE(contains(head, "- fence, frame 0, a: layered_casters"));
    EXPECT_TRUE(contains(head, "- fence, frame 0, a: 17 pixels"));
    EXPECT_FALSE(contains(head, "None."));
}

TEST(Summary, LongWarningListsAreCut) {
    SummaryInput input;
    for (int i = 0; i < 25; ++i) input.skippedScenes.emplace_back("scene" + std::to_string(i), "x");
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text, "**Skipped scenes: 25**"));
    EXPECT_TRUE(contains(text, "- scene19: x\n- … and 5 more"));
    EXPECT_FALSE(contains(text, "scene20"));
}

TEST(Summary, OverviewAveragesCellsAndComparesTimesWithinAScene) {
    SummaryInput input;
    // b takes twice the fastest in one scene and eight times in the other: geometric mean 4.
    input.rows = {okRow("s1", "b", 20, 0.2), okRow("s1", "a", 10, 0.1), okRow("s2", "b", 800, 0.4),
                  okRow("s2", "a", 100, 0.3)};
    Row failed = okRow("s3", "b", 1, 0.0);
    failed.status = "failed";
    input.rows.push_back(failed);
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text,
                         "| a |  | 2 | 2/2 | 0.200 | 0.400 | -0.200 | 12.5 % |  | 1.00 | 165 |\n"
                         "| b |  | 2 | 2/3 | 0.300 | 0.600 | -0.300 | 12.5 % |  | 4.00 | 1230 |\n"))
        << text;
}

TEST(Summary, TimesOfDifferentRenderersAreNotCompared) {
    SummaryInput input;
    input.rows = {okRow("s", "a", 10, 0.1), okRow("s", "b", 1000, 0.2)};
    input.rows[1].renderer = "another";
    const std::string line = lineStarting(summaryMarkdown(input), "| b |");
    EXPECT_TRUE(line.ends_with("| 1.00 | 3000 |")) << line;
}

TEST(Summary, SceneTableHasEachCell) {
    SummaryInput input;
    input.rows = {okRow("s", "b", 20, 0.0123456), okRow("s", "a", 1234.5, 0.00001)};
    input.rows[0].metrics.maxError = 0.5;
    input.rows[0].drawCalls = 12;
    const std::string text = summaryMarkdown(input);
    ASSERT_TRUE(contains(text, "### s\n"));
    const std::string scene = text.substr(text.find("### s\n"));
    EXPECT_EQ(lineStarting(scene, "| 0 | b |"),
              "| 0 | b | ok | 0.0123 ± 0.000976 | 0.0247 | -0.0123 |  | 0.500 | 12.5 % |  | "
              "20.0 [18.0, 22.0] | 5.00 | 15.0 |  | 12 |");
    EXPECT_TRUE(contains(lineStarting(scene, "| 0 | a |"), "| 1.00e-05 ± ")) << "tiny";
    EXPECT_LT(scene.find("| 0 | a |"), scene.find("| 0 | b |")) << "not in the order measured";
}

TEST(Summary, CellsCannotBreakTheTable) {
    SummaryInput input;
    Row row = okRow("a|b", "x|y", 1, 0.1);
    row.status = "ok";
    row.method = "x";
    row.params = "k=1|2\nl=<b>*3*";
    input.rows = {row};
    const std::string text = summaryMarkdown(input);
    const std::string line = lineStarting(text, "| x\\|y |");
    EXPECT_EQ(pipes(line), 12U) << line;
    EXPECT_TRUE(contains(line, "k=1\\|2<br>l=&lt;b>\\*3\\*")) << line;
    EXPECT_EQ(pipes(lineStarting(text, "| 0 | x\\|y |")), 16U);
}

TEST(Summary, SnakeCaseStaysReadable) {
    SummaryInput input;
    input.skippedScenes = {{"ray_traced", "_em_ 1_ x"}};
    EXPECT_TRUE(contains(summaryMarkdown(input), "- ray_traced: \\_em\\_ 1\\_ x\n"));
}

/// What separating costs in `scene`.
Row separationRow(const std::string& scene, int frame, double rmse) {
    Row row = okRow(scene, "separation", 1, rmse);
    row.frame = frame;
    row.frameMs = row.frameMsLow = row.frameMsHigh = row.buildMs = row.shadeMs = std::nullopt;
    row.metrics.p99 = 3 * rmse;
    row.metrics.maxError = 4 * rmse;
    return row;
}

TEST(Summary, TheSeparationHasATableOfItsOwn) {
    SummaryInput input;
    input.rows = {okRow("s", "a", 10, 0.2), okRow("s", "b", 20, 0.1), separationRow("s", 0, 0.02),
                  separationRow("s", 1, 0.04), separationRow("t", 0, 0.25)};
    input.rows.push_back(okRow("s", "a", 10, 0.3));
    input.rows.back().frame = 1;
    const std::string text = summaryMarkdown(input);
    const std::size_t start = text.find("## What separating shading from visibility costs");
    ASSERT_NE(start, std::string::npos);
    // b would be better, but lacks a frame.
    EXPECT_EQ(lineStarting(text.substr(start), "| s |"),
              "| s | 2 | 0.0300 | 0.0600 | 0.0900 | 0.160 | -0.0300 | a | 12.0 % |");
    EXPECT_EQ(lineStarting(text.substr(start), "| t |"),
              "| t | 1 | 0.250 | 0.500 | 0.750 | 1.00 | -0.250 |  |  |");
    EXPECT_FALSE(contains(text.substr(0, start), "separation")) << "it is no method";
    EXPECT_FALSE(contains(text, "### t")) << "no method ran there";
    input.rows = {okRow("s", "a", 10, 0.2)};
    EXPECT_FALSE(contains(summaryMarkdown(input), "## What separating"));
}

TEST(Summary, PenumbraeOnStraightEdges) {
    SummaryInput input;
    input.rows = {okRow("s", "b", 10, 0.2), okRow("s", "a", 20, 0.1), okRow("t", "a", 20, 0.1)};
    input.rows[0].metrics.penumbraWidthError = -0.985;
    input.rows[0].metrics.penumbraShift = 0.0125;
    input.rows[1].metrics.penumbraWidthError = 0.0;
    input.rows[1].metrics.penumbraShift = 0.0;
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text,
                         "| s | 0 | a | 0 % | 0 % |\n"
                         "| s | 0 | b | -98.5 % | 1.25 % |\n\n"))
        << text;
    input.rows.erase(input.rows.begin(), input.rows.begin() + 2);
    EXPECT_FALSE(contains(summaryMarkdown(input), "straight edges"));
}

/// A setting of the ladder of `method`.
Row rung(const std::string& scene, const std::string& method, int step, double frameMs,
         double rmse) {
    Row row = okRow(scene, method, frameMs, rmse);
    row.setting += '-' + std::to_string(step);
    row.params = "filter=box;taps=" + std::to_string(step);
    return row;
}

TEST(Summary, WhatAccuracyCosts) {
    SummaryInput input;
    for (const char* scene : {"s", "t"}) {
        Row hard = okRow(scene, "hard", 1, 0.4);
        hard.params = "map_size=1024";
        input.rows.insert(input.rows.end(),
                          {hard, rung(scene, "a", 4, 4, 0.16), rung(scene, "a", 9, 40, 0.016),
                           rung(scene, "b", 4, 5, 0.2)});
    }
    Row refused = rung("s", "q", 1, 2, 0.01);
    input.rows.push_back(refused);
    refused.scene = "t";
    refused.status = "unsupported";
    input.rows.push_back(refused);
    input.studies = costStudies(input.rows, "rmse");
    const std::string text = summaryMarkdown(input);
    const std::size_t start = text.find("## What accuracy costs\n");
    ASSERT_NE(start, std::string::npos);
    EXPECT_LT(start, text.find("## Scenes"));
    const std::string section = text.substr(start, text.find("## Scenes") - start);

    EXPECT_TRUE(contains(section,
                         "- q-1: 1 of 2 frames, 1 of 2 scenes; nothing more accurate is as fast "
                         "there\n"))
        << section;
    // b is beaten by a-4, which also is the sooner to reach half of what hard has.
    EXPECT_TRUE(contains(
        section,
        "| **all scenes** | hard |  | 0.400 | 1.00 [0.900, 1.10] | 1.00 | 4.00 | a-4 |\n"
        "| **all scenes** | a-4 | taps=4 | 0.160 | 4.00 [3.60, 4.40] | 4.00 | 10.0 | a-9 |\n"
        "| **all scenes** | a-9 | taps=9 | 0.0160 | 40.0 [36.0, 44.0] | 40.0 | none |  |\n\n"))
        << section;
    EXPECT_TRUE(
        contains(section, "| **all scenes** | 40.0 ms a-9 | 40.0 ms a-9 | 40.0 ms a-9 | – | – |\n"))
        << section;
    EXPECT_TRUE(
        contains(section, "| s | 2.00 ms q-1 | 2.00 ms q-1 | 2.00 ms q-1 | 2.00 ms q-1 | – |\n"))
        << section;
    EXPECT_TRUE(contains(section, "| b | – | – | – | – | – |\n")) << section;
    EXPECT_TRUE(contains(section,
                         "| **all scenes** | 1.00 | 0.400 hard | 0.400 hard | 0.160 a-4 | 0.160 "
                         "a-4 | 0.0160 a-9 |\n"))
        << section;
}

TEST(Summary, TheErrorIsWhatItWasAskedToBe) {
    SummaryInput input;
    input.rows = {rung("s", "a", 1, 10, 0.2), rung("s", "a", 2, 20, 0.1)};
    input.rows[0].metrics.ssim = 0.5;
    input.rows[1].metrics.ssim = 0.75;
    input.costMetric = "ssim";
    input.studies = costStudies(input.rows, "ssim");
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text, "| scene | 1 - ssim ≤ 0.1 |")) << text;
    EXPECT_TRUE(contains(text, "| s | a-1 | taps=1 | 0.500 | 10.0 [9.00, 11.0] |  | 2.00 | a-2 |"))
        << text;
    EXPECT_FALSE(contains(text, "within a multiple")) << "nothing to take multiples of";
    EXPECT_FALSE(contains(text, "<details>")) << "one scene has one table";
    input.studies.clear();
    EXPECT_FALSE(contains(summaryMarkdown(input), "## What accuracy costs"));
}

TEST(Summary, ReferenceTable) {
    SummaryInput input;
    input.references = {{.scene = "s",
                         .frame = 2,
                         .rays = 60e6,
                         .seconds = 2.0,
                         .cached = false,
                         .penumbraPixels = 25,
                         .scoredPixels = 200,
                         .uniformEquivalentRays = 300e6},
                        {.scene = "t",
                         .frame = 0,
                         .rays = 40e6,
                         .seconds = 0.01,
                         .cached = true,
                         .penumbraPixels = 0,
                         .scoredPixels = 0,
                         .uniformEquivalentRays = 100e6}};
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text, "| s | 2 | traced | 60.0 M | 30.0 M | 2.00 s | 12.5 % | 0.200 |\n"))
        << text;
    EXPECT_TRUE(contains(text, "| t | 0 | cached | 40.0 M |  | 0.0100 s |  | 0.400 |\n")) << text;
    EXPECT_TRUE(contains(text, "- Reference rays per second over the run: 30.0 M\n"));
    EXPECT_TRUE(contains(text, "adaptive / uniform, over the run: 0.250\n"));
}

TEST(Summary, EffectsWithTheirEvidence) {
    SummaryInput input;
    EffectsRecord record{"fence", 0, 100.0, 2.5, {}};
    for (const EffectInfo& info : allEffects())
        record.findings[info.effect] = {false, "nothing lies between"};
    record.findings[Effect::layered_casters] = {true, "31 % of 1024 sampled light rays"};
    EffectsRecord second = record, third = record;
    second.frame = 1, third.frame = 2;
    third.findings[Effect::layered_casters] = {false, "casters are convex"};
    input.analysis = {record, third, second};  // as a resumed run leaves them
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text, "| fence | 0 to 1 | layered_casters |\n| fence | 2 | nothing |\n"));
    EXPECT_TRUE(contains(
        text, "| fence | 0 to 1 | layered_casters | yes | 31 % of 1024 sampled light rays |\n"));
    EXPECT_TRUE(contains(text, "| fence | 2 | layered_casters | no | casters are convex |\n"));
    EXPECT_TRUE(contains(text, "| fence | 0 | 100 | 2.50 | 2.50 % |\n"));
    EXPECT_TRUE(contains(text, "| all |  | 300 | 7.50 | 2.50 % |\n"));
}

TEST(Summary, WhatMethodsCanSimulateIsByTheirTraits) {
    SummaryInput input;
    input.rows = {okRow("fence", "hard", 1, 0.1), okRow("fence", "penumbra_quads", 1, 0.1),
                  okRow("fence", "another_renderer", 1, 0.1)};
    const std::string text = summaryMarkdown(input);
    const std::string table = text.substr(text.find("## What methods can simulate"));
    EXPECT_EQ(lineStarting(table, "| hard "),
              "| hard | **no** | yes | yes | yes | yes | yes | yes | yes |");
    EXPECT_EQ(lineStarting(table, "| penumbra_quads "),
              "| penumbra_quads | yes | yes | yes | yes | **no** | yes | yes | yes |");
    EXPECT_EQ(lineStarting(table, "| another"), "");
    EXPECT_FALSE(contains(summaryMarkdown({}), "can simulate"));
}

TEST(Summary, PhasesAddUpAndNameTheOverhead) {
    SummaryInput input;
    input.phases = {{"prepare", 3}, {"reference", 60}, {"methods", 30}, {"images", 6}, {"rest", 1}};
    const std::string text = summaryMarkdown(input);
    EXPECT_TRUE(contains(text, "| reference | 60.0 s | 60.0 % |\n"));
    EXPECT_TRUE(contains(text, "| total | 100 s |  |\n"));
    EXPECT_TRUE(contains(text, "Outside reference, methods and images: 4.00 % of the run.\n"));
}

}  // namespace
}  // namespace penumbra
