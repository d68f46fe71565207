#include "core/passes/pixel_classes.hpp"

#include <algorithm>

namespace penumbra {
namespace {

// shaders/common/pixel_classes.glsl, pixel_classes_pass.glsl, receiver.glsl
constexpr int kTilePixels = 4;
constexpr double kWindowsAcross = 2.0;  // of a box at least: kFiner
constexpr GLuint kPositionUnit = 8, kNormalUnit = 9, kTilesUnit = 10, kShadedUnit = 11;

}  // namespace

PixelClasses PixelClasses::create(Dark dark, Footprint footprint) {
    std::vector<std::string> defines = {"PASS_CLASSIFY"};
    if (dark == Dark::yes) defines.emplace_back("DARK");
    if (footprint != Footprint::light) defines.emplace_back("BOX");
    if (footprint == Footprint::moments) defines.emplace_back("MOMENTS");
    return create(gl::Program::graphics("common/pixel_classes_pass.glsl", defines));
}

PixelClasses PixelClasses::create(gl::Program test) {
    PixelClasses classes = decided();
    classes.classify_ = std::move(test);
    return classes;
}

PixelClasses PixelClasses::decided() {
    PixelClasses classes;
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

void PixelClasses::allocate(const Frame& frame) {
    if (shaded_.width() == frame.width() && shaded_.height() == frame.height()) return;
    const auto across = [](int pixels) { return (pixels + kTilePixels - 1) / kTilePixels; };
    shaded_ = gl::Texture::create2D(GL_R32F, frame.width(), frame.height());
    tiles_ = gl::Texture::create2D(GL_RGBA32F, across(frame.width()), across(frame.height()));
    glNamedFramebufferTexture(pixelBuffer_.id(), GL_COLOR_ATTACHMENT0, shaded_.id(), 0);
    glNamedFramebufferTexture(tileBuffer_.id(), GL_COLOR_ATTACHMENT0, tiles_.id(), 0);
}

void PixelClasses::decide(const Frame& frame, const LitTiles& tiles) {
    static_assert(LitTiles::kSide == kTilePixels);
    // shaders/common/pixel_classes.glsl: a tile's texel
    const glm::vec4 kLit(2.0f, 0.0f, 1.0f, 0.0f), kEverywhere(-1e30f, -1e30f, 1e30f, 1e30f);
    allocate(frame);
    std::vector<glm::vec4> texels;
    for (int y = 0; y < tiles.down(); ++y)
        for (int x = 0; x < tiles.across(); ++x)
            texels.push_back(tiles.isLit(x, y) ? kLit : kEverywhere);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(tiles_.id(), 0, 0, 0, tiles.across(), tiles.down(), GL_RGBA, GL_FLOAT,
                        texels.data());
}

void PixelClasses::classify(const Frame& frame) {
    const gl::DebugGroup group("pixel classes: classify");
    allocate(frame);
    begin(tileBuffer_, frame);
    glViewport(0, 0, tiles_.width(), tiles_.height());
    classify_.use();
    classify_.set("tilePixels", kTilePixels);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void PixelClasses::classifyUnder(const Frame& frame, const DepthPass& depth,
                                 const MinMaxPyramid& pyramid, float biasTexels,
                                 const Kernel& kernel) {
    classify_.use();
    depth.bind(classify_, 0);
    pyramid.bind(classify_);
    classify_.set("biasTexels", biasTexels);
    classify_.set("minKernel", kernel.least);
    classify_.set("maxKernel", kernel.most);
    classify(frame);
}

void PixelClasses::classify(const Frame& frame, const DepthPass& depth,
                            const MinMaxPyramid& pyramid, float biasTexels, const Kernel& kernel) {
    setFootprint(classify_, frame.light);
    classifyUnder(frame, depth, pyramid, biasTexels, kernel);
}

void PixelClasses::classify(const Frame& frame, const DepthPass& depth,
                            const MinMaxPyramid& pyramid, float biasTexels, const Box& box) {
    classify_.set("boxHalfM", glm::vec2(box.halfM));
    classify_.set("boxPad", box.padTexels);
    classify_.set("leastVariance", box.leastVariance);
    classify_.set("bleed", box.bleed);
    for (std::size_t tile = 0; tile < box.nearestS.size(); ++tile) {
        const std::string index = "[" + std::to_string(tile) + "]";
        classify_.set(("tileNearestS" + index).c_str(), box.nearestS[tile]);
        classify_.set(("depthPerM" + index).c_str(), box.depthPerM[tile]);
    }
    classifyUnder(frame, depth, pyramid, biasTexels, box.kernel);
}

bool PixelClasses::areWorth(const Frame& frame, int mapSize, double lookupsSpared) {
    constexpr double kLookupsPerTexel = 6.0;
    const double pixels = static_cast<double>(frame.width()) * frame.height();
    return lookupsSpared * pixels >= kLookupsPerTexel * mapSize * mapSize;
}

double PixelClasses::widestWindow(const Frame& frame, const DepthPass& depth, const Box& box) {
    const std::vector<LightTile>& tiles = depth.view().tiles;
    double widest = 0.0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const SideBounds& side =
            tiles.size() == 1 ? frame.lightBounds.whole : frame.lightBounds.sides[i];
        if (side.empty()) continue;
        // clamp(nearestS / s - 1, least, most) / z over the depths z of receivers, s = nearM / z.
        const double cut = box.nearestS[i] / tiles[i].nearM - 1.0 / side.receiverFarM;
        const double perM = std::clamp(cut, box.kernel.least / side.receiverNearM,
                                       box.kernel.most / side.receiverNearM);
        const glm::dvec2 halfM =
            i == 0 ? box.halfM : glm::dvec2(std::max(box.halfM.x, box.halfM.y));
        const glm::dvec2 texels =
            2.0 * perM * halfM / tiles[i].tangentSize() * static_cast<double>(depth.map().width());
        widest = std::max({widest, texels.x, texels.y});
    }
    return widest / kWindowsAcross;
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
