#include "core/gl/work_counter.hpp"

#include <glad/gl.h>

#include <type_traits>

namespace penumbra::gl {
namespace {

std::uint64_t drawCalls = 0;

/// The loaded entry point behind a counting one of the same signature.
template <auto* Slot, class Function = std::remove_pointer_t<decltype(Slot)>>
struct Counted;

template <auto* Slot, class... Arguments>
struct Counted<Slot, void(GLAD_API_PTR*)(Arguments...)> {
    static inline void(GLAD_API_PTR* original)(Arguments...) = nullptr;
    static void GLAD_API_PTR call(Arguments... arguments) {
        ++drawCalls;
        original(arguments...);
    }
    static void install() {
        original = *Slot;
        *Slot = &call;
    }
    static void remove() { *Slot = original; }
};

template <auto*... Slots>
struct AllCounted {
    static void install() { (Counted<Slots>::install(), ...); }
    static void remove() { (Counted<Slots>::remove(), ...); }
};

using DrawCalls =
    AllCounted<&glad_glDrawArrays, &glad_glDrawArraysInstanced, &glad_glDrawArraysIndirect,
               &glad_glDrawElements, &glad_glDrawElementsInstanced, &glad_glDrawElementsBaseVertex,
               &glad_glDrawElementsInstancedBaseVertex, &glad_glDrawElementsIndirect,
               &glad_glMultiDrawArrays, &glad_glMultiDrawArraysIndirect,
               &glad_glMultiDrawElementsIndirect, &glad_glDispatchCompute,
               &glad_glDispatchComputeIndirect>;

constexpr GLenum kTargets[2] = {GL_PRIMITIVES_SUBMITTED_ARB, GL_FRAGMENT_SHADER_INVOCATIONS_ARB};

}  // namespace

WorkCounter::WorkCounter() : statistics_(GLAD_GL_ARB_pipeline_statistics_query != 0) {
    drawCalls = 0;
    DrawCalls::install();
    if (!statistics_) return;
    // Mesa refuses these targets in glCreateQueries.
    glGenQueries(2, queries_);
    for (int i = 0; i < 2; ++i) glBeginQuery(kTargets[i], queries_[i]);
}

Work WorkCounter::stop() {
    DrawCalls::remove();
    running_ = false;
    Work work;
    work.drawCalls = drawCalls;
    if (statistics_) {
        GLuint64 counts[2] = {0, 0};
        for (int i = 0; i < 2; ++i) {
            glEndQuery(kTargets[i]);
            glGetQueryObjectui64v(queries_[i], GL_QUERY_RESULT, &counts[i]);
        }
        glDeleteQueries(2, queries_);
        work.triangles = counts[0];
        work.fragments = counts[1];
    }
    return work;
}

WorkCounter::~WorkCounter() {
    if (running_) stop();
}

}  // namespace penumbra::gl
