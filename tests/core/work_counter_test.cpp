#include "core/gl/work_counter.hpp"

#include <gtest/gtest.h>

#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using namespace test;

class WorkCounterTest : public GlTest {};

/// A triangle that covers all of a 32 x 32 target, drawn with the loaded entry points.
class Target {
  public:
    Target() : texture_(gl::Texture::create2D(GL_R32F, 32, 32)) {
        GLuint id = 0;
        glCreateFramebuffers(1, &id);
        framebuffer_ = gl::Framebuffer(id);
        glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, texture_.id(), 0);
        glCreateVertexArrays(1, &id);
        vertices_ = gl::VertexArray(id);
    }
    void draw(int instances) const {
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_SCISSOR_TEST);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
        glViewport(0, 0, 32, 32);
        glBindVertexArray(vertices_.id());
        program_.use();
        glDrawArraysInstanced(GL_TRIANGLES, 0, 3, instances);
    }

  private:
    gl::Program program_ = gl::Program::graphics("common/clock_test.glsl");
    gl::Texture texture_;
    gl::Framebuffer framebuffer_;
    gl::VertexArray vertices_;
};

TEST_F(WorkCounterTest, CountsDrawsTrianglesAndFragments) {
    const Target target;
    gl::WorkCounter counter;
    target.draw(1);
    target.draw(3);
    const gl::Work work = counter.stop();
    EXPECT_EQ(work.drawCalls, 2u);
    ASSERT_TRUE(counter.statistics()) << "llvmpipe has pipeline statistics";
    EXPECT_EQ(work.triangles, 4u);
    // Renderers shade whole blocks of pixels along a triangle's edges and count those too.
    EXPECT_GE(work.fragments, 4u * 32 * 32);
    EXPECT_LE(work.fragments, 4u * 36 * 36);
}

TEST_F(WorkCounterTest, CountsADepthPassPerTile) {
    Shape shape;
    shape.box({-1, -1, -3}, {1, 1, -2});  // 12 triangles
    const AreaLight light = lightAbove(0.0, 0.0, 0.0);
    const TestFrame frame({shape.geometry(), light},
                          planeGBuffer(1, 1, {0, 0, -3}, {0.1, 0, 0}, {0, 0.1, 0}, light));
    LightView view;
    for (std::size_t side = 0; side < 5; ++side) {
        const auto [x, y, z] = lightSideAxes(light, side);
        view.tiles.push_back({x, y, z});
    }
    DepthPass pass(Plan{});
    gl::WorkCounter counter;
    pass.render(*frame, view, 64);
    const gl::Work work = counter.stop();
    EXPECT_EQ(work.drawCalls, 5u);
    EXPECT_EQ(work.triangles, 5u * 12);
}

TEST_F(WorkCounterTest, EachCountStartsAtZeroAndEndsAtStop) {
    const Target target;
    {
        gl::WorkCounter counter;
        target.draw(1);
    }
    target.draw(1);
    gl::WorkCounter counter;
    const gl::Work none = counter.stop();
    EXPECT_EQ(none.drawCalls + none.triangles + none.fragments, 0u);
    target.draw(1);
    gl::WorkCounter again;
    target.draw(1);
    EXPECT_EQ(again.stop().drawCalls, 1u);
}

}  // namespace
}  // namespace penumbra
