#pragma once

#include <glm/glm.hpp>
#include <span>

#include "core/gl/handles.hpp"
#include "harness/report/shade.hpp"

namespace penumbra {

/// A picture on the GPU for the window to show: linear RGB in, sRGB bytes out, as writePng() has
/// them.
class Picture {
  public:
    void upload(const Image& linearRgb);
    void clear() { texture_ = {}; }
    bool empty() const { return !texture_; }
    GLuint id() const { return texture_.id(); }
    int width() const { return texture_.width(); }
    int height() const { return texture_.height(); }

  private:
    gl::Texture texture_;
};

/// `light` of a picture taken `stops` brighter.
PictureLight exposed(PictureLight light, float stops);

/// a - b in errorColour(), hatched where nobody answers; empty where either is.
Image differenceMap(const GBuffer& gbuffer, std::span<const float> a, std::span<const float> b);

}  // namespace penumbra
