#include "core/passes/light_maps.hpp"

#include <algorithm>

#include "core/frame/shadow_casters.hpp"

namespace penumbra {
namespace {

/// Lookups of the widest kernel, 5 x 5, and rounding to spare.
constexpr double kMarginTexels = 4.0;

double marginM(const LightView& view, const LightBounds& bounds, int size) {
    double tangent = 0.0, farM = bounds.whole.receiverFarM;
    for (const LightTile& tile : view.tiles)
        tangent = std::max({tangent, tile.tangentSize().x, tile.tangentSize().y});
    if (view.tiles.size() > 1)
        for (const SideBounds& side : bounds.sides) farM = std::max(farM, side.receiverFarM);
    return kMarginTexels * tangent / size * farM;
}

}  // namespace

LightMaps::LightMaps(const Plan& plan, MapParts parts, int kernel)
    : all_(plan.everyPixel),
      parts_(parts),
      kernel_(kernel),
      depth_(plan),
      sampleBuffer_(
          gl::Buffer::create(kMaxSamples * sizeof(GpuSample), nullptr, GL_DYNAMIC_STORAGE_BIT)) {}

void LightMaps::fit(const Frame& frame, int size, bool wholeLight) {
    views_ = TranslatedViews(frame, size, wholeLight);
    size_ = size;
    half_ = wholeLight ? glm::dvec2(frame.light.halfU, frame.light.halfV) : glm::dvec2(0.0);
    casters_ = frame.geometry;
    gpuCasters_.reset();
    if (all_) return;
    const LightView centre = views_.from(glm::dvec2(0.0));
    const bool onlyInTheWay =
        parts_ == MapParts::compared && comparesInTheWay(frame, centre, size, kernel_);
    casters_ = std::make_shared<const Geometry>(
        shadowCasters(frame, {wholeLight, parts_ == MapParts::casting, onlyInTheWay,
                              marginM(centre, frame.lightBounds, size)}));
    gpuCasters_ = std::make_unique<GpuGeometry>(casters_, frame.gpuGeometry.materials());
}

glm::dvec2 LightMaps::reachTangent(int kernel) const {
    // The texels of a kernel are within half of its width of the place it is around; rasterisation
    // moves vertices by a 256th.
    const double texels = 0.5 * kernel + 0.01;
    return texels / size_ * views_.from(glm::dvec2(0.0)).tiles[0].tangentSize();
}

void LightMaps::drawDepth(const Frame& frame, std::span<const LightView> views, int before) {
    if (!gpuCasters_) return depth_.render(frame, views, size_, before);
    const Frame reduced{frame.scene,           frame.index,  frame.light,       frame.lightBounds,
                        frame.camera,          casters_,     frame.tracer,      frame.gbuffer,
                        frame.gbufferTextures, *gpuCasters_, frame.casterFacts, frame.seed};
    depth_.render(reduced, views, size_, before);
}

std::size_t LightMaps::capacity() const {
    GLint mostLayers = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &mostLayers);
    const double layerMebibytes = 4.0 * size_ * size_ / (1024.0 * 1024.0);
    const double layers = std::min(kMaxMebibytes / layerMebibytes, static_cast<double>(mostLayers));
    const auto samples = static_cast<std::size_t>(layers) / views_.tileCount();
    return std::clamp<std::size_t>(samples, 1, kMaxSamples);
}

void LightMaps::render(const Frame& frame, std::span<const LightSample> samples) {
    samples_.clear();
    append(frame, samples);
}

void LightMaps::append(const Frame& frame, std::span<const LightSample> samples) {
    const LightView centre = views_.from(glm::dvec2(0.0));
    const LightTile& front = centre.tiles[0];
    const glm::dvec2 texelsPerTangent = static_cast<double>(size_) / front.tangentSize();
    const int before = count();
    std::vector<LightView> views;
    for (const LightSample& sample : samples) {
        const LightView& view = views.emplace_back(views_.from(sample.offsetM));
        const glm::dvec2 frustumShift = front.tangentLo - view.tiles[0].tangentLo;
        samples_.push_back({glm::vec4(glm::dvec4(frustumShift * texelsPerTangent,
                                                 -sample.offsetM * texelsPerTangent)),
                            glm::vec4(glm::vec3(view.centre - centre.centre), sample.weight)});
    }
    upload();
    drawDepth(frame, views, before);
}

void LightMaps::setWeights(std::span<const float> weights) {
    for (std::size_t i = 0; i < samples_.size(); ++i) samples_[i].offsetWeight.w = weights[i];
    upload();
}

void LightMaps::upload() {
    glNamedBufferSubData(sampleBuffer_.id(), 0,
                         static_cast<GLsizeiptr>(samples_.size() * sizeof(GpuSample)),
                         samples_.data());
    select(0, count());
}

void LightMaps::select(int first, int count) {
    first_ = first;
    count_ = count;
    weight_ = 0.0f;
    for (int i = first; i < first + count; ++i)
        weight_ += samples_[static_cast<std::size_t>(i)].offsetWeight.w;
}

void LightMaps::bind(const gl::Program& program) const {
    depth_.map().bind(0);
    setLightView(program, views_.from(glm::dvec2(0.0)), size_);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, sampleBuffer_.id());
    program.set("firstLightSample", first_);
    program.set("lightSampleCount", count_);
    program.set("lightSampleWeight", weight_);
}

}  // namespace penumbra
