#pragma once

#include <array>
#include <vector>

#include "core/sampling/sampling.hpp"

namespace penumbra {

/// The first points of R independent Owen-scrambled Sobol sequences, shared by all pixels. XOR with
/// a random word per dimension (a digital shift) makes of each a further one that keeps the net
/// property, so a pixel pays one XOR per coordinate for its own samples.
class ReplicateTables {
  public:
    static constexpr int kReplicates = 16;
    /// Of the pilot's net: one point in each of 32 x 32 cells.
    static constexpr int kCoarseGrid = 16, kGrid = 32;

    explicit ReplicateTables(int points);
    /// Points between two lengths in use are sorted so that consecutive rays are close together: in
    /// Morton order over the light, or by x for sampling along a list.
    const SobolPoint* overLight(int r) const { return overLight_[r].data(); }
    const SobolPoint* alongList(int r) const { return alongList_[r].data(); }
    /// The net's first 16 x 16 points, one in each of 16 x 16 cells, in Morton order.
    const SobolPoint* coarsePilot() const { return pilot_.data(); }
    /// The other three in one of these cells.
    const SobolPoint* finePilot(int x, int y) const {
        return pilot_.data() + kCoarseGrid * kCoarseGrid + 3 * (y * kCoarseGrid + x);
    }
    int size() const { return static_cast<int>(overLight_[0].size()); }

    /// Lengths in use: 2^k and 3 * 2^(k-1).
    static int roundUp(double n);
    static int roundDown(double n);

  private:
    std::array<std::vector<SobolPoint>, kReplicates> overLight_, alongList_;
    std::vector<SobolPoint> pilot_;
};

}  // namespace penumbra
