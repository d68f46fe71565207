#pragma once

#include "core/frame/slice_view.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// Which casters are written into the slice below their own, too.
struct SliceFill {
    bool always = false;  ///< every caster into every next slice
    /// R32F, vertex v at (v % width, v / width): the depth down to which its caster goes on; the
    /// slices that begin above that depth are filled with the one before. Not used where null or
    /// `always`.
    const gl::Texture* depthM = nullptr;
};

/// Occlusion textures: all casters between a light and its receivers in one geometry pass without
/// depth test, each fragment a 1 in the channel of its slice (Eisemann, Decoret 2006, 3.4). Both
/// sides of every triangle count.
class SlicePass {
  public:
    static constexpr int kMostSlices = 64;
    /// Up to here slices are drawn into channels of up to four RGBA8 targets; more become bits of
    /// one RGBA32UI target (Eisemann, Decoret 2006, I3D: slice maps), unpacked afterwards.
    static constexpr int kMostChannels = 16;

    SlicePass() = default;
    /// Compiles for that many slices (1 to kMostSlices), with or without the alpha test.
    SlicePass(int slices, bool alphaMask);

    /// `view` has as many slices. `levels` mip levels are allocated, level 0 is drawn. Sets all GL
    /// state it needs.
    void render(const Frame& frame, const SliceView& view, const SliceFill& fill, int size,
                int levels = 1);

    /// RGBA8 2D array of 0 and 1: slice k is channel k % 4 of layer k / 4.
    const gl::Texture& texture() const { return texture_; }
    double mebibytes() const { return texture_.mebibytes() + bits_.mebibytes(); }

  private:
    bool packed() const { return slices_ > kMostChannels; }
    int layers() const { return (slices_ + 3) / 4; }
    void allocate(int size, int levels);
    void unpack() const;

    int slices_ = 0, levels_ = 0;
    bool alphaMask_ = false;
    gl::Program program_, unpack_;
    gl::Texture texture_, bits_;
    gl::Framebuffer framebuffer_;
};

}  // namespace penumbra
