#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/gl/handles.hpp"
#include "core/gl/program.hpp"
#include "core/passes/light_maps.hpp"
#include "core/sampling/light_tree.hpp"

namespace penumbra {

/// Maps that are to agree at a pixel, by their index in LightMaps. Two are named twice: a b a b.
using MapComparison = glm::ivec4;

/// Comparisons that a part of the light is judged by: all its corners with each other or, with
/// `allPairs` false, opposite ones; and its centre, where it has one, with a corner.
std::vector<MapComparison> comparisonsOf(const LightTree::Leaf& leaf, bool allPairs);

/// Square tiles of an image, the last ones cut off by its rim; one tile holds all where they are as
/// large as the image.
struct TileGrid {
    int width = 1, height = 1, side = 1;  ///< pixels
    int columns() const { return (width + side - 1) / side; }
    int rows() const { return (height + side - 1) / side; }
    std::size_t count() const { return static_cast<std::size_t>(columns() * rows()); }
};

/// Every `stride`-th pixel of a G-buffer's rows and columns, as comparedPixel of
/// shaders/adaptive_light_sampled.glsl has them: how many of them receive light.
int receiversAmong(const GBuffer& gbuffer, int stride);

/// Full-screen passes that have no picture, only what they store or what a query counts.
class BlankTarget {
  public:
    BlankTarget() = default;
    BlankTarget(int width, int height);

    /// Binds the target and the G-buffer and sets all GL state of the draws that follow.
    void begin(const GBufferTextures& gbuffer) const;
    void draw() const;
    /// Ends the draws.
    void end() const;
    int width() const { return width_; }
    int height() const { return height_; }

  private:
    gl::Framebuffer framebuffer_;
    gl::VertexArray empty_;
    int width_ = 0, height_ = 0;
};

/// The receivers that a pass over all pixels finds worth comparing, one after another in the rows
/// of a texture, so that what is drawn many times is drawn for those only. The programs are
/// shaders/adaptive_light_sampled.glsl's PASS_COLLECT and, to read them, PASS_COMPARE with
/// COLLECTED.
class CollectedReceivers {
  public:
    /// Replaces them by what `program` (in use, its own uniforms and textures set) finds among
    /// `pixels`' pixels. Waits for their number.
    void collect(const gl::Program& program, const BlankTarget& pixels,
                 const GBufferTextures& gbuffer);
    /// Sets what `program` (in use) reads them by.
    void bind(const gl::Program& program) const;
    /// As large as the rows that are filled, 1 at least.
    const BlankTarget& target() const { return rows_; }
    double mebibytes() const { return receivers_.mebibytes(); }

  private:
    BlankTarget rows_;
    gl::Texture receivers_;  ///< RGBA32F: place in the map of the light's centre (texels), 1 / z
    gl::Buffer counter_;
    int count_ = 0;
};

/// Counts pixels at which maps differ by occlusion queries (GL_SAMPLES_PASSED), one per comparison
/// and tile, all of them submitted before any is read.
class QueriedComparison {
  public:
    /// `pass` sets the program's uniforms once per draw; it is called with each comparison,
    /// `drawsPerComparison` times with the number of the draw, whose pixels a query adds up. The
    /// program is in use. The counts of a comparison's tiles follow each other.
    template <class SetUniforms>
    std::vector<std::uint64_t> count(const BlankTarget& target, const GBufferTextures& gbuffer,
                                     std::span<const MapComparison> comparisons,
                                     const TileGrid& tiles, int drawsPerComparison,
                                     const SetUniforms& setUniforms) {
        begin(comparisons.size() * tiles.count());
        target.begin(gbuffer);
        std::size_t query = 0;
        for (const MapComparison& comparison : comparisons)
            for (std::size_t tile = 0; tile < tiles.count(); ++tile) {
                beginQuery(query++, tiles, static_cast<int>(tile));
                for (int draw = 0; draw < drawsPerComparison; ++draw) {
                    setUniforms(comparison, draw);
                    target.draw();
                }
                endQuery();
            }
        target.end();
        return results(query);
    }

  private:
    void begin(std::size_t queries);
    void beginQuery(std::size_t query, const TileGrid& tiles, int tile) const;
    void endQuery() const;
    std::vector<std::uint64_t> results(std::size_t queries) const;

    std::vector<gl::Query> queries_;
};

/// Shadow tests kept as one bit per pixel and map, so that a map is looked up once however many
/// comparisons it takes part in; pixels that differ are counted by atomics. The programs are
/// shaders/adaptive_light_sampled.glsl's PASS_MARK_BITS and PASS_SHADE_BITS.
class ShadowBits {
  public:
    ShadowBits() = default;
    ShadowBits(int width, int height);

    /// Tests every pixel against the maps that `maps` has selected, all those before them having
    /// been marked, and counts for each comparison (of maps marked by now) in how many pixels of
    /// each tile they differ. The counts of a comparison's tiles follow each other.
    std::vector<std::uint64_t> mark(const gl::Program& program, const GBufferTextures& gbuffer,
                                    std::span<const MapComparison> comparisons,
                                    const TileGrid& tiles);
    /// Binds the bits for a program that reads them, after mark.
    void bind() const;
    bool holds(int width, int height) const {
        return bits_.width() == width && bits_.height() == height;
    }
    double mebibytes() const { return bits_.mebibytes(); }

  private:
    BlankTarget target_;
    gl::Texture bits_;  ///< R32UI array, bit i % 32 of layer i / 32 is map i's
    gl::Buffer comparisons_, counts_;
};

}  // namespace penumbra
