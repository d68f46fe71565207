#pragma once

#include <glad/gl.h>
#include <signal.h>
#include <tbb/parallel_for.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "methods/shadow_method.hpp"

/// Methods that misbehave in one way each. A test program that includes this header has them in its
/// registry, so its tests name the methods that they run.
namespace penumbra::test {

/// Answers one half everywhere and claims one map per build.
class Constant : public ShadowMethod {
  public:
    Traits traits() const override { return {{Effect::penumbra, Effect::moving_light}}; }
    std::vector<Assignments> ladder() const override { return {{}}; }
    void prepare(const Scene&, const Plan&) override {}
    void build(const Frame&, const Plan&) override { built_ = true; }
    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        // Light-space work that never happened must show.
        target.upload(std::vector<float>(frame.gbuffer.size(), built_ ? 0.5f : 7.0f));
    }
    WorkCounters counters() const override { return {1, 64.0, 0.25, ""}; }

  private:
    bool built_ = false;
};

class ThrowsInBuild : public Constant {
  public:
    void build(const Frame&, const Plan&) override {
        // As a pass that is left half-way: none of this may reach the next method.
        glEnable(GL_BLEND);
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, 1, 1);
        glDepthMask(GL_FALSE);
        glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        throw std::runtime_error("the build broke\nin \"two\" lines, with a comma");
    }
};

class ThrowsInPrepare : public Constant {
  public:
    void prepare(const Scene&, const Plan&) override { throw std::bad_alloc(); }
};

class RefusesScene : public Constant {
  public:
    void prepare(const Scene&, const Plan&) override {
        throw Unsupported("needs a light of another shape");
    }
};

class RaisesGlError : public Constant {
  public:
    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        Constant::shade(frame, plan, target);
        glEnable(0xdead);
    }
};

/// Leaves its target as it was.
class WritesNothing : public Constant {
  public:
    void shade(const Frame&, const Plan&, const VisibilityTarget&) override {}
};

/// Good in the warm-up, fails in the first timed repeat.
class FailsWhenTimed : public Constant {
  public:
    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        if (shaded_++ > 0) throw std::runtime_error("only once");
        Constant::shade(frame, plan, target);
    }

  private:
    int shaded_ = 0;
};

/// Fails in frame 1 while `broken`.
class Flaky : public Constant {
  public:
    static inline bool broken = false;
    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        if (broken && frame.index == 1) throw std::runtime_error("not today");
        Constant::shade(frame, plan, target);
    }
};

/// Takes `first` for the warm-up's frame and `further` for each of the others.
class Slow : public Constant {
  public:
    static inline std::chrono::milliseconds first{0}, further{0};
    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        std::this_thread::sleep_for(shaded_++ == 0 ? first : further);
        Constant::shade(frame, plan, target);
    }

  private:
    int shaded_ = 0;
};

/// Asks the program to stop by `signal`, once, in frame 0.
class Interrupts : public Constant {
  public:
    static inline int signal = 0;
    void shade(const Frame& frame, const Plan& plan, const VisibilityTarget& target) override {
        if (const int now = frame.index == 0 ? std::exchange(signal, 0) : 0) raise(now);
        Constant::shade(frame, plan, target);
    }
};

/// One of many tasks on all threads throws.
class ThrowsInTask : public Constant {
  public:
    void shade(const Frame&, const Plan&, const VisibilityTarget&) override {
        tbb::parallel_for(0, 1000, [](int task) {
            if (task == 500) throw std::runtime_error("a task broke");
        });
    }
};

class ThrowsANumber : public Constant {
  public:
    void shade(const Frame&, const Plan&, const VisibilityTarget&) override {
        tbb::parallel_for(0, 1000, [](int task) {
            if (task == 500) throw task;
        });
    }
};

inline const Register<Constant> kConstant{"fake_constant", "One half", "tests"};
inline const Register<ThrowsInBuild> kThrowsInBuild{"fake_throws_in_build", "Throws", "tests"};
inline const Register<ThrowsInPrepare> kThrowsInPrepare{"fake_throws_in_prepare", "Throws",
                                                        "tests"};
inline const Register<RefusesScene> kRefuses{"fake_refuses", "Unsupported", "tests"};
inline const Register<RaisesGlError> kRaisesGlError{"fake_gl_error", "GL error", "tests"};
inline const Register<WritesNothing> kWritesNothing{"fake_writes_nothing", "Nothing", "tests"};
inline const Register<FailsWhenTimed> kFailsWhenTimed{"fake_fails_when_timed", "Throws later",
                                                      "tests"};
inline const Register<Flaky> kFlaky{"fake_flaky", "Throws now and then", "tests"};
inline const Register<Interrupts> kInterrupts{"fake_interrupts", "Raises a signal", "tests"};
inline const Register<ThrowsInTask> kThrowsInTask{"fake_throws_in_task", "Throws in a task",
                                                  "tests"};
inline const Register<ThrowsANumber> kThrowsANumber{"fake_throws_a_number", "Throws a number",
                                                    "tests"};
inline const Register<Slow> kSlow{"fake_slow", "Takes its time", "tests"};

}  // namespace penumbra::test
