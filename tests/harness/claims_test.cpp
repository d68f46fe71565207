#include "harness/study/claims.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "harness/study/claims_report.hpp"
#include "harness/study/reproduce.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra {
namespace {

/// Whether `text` has `part` in it; shows both where it is expected to and does not.
::testing::AssertionResult says(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos)
        return ::testing::AssertionSuccess() << "\"" << part << "\" is in: " << text;
    return ::testing::AssertionFailure() << "\"" << part << "\" is not in: " << text;
}

const std::string kClaim = R"(citation = "Someone 1999"
[[claim]]
id     = "one"
claim  = "a is twice b"
place  = "fig. 1"
scene  = "fence"
frame  = 1
a      = "pcf:taps=9;kernel=0.1"
b      = { setting = "pcf:taps=9", light_scale = 2.0, frame = 2, subdivisions = 1 }
metric = "maps"
paper  = 2
expect = "match"
factor = 1.5
why    = "because"
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

class ClaimFiles : public ::testing::Test {
  protected:
    /// With what loadPapers refuses a folder of this one file; empty when it does not.
    std::string errorOf(const std::string& content) const {
        folder.write("p.toml", content);
        try {
            loadPapers(folder.path());
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
    std::string at(int line) const {
        return (folder.path() / "p.toml").string() + ":" + std::to_string(line) + ": ";
    }
    testing::TempFolder folder;
};

TEST_F(ClaimFiles, AreReadAsWritten) {
    folder.write("p.toml", kClaim);
    folder.write("notes.txt", "no claims");
    const std::vector<Paper> papers = loadPapers(folder.path());
    ASSERT_EQ(papers.size(), 1U);
    EXPECT_EQ(papers[0].id, "p");
    EXPECT_EQ(papers[0].citation, "Someone 1999");
    ASSERT_EQ(papers[0].claims.size(), 1U);
    const Claim& claim = papers[0].claims[0];
    EXPECT_EQ(claim.id, "one");
    EXPECT_EQ(claim.statement, "a is twice b");
    EXPECT_EQ(claim.place, "fig. 1");
    EXPECT_EQ(claim.technique, "");
    EXPECT_EQ(claim.a, (ClaimSide{"pcf:taps=9;kernel=0.1", "fence", 1, {}}));
    EXPECT_EQ(claim.b, (ClaimSide{"pcf:taps=9", "fence", 2, {2.0, 1}}));
    EXPECT_EQ(claim.metric, "maps");
    EXPECT_EQ(claim.expected.relation, Relation::match);
    EXPECT_EQ(claim.expected.ratio, 2.0);
    EXPECT_EQ(claim.expected.factor, 1.5);
    EXPECT_EQ(claim.why, "because");
    EXPECT_EQ(claim.found, "");
}

TEST_F(ClaimFiles, ErrorsNameTheFileAndTheLine) {
    const auto changed = [&](const std::string& from, const std::string& to) {
        return errorOf(replaced(kClaim, from, to));
    };
    EXPECT_EQ(errorOf(kClaim), "");
    EXPECT_TRUE(errorOf("citation = \n").starts_with(at(1)));
    EXPECT_EQ(errorOf("citation = \"x\"\n"),
              at(1) + "claims are written as [[claim]], at least one");
    EXPECT_EQ(changed("why    = \"because\"", "wy = 1"),
              at(14) +
                  "unknown key 'wy' in [[claim]]; valid keys are id, claim, place, "
                  "not_implemented, metric, scene, frame, light_scale, subdivisions, a, b, "
                  "paper, expect, factor, why, found");
    EXPECT_EQ(changed("why    = \"because\"", ""), at(2) + "'why' is missing");
    EXPECT_TRUE(says(changed("\"maps\"", "\"mops\""), at(10) + "unknown metric 'mops'; valid"));
    EXPECT_TRUE(says(changed("\"fence\"", "\"hedge\""), at(6) + "unknown scene 'hedge'; scenes"));
    EXPECT_TRUE(says(changed("\"match\"", "\"equal\""),
                     "unknown relation 'equal'; valid are match, at_least, at_most, above_one, "
                     "below_one"));
    EXPECT_TRUE(says(changed("pcf:taps=9;", "pfc:"), at(8)));
    EXPECT_TRUE(says(changed("taps=9;", "taps=0;"), at(8)));
    EXPECT_TRUE(says(changed("taps=9;", "tops=9;"), at(8)));
    EXPECT_EQ(changed("frame  = 1", "frame  = -1"),
              at(7) + "frame must be a whole number in 0..9999");
    EXPECT_EQ(changed("light_scale = 2.0", "light_scale = 0"),
              at(9) + "light_scale must be a finite number above 0");
    EXPECT_EQ(changed("paper  = 2", ""), at(2) + "expect = \"match\" needs 'paper', its ratio");
    const std::string factor =
        "'factor', above 1, goes with expect = \"match\" and with nothing else";
    EXPECT_EQ(changed("factor = 1.5", "factor = 1"), at(13) + factor);
    EXPECT_EQ(changed("\"match\"", "\"at_least\""), at(13) + factor);
    EXPECT_EQ(changed("\"pcf:taps=9;kernel=0.1\"", "\"reference\""),
              at(8) + "reference has a penumbra_width only");
    EXPECT_EQ(
        changed("{ setting = \"pcf:taps=9\", light_scale = 2.0, frame = 2, subdivisions = 1 }",
                "\"pcf:taps=9;kernel=0.1\""),
        at(9) + "b is the same as a");
    EXPECT_EQ(errorOf(kClaim + kClaim.substr(kClaim.find("[["))),
              at(16) + "a claim is called 'one' already");
    EXPECT_EQ(errorOf(kClaim + "not_implemented = \"x\"\n"),
              at(8) +
                  "unknown key 'a' in a claim that is not implemented here; valid keys are id, "
                  "claim, place, not_implemented, paper");
}

TEST_F(ClaimFiles, AnEmptyFolderHoldsNoPaper) {
    EXPECT_THROW(loadPapers(folder.path()), InputError);
    EXPECT_THROW(loadPapers(folder.path() / "absent"), InputError);
}

/// What METHODS's sources promise, by the ratio that each promises.
TEST(ShippedClaims, NameWhatThereIsAndCoverTheHeadlines) {
    const SceneLibrary library = SceneLibrary::standard();
    std::multiset<double> ratios;
    for (const Paper& paper : loadPapers(library.scripts / "papers")) {
        for (const Claim& claim : paper.claims) {
            if (claim.expected.ratio) ratios.insert(*claim.expected.ratio);
            if (!claim.technique.empty()) continue;
            for (const ClaimSide& side : {claim.a, claim.b}) {
                try {
                    EXPECT_LT(side.frame, loadScene(side.scene, library)->frameCount())
                        << paper.id << " " << claim.id;
                } catch (const AssetAbsent&) {  // nothing to ask
                }
            }
        }
    }
    for (const double ratio :
         {10.7, 12.6, 3.7, 4.3, 3.33, 5.8, 5.45, 2.0, 0.66, 25.0, 62.5, 0.125, 12.0})
        EXPECT_TRUE(ratios.contains(ratio)) << ratio;
}

Expectation expecting(Relation relation, std::optional<double> ratio = {}, double factor = 1.0) {
    return {relation, ratio, factor};
}

TEST(Verdict, IsThatOfTheWholeInterval) {
    const double inf = std::numeric_limits<double>::infinity();
    const auto verdict = [](const Expectation& e, double low, double high) {
        return judge(e, {std::sqrt(low * high), low, high});
    };
    const Expectation match = expecting(Relation::match, 4.0, 2.0);
    EXPECT_EQ(verdict(match, 2.0, 8.0), Verdict::holds);
    EXPECT_EQ(verdict(match, 1.9, 3.0), Verdict::undecided);
    EXPECT_EQ(verdict(match, 7.0, 8.1), Verdict::undecided);
    EXPECT_EQ(verdict(match, 1.0, 9.0), Verdict::undecided) << "around all that agrees";
    EXPECT_EQ(verdict(match, 1.0, 1.9), Verdict::does_not_hold);
    EXPECT_EQ(verdict(match, 8.1, 9.0), Verdict::does_not_hold);
    const Expectation atLeast = expecting(Relation::at_least, 4.0);
    EXPECT_EQ(verdict(atLeast, 4.0, 5.0), Verdict::holds);
    EXPECT_EQ(judge(atLeast, Interval::exact(inf)), Verdict::holds);
    EXPECT_EQ(verdict(atLeast, 3.9, 5.0), Verdict::undecided);
    EXPECT_EQ(verdict(atLeast, 3.0, 3.9), Verdict::does_not_hold);
    const Expectation atMost = expecting(Relation::at_most, 4.0);
    EXPECT_EQ(verdict(atMost, 3.0, 4.0), Verdict::holds);
    EXPECT_EQ(verdict(atMost, 3.0, 4.1), Verdict::undecided);
    EXPECT_EQ(verdict(atMost, 4.1, 5.0), Verdict::does_not_hold);
    EXPECT_EQ(verdict(expecting(Relation::above_one), 1.01, 2.0), Verdict::holds);
    EXPECT_EQ(verdict(expecting(Relation::above_one), 1.0, 2.0), Verdict::undecided);
    EXPECT_EQ(judge(expecting(Relation::above_one), Interval::exact(1.0)), Verdict::does_not_hold);
    EXPECT_EQ(verdict(expecting(Relation::below_one), 0.5, 0.9), Verdict::holds);
    EXPECT_EQ(verdict(expecting(Relation::below_one), 1.1, 1.2), Verdict::does_not_hold);
}

ClaimResult resultOf(Verdict verdict) {
    ClaimResult r;
    r.paper = "p";
    r.citation = "Someone 1999";
    r.claim.id = "one";
    r.claim.statement = "a, \"twice\" | b";
    r.claim.metric = "maps";
    r.claim.expected = expecting(Relation::at_least, 2.0);
    r.claim.found = "Half of them were lost.";
    r.verdict = verdict;
    r.a = 3.0;
    r.b = 2.0;
    r.ratio = {1.5, 1.25, 1.75};
    return r;
}

TEST(ClaimsReport, ExplainsOnlyWhatDoesNotHold) {
    for (const Verdict verdict : {Verdict::holds, Verdict::undecided, Verdict::does_not_hold}) {
        const std::vector<ClaimResult> results = {resultOf(verdict)};
        for (const std::string& text :
             {claimsMarkdown(results, {"# Claims"}), claimsText(results)}) {
            EXPECT_TRUE(says(text, "1.5 (1.25 to 1.75)"));
            EXPECT_TRUE(says(text, textOf(verdict)));
            EXPECT_TRUE(says(text, "at least 2"));
            if (verdict == Verdict::does_not_hold)
                EXPECT_TRUE(says(text, "Half of them were lost."));
            else
                EXPECT_FALSE(says(text, "Half of them were lost."));
        }
    }
    // A bar would end the cell.
    EXPECT_TRUE(says(claimsMarkdown({resultOf(Verdict::holds)}, {}), "\"twice\" \\| b |"));
}

TEST(ClaimsReport, IsOneCsvRowPerClaim) {
    ClaimResult absent;
    absent.claim.technique = "magic";
    absent.verdict = Verdict::not_implemented;
    const auto lines = test::lines(claimsCsv({resultOf(Verdict::holds), absent}));
    ASSERT_EQ(lines.size(), 3U);
    EXPECT_TRUE(lines[1].starts_with("p,one,\"a, \"\"twice\"\" | b\",")) << lines[1];
    EXPECT_TRUE(lines[1].ends_with(",2,at least 2,3,2,1.5,1.25,1.75,holds,")) << lines[1];
    EXPECT_TRUE(lines[2].ends_with(",not implemented here,")) << lines[2];
    const auto commas = [](const std::string& line) { return std::ranges::count(line, ','); };
    EXPECT_EQ(commas(lines[0]), commas(lines[2]));
}

/// n pixels that are all off by d under a reference of standard error s: the rmse's own is
/// s/sqrt(n).
TEST(RmseStandardError, IsThatOfAMean) {
    const std::size_t n = 400;
    GBuffer gbuffer;
    gbuffer.mask.assign(n, PixelClass::scored);
    Reference reference;
    reference.visibility.assign(n, 0.5F);
    reference.standardError.assign(n, 0.001F);
    // d = 0.1 >> s = 0.001: the s^4 term is 1e-4 of the other, a twentieth of a thousandth of the
    // root.
    const std::vector<float> image(n, 0.6F);
    EXPECT_NEAR(rmseStandardError(image, reference, gbuffer), 0.001 / 20.0, 1e-8);
    reference.visibility.assign(n, 1.0F);  // all rays agree: certain
    EXPECT_EQ(rmseStandardError(image, reference, gbuffer), 0.0);
    gbuffer.mask.assign(n, PixelClass::background);
    EXPECT_EQ(rmseStandardError(image, reference, gbuffer), 0.0);
}

}  // namespace
}  // namespace penumbra
