#include "core/passes/pixel_classes.hpp"

namespace penumbra {
namespace {

// shaders/common/pixel_classes.glsl, pixel_classes_pass.glsl, receiver.glsl
constexpr int kTilePixels = 4;
constexpr GLuint kTilesUnit = 2, kShadedUnit = 3, kPositionUnit = 8, kNormalUnit = 9;

}  // namespace

PixelClasses PixelClasses::create(Dark dark) {
    PixelClasses classes;
    std::vector<std::string> defines = {"PASS_CLASSIFY"};
    if (dark == Dark::yes) defines.emplace_back("DARK");
    classes.classify_ = gl::Program::graphics("common/pixel_classes_pass.glsl", defines);
    classes.answers_ = gl::Program::graphics("common/pixel_classes_pass.glsl", {"PASS_ANSWERS"});
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    classes.tileBuffer_ = gl::Framebuffer(id);
    glCreateFramebuffers(1, &id);
    classes.pixelBuffer_ = gl::Framebuffer(id);
    glCreateVertexArrays(1, &id);
    classes.empty_ = gl::VertexArray(id);
    return classes;
}

void PixelClasses::begin(const gl::Framebuffer& framebuffer, const Frame& frame) const {
    frame.gbufferTextures.position.bind(kPositionUnit);
    frame.gbufferTextures.normal.bind(kNormalUnit);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glBindVertexArray(empty_.id());
}

void PixelClasses::classify(const Frame& frame, const DepthPass& depth,
                            const MinMaxPyramid& pyramid, float biasTexels, const Kernel& kernel) {
    const gl::DebugGroup group("pixel classes: classify");
    if (shaded_.width() != frame.width() || shaded_.height() != frame.height()) {
        const auto across = [](int pixels) { return (pixels + kTilePixels - 1) / kTilePixels; };
        shaded_ = gl::Texture::create2D(GL_R32F, frame.width(), frame.height());
        tiles_ = gl::Texture::create2D(GL_RGBA32F, across(frame.width()), across(frame.height()));
        glNamedFramebufferTexture(pixelBuffer_.id(), GL_COLOR_ATTACHMENT0, shaded_.id(), 0);
        glNamedFramebufferTexture(tileBuffer_.id(), GL_COLOR_ATTACHMENT0, tiles_.id(), 0);
    }
    begin(tileBuffer_, frame);
    glViewport(0, 0, tiles_.width(), tiles_.height());
    classify_.use();
    depth.bind(classify_, 0);
    pyramid.bind(classify_);
    setFootprint(classify_, frame.light);
    classify_.set("biasTexels", biasTexels);
    classify_.set("tilePixels", kTilePixels);
    classify_.set("minKernel", kernel.least);
    classify_.set("maxKernel", kernel.most);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void PixelClasses::shade(const gl::Program& program, const Frame& frame) const {
    const gl::DebugGroup group("pixel classes: shade");
    begin(pixelBuffer_, frame);
    tiles_.bind(kTilesUnit);
    program.use();
    // Whole tiles, also where they reach beyond the image.
    glViewport(0, 0, tiles_.width() * kTilePixels, tiles_.height() * kTilePixels);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glDrawArrays(GL_POINTS, 0, tiles_.width() * tiles_.height());
    glDisable(GL_PROGRAM_POINT_SIZE);
}

void PixelClasses::bind() const {
    tiles_.bind(kTilesUnit);
}

const gl::Program& PixelClasses::answers() const {
    bind();
    shaded_.bind(kShadedUnit);
    answers_.use();
    return answers_;
}

void setFootprint(const gl::Program& program, const AreaLight& light) {
    program.set("lightU", glm::vec3(light.halfU * light.axisU));
    program.set("lightV", glm::vec3(light.halfV * light.axisV));
}

}  // namespace penumbra
