#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/effects/effects.hpp"
#include "core/frame/translated_views.hpp"
#include "core/passes/depth_pass.hpp"

namespace penumbra {

/// A point of the light and what its map counts.
struct LightSample {
    glm::dvec2 offsetM{0.0};  ///< from the light's centre along axisU and axisV
    float weight = 1.0f;
    bool operator==(const LightSample&) const = default;
};

/// Shadow maps of one frame from many points of its light (TranslatedViews), as many at a time as
/// one array is allowed to hold. shaders/common/light_maps.glsl looks them up.
class LightMaps {
  public:
    LightMaps() = default;
    /// Compiles for the plan. Unless every pixel is to get all of the work the maps hold just what
    /// shadowCasters leaves, of `parts`. Lookups are of `kernel` x `kernel` texels at most.
    LightMaps(const Plan& plan, MapParts parts, int kernel);

    /// A new frame: fits its views, for maps of `size` texels across. With `wholeLight` false the
    /// only sample may be the light's centre, and its map is that of the method `hard`.
    void fit(const Frame& frame, int size, bool wholeLight = true);
    /// How many samples one array may hold: at most kMaxSamples, kMaxMebibytes and the renderer's
    /// layers, at least 1.
    std::size_t capacity() const;
    /// Replaces the array's maps by those of `samples`, at most capacity() of them. Nothing is read
    /// back: the calls only queue work.
    void render(const Frame& frame, std::span<const LightSample> samples);
    /// Adds the maps of `samples` after those in the array, capacity() of them in all at most.
    void append(const Frame& frame, std::span<const LightSample> samples);
    /// Replaces the weights of all samples, one each in their order.
    void setWeights(std::span<const float> weights);
    /// Only samples first to first + count - 1 are looked up and weighed from here on; render,
    /// append and setWeights select all.
    void select(int first, int count);
    /// Sets the uniforms of shaders/common/light_maps.glsl on `program` (in use), binds the array
    /// to texture unit 0 and the samples to uniform buffer 1.
    void bind(const gl::Program& program) const;

    /// What the maps hold: the frame's own geometry or what shadowCasters left of it.
    const Geometry& casters() const { return *casters_; }
    /// Half of the light where `wholeLight`, else 0, and how far beside a receiver's place lookups
    /// of `kernel` x `kernel` texels reach in every map, in tangents: for LitTiles.
    const glm::dvec2& half() const { return half_; }
    glm::dvec2 reachTangent(int kernel) const;
    int count() const { return static_cast<int>(samples_.size()); }
    float weight() const { return weight_; }  ///< of all that are selected
    LightView centre() const { return views_.from(glm::dvec2(0.0)); }
    int tileCount() const { return static_cast<int>(views_.tileCount()); }
    const gl::Texture& texture() const { return depth_.map(); }  ///< as DepthPass::map
    double mebibytes() const { return depth_.map().mebibytes(); }

    static constexpr std::size_t kMaxSamples = 256;  ///< 8 KiB of uniforms; in the shader, too
    static constexpr double kMaxMebibytes = 256.0;

  private:
    /// LightSample of shaders/common/light_maps.glsl, std140.
    struct GpuSample {
        glm::vec4 shift;
        glm::vec4 offsetWeight;
    };
    void upload();
    void drawDepth(const Frame& frame, std::span<const LightView> views, int before);

    bool all_ = true;
    MapParts parts_ = MapParts::all;
    int kernel_ = 1;
    std::shared_ptr<const Geometry> casters_;
    std::unique_ptr<GpuGeometry> gpuCasters_;
    glm::dvec2 half_{0.0};
    TranslatedViews views_;
    int size_ = 0;
    DepthPass depth_;
    gl::Buffer sampleBuffer_;
    std::vector<GpuSample> samples_;
    int first_ = 0, count_ = 0;
    float weight_ = 0.0f;
};

}  // namespace penumbra
