#pragma once

#include "core/image/image.hpp"
#include "core/sampling/light_tree.hpp"

namespace penumbra {

/// The light as a tree has cut it, for people to look at: one channel "depth" of `size` x `size`
/// pixels over the light, v upwards. A leaf's pixels hold its depth + 1, those on its border and
/// beyond the outermost samples 0.
Image leafDepths(const LightTree& tree, int size);

}  // namespace penumbra
