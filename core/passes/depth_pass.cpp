#include "core/passes/depth_pass.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {
namespace {

/// Whether all of the box is in front of the light and not so far beside the map that floats have
/// no digits for steps of its rasterisation.
bool isAhead(const Bounds& box, const glm::mat4& clipFromWorld) {
    constexpr float kFarthest = 8.0f;  // halves of the map
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                           corner & 4 ? box.hi.z : box.lo.z);
        const glm::vec4 clip = clipFromWorld * glm::vec4(p, 1.0);
        if (!(clip.w > 0.0f) || std::abs(clip.x) > kFarthest * clip.w ||
            std::abs(clip.y) > kFarthest * clip.w)
            return false;
    }
    return true;
}

}  // namespace

DepthPass::DepthPass(const Plan& plan, MapParts parts)
    : alphaMask_(plan.has(Effect::alpha_mask)), parts_(parts), leavesAverted_(!plan.everyPixel) {
    program_ = gl::Program::graphics(
        "common/depth_pass.glsl",
        alphaMask_ ? std::vector<std::string>{"ALPHA_MASK"} : std::vector<std::string>{});
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    framebuffer_ = gl::Framebuffer(id);
    glNamedFramebufferDrawBuffer(id, GL_NONE);
}

void DepthPass::render(const Frame& frame, const LightView& view, int size) {
    render(frame, std::span(&view, 1), size);
}

void DepthPass::allocate(int layers, std::size_t tiles, int size, int keptLayers) {
    if (map_.width() == size && map_.layers() >= layers && view_.tiles.size() == tiles) return;
    // Allocated by half more than there was, so that what is kept is copied a few times at most.
    GLint mostLayers = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &mostLayers);
    if (keptLayers > 0)
        layers = std::min(std::max(layers, keptLayers + keptLayers / 2), mostLayers);
    gl::Texture grown = gl::Texture::createArray(GL_DEPTH_COMPONENT32F, size, size, layers);
    if (keptLayers > 0)
        glCopyImageSubData(map_.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, grown.id(),
                           GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, size, size, keptLayers);
    map_ = std::move(grown);
}

void DepthPass::render(const Frame& frame, std::span<const LightView> views, int size,
                       int firstView) {
    const gl::DebugGroup group("depth pass");
    const std::size_t tiles = views[0].tiles.size();
    const int layers = static_cast<int>(views.size() * tiles);
    const int firstLayer = firstView * static_cast<int>(tiles);
    allocate(firstLayer + layers, tiles, size, firstLayer);
    if (firstView == 0) view_ = views[0];

    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glEnable(GL_DEPTH_CLAMP);
    glFrontFace(GL_CCW);
    glDisable(GL_BLEND);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, size, size);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    program_.use();
    for (int layer = 0; layer < layers; ++layer) {
        glNamedFramebufferTextureLayer(framebuffer_.id(), GL_DEPTH_ATTACHMENT, map_.id(), 0,
                                       firstLayer + layer);
        constexpr float kNothing = 0.0f;
        glClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &kNothing);
        const auto index = static_cast<std::size_t>(layer);
        const LightView& view = views[index / tiles];
        program_.set("clipFromWorld", view.clipFromWorld(index % tiles));
        frame.gpuGeometry.draw(program_.id(), alphaMask_, 1,
                               howDrawn(frame, view, index % tiles, size));
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
}

std::vector<PartDraw> DepthPass::howDrawn(const Frame& frame, const LightView& view,
                                          std::size_t tile, int size) const {
    const LightTile& t = view.tiles[tile];
    // In a right-handed frame what runs counterclockwise for the light runs clockwise in its map.
    const double handed = glm::dot(glm::cross(t.axisX, t.axisY), t.axisZ);
    const glm::mat4 clipFromWorld = view.clipFromWorld(tile);
    GLint subpixelBits = 0;
    glGetIntegerv(GL_SUBPIXEL_BITS, &subpixelBits);
    const float rasterSteps = std::ldexp(static_cast<float>(size), subpixelBits);
    const bool compared = parts_ == MapParts::compared && comparesInTheWay(frame, view, size, 1);
    std::vector<PartDraw> how;
    how.reserve(frame.casterFacts.parts.size());
    for (const PartFacts& part : frame.casterFacts.parts) {
        PartDraw& drawn = how.emplace_back();
        if (parts_ == MapParts::casting) drawn.drawn = part.casts;
        if (compared) drawn.drawn = part.inTheWay;
        if (part.outward == 0 || !isAhead(part.bodies, clipFromWorld)) continue;
        drawn.rasterSteps = rasterSteps;
        if (leavesAverted_)
            drawn.culled = (handed < 0.0) == (part.outward > 0) ? GL_BACK : GL_FRONT;
    }
    return how;
}

bool comparesInTheWay(const Frame& frame, const LightView& view, int size, int kernel) {
    // Rasterisation moves vertices by a 256th of a texel.
    const double reachTexels = 0.5 * kernel + 0.01;
    const glm::dvec2 width = view.tiles[0].tangentSize();
    return view.tiles.size() == 1 &&
           reachTexels * std::max(width.x, width.y) / size <= frame.casterFacts.besideTangent;
}

void DepthPass::bind(const gl::Program& program, GLuint unit) const {
    map_.bind(unit);
    setLightView(program, view_, map_.width());
}

double DepthPass::texels() const {
    return static_cast<double>(map_.width()) * map_.height() * map_.layers();
}

gl::Sampler comparingSampler() {
    GLuint id = 0;
    glCreateSamplers(1, &id);
    glSamplerParameteri(id, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glSamplerParameteri(id, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glSamplerParameteri(id, filter, GL_LINEAR);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        glSamplerParameteri(id, wrap, GL_CLAMP_TO_BORDER);
    constexpr float kNothing[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glSamplerParameterfv(id, GL_TEXTURE_BORDER_COLOR, kNothing);
    return gl::Sampler(id);
}

void setLightView(const gl::Program& program, const LightView& view, int size) {
    program.set("lightCentre", glm::vec3(view.centre));
    program.set("tileCount", static_cast<int>(view.tiles.size()));
    program.set("mapSize", size);
    for (std::size_t i = 0; i < view.tiles.size(); ++i) {
        const LightTile& tile = view.tiles[i];
        const std::string index = "[" + std::to_string(i) + "]";
        program.set(("tileAxes" + index).c_str(),
                    glm::mat3(glm::transpose(glm::dmat3(tile.axisX, tile.axisY, tile.axisZ))));
        program.set(("tileTangents" + index).c_str(),
                    glm::vec4(tile.tangentLo, 1.0 / tile.tangentSize()));
        program.set(("tileNear" + index).c_str(), static_cast<float>(tile.nearM));
    }
}

}  // namespace penumbra
