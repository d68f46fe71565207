#pragma once

#include <span>
#include <vector>

#include "core/effects/effects.hpp"
#include "core/frame/gpu_geometry.hpp"
#include "core/frame/light_view.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"

namespace penumbra {

/// Which parts of a frame a map holds.
enum class MapParts {
    all,
    /// Without those that no comparison can find, where the frame's CasterFacts say so for maps as
    /// coarse: for maps that receivers are compared with, moved towards the
    /// light by as many texels as they look aside or more. Floors and walls that shadow nothing are
    /// the most of what a small map costs.
    compared,
    /// Without those that shadow nothing (CasterFacts): for plans without Effect::self_shadow.
    casting,
};

/// Whether PartFacts::inTheWay holds for maps of that view and size, where comparisons are with
/// `kernel` x `kernel` texels.
bool comparesInTheWay(const Frame& frame, const LightView& view, int size, int kernel);

/// A shadow map of a light view: DEPTH_COMPONENT32F 2D array, one layer per tile, storing
/// s = nearM / z (see LightView), 0 where no caster is. Both sides of every triangle cast. Of
/// bodies known to be closed (PartFacts::outward) that are all in front of the light, those that
/// are turned away are left out: along any ray they are met behind others, and the map is the same
/// to the last bit (PartDraw::rasterSteps).
class DepthPass {
  public:
    DepthPass() = default;
    /// Compiles the program, with the alpha test if the plan has it; maps are allocated by render.
    /// MapParts::compared is for comparisons with one texel. A plan of every pixel draws both sides
    /// of everything.
    explicit DepthPass(const Plan& plan, MapParts parts = MapParts::all);

    /// Renders the casters into `size` x `size` texels per tile. Sets all GL state it needs.
    void render(const Frame& frame, const LightView& view, int size);
    /// Several views of equally many tiles: tile t of view i into layer (firstView + i) * tiles +
    /// t. view() and bind are the first one's. Other layers are kept; with `firstView` the views
    /// before it have been rendered in the same size, and an array that grows does so by half.
    void render(const Frame& frame, std::span<const LightView> views, int size, int firstView = 0);

    const gl::Texture& map() const { return map_; }
    const LightView& view() const { return view_; }
    double texels() const;  ///< of all layers
    /// Sets the uniforms of shaders/common/light_view.glsl on `program` (in use) and binds the map
    /// to texture unit `unit`.
    void bind(const gl::Program& program, GLuint unit) const;

  private:
    void allocate(int layers, std::size_t tiles, int size, int keptLayers);
    std::vector<PartDraw> howDrawn(const Frame& frame, const LightView& view, std::size_t tile,
                                   int size) const;

    gl::Program program_;
    gl::Texture map_;
    gl::Framebuffer framebuffer_;
    LightView view_;
    bool alphaMask_ = false;
    MapParts parts_ = MapParts::all;
    bool leavesAverted_ = false;
};

/// For reading a depth pass's map as a sampler2DArrayShadow: the share, bilinear, of the four
/// nearest texels whose s is at most the reference. Past the map's border no caster is.
gl::Sampler comparingSampler();

/// Sets the uniforms of shaders/common/light_view.glsl on `program` (in use) for maps of `size`
/// texels across.
void setLightView(const gl::Program& program, const LightView& view, int size);

}  // namespace penumbra
