#pragma once

#include <vector>

#include "core/passes/layer_pass.hpp"

namespace penumbra {

enum class BlurShape {
    box,       ///< equal weights, the outermost texels by the part of them that it covers
    gaussian,  ///< of the same variance as that box, up to three standard deviations
};

/// One half of a symmetric kernel `widthTexels` wide: entry i is the weight of the texels i before
/// and i after the middle one; entry 0 and twice the others add up to 1. A width of at most one
/// texel gives {1}, the kernel that changes nothing.
std::vector<float> blurWeights(BlurShape shape, double widthTexels);

/// Separable blur of all layers of a 2D array texture with one or two colour channels. At the
/// borders the texels outside are left out and the weights of the others scaled up to 1.
class Blur {
  public:
    Blur() = default;
    /// For the current context.
    static Blur create();

    /// Blurs level 0 of `texture` in place, along x with `weightsX`, along y with `weightsY`
    /// (blurWeights). Intermediate results have the texture's own format.
    void apply(const gl::Texture& texture, const std::vector<float>& weightsX,
               const std::vector<float>& weightsY);

    double mebibytes() const { return scratch_.mebibytes(); }

  private:
    void along(int x, int y, const std::vector<float>& weights, const gl::Texture& from,
               const gl::Texture& to) const;

    LayerPass pass_;
    gl::Program program_;
    gl::Texture scratch_;
};

}  // namespace penumbra
