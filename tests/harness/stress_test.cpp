// What `penumbra stress` is made of (harness/study/stress): that its invariants can fail, its lists
// are read strictly, and a failure becomes a small scene that shows it again.

#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "core/error.hpp"
#include "harness/study/stress/fuzz.hpp"
#include "harness/study/stress/invariants.hpp"
#include "harness/study/stress/matrix.hpp"
#include "harness/study/stress/output.hpp"
#include "harness/study/stress/shrink.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/fake_methods.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra::stress {
namespace {

/// Answers what `Answer` says of each pixel's position in the world.
template <class Answer>
class Fake : public ShadowMethod {
  public:
    Traits traits() const override { return {{Effect::penumbra}}; }
    std::vector<Assignments> ladder() const override { return {{}}; }
    void prepare(const Scene&, const Plan&) override {}
    void build(const Frame&, const Plan&) override {}
    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        std::vector<float> image;
        for (const glm::vec3& p : frame.gbuffer.position)
            image.push_back(Answer{}(frame, p + glm::vec3(frame.scene.origin)));
        target.upload(image);
    }
};
struct Lit {
    float operator()(const Frame&, const glm::vec3&) const { return 1.0f; }
};
struct Dark {
    float operator()(const Frame&, const glm::vec3&) const { return 0.0f; }
};
/// One pixel in many is not a number: where x is close to one place.
struct NanSomewhere {
    float operator()(const Frame&, const glm::vec3& p) const {
        return std::abs(p.x - 0.1f) < 0.07f ? NAN : 1.0f;
    }
};
struct OverRange {
    float operator()(const Frame&, const glm::vec3&) const { return 1.0f + 1e-6f; }
};
struct WorldDependent {
    float operator()(const Frame& frame, const glm::vec3&) const {
        return frame.scene.origin.x > 1000.0 ? 0.9f : 1.0f;
    }
};
/// Lighter towards -x, but for a dark line.
struct Dented {
    float operator()(const Frame&, const glm::vec3& p) const {
        return p.x > 0.1f ? 0.0f : std::abs(p.x + 0.3f) < 0.05f ? 0.5f : 1.0f;
    }
};
/// Differs by one step of float from call to call.
struct Restless {
    float operator()(const Frame&, const glm::vec3&) const {
        static int calls = 0;
        return ++calls % 3 == 0 ? 0.5f : std::nextafter(0.5f, 1.0f);
    }
};

const Register<Fake<Lit>> kLit{"fake_lit", "All lit", "tests"};
const Register<Fake<Dark>> kDark{"fake_dark", "All dark", "tests"};
const Register<Fake<NanSomewhere>> kNan{"fake_nan", "NaN", "tests"};
const Register<Fake<OverRange>> kOver{"fake_over", "Too light", "tests"};
const Register<Fake<WorldDependent>> kWorld{"fake_world", "Place matters", "tests"};
const Register<Fake<Dented>> kDented{"fake_dented", "A dark line", "tests"};
const Register<Fake<Restless>> kRestless{"fake_restless", "Noise", "tests"};

HardCase floorCase(const std::string& invariant) {
    HardCase c;
    c.id = "test";
    c.file = "test.toml";
    c.invariant = invariant;
    c.bound = 0.01;
    c.size = 16;
    c.scene.bodies = {{"box", {{"lo", {-1, -0.1, -1}}, {"hi", {1, 0, 1}}}}};
    c.scene.cameraPosition = {0, 2, 0};
    return c;
}

/// Half of the floor is shadowed.
HardCase halfCase(const std::string& invariant) {
    HardCase c = floorCase(invariant);
    c.scene.bodies.push_back(
        {"quad", {{"corner", {0, 0.5, 5}}, {"edge_u", {5, 0, 0}}, {"edge_v", {0, 0, -10}}}});
    c.scene.cameraPosition = {0, 0.45, 0};
    c.scene.fovYDeg = 90.0;
    c.direction = {-1, 0, 0};
    return c;
}

Cell run(const HardCase& c, const std::string& method,
         const std::vector<KnownLimitation>& known = {}) {
    return runCase(c, {method}, known, 1).at(0);
}

class StressTest : public test::GlTest {
  protected:
    penumbra::testing::TempFolder folder_;

    std::string refusal(const auto& work) {
        try {
            work();
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
    CaseLibrary library(const std::string& text) {
        folder_.write("one.toml", text);
        return {folder_.path()};
    }
};

TEST_F(StressTest, RangeIsCheckedInEveryCase) {
    for (const char* invariant : {"range", "value", "mean_value", "exact"}) {
        HardCase c = floorCase(invariant);
        c.value = 1.0;
        c.allowed = 0.5;  // spares no pixel that is out of range
        for (const char* broken : {"fake_nan", "fake_over"}) {
            const Cell cell = run(c, broken);
            EXPECT_EQ(cell.status, Status::fail) << invariant << ' ' << broken;
            EXPECT_EQ(cell.invariant, "range");
        }
        EXPECT_EQ(run(c, "fake_lit").status, Status::pass) << invariant;
    }
    EXPECT_TRUE(std::isinf(run(floorCase("range"), "fake_nan").deviation));
}

TEST_F(StressTest, ComparisonsWithTruthCatchAWrongPicture) {
    for (const char* invariant : {"value", "mean_value", "exact", "mean_exact", "hard"}) {
        HardCase c = floorCase(invariant);
        c.value = 1.0;
        const Cell dark = run(c, "fake_dark");
        EXPECT_EQ(dark.status, Status::fail) << invariant;
        EXPECT_EQ(dark.deviation, 1.0) << invariant;
        EXPECT_EQ(run(c, "fake_lit").deviation, 0.0) << invariant;
        // Where half is in shadow, all lit is wrong, too.
        HardCase half = halfCase(invariant);
        half.value = 0.5;
        EXPECT_EQ(run(half, "fake_lit").status, Status::fail) << invariant;
    }
}

TEST_F(StressTest, ComparisonsOfVariantsCatchADependence) {
    for (const char* invariant : {"unchanged", "mean_unchanged"}) {
        HardCase c = floorCase(invariant);
        c.variants.push_back({"offset", c.scene});
        c.variants[0].scene.placement.offset = {1e5, 0, 0};
        const Cell cell = run(c, "fake_world");
        EXPECT_EQ(cell.status, Status::fail) << invariant;
        EXPECT_NEAR(cell.deviation, 0.1, 1e-6) << "0.9f is not 0.9";
        EXPECT_EQ(run(c, "fake_lit").status, Status::pass) << invariant;
    }
}

TEST_F(StressTest, MirroredVariantsAreComparedAsInAMirror) {
    HardCase c = halfCase("unchanged");
    c.variants.push_back({"mirror", c.scene});
    c.variants[0].scene.placement.mirror = true;
    // Rays at the shadow's edge may fall to either side: a column of sixteen.
    c.allowed = 1.0 / 16;
    c.scene.lightSize = c.variants[0].scene.lightSize = {0, 0};
    EXPECT_EQ(run(c, "ray_traced").status, Status::pass);
    EXPECT_EQ(run(c, "fake_dented").status, Status::fail) << "its picture stays where it is";
}

TEST_F(StressTest, MonotoneCatchesADent) {
    EXPECT_EQ(run(halfCase("monotone"), "fake_dented").deviation, 0.5);
    EXPECT_EQ(run(halfCase("monotone"), "fake_lit").status, Status::pass);
    HardCase other = halfCase("monotone");
    other.direction = {1, 0, 0};
    EXPECT_EQ(run(other, "fake_dented").deviation, 1.0);
}

TEST_F(StressTest, RepeatsCatchesTheLeastBit) {
    const HardCase c = floorCase("repeats");
    EXPECT_GT(run(c, "fake_restless").deviation, 0.0);
    EXPECT_EQ(run(c, "fake_lit").status, Status::pass);
}

TEST_F(StressTest, ThrowingFailsRefusingDoesNotApply) {
    const HardCase c = floorCase("range");
    EXPECT_EQ(run(c, "fake_throws_in_build").status, Status::fail);
    const Cell refused = run(c, "fake_refuses");
    EXPECT_EQ(refused.status, Status::notApplicable);
    EXPECT_EQ(refused.note, "needs a light of another shape");
    HardCase needy = floorCase("range");
    needy.needs = {Effect::penumbra, Effect::alpha_mask};
    EXPECT_EQ(run(needy, "fake_lit").note, "does not simulate alpha_mask");
}

TEST_F(StressTest, KnownLimitationsAreKnownAsPredictedOnly) {
    const KnownLimitation known{"test", "fake_dark", 1.0, 0.1, "it is dark", "known.toml:3"};
    HardCase c = floorCase("value");
    c.value = 1.0;
    EXPECT_EQ(run(c, "fake_dark", {known}).status, Status::known);
    EXPECT_FALSE(run(c, "fake_dark", {known}).wrong());
    KnownLimitation less = known;
    less.predicted = 0.5;
    EXPECT_EQ(run(c, "fake_dark", {less}).status, Status::fail) << "worse than predicted";
    c.value = 0.0;
    const Cell mended = run(c, "fake_dark", {known});
    EXPECT_EQ(mended.status, Status::mended);
    EXPECT_TRUE(mended.wrong());
    EXPECT_NE(mended.note.find("known.toml:3"), std::string::npos);
}

TEST_F(StressTest, KnownFileIsReadStrictly) {
    const auto message = [&](const std::string& text) {
        const auto file = folder_.write("known.toml", text);
        return refusal([&] { readKnown(file, {"one", "two"}); });
    };
    const std::string good =
        "[[known]]\ncase = \"one\"\nmethod = \"hard\"\npredicted = 1\ntolerance = 0.1\n"
        "because = \"it is\"\n";
    EXPECT_EQ(message(good), "");
    EXPECT_TRUE(message(good + good).ends_with("known.toml:8: one with hard is listed already"));
    EXPECT_NE(message("[[known]]\ncase = \"three\"")
                  .find("known.toml:2: unknown case 'three'; the "
                        "cases are one, two"),
              std::string::npos);
    EXPECT_NE(message("[[known]]\ncase = \"one\"\nmethod = \"soft\"")
                  .find("known.toml:3: unknown method 'soft'; the methods are "),
              std::string::npos);
    EXPECT_NE(message(good + "why = 1").find("known.toml:7: unknown key 'why' in [[known]]"),
              std::string::npos);
    EXPECT_NE(message("[[known]]\ncase = \"one\"\nmethod = \"hard\"").find("needs 'predicted'"),
              std::string::npos);
    EXPECT_NE(message("[[known]\n").find("known.toml:1: "), std::string::npos);
    EXPECT_TRUE(readKnown(folder_.path() / "none.toml", {}).empty());
}

TEST_F(StressTest, ElsewhereFileIsReadStrictly) {
    const auto message = [&](const std::string& text) {
        const auto file = folder_.write("elsewhere.toml", text);
        return refusal([&] { readElsewhere(file); });
    };
    const std::string good = "[[elsewhere]]\nnumber = 58\nwhat = \"x\"\nbecause = \"so\"\n";
    EXPECT_EQ(message(good), "");
    EXPECT_TRUE(message(good + good).ends_with("elsewhere.toml:6: 58 is listed already"));
    EXPECT_NE(message("[[elsewhere]]\nnumber = 59").find("elsewhere.toml:2: "), std::string::npos);
    EXPECT_NE(message("[[elsewhere]]\nnumber = 1\nwhat = \"x\"").find("needs 'because'"),
              std::string::npos);
    EXPECT_TRUE(readElsewhere(folder_.path() / "none.toml").empty());
}

TEST_F(StressTest, EveryHardCaseIsACaseOrElsewhere) {
    const CaseLibrary cases = CaseLibrary::standard();
    std::map<int, std::string> found;
    for (const std::string& id : cases.ids())
        for (const int number : cases.load(id).numbers) found[number] = id;
    std::string sources;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(PENUMBRA_TEST_DIR))
        if (entry.path().extension() == ".cpp") sources += test::readText(entry.path());
    for (const Elsewhere& entry : readElsewhere(cases.folder / "elsewhere.toml")) {
        EXPECT_FALSE(found.contains(entry.number))
            << entry.number << " is in " << found[entry.number];
        found[entry.number] = "elsewhere";
        for (const std::string& test : entry.tests) {
            const std::size_t dot = test.find('.');
            const std::string name =
                "(" + test.substr(0, dot) + ", " + test.substr(dot + 1) + ") {";
            EXPECT_NE(sources.find(name), std::string::npos) << test;
        }
    }
    for (int number = 1; number <= kNumbers; ++number)
        EXPECT_TRUE(found.contains(number)) << number;
}

TEST_F(StressTest, CaseFilesAreReadStrictly) {
    const std::string good =
        "shows = \"a floor\"\ninvariant = \"value\"\nbound = 0.1\nbecause = \"so\"\n"
        "[[body]]\nkind = \"quad\"\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, -1]\n";
    const auto message = [&](const std::string& text) {
        const CaseLibrary cases = library(text);
        return refusal([&] { cases.load("one"); });
    };
    EXPECT_EQ(message(good), "");
    EXPECT_NE(message("shows = \"x\"\ninvariant = \"nice\"")
                  .find("one.toml:2: unknown invariant 'nice'; there are range, repeats"),
              std::string::npos);
    EXPECT_NE(message(good + "[[body]]\nkind = \"cow\"")
                  .find("one.toml:11: unknown kind of body 'cow'; there are box, "),
              std::string::npos);
    EXPECT_NE(message(good + "width = 3")
                  .find("one.toml:10: unknown key 'width' in [[body]]; "
                        "valid are corner, edge_u, edge_v, kind"),
              std::string::npos);
    EXPECT_NE(message(good + "[[variant]]\nscale = 2").find("'value' does not take a [[variant]]"),
              std::string::npos);
    EXPECT_NE(message(good + "[light]\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\nsize = [1, 0]")
                  .find("one.toml:13: size must be"),
              std::string::npos);
    EXPECT_NE(message(good + "[[setting]]\nmethod = \"hard\"\nset = { cows = 3 }").find("'cows'"),
              std::string::npos);
    EXPECT_NE(
        refusal([&] { library(good).load("two"); }).find("unknown case 'two'; the cases are "),
        std::string::npos);
}

TEST_F(StressTest, OutputsSayWhatIsWrong) {
    Matrix matrix;
    HardCase c = floorCase("value");
    c.value = 1.0;
    matrix.cases = {c};
    matrix.methods = {"fake_lit", "fake_dark"};
    matrix.cells = runCase(c, matrix.methods, {}, 1);
    EXPECT_TRUE(matrix.wrong());
    EXPECT_NE(tableText(matrix).find("2 cells: 1 pass, 0 known, 1 failed"), std::string::npos);
    EXPECT_NE(csvText(matrix).find("test,fake_dark,fake_dark,value,FAIL,1,0.01,"),
              std::string::npos);
    EXPECT_NE(junitText(matrix).find("failures=\"1\""), std::string::npos);
    EXPECT_NE(markdownText(matrix).find("| test | pass 0 | FAIL 1 |"), std::string::npos);
    writeMatrix(matrix, folder_.path() / "out");
    for (const char* name : {"stress.csv", "junit.xml", "stress.md"})
        EXPECT_TRUE(std::filesystem::exists(folder_.path() / "out" / name)) << name;
}

TEST_F(StressTest, WrittenScenesAreTheSame) {
    SmallScene scene = halfCase("range").scene;
    scene.placement = {2.0, {10, 20, 30}, false, {1e5, 0, -1e5}};
    scene.write(folder_.path() / "draw", {"a comment"});
    const auto made = scene.build();
    const auto loaded =
        loadScene((folder_.path() / "draw.toml").string(), SceneLibrary::standard());
    const SceneFrame a = made->frame(0), b = loaded->frame(0);
    EXPECT_LT(glm::distance(made->origin, loaded->origin), 1e-6);
    EXPECT_LT(glm::distance(a.light.centre, b.light.centre), 1e-6);
    EXPECT_NEAR(a.light.halfU, b.light.halfU, 1e-12);
    EXPECT_LT(glm::distance(a.light.normal(), b.light.normal()), 1e-12);
    EXPECT_LT(glm::distance(a.camera.back, b.camera.back), 1e-9);
    ASSERT_EQ(a.geometry->triangleCount(), b.geometry->triangleCount());
    // Two roundings to float of coordinates below 16 metres.
    for (std::size_t i = 0; i < a.geometry->indices.size(); ++i)
        EXPECT_LT(glm::distance(a.geometry->positions[a.geometry->indices[i]],
                                b.geometry->positions[b.geometry->indices[i]]),
                  2e-6f);
}

TEST(StressShrink, KeepsOnlyWhatFails) {
    Draw draw = drawRandom(7, 0, {"hard"});
    draw.scene.bodies = {
        {"box", {{"lo", {-1, -0.1, -1}}, {"hi", {1, 0, 1}}}},
        {"sphere", {{"centre", {0.123, 0.5, 0}}, {"radius", {0.2}}, {"rings", {8}}}},
        {"box", {{"lo", {0, 0.3, 0}}, {"hi", {0.2, 0.5, 0.3}}}}};
    draw.scene.placement = {3.0, {10, 0, 0}, false, {1e5, 0, 0}};
    draw.assignments = {{"bias", "2"}, {"map_size", "64"}};
    const auto fails = [](const Draw& d) {
        return std::ranges::any_of(d.scene.bodies,
                                   [](const Body& b) { return b.kind == "sphere"; }) &&
               std::ranges::any_of(d.assignments, [](const auto& a) { return a.first == "bias"; });
    };
    const Draw small = shrink(draw, fails);
    ASSERT_EQ(small.scene.bodies.size(), 1u);
    EXPECT_EQ(small.scene.bodies[0].kind, "sphere");
    EXPECT_EQ(small.assignments, (Assignments{{"bias", "2"}}));
    EXPECT_EQ(small.scene.placement, Placement{});
    EXPECT_EQ(small.size, 8);
    EXPECT_TRUE(fails(small));
}

TEST(StressDraws, DependOnSeedAndIndexOnly) {
    const std::vector<std::string> methods = {"hard", "pcf"};
    EXPECT_EQ(drawRandom(3, 5, methods).scene, drawRandom(3, 5, methods).scene);
    EXPECT_FALSE(drawRandom(3, 5, methods).scene == drawRandom(3, 6, methods).scene);
    EXPECT_FALSE(drawRandom(3, 5, methods).scene == drawRandom(4, 5, methods).scene);
}

TEST_F(StressTest, ABrokenMethodIsFoundShrunkAndWritten) {
    TruthBounds bounds;
    bounds.general.meanBeyondHard = 1.0;
    const FuzzOptions options{1, 3, {"fake_over"}, folder_.path() / "found"};
    const FuzzResult result = fuzz(options, bounds, [](std::uint32_t) {});
    ASSERT_FALSE(result.failures.empty());
    const FuzzFailure& first = result.failures[0];
    EXPECT_EQ(first.failure.check, "range");
    EXPECT_EQ(first.draw.scene.bodies.size(), 1u);
    ASSERT_TRUE(std::filesystem::exists(first.script));
    EXPECT_GT(loadScene(first.script.string(), SceneLibrary::standard())->radiusM, 0.0);
}

TEST_F(StressTest, TruthBoundsCatchAMethodThatIgnoresShadows) {
    TruthBounds bounds;
    bounds.general.meanBeyondHard = 0.0;
    Draw draw;
    draw.scene = halfCase("range").scene;
    draw.method = "fake_lit";
    const DrawResult wrong = checkDraw(draw, bounds);
    ASSERT_TRUE(wrong.failure);
    EXPECT_EQ(wrong.failure->check, "truth");
    draw.method = "ray_traced";
    bounds.own["ray_traced"] = {"rays", 0.83, 0.0, ""};
    EXPECT_FALSE(checkDraw(draw, bounds).failure);
    draw.scene.lightSize = {0, 0};
    draw.method = "fake_lit";
    EXPECT_EQ(checkDraw(draw, bounds).failure->check, "hard");
}

}  // namespace
}  // namespace penumbra::stress
