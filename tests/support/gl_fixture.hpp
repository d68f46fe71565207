#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "core/gl/context.hpp"

namespace penumbra::test {

/// The one context of a test program, and its end before static objects die.
class GlEnvironment : public ::testing::Environment {
  public:
    void TearDown() override { context.reset(); }
    std::unique_ptr<gl::Context> context;
};

inline GlEnvironment* const kGlEnvironment = static_cast<GlEnvironment*>(
    ::testing::AddGlobalTestEnvironment(new GlEnvironment));  // googletest owns it

/// The process-wide OSMesa context, made on first use and current on the calling thread.
inline gl::Context& glContext() {
    if (!kGlEnvironment->context)
        kGlEnvironment->context = gl::Context::create(gl::ContextKind::osmesa);
    return *kGlEnvironment->context;
}

/// Ends that context, so that a test may make one of another kind; the next glContext() makes a
/// new one. No GL object of the old context may be alive.
inline void endGlContext() {
    kGlEnvironment->context.reset();
}

/// Base of tests that draw: a context before, and no OpenGL error or warning left behind after.
class GlTest : public ::testing::Test {
  protected:
    void SetUp() override {
        glContext();
        gl::takeErrors();
    }
    void TearDown() override { EXPECT_EQ(gl::takeErrors(), ""); }
};

}  // namespace penumbra::test
