#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/trace/shaft.hpp"

namespace penumbra {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

class Numbers {
  public:
    explicit Numbers(unsigned seed) : engine_(seed) {}
    double operator()(double lo, double hi) {
        return std::uniform_real_distribution<double>(lo, hi)(engine_);
    }

  private:
    std::mt19937 engine_;
};

/// Whether the segment from `a` to `b` meets the triangle.
bool meets(const glm::dvec3& a, const glm::dvec3& b, const std::array<glm::dvec3, 3>& t) {
    const auto volume = [](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r,
                           const glm::dvec3& s) {
        return glm::dot(glm::cross(q - p, r - p), s - p);
    };
    if (volume(t[0], t[1], t[2], a) * volume(t[0], t[1], t[2], b) > 0.0) return false;
    const double u = volume(a, b, t[0], t[1]), v = volume(a, b, t[1], t[2]),
                 w = volume(a, b, t[2], t[0]);
    return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

TEST(Shaft, FindsEveryTriangleOnAWayToTheLightAndNotMany) {
    Numbers number(7);
    std::size_t found = 0, all = 0, met = 0;
    for (int round = 0; round < 40; ++round) {
        const glm::dvec2 half(number(0.0, 1.0), number(0.0, 1.0));
        Bounds points;  // before the light, beside it, small or larger than it
        const glm::dvec3 centre(number(-4, 4), number(-4, 4), number(2, 6));
        const double size = number(0.0, 1.5);
        points.add(centre - size);
        points.add(centre + size);
        std::vector<glm::dvec3> vertices;
        std::vector<Triangle> triangles;
        for (std::uint32_t i = 0; i < 600; ++i) {
            const glm::dvec3 at(number(-5, 5), number(-5, 5), number(-1, 8));
            for (int k = 0; k < 3; ++k)
                vertices.push_back(at +
                                   glm::dvec3(number(-.5, .5), number(-.5, .5), number(-.5, .5)));
            triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
        const ShaftTree tree(vertices, triangles);
        std::vector<std::uint32_t> candidates;
        tree.query(Shaft(points, half), candidates);
        std::sort(candidates.begin(), candidates.end());
        EXPECT_EQ(std::adjacent_find(candidates.begin(), candidates.end()), candidates.end());
        found += candidates.size();
        all += triangles.size();
        for (int ray = 0; ray < 200; ++ray) {
            const glm::dvec3 from(number(points.lo.x, points.hi.x),
                                  number(points.lo.y, points.hi.y),
                                  number(points.lo.z, points.hi.z));
            const glm::dvec3 to(number(-half.x, half.x), number(-half.y, half.y), 0.0);
            for (std::uint32_t i = 0; i < triangles.size(); ++i) {
                if (!meets(from, to, {vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]}))
                    continue;
                ++met;
                EXPECT_TRUE(std::binary_search(candidates.begin(), candidates.end(), i));
            }
        }
    }
    EXPECT_GT(met, 1000u);
    EXPECT_LT(found, all / 4) << "the shafts fill far less than a quarter of the volume";
}

TEST(Shaft, NoTriangles) {
    const std::vector<glm::dvec3> vertices;
    const std::vector<Triangle> triangles;
    std::vector<std::uint32_t> found = {3};
    Bounds point;
    point.add({0, 0, 1});
    ShaftTree(vertices, triangles).query(Shaft(point, {1, 1}), found);
    EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace penumbra
