#pragma once

#include <span>
#include <vector>

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
    explicit LightMaps(bool alphaMask);

    /// A new frame: fits its views, for maps of `size` texels across. With `wholeLight` false the
    /// only sample may be the light's centre, and its map is that of the method `hard`.
    void fit(const Frame& frame, int size, bool wholeLight = true);
    /// How many samples one array may hold: at most kMaxSamples, kMaxMebibytes and the renderer's
    /// layers, at least 1.
    std::size_t capacity() const;
    /// Replaces the array's maps by those of `samples`, at most capacity() of them. Nothing is read
    /// back: the calls only queue work.
    void render(const Frame& frame, std::span<const LightSample> samples);
    /// Sets the uniforms of shaders/common/light_maps.glsl on `program` (in use), binds the array
    /// to texture unit 0 and the samples to uniform buffer 1.
    void bind(const gl::Program& program) const;

    int tileCount() const { return static_cast<int>(views_.tileCount()); }
    double mebibytes() const { return depth_.map().mebibytes(); }

    static constexpr std::size_t kMaxSamples = 256;  ///< 8 KiB of uniforms; in the shader, too
    static constexpr double kMaxMebibytes = 256.0;

  private:
    TranslatedViews views_;
    int size_ = 0;
    DepthPass depth_;
    gl::Buffer sampleBuffer_;
    int count_ = 0;
    float weight_ = 0.0f;
};

}  // namespace penumbra
