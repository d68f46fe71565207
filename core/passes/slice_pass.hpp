#pragma once

#include "core/frame/used_slices.hpp"
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

/// What slices are drawn into.
enum class SliceTargets {
    channels,  ///< one to four RGBA8 targets, a slice each channel, at most kMostChannels
    bits,      ///< bits of one R32UI or RG32UI target (slice maps; Eisemann, Decoret 2006, I3D)
};

/// Occlusion textures: all casters between a light and its receivers in one geometry pass without
/// depth test, each fragment a 1 in the channel of its slice (Eisemann, Decoret 2006, 3.4). Both
/// sides of every triangle count. Textures hold the used slices only, one after the other.
class SlicePass {
  public:
    static constexpr int kMostSlices = 64;
    static constexpr int kMostChannels = 16;

    SlicePass() = default;
    /// Compiles for that many slices (1 to kMostSlices), with or without the alpha test. More than
    /// kMostChannels are drawn as bits whatever `targets` says.
    SlicePass(int slices, SliceTargets targets, bool alphaMask);

    /// `view` has as many slices, into `used` of which at most something is drawn. Sets all GL
    /// state it needs.
    void render(const Frame& frame, const SliceView& view, const SliceFill& fill, int size,
                SliceSet used = ~SliceSet{0});
    /// Makes channels() from bits, where they are bits.
    void unpack();

    int used() const { return used_; }  ///< slices that the last render may have drawn to
    SliceTargets targets() const { return targets_; }
    /// R32UI up to 32 slices, RG32UI above: the used slice i is bit i % 32 of channel i / 32.
    const gl::Texture& bits() const { return bits_; }
    /// RGBA8 2D array of 0 and 1: the used slice i is channel i % 4 of layer i / 4. All mip levels
    /// are allocated, level 0 is drawn; where targets are bits, once they are unpacked.
    const gl::Texture& channels() const { return channels_; }
    double mebibytes() const { return channels_.mebibytes() + bits_.mebibytes(); }

  private:
    int layers() const { return (slices_ + 3) / 4; }
    void allocateChannels(int size);
    void attach(int size);

    int slices_ = 0, used_ = 0, size_ = 0;
    SliceTargets targets_ = SliceTargets::bits;
    bool alphaMask_ = false;
    gl::Program program_, unpack_;
    gl::Texture channels_, bits_;
    gl::Framebuffer framebuffer_;
};

}  // namespace penumbra
