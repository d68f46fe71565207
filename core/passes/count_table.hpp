#pragma once

#include <glm/glm.hpp>

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"
#include "core/passes/slice_pass.hpp"

namespace penumbra {

/// Summed-area tables (Crow 1984) of occlusion textures: how many texels of any rectangle of each
/// slice are covered, exactly, from four fetches. A plane's texel (x, y) holds the sum of all
/// texels left of x and above y, so that it is one texel larger than the slices each way.
///
/// Sums are modulo 2^32 and differences of corners right as long as the box's own count fits. Where
/// no box has more than 65535 texels two slices share a number: the low one's carries into the high
/// one's half cancel in the difference, which halves what is to be written. Planes are one channel
/// each, for a lookup asks for one slice at a time.
class CountTable {
  public:
    CountTable() = default;
    /// For the current context.
    static CountTable create();

    /// Texels of the slices, from `lo` to before `hi`, outside of which all are empty.
    struct Region {
        glm::ivec2 lo, hi;
    };
    /// Of the used slices. `maxBoxTexels` is the area of the largest box of whole texels that will
    /// be asked for. Nothing is summed up outside of `region`, rounded up to whole blocks.
    void build(const SlicePass& slices, double maxBoxTexels, const Region& region);
    void build(const SlicePass& slices, double maxBoxTexels);

    /// Binds planes() to `unit` and sets the uniforms that shaders/common/slice_kernels.glsl finds
    /// sums by on `program`, in use.
    void bind(const gl::Program& program, GLuint unit) const;

    /// Texel (0, 0) is that of the region's `lo`. R32UI 2D array: the used slice i is plane i /
    /// lanes(), in half i % lanes() of its numbers.
    const gl::Texture& planes() const { return planes_; }
    int lanes() const { return lanes_; }  ///< slices that share a plane, 1 or 2
    double mebibytes() const { return rowSums_.mebibytes() + planes_.mebibytes(); }

  private:
    gl::Program rowsOfBits_, rowsOfChannels_, columns_;
    gl::Texture rowSums_;  ///< RGBA32UI, four planes a layer: the scans of rows
    gl::Texture planes_;
    glm::ivec2 first_{0};  ///< texel of the slices that the planes begin at
    int lanes_ = 0;
};

}  // namespace penumbra
