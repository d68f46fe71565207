#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "harness/viewer/view_session.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/gl_fixture.hpp"

namespace penumbra::test {

/// What a small view is opened with: a rough reference (standard error 0.05), for nothing here is
/// about its accuracy.
inline ViewOptions smallView(const std::string& scene, std::vector<std::string> methods,
                             const std::filesystem::path& cache) {
    ViewOptions o;
    o.scene = scene;
    o.methods = std::move(methods);
    o.width = o.height = 64;
    o.referenceSe = 0.05;
    o.threads = 2;
    o.cache = cache;
    return o;
}

/// Until nothing is left to be made but the reference.
inline void settle(ViewSession& session) {
    do {
        session.update();
    } while (!session.still());
    // Each of these counts the work of one method.
    session.update();
    session.update();
}

/// Until the reference is as good as was asked for.
inline void converge(ViewSession& session) {
    for (int i = 0; i < 3000; ++i) {  // half a minute
        session.update();
        if (session.reference() && session.reference()->converged) return;
        ASSERT_EQ(session.tracing().error(), "");
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    FAIL() << "the reference did not converge";
}

class ViewerTest : public GlTest {
  protected:
    ViewOptions options(const std::string& scene, std::vector<std::string> methods) const {
        return smallView(scene, std::move(methods), folder.path() / "cache");
    }
    testing::TempFolder folder;
};

}  // namespace penumbra::test
