#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "harness/run/compare.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra::test {

/// Small, quick runs in a folder of their own. The reference is a rough one (standard error 0.05,
/// some 100 rays a pixel): nothing here is about its accuracy.
class CompareTest : public ::testing::Test {
  protected:
    void SetUp() override {
        endGlContext();  // compare() makes its own
        unsetenv("GITHUB_STEP_SUMMARY");
    }

    CompareOptions options(const std::string& run, std::vector<std::string> scenes,
                           std::vector<std::string> methods) const {
        CompareOptions o;
        o.scenes = std::move(scenes);
        o.settings.methods = std::move(methods);
        o.width = o.height = 64;
        o.repeats = 2;
        o.referenceSe = 0.05;
        o.cache = folder.path() / "cache";
        o.out = path(run);
        o.command = "a test";
        return o;
    }
    std::filesystem::path path(const std::string& run) const { return folder.path() / run; }
    std::vector<Row> rows(const std::string& run) const {
        return readCsv(RunFolder(path(run)).results());
    }
    RunRecord record(const std::string& run) const {
        return RunRecord::read(RunFolder(path(run)).record());
    }
    Row row(const std::string& run, const std::string& setting, int frame = 0) const {
        for (const Row& r : rows(run))
            if (r.setting == setting && r.frame == frame) return r;
        ADD_FAILURE() << "no row of " << setting << " frame " << frame;
        return {};
    }
    /// The message with which compare refuses `o`; empty when it does not.
    static std::string refusal(const CompareOptions& o) {
        try {
            compare(o);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
    /// half_plane through the frames at 0 and 1 s, with what else is in `more`.
    std::string script(const std::string& name, const std::string& more = "") const {
        return folder
            .write(name + ".toml", R"(shows  = "a test"
asset  = "generated:half_plane.glb"

[camera]
position = [-1.7, 2.6, 0.0]
target   = [0.15, 0.0, 0.0]
fov_y    = 45.0

[light]
position = [0.0, 4.0, 0.0]
target   = [0.0, 0.0, 0.0]
up       = [0.0, 0.0, -1.0]
size     = [1.6, 1.0]

[frames]
times = [0.0, 1.0]
)" + more)
            .string();
    }

    testing::TempFolder folder;
};

}  // namespace penumbra::test
