#include <glad/gl.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/gl/context.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra::gl {
namespace {

constexpr int kTargetSize = 512;
constexpr int kDraws = 4;
constexpr double kLeastMs = 10.0;
constexpr double kTolerance = 0.10;

/// Full-screen draws whose cost grows with `steps`.
class KnownWork {
  public:
    KnownWork()
        : program_(Program::graphics("common/clock_test.glsl")),
          target_(Texture::create2D(GL_R32F, kTargetSize, kTargetSize)) {
        GLuint id = 0;
        glCreateFramebuffers(1, &id);
        framebuffer_ = Framebuffer(id);
        glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, target_.id(), 0);
        glCreateVertexArrays(1, &id);
        noAttributes_ = VertexArray(id);
    }

    void draw(int steps) const {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
        glViewport(0, 0, kTargetSize, kTargetSize);
        for (GLenum state : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_SCISSOR_TEST})
            glDisable(state);
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glBindVertexArray(noAttributes_.id());
        program_.use();
        program_.set("steps", steps);
        for (int i = 0; i < kDraws; ++i) glDrawArrays(GL_TRIANGLES, 0, 3);
        glBindVertexArray(0);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    }

  private:
    Program program_;
    Texture target_;
    Framebuffer framebuffer_;
    VertexArray noAttributes_;
};

ClockSelfTest measure(const KnownWork& work, GLuint query, int steps) {
    ClockSelfTest result;
    const FencedTimer timer;
    glBeginQuery(GL_TIME_ELAPSED, query);
    work.draw(steps);
    glEndQuery(GL_TIME_ELAPSED);
    result.fencedMs = timer.stop();
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
    result.queryMs = static_cast<double>(nanoseconds) * 1e-6;
    return result;
}

double nowMs() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

FencedTimer::FencedTimer() {
    glFinish();
    startMs_ = nowMs();
}

double FencedTimer::stop() const {
    glFinish();
    return nowMs() - startMs_;
}

ClockSelfTest runClockSelfTest() {
    const DebugGroup group("clock self-test");
    const KnownWork work;
    GLuint id = 0;
    glCreateQueries(GL_TIME_ELAPSED, 1, &id);
    const Query query(id);

    constexpr int kMostSteps = 1 << 20;  // 10^12 in all: far more than 10 ms anywhere
    int steps = 8;
    measure(work, query.id(), steps);  // the first draw pays for compilation
    ClockSelfTest best = measure(work, query.id(), steps);
    while (best.fencedMs < kLeastMs && steps < kMostSteps) {
        steps *= 2;
        best = measure(work, query.id(), steps);
    }
    // Whatever else the machine does in between only lengthens the fenced time: the shortest of
    // a few is the fair comparison.
    for (int repeat = 0; repeat < 2; ++repeat) {
        const ClockSelfTest again = measure(work, query.id(), steps);
        if (again.fencedMs < best.fencedMs) best = again;
    }
    best.timerQueriesTrusted = best.fencedMs >= kLeastMs / 2 &&
                               std::abs(best.queryMs - best.fencedMs) <= kTolerance * best.fencedMs;
    return best;
}

}  // namespace penumbra::gl
