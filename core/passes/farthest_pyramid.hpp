#pragma once

#include <array>

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// How far from the light the farthest surface is in any part of two shadow maps of s = nearM / z:
/// the least s that is not 0. R32F array of one layer a map; a texel of level l bounds a block of
/// kBlockTexels * 2^l texels across, and is kNothing where the block shows no surface.
class FarthestPyramid {
  public:
    static constexpr int kBlockTexels = 8;
    static constexpr float kNothing = 2.0f;  ///< nearer than any surface

    FarthestPyramid() = default;
    /// Compiles; the texture is allocated by build.
    static FarthestPyramid create();

    /// Of the first layers of two array textures of one size. What is fetched next sees it.
    void build(const std::array<const gl::Texture*, 2>& maps);

    const gl::Texture& texture() const { return texture_; }

  private:
    gl::Program base_, reduce_;
    gl::Texture texture_;
    int levels_ = 0;
};

}  // namespace penumbra
