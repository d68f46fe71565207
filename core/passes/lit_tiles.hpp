#pragma once

#include "core/passes/pixel_classes.hpp"

namespace penumbra {

/// Tiles of pixels that see all of the light, told from one map from its centre that holds whatever
/// may hide a part of it (PixelClasses without dark tiles and without a bound on the kernel).
///
/// A tile is answered 1 only where no texel of that map can be between its receivers and any point
/// of the light. The map is widened so that a ray from a receiver to the light stays inside it down
/// to the nearest vertex's depth, and its texels are no larger than those of a map fitted to the
/// receivers; what is lost is what lies between the centres of its texels.
class LitTiles {
  public:
    LitTiles() = default;
    /// Compiles; textures are allocated by classify.
    explicit LitTiles(bool alphaMask);

    /// Renders the map, its texels as large as those of `mapSize` across the receivers, and
    /// classifies the frame's tiles. Does nothing, so that usable() is false, where the map would
    /// be more than twice as wide as the receivers are (casters close to the light) or would need
    /// five tiles (PixelClasses leaves the light's own depth out there). `biasTexels`: how far
    /// receivers are moved towards the light, texel footprints.
    void classify(const Frame& frame, int mapSize, float biasTexels);
    bool usable() const { return usable_; }
    const PixelClasses& classes() const { return classes_; }

    int maps() const { return usable_ ? 1 : 0; }  ///< rendered by the last call
    double texels() const { return usable_ ? depth_.texels() : 0.0; }
    double mebibytes() const;

  private:
    DepthPass depth_;
    MinMaxPyramid pyramid_;
    PixelClasses classes_;
    bool usable_ = false;
};

}  // namespace penumbra
