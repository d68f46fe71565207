// Every method and the reference: the same command gives the same rows, but for times, and the same
// images and pictures, on any number of threads.
#include <ostream>

#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

struct Work {
    std::string scene, reference;
    friend std::ostream& operator<<(std::ostream& out, const Work& work) {
        return out << work.scene << ", reference " << work.reference;
    }
};

class Determinism : public ::testing::TestWithParam<Work> {};

TEST_P(Determinism, ThreadsChangeNothing) {
    const testing::TempFolder folder;
    const auto path = [&](const std::string& name) { return folder.path() / name; };
    // The same number twice: nothing may depend on how threads happen to be scheduled, either.
    const std::vector<std::pair<std::string, std::string>> runs = {
        {"one", "1"}, {"two", "2"}, {"five", "5"}, {"five_again", "5"}};
    for (const auto& [name, threads] : runs) {
        // Caches of their own: every reference is traced. 96 pixels are several tiles of llvmpipe.
        const test::Finished done = test::penumbra(
            {"compare", "--out", path(name).string(), "--cache", path("cache_" + name).string(),
             "--size", "96x96", "--repeats", "1", "--reference-se", "0.02", "--scene",
             GetParam().scene, "--reference", GetParam().reference, "--threads", threads});
        ASSERT_EQ(done.exitCode, 0) << done.err;
        test::drawUntimed(path(name), path("drawn_" + name));
    }
    EXPECT_GT(test::untimedRows(path("one")).size(), 7u) << "all methods";
    for (const auto& [name, threads] : runs) {
        if (name == "one") continue;
        SCOPED_TRACE(name);
        EXPECT_EQ(test::untimedRows(path(name), test::Threads::ignored),
                  test::untimedRows(path("one"), test::Threads::ignored));
        test::expectSameFiles(path(name) / "images", path("one") / "images");
        if (GetParam().reference != "exact")  // which is not cached
            test::expectSameFiles(path("cache_" + name), path("cache_one"));
        test::expectSameFiles(path("drawn_" + name) / "grid", path("drawn_one") / "grid");
    }
    EXPECT_EQ(test::untimedRows(path("five")), test::untimedRows(path("five_again")));
}

INSTANTIATE_TEST_SUITE_P(Long, Determinism,
                         ::testing::Values(Work{"foliage_masked", "embree"},
                                           Work{"butterfly", "embree"},
                                           Work{"sphere_plate", "exact"}),
                         [](const auto& work) { return work.param.scene; });

}  // namespace
}  // namespace penumbra
