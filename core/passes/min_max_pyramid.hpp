#pragma once

#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"

namespace penumbra {

/// Bounds of a shadow map's s = nearM / z over square windows. The map is cut into blocks of
/// texels; level l holds, for every block, the window of 2^l x 2^l blocks that starts there.
/// Windows overlap as in N-buffers (Decoret 2005), so that four of them cover any square to within
/// a block, where a pyramid of disjoint blocks reaches out by half the square.
///
/// Besides the greatest and the least s a window has a plane above all of its texels: s is affine
/// over a surface that is flat, so a tilted one is bounded tightly and a receiver can be told from
/// its casters.
///
/// RGBA32UI array of maps x levels layers, level l of map t in layer t levels() + l. A texel: max s
/// and min s as float bits in r and g, the plane's slope per texel as two half floats in b (scaled,
/// see shaders/common/min_max_pyramid.glsl), its height at the window's centre as float bits in a.
/// Windows that reach beyond the map hold nothing of use.
class MinMaxPyramid {
  public:
    MinMaxPyramid() = default;
    /// Compiles; the texture is allocated by build.
    static MinMaxPyramid create();

    /// Bounds `depth`'s map as it was rendered last, in windows of up to `widestTexels` across and
    /// of one block at least. Sets all GL state it needs.
    void build(const DepthPass& depth, double widestTexels = 1e9);

    const gl::Texture& texture() const { return texture_; }
    int levels() const { return levels_; }
    int blockTexels() const { return blockTexels_; }  ///< side of a block
    /// Sets the uniforms of shaders/common/min_max_pyramid.glsl on `program` and binds the texture
    /// to unit 1.
    void bind(const gl::Program& program) const;

  private:
    gl::Program base_, reduce_;
    gl::Texture texture_;
    gl::Framebuffer framebuffer_;
    gl::VertexArray empty_;
    int levels_ = 0, blockTexels_ = 0;
};

}  // namespace penumbra
