#include "core/passes/pixel_tiles.hpp"

namespace penumbra {
namespace {

// shaders/common/pixel_tiles.glsl, receiver.glsl
constexpr int kTilePixels = 8;
constexpr GLuint kTilesUnit = 2, kPixelsUnit = 3, kNotesUnit = 4, kPositionUnit = 8,
                 kNormalUnit = 9;

}  // namespace

PixelTiles PixelTiles::create() {
    PixelTiles tiles;
    tiles.answers_ = gl::Program::graphics("common/pixel_tiles.glsl", {"PASS_ANSWERS"});
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    tiles.tileBuffer_ = gl::Framebuffer(id);
    constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(id, 2, kBoth);
    glCreateFramebuffers(1, &id);
    tiles.pixelBuffer_ = gl::Framebuffer(id);
    glCreateVertexArrays(1, &id);
    tiles.empty_ = gl::VertexArray(id);
    return tiles;
}

void PixelTiles::begin(const gl::Framebuffer& framebuffer, const Frame& frame) const {
    frame.gbufferTextures.position.bind(kPositionUnit);
    frame.gbufferTextures.normal.bind(kNormalUnit);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glBindVertexArray(empty_.id());
}

void PixelTiles::classify(const gl::Program& program, const Frame& frame) {
    const gl::DebugGroup group("pixel tiles: classify");
    if (pixels_.width() != frame.width() || pixels_.height() != frame.height()) {
        const auto across = [](int pixels) { return (pixels + kTilePixels - 1) / kTilePixels; };
        const int width = across(frame.width()), height = across(frame.height());
        pixels_ = gl::Texture::create2D(GL_R32F, frame.width(), frame.height());
        tiles_ = gl::Texture::create2D(GL_R32F, width, height);
        notes_ = gl::Texture::create2D(GL_RGBA32F, width, height);
        glNamedFramebufferTexture(pixelBuffer_.id(), GL_COLOR_ATTACHMENT0, pixels_.id(), 0);
        glNamedFramebufferTexture(tileBuffer_.id(), GL_COLOR_ATTACHMENT0, tiles_.id(), 0);
        glNamedFramebufferTexture(tileBuffer_.id(), GL_COLOR_ATTACHMENT1, notes_.id(), 0);
    }
    begin(tileBuffer_, frame);
    glViewport(0, 0, tiles_.width(), tiles_.height());
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void PixelTiles::shade(const gl::Program& program, const Frame& frame) const {
    const gl::DebugGroup group("pixel tiles: shade");
    begin(pixelBuffer_, frame);
    tiles_.bind(kTilesUnit);
    notes_.bind(kNotesUnit);
    program.use();
    // Whole tiles, also where they reach beyond the image.
    glViewport(0, 0, tiles_.width() * kTilePixels, tiles_.height() * kTilePixels);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glDrawArrays(GL_POINTS, 0, tiles_.width() * tiles_.height());
    glDisable(GL_PROGRAM_POINT_SIZE);
}

const gl::Program& PixelTiles::answers() const {
    tiles_.bind(kTilesUnit);
    pixels_.bind(kPixelsUnit);
    answers_.use();
    return answers_;
}

}  // namespace penumbra
