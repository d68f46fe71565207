#include "harness/viewer/gui_renderer.hpp"

#include <imgui.h>

#include <cstddef>
#include <cstdint>

namespace penumbra {

GuiRenderer::GuiRenderer() : program_(gl::Program::graphics("common/gui.glsl")) {
    ImGuiIO& io = ImGui::GetIO();
    io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    font_ = gl::Texture::create2D(GL_RGBA8, width, height);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(font_.id(), 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    glTextureParameteri(font_.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(font_.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    io.Fonts->SetTexID(reinterpret_cast<ImTextureID>(std::uintptr_t{font_.id()}));

    GLuint id = 0;
    glCreateVertexArrays(1, &id);
    vertexArray_ = gl::VertexArray(id);
    const auto attribute = [&](GLuint index, GLint size, GLenum type, GLboolean normalised,
                               std::size_t offset) {
        glEnableVertexArrayAttrib(id, index);
        glVertexArrayAttribFormat(id, index, size, type, normalised, static_cast<GLuint>(offset));
        glVertexArrayAttribBinding(id, index, 0);
    };
    attribute(0, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, pos));
    attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, uv));
    attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(ImDrawVert, col));
}

GuiRenderer::~GuiRenderer() {
    ImGui::GetIO().Fonts->SetTexID(nullptr);
}

void GuiRenderer::draw(const ImDrawData& data, GLuint framebuffer) {
    const int width = static_cast<int>(data.DisplaySize.x * data.FramebufferScale.x);
    const int height = static_cast<int>(data.DisplaySize.y * data.FramebufferScale.y);
    if (width <= 0 || height <= 0) return;
    const gl::DebugGroup group("gui");
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height);
    glDisable(GL_SCISSOR_TEST);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    const float clear[4] = {0.07f, 0.07f, 0.08f, 1.0f};
    glClearBufferfv(GL_COLOR, 0, clear);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_CULL_FACE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    const glm::vec2 scale(2.0f / data.DisplaySize.x, -2.0f / data.DisplaySize.y);
    program_.use();
    program_.set("toClip", glm::vec4(scale, -1.0f - data.DisplayPos.x * scale.x,
                                     1.0f - data.DisplayPos.y * scale.y));
    glBindVertexArray(vertexArray_.id());
    glBindSampler(0, 0);
    for (int l = 0; l < data.CmdListsCount; ++l) {
        const ImDrawList& list = *data.CmdLists[l];
        const auto vertices = gl::Buffer::create(
            static_cast<std::size_t>(list.VtxBuffer.size_in_bytes()), list.VtxBuffer.Data);
        const auto indices = gl::Buffer::create(
            static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()), list.IdxBuffer.Data);
        glVertexArrayVertexBuffer(vertexArray_.id(), 0, vertices.id(), 0, sizeof(ImDrawVert));
        glVertexArrayElementBuffer(vertexArray_.id(), indices.id());
        for (const ImDrawCmd& command : list.CmdBuffer) {
            if (command.UserCallback) {
                // ImDrawCallback_ResetRenderState is a marker, no function; nothing here needs it.
                if (command.UserCallback != ImDrawCallback_ResetRenderState)
                    command.UserCallback(&list, &command);
                continue;
            }
            const float x0 = (command.ClipRect.x - data.DisplayPos.x) * data.FramebufferScale.x;
            const float y0 = (command.ClipRect.y - data.DisplayPos.y) * data.FramebufferScale.y;
            const float x1 = (command.ClipRect.z - data.DisplayPos.x) * data.FramebufferScale.x;
            const float y1 = (command.ClipRect.w - data.DisplayPos.y) * data.FramebufferScale.y;
            if (x1 <= x0 || y1 <= y0) continue;
            glScissor(static_cast<int>(x0), static_cast<int>(static_cast<float>(height) - y1),
                      static_cast<int>(x1 - x0), static_cast<int>(y1 - y0));
            glBindTextureUnit(
                0, static_cast<GLuint>(reinterpret_cast<std::uintptr_t>(command.GetTexID())));
            glDrawElementsBaseVertex(
                GL_TRIANGLES, static_cast<GLsizei>(command.ElemCount),
                sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT,
                reinterpret_cast<const void*>(command.IdxOffset * sizeof(ImDrawIdx)),
                static_cast<GLint>(command.VtxOffset));
        }
    }
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
}

}  // namespace penumbra
