#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/trace/shaft.hpp"

namespace penumbra {

/// Tiles of 4 x 4 pixels that see all of the light, by geometry: no triangle that reaches above the
/// tangent plane of any of a tile's receivers is in the hull of the tile and the light (Haines,
/// Wallace 1991, "Shaft Culling for Efficient Ray-Traced Radiosity"). What is drawn into no map can
/// hide nothing in one, and no ray meets what is not there, so that the answer 1 is what any number
/// of maps or rays from points of the light give: nothing is sampled, and no caster is too thin.
///
/// Blocks of 32 x 32 pixels are asked first, and divided where something is in the way. Tiles with
/// horizon pixels, or receivers at the light's plane or behind it, are never lit.
class LitTiles {
  public:
    static constexpr int kSide = 4;  ///< pixels

    /// Makes the tree of `casters` (shadowCasters), which no later call needs.
    void build(const Frame& frame, const Geometry& casters);
    /// Finds the frame's tiles. `half`: the light's half sides, zero for its centre alone;
    /// `reachTangent`: how far beside a receiver is looked, as a part of its depth z.
    void find(const Frame& frame, const glm::dvec2& half, const glm::dvec2& reachTangent);
    /// Whether the tiles are those that this camera sees.
    bool isFor(const Camera& camera) const { return camera_ == camera; }
    /// They are no camera's from now on.
    void forgetCamera() { camera_.reset(); }

    int across() const { return across_; }
    int down() const { return down_; }
    bool isLit(int tileX, int tileY) const {
        return lit_[static_cast<std::size_t>(tileY * across_ + tileX)] != 0;
    }

  private:
    struct Casters {
        std::vector<glm::dvec3> vertices;  ///< in light space
        std::vector<std::array<std::uint32_t, 3>> triangles;
        ShaftTree tree;
        Casters(const Frame& frame, const Geometry& casters);
    };
    std::unique_ptr<Casters> casters_;
    std::vector<char> lit_;
    int across_ = 0, down_ = 0;
    std::optional<Camera> camera_;
};

}  // namespace penumbra
