#include "harness/gate/gate_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "harness/report/benchmark.hpp"
#include "harness/report/escape.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/gate_rows.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra::gate {
namespace {

using test::baselineOf;
using test::gateRow;
using test::runOf;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Names that mean something in every format there is, and bytes that are no text.
const std::string kHostile =
    "a,\"b\" <script>alert('x')</script> & | ]]> %25\r\n::error::owned \x01 \xff \xe2\x82\xac";

struct Judged {
    JudgedRun run;
    Verdict verdict;
};

/// A leak, a vanished row and a new one, all in scenes with that name.
Judged judgedHostile() {
    const Row before = gateRow(kHostile, "pcss"), gone = gateRow(kHostile, "gone");
    Row after = before;
    after.metrics.leakRate = 0.25;
    after.message = after.params = kHostile;
    const JudgedRun run = runOf({after, gateRow(kHostile, "fresh")});
    return {run, judge(baselineOf({before, gone}), run, {})};
}

TEST(Escape, EachFormatKeepsTheTextAndNothingElse) {
    EXPECT_EQ(printable("a\nb\r\nc\td\x1b[31m"), "a b c d\uFFFD[31m");
    EXPECT_EQ(xmlEscaped("<a b=\"1\" c='2'>&\n\x02"),
              "&lt;a b=&quot;1&quot; c=&#39;2&#39;&gt;&amp;&#10;\uFFFD");
    EXPECT_EQ(commandData("50 %\r\n::error::x"), "50 %25%0A::error::x");
    EXPECT_EQ(commandProperty("a:b,c%"), "a%3Ab%2Cc%25");
}

TEST(Escape, OnlyCharactersThatXmlAllowsStay) {
    const std::string euro = "\xe2\x82\xac", emoji = "\xf0\x9f\x8c\x92";
    EXPECT_EQ(printable(euro + emoji), euro + emoji);
    for (const std::string& bad :
         {std::string("\xff"), std::string("\xc0\x80"), std::string("\xed\xa0\x80"),
          std::string("\xf5\x80\x80\x80"), std::string("\xef\xbf\xbe"), std::string("\xe2\x82")})
        EXPECT_THAT(printable(bad + "|"), AllOf(HasSubstr("\uFFFD"), Not(HasSubstr(bad)))) << bad;
}

TEST(Junit, IsWellFormedWhateverTheNames) {
    const auto [run, verdict] = judgedHostile();
    const testing::TempFolder folder;
    const auto file = folder.write("junit.xml", verdictJunit(verdict, run));
    const auto script = folder.write("parse.py", R"(
import sys, xml.etree.ElementTree as tree
suite = tree.parse(sys.argv[1]).getroot().find('testsuite')
cases = suite.findall('testcase')
assert int(suite.get('tests')) == len(cases), len(cases)
assert int(suite.get('failures')) == len(suite.findall('testcase/failure'))
assert int(suite.get('skipped')) == len(suite.findall('testcase/skipped'))
assert all(case.get('name') and case.get('classname') for case in cases)
for case in cases:
    failure = case.find('failure')
    if failure is not None:
        print(failure.get('type'), failure.get('message'))
        print(case.get('name').encode('ascii', 'backslashreplace').decode())
)");
    const test::Finished done =
        test::Program({"/usr/bin/python3", script.string(), file.string()}).wait();
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr("regression leak_rate 0 -> 0.25 (+0.25)"));
    EXPECT_THAT(done.out, HasSubstr("missing row vanished: the run has no such row"));
    EXPECT_THAT(done.out, HasSubstr("<script>alert('x')</script> & | ]]> %25\n::error::owned"))
        << "the name means itself again once it is parsed";
}

TEST(Annotations, NamesCannotMakeCommands) {
    const auto [run, verdict] = judgedHostile();
    const std::string text = verdictAnnotations(verdict, run);
    for (const std::string& line : test::lines(text))
        EXPECT_TRUE(line.starts_with("::error title=")) << line;
    EXPECT_EQ(test::lines(text).size(), 2u) << text;
    EXPECT_THAT(text, HasSubstr("%2525%0A%3A%3Aerror%3A%3Aowned")) << "in a title";
    EXPECT_THAT(text, HasSubstr("::leak_rate 0 -> 0.25 (+0.25); allowed 0.000488"));
    for (const std::string& line : test::lines(verdictText(verdict, run)))
        EXPECT_FALSE(line.starts_with("::")) << line;
}

TEST(Annotations, TheTenthCountsTheOthers) {
    std::vector<Row> rows;
    for (int frame = 0; frame < 12; ++frame) rows.push_back(gateRow("fence", "pcss", frame));
    const JudgedRun run = runOf({gateRow("fence", "hard")});
    const Verdict verdict = judge(baselineOf(rows), run, {});
    const auto lines = test::lines(verdictAnnotations(verdict, run));
    ASSERT_EQ(lines.size(), 10u);
    EXPECT_EQ(lines.back(), "::error title=penumbra::and 3 more, see junit.xml");
}

TEST(VerdictMarkdown, NamesStayInTheirCells) {
    const auto [run, verdict] = judgedHostile();
    const std::string text = verdictMarkdown(verdict, run);
    EXPECT_THAT(text, Not(HasSubstr("<script")));
    EXPECT_THAT(text,
                HasSubstr("**the gate fails: 7 gates, 4 passed, 1 failed, 1 missing, 1 new**"));
    for (const std::string& line : test::lines(text)) {
        if (!line.starts_with("|")) continue;
        std::size_t bars = 0;
        for (std::size_t i = 0; i < line.size(); ++i)
            bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
        EXPECT_EQ(bars, 5u) << line;  // four cells
    }
}

TEST(VerdictText, SaysWhatWhereHowMuchAndHowToSeeIt) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.metrics.leakRate = 0.25;
    const testing::TempFolder folder;
    JudgedRun run = runOf({after});
    run.folder = folder.path();
    std::filesystem::create_directories(folder.path() / "grid");
    std::filesystem::create_directories(folder.path() / "images/fence/0000");
    folder.write("grid/fence.png", "");
    folder.write("images/fence/0000/pcss.exr", "");
    const std::string text = verdictText(judge(baselineOf({before}), run, {}), run);
    EXPECT_EQ(text,
              "FAIL fence frame 0 pcss: accuracy\n"
              "    leak_rate 0 -> 0.25 (+0.25); allowed 0.000488 (an image is deterministic "
              "on one renderer; another one's rounding moves means by less); the references' "
              "noise explains 0.00566\n"
              "    look at " +
                  (folder.path() / "grid/fence.png").string() + ", " +
                  (folder.path() / "images/fence/0000/pcss.exr").string() +
                  "\n"
                  "    run penumbra compare --scene fence --method pcss --size 512x512 "
                  "--repeats 5 --threads 2\n"
                  "the gate fails: 5 gates, 4 passed, 1 failed\n");
}

TEST(BenchmarkJson, HasTheFieldsThatDashboardsTake) {
    Row row = gateRow(kHostile, "pcss"), failed = gateRow("fence", "hard");
    failed.status = "failed";
    Row separation = gateRow("fence", "separation");
    separation.frameMs.reset();
    const auto json = nlohmann::json::parse(benchmarkJson({row, failed, separation}));
    ASSERT_EQ(json.size(), 3u) << "time and rmse, nothing of the failed row, rmse alone";
    for (const auto& entry : json) {
        ASSERT_EQ(entry.size(), 5u);
        EXPECT_TRUE(entry.at("value").is_number());
        for (const char* field : {"name", "unit", "range", "extra"})
            EXPECT_TRUE(entry.at(field).is_string()) << field;
    }
    EXPECT_EQ(json[0].at("unit"), "ms");
    EXPECT_EQ(json[0].at("value"), 10.0);
    EXPECT_EQ(json[0].at("range"), "9.8 .. 10.2");
    EXPECT_EQ(json[2].at("name"), "fence frame 0 separation: rmse");
}

}  // namespace
}  // namespace penumbra::gate
