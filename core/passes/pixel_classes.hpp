#pragma once

#include <array>

#include "core/frame/frame.hpp"
#include "core/frame/lit_tiles.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"
#include "core/passes/depth_pass.hpp"
#include "core/passes/min_max_pyramid.hpp"

namespace penumbra {

/// Answers tiles of 4 x 4 pixels at once where the min/max pyramid of the map from the light's
/// centre leaves no doubt, so that a method shades only the others: `classify`, `shade` with the
/// method's program, and `answers` over the whole image. llvmpipe takes both sides of every branch;
/// a tile that is not drawn costs nothing.
///
/// A tile is lit where no texel of the map that lies between any of its receivers and any point of
/// the light is above that receiver's tangent plane by the bias, by the comparison that litAt of
/// shaders/common/light_view.glsl makes. A caster that hides a point of the light from a receiver
/// lies in the pyramid between the receiver and the light, and so does whatever hides that caster
/// from the light's centre: the answer 1 is sound for every method, up to the map's resolution and
/// its bias (a caster thinner than a texel can fall between), if the map holds all that the
/// footprints pass over. Tiles of receivers for whom part of the light is below the horizon are
/// undecided. In side tiles of a half cube the
/// footprint leaves the light's perspective over its own depth out, as pcss does.
///
/// A tile is dark where all of those texels block all of its receivers. That is not the truth (the
/// light's rim may see past what the centre sees) but what a filter over that map must answer:
/// for pcss alone.
///
/// With Footprint::box the question is another: what a filter answers that looks at a rectangle of
/// the map around the receiver, all of it. Lit and dark tiles are those where all of its texels are
/// under, or all block, whatever weights the filter gives them. Under is meant of the tangent plane
/// itself, at every texel, so that the mean depth of any of them is behind the plane's own. With
/// Footprint::moments dark are those where Chebyshev's bound is nothing as well, by the nearest and
/// the farthest of the texels.
///
/// Pixels of undecided tiles know a box of the map outside of which nothing blocks.
/// shaders/common/pixel_classes.glsl has the GLSL side.
///
/// A method whose answer rests on more than such a map brings a test of its own.
class PixelClasses {
  public:
    /// What is decided besides lit tiles.
    enum class Dark { no, yes };
    enum class Footprint { light, box, moments };  ///< moments: a box that vsm averages

    PixelClasses() = default;
    /// Compiles; textures are allocated by classify.
    static PixelClasses create(Dark dark, Footprint footprint = Footprint::light);
    /// With a method's own test: a program over the tiles, one fragment each, that includes
    /// shaders/common/tile_class.glsl and writes `tileClass` as
    /// shaders/common/pixel_classes.glsl reads it.
    static PixelClasses create(gl::Program test);
    /// For decide: compiles nothing that classifies.
    static PixelClasses decided();

    /// Widths of the footprint at the receiver, in sizes of the light: as wide as the casters
    /// found make it within these. For casters at any height `most` has no bound.
    struct Kernel {
        float least = 0.0f;
        float most = 1e6f;
    };
    /// Classes of the tiles of `frame`'s pixels under `depth`'s map and the pyramid built of it.
    void classify(const Frame& frame, const DepthPass& depth, const MinMaxPyramid& pyramid,
                  float biasTexels, const Kernel& kernel);

    /// A rectangle around a receiver, along the light's u and v; in side tiles the wider extent
    /// serves for both.
    struct Box {
        glm::dvec2 halfM{0.0};  ///< half extents at the receiver's depth, times:
        Kernel kernel;          ///< clamp(nearestS / s - 1, least, most) of the receiver's s
        std::array<float, 5> nearestS = {1, 1, 1, 1, 1};  ///< of tiles: of the nearest caster
        /// Farther than half a texel from the rectangle's own places, texels that are looked at,
        /// those of one place compared with one reference.
        float padTexels = 0.0f;
        /// Footprint::moments: depths per metre of each tile, the least variance of a cell, in
        /// those, and what of Chebyshev's bound counts as nothing.
        std::array<float, 5> depthPerM{};
        float leastVariance = 0.0f, bleed = 0.0f;
    };
    /// Whether tiles of a box spare more than they cost, where an answered pixel spares so many
    /// lookups of the map or of what is made of it: bounding a texel of the map takes as long as
    /// one or two, classes and answers as much again, and a half of all pixels are answered.
    static bool areWorth(const Frame& frame, int mapSize, double lookupsSpared);
    /// Windows of the pyramid that are asked for of it, texels: MinMaxPyramid::build.
    static double widestWindow(const Frame& frame, const DepthPass& depth, const Box& box);
    /// The same for Footprint::box.
    void classify(const Frame& frame, const DepthPass& depth, const MinMaxPyramid& pyramid,
                  float biasTexels, const Box& box);
    /// The same by the method's own test, all of whose own uniforms are set on test() and textures
    /// bound.
    void classify(const Frame& frame);
    const gl::Program& test() const { return classify_; }
    /// Lit tiles as they were found by geometry, all others undecided everywhere.
    void decide(const Frame& frame, const LitTiles& tiles);
    /// Runs `program` (UNDECIDED_TILES defined, all of its own textures bound, units 10 and 11
    /// free) over the pixels of undecided tiles. Sets all GL state it needs.
    void shade(const gl::Program& program, const Frame& frame) const;
    /// The program that writes the answers, in use and with what it reads bound, for
    /// VisibilityTarget::draw.
    const gl::Program& answers() const;

    /// Binds the tiles for a program that asks for their classes itself.
    void bind() const;
    const gl::Texture& tiles() const { return tiles_; }  ///< RGBA32F, a texel per tile
    double mebibytes() const { return tiles_.mebibytes() + shaded_.mebibytes(); }

  private:
    void begin(const gl::Framebuffer& framebuffer, const Frame& frame) const;
    void allocate(const Frame& frame);
    void classifyUnder(const Frame& frame, const DepthPass& depth, const MinMaxPyramid& pyramid,
                       float biasTexels, const Kernel& kernel);

    gl::Program classify_, answers_;
    gl::Texture tiles_, shaded_;
    gl::Framebuffer tileBuffer_, pixelBuffer_;
    gl::VertexArray empty_;
};

/// Sets the uniforms of shaders/common/footprint.glsl on `program` (in use).
void setFootprint(const gl::Program& program, const AreaLight& light);

}  // namespace penumbra
