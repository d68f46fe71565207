#pragma once

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// Means over squares at every place, not only at multiples of their size as mip levels have them
/// (Decoret 2005): texel (x, y) of level l is the mean of the 2^l x 2^l source texels from (x, y)
/// on, what lies outside counting as 0. One texel's shift of the source shifts every level by one.
/// RGBA16F, whose rounding adds up to less than 2^-11 per level.
class NBuffers {
  public:
    NBuffers() = default;
    /// For the current context.
    static NBuffers create();

    /// Levels 0 to `levels` - 1 of all layers of `source`, a four-channel float or normalized 2D
    /// array texture.
    void build(const gl::Texture& source, int levels);

    /// Level l of source layer i is layer i * levels() + l; linear filtering.
    const gl::Texture& texture() const { return texture_; }
    int levels() const { return levels_; }
    double mebibytes() const { return texture_.mebibytes(); }

  private:
    gl::Program base_, next_;
    gl::Texture texture_;
    int levels_ = 0;
};

}  // namespace penumbra
