#include "core/sampling/light_tree_picture.hpp"

#include <algorithm>

namespace penumbra {

Image leafDepths(const LightTree& tree, int size) {
    Image image = Image::withChannels(size, size, {"depth"});
    const auto pixelOf = [&](double place) {
        return std::clamp(static_cast<int>(0.5 * (place + 1.0) * size), 0, size);
    };
    for (const LightTree::Leaf& leaf : tree.leaves()) {
        glm::dvec2 lo = tree.position(static_cast<std::size_t>(leaf.corners[0]));
        glm::dvec2 hi = tree.position(static_cast<std::size_t>(leaf.corners[3]));
        for (int axis = 0; axis < 2; ++axis)
            if (!tree.extent()[axis]) lo[axis] = -1.0, hi[axis] = 1.0;
        for (int y = pixelOf(lo.y) + 1; y < pixelOf(hi.y); ++y)
            for (int x = pixelOf(lo.x) + 1; x < pixelOf(hi.x); ++x)
                image.at(x, size - 1 - y, 0) = static_cast<float>(leaf.depth + 1);
    }
    return image;
}

}  // namespace penumbra
