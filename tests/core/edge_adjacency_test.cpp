#include "core/scene/edge_adjacency.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "tests/support/procedural.hpp"

namespace penumbra {
namespace {

using namespace test;

bool silhouetteFrom(const OutlineEdge& edge, const glm::dvec3& point) {
    int side[2];
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec4 plane(edge.planes[i]);
        const bool facing = glm::dot(glm::dvec3(plane), point) > plane.w;
        side[i] = facing == edge.forward[i] ? 1 : -1;
    }
    return side[0] == side[1];
}

std::size_t silhouettes(const Geometry& geometry, const glm::dvec3& point, bool weld = true) {
    std::size_t count = 0;
    for (const OutlineEdge& edge : EdgeAdjacency(geometry, weld).outlineEdges(geometry))
        count += silhouetteFrom(edge, point);
    return count;
}

Shape cube() {
    Shape shape;
    shape.box({0, 0, 0}, {1, 1, 1});
    return shape;
}

TEST(EdgeAdjacency, CubeIsClosed) {
    const auto geometry = cube().geometry();
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.defects(), MeshDefects{});
    EXPECT_EQ(adjacency.defects().text(), "");
    EXPECT_EQ(adjacency.edgeCount(), 18u) << "12 and a diagonal in each side";
    EXPECT_EQ(adjacency.outlineEdges(*geometry).size(), 12u) << "diagonals are flat";
    EXPECT_EQ(adjacency.pieceCount(), 1u);
    for (const EdgeAdjacency::Face& face : adjacency.faces()) EXPECT_TRUE(face.solid);
}

TEST(EdgeAdjacency, SolidsAreTurnedOutward) {
    Shape inside;  // clockwise seen from outside
    inside.box({1, 0, 0}, {0, 1, 1});
    const auto geometry = inside.geometry();
    const EdgeAdjacency adjacency(*geometry);
    double volume = 0.0;
    for (const EdgeAdjacency::Face& face : adjacency.faces()) {
        ASSERT_TRUE(face.solid);
        const auto at = [&](std::size_t k) {
            return glm::dvec3(geometry->positions[face.vertices[k]]);
        };
        volume += glm::dot(at(0), glm::cross(at(1), at(2))) / 6.0;
    }
    EXPECT_NEAR(volume, 1.0, 1e-12);  // corners are exact
    for (const OutlineEdge& edge : adjacency.outlineEdges(*geometry)) {
        const glm::dvec3 corner = glm::sign(glm::dvec3(edge.a) - 0.5);
        // A cube's corner is cut by as many diagonals as may be: its normal is the cube's diagonal.
        EXPECT_NEAR(glm::dot(glm::dvec3(edge.stretchA), corner), std::sqrt(3.0), 1e-6);
    }
}

TEST(EdgeAdjacency, FacesAreTurnedAsTheirNeighbours) {
    const auto geometry = cube().geometry();
    const EdgeAdjacency outward(*geometry);
    for (unsigned flipped = 1; flipped < 4096; flipped += 97) {
        Geometry mixed = *geometry;
        for (std::size_t face = 0; face < 12; ++face)
            if (flipped >> face & 1u)
                std::swap(mixed.indices[3 * face], mixed.indices[3 * face + 1]);
        const EdgeAdjacency adjacency(mixed);
        double volume = 0.0;
        for (const EdgeAdjacency::Face& face : adjacency.faces()) {
            EXPECT_TRUE(face.closed) << flipped;
            const auto at = [&](std::size_t k) {
                return glm::dvec3(mixed.positions[face.vertices[k]]);
            };
            volume += glm::dot(at(0), glm::cross(at(1), at(2))) / 6.0;
        }
        EXPECT_NEAR(volume, 1.0, 1e-12) << "corners are exact";
        EXPECT_EQ(adjacency.outlineEdges(mixed).size(), outward.outlineEdges(*geometry).size());
    }
}

TEST(EdgeAdjacency, OneSidedSurfacesStayAsTheyAre) {
    // A band of an odd number of half turns.
    constexpr int kParts = 12;
    const auto rim = [](int i, double side) {
        const double turn = 2.0 * std::numbers::pi * i / kParts, half = 0.5 * turn;
        const double r = 2.0 + 0.5 * side * std::cos(half);
        return glm::dvec3(r * std::cos(turn), r * std::sin(turn), 0.5 * side * std::sin(half));
    };
    Shape band;
    for (int i = 0; i < kParts; ++i) {
        const bool last = i + 1 == kParts;  // meets the first upside down
        band.quad(rim(i, -1), rim(i, 1), rim(last ? 0 : i + 1, last ? -1 : 1),
                  rim(last ? 0 : i + 1, last ? 1 : -1));
    }
    const auto geometry = band.geometry();
    const EdgeAdjacency adjacency(*geometry);
    ASSERT_EQ(adjacency.faces().size(), 2u * kParts);
    EXPECT_EQ(adjacency.defects().openEdges, 2u * kParts);
    for (const EdgeAdjacency::Face& face : adjacency.faces()) {
        EXPECT_FALSE(face.solid);
        const std::array<std::uint32_t, 3> v = face.vertices;
        bool asItWas = false;
        for (std::size_t i = 0; i < geometry->indices.size(); i += 3)
            for (std::size_t k = 0; k < 3; ++k) {
                bool same = true;
                for (std::size_t c = 0; c < 3; ++c)
                    same = same && geometry->positions[v[c]] ==
                                       geometry->positions[geometry->indices[i + (c + k) % 3]];
                asItWas = asItWas || same;
            }
        EXPECT_TRUE(asItWas);
    }
}

TEST(EdgeAdjacency, SilhouettesOfACubeAreClosedLoops) {
    const auto geometry = cube().geometry();
    EXPECT_EQ(silhouettes(*geometry, {0.5, 0.5, 3.0}), 4u) << "one side seen";
    EXPECT_EQ(silhouettes(*geometry, {3.0, 0.5, 3.0}), 6u) << "two sides seen";
    EXPECT_EQ(silhouettes(*geometry, {3.0, 4.0, 3.0}), 6u) << "three sides seen";
}

TEST(EdgeAdjacency, EdgeOnFacesAreOnOneSideForAllTheirEdges) {
    // In the plane of one side, of two, of three (a corner's): the loop stays closed, each vertex
    // on it twice.
    const auto geometry = cube().geometry();
    const EdgeAdjacency adjacency(*geometry);
    for (const glm::dvec3 point : {glm::dvec3(1.0, 0.5, 3.0), glm::dvec3(1.0, 1.0, 3.0),
                                   glm::dvec3(1.0, 0.0, 3.0), glm::dvec3(0.0, 1.0, 5.0)}) {
        std::vector<glm::vec3> ends;
        for (const OutlineEdge& edge : adjacency.outlineEdges(*geometry))
            if (silhouetteFrom(edge, point)) {
                ends.push_back(edge.a);
                ends.push_back(edge.b);
            }
        EXPECT_GE(ends.size(), 8u);
        for (const glm::vec3& end : ends) EXPECT_EQ(std::ranges::count(ends, end), 2);
    }
}

TEST(EdgeAdjacency, UnweldedCubeFallsApart) {
    const auto geometry = cube().geometry();  // a vertex for each corner of each triangle
    const EdgeAdjacency adjacency(*geometry, false);
    EXPECT_EQ(adjacency.defects().openEdges, 36u);
    EXPECT_EQ(adjacency.pieceCount(), 12u);
    EXPECT_EQ(silhouettes(*geometry, {0.5, 0.5, 3.0}, false), 36u);
}

TEST(EdgeAdjacency, WallBetweenTwoBoxesIsDropped) {
    Shape shape = cube();
    shape.box({1, 0, 0}, {2, 1, 1});
    const auto geometry = shape.geometry();
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.faces().size(), 20u);
    MeshDefects expected;
    expected.backToBack = 4;
    EXPECT_EQ(adjacency.defects(), expected);
    EXPECT_EQ(adjacency.defects().text(), "4 back-to-back triangles dropped");
    EXPECT_EQ(silhouettes(*geometry, {1.0, 0.5, 3.0}), 6u) << "both boxes' long sides in two";
}

TEST(EdgeAdjacency, FacesThatAreThereTwiceStayOnce) {
    Shape whole = cube();
    whole.box({0, 0, 0}, {1, 1, 1});
    Shape side = cube();  // the roof alone, as Shape::box cuts it
    side.quad({0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1});
    for (const auto& [shape, dropped] : {std::pair(whole, 12u), std::pair(side, 2u)}) {
        const auto geometry = shape.geometry();
        const EdgeAdjacency adjacency(*geometry);
        MeshDefects expected;
        expected.backToBack = dropped;
        EXPECT_EQ(adjacency.defects(), expected);
        EXPECT_EQ(adjacency.faces().size(), 12u);
        EXPECT_TRUE(adjacency.faces()[0].closed);
    }
}

TEST(EdgeAdjacency, TwoSidedSheetKeepsOneSide) {
    Shape shape;
    shape.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    shape.quad({0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0});
    const auto geometry = shape.geometry();
    const EdgeAdjacency adjacency(*geometry);
    // The second side is cut along the same diagonal.
    ASSERT_EQ(adjacency.faces().size(), 2u);
    EXPECT_EQ(adjacency.defects().backToBack, 2u);
    EXPECT_EQ(adjacency.defects().openEdges, 4u);
    EXPECT_FALSE(adjacency.faces()[0].solid);
    for (const OutlineEdge& edge : adjacency.outlineEdges(*geometry)) {
        EXPECT_EQ(edge.stretchA.z, 0.0f) << "in the sheet's plane";
        EXPECT_GT(glm::dot(glm::dvec3(edge.stretchA), glm::dvec3(edge.a) - glm::dvec3(0.5, 0.5, 0)),
                  0.5)
            << "away from it";
        EXPECT_TRUE(silhouetteFrom(edge, {0.5, 0.5, 2.0}));
        EXPECT_TRUE(silhouetteFrom(edge, {0.5, 0.5, -2.0}));
    }
}

TEST(EdgeAdjacency, TJunctionsAreSplit) {
    // One quad beside two: the long side holds a vertex of the short ones.
    Shape shape;
    shape.quad({0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0});
    shape.quad({1, 0, 0}, {2, 0, 1}, {2, 0.7, 1}, {1, 0.7, 0});
    shape.quad({1, 0.7, 0}, {2, 0.7, 1}, {2, 2, 1}, {1, 2, 0});
    const auto geometry = shape.geometry();
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.defects().tJunctions, 1u);
    EXPECT_EQ(adjacency.defects().openEdges, 7u) << "the rim alone";
    EXPECT_EQ(adjacency.defects().text(), "7 open edges, 1 T-junctions split");
    // From above the fold, both wings lie to its sides: no silhouette but the rim.
    EXPECT_EQ(silhouettes(*geometry, {1.0, 1.0, 9.0}), 7u);
    // From far to the right and low, the fold's wings lie on one side of it: two pieces more.
    EXPECT_EQ(silhouettes(*geometry, {9.0, 1.0, 0.5}), 9u);
}

TEST(EdgeAdjacency, LongEdgesOverManyVerticesAreSplitInOrder) {
    constexpr int kPieces = 37;
    Shape shape;
    shape.quad({0, -1, 0}, {1, -1, 0}, {1, 0, 0}, {0, 0, 0});
    for (int i = 0; i < kPieces; ++i)
        shape.quad({i / double(kPieces), 0, 0}, {(i + 1) / double(kPieces), 0, 0},
                   {(i + 1) / double(kPieces), 1, 1}, {i / double(kPieces), 1, 1});
    const auto geometry = shape.geometry();
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.defects().tJunctions, kPieces - 1u);
    EXPECT_EQ(adjacency.defects().openEdges, kPieces + 5u);
}

TEST(EdgeAdjacency, FansOfThreeFacesAreSilhouettesWhereAllLieOnOneSide) {
    Shape shape;  // three wings on the z axis, at 0, 60 and 100 degrees
    for (const double degrees : {0.0, 60.0, 100.0}) {
        const double a = glm::radians(degrees);
        const glm::dvec3 out(std::cos(a), std::sin(a), 0.0);
        shape.quad({0, 0, 0}, out, out + glm::dvec3(0, 0, 1), {0, 0, 1});
    }
    const auto geometry = shape.geometry();
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.defects().nonManifoldEdges, 1u);
    const auto onAxis = [&](double degrees) {
        const double a = glm::radians(degrees);
        std::size_t count = 0;
        for (const OutlineEdge& edge : adjacency.outlineEdges(*geometry))
            if (edge.a.x == 0.0f && edge.b.x == 0.0f && edge.a.y == 0.0f && edge.b.y == 0.0f)
                count += silhouetteFrom(edge, {5 * std::cos(a), 5 * std::sin(a), 0.5});
        return count;
    };
    // A line through the axis misses the wings' 100 degrees on one side: from 100 to 180 degrees
    // and the opposite.
    for (const double degrees : {101.0, 140.0, 179.0, 281.0, 320.0, 359.0})
        EXPECT_EQ(onAxis(degrees), 1u) << degrees;
    for (const double degrees : {1.0, 30.0, 61.0, 99.0, 181.0, 230.0, 279.0})
        EXPECT_EQ(onAxis(degrees), 0u) << degrees;
}

TEST(EdgeAdjacency, FansAllAroundAreNeverSilhouettes) {
    Shape shape;
    for (const double degrees : {0.0, 120.0, 240.0}) {
        const double a = glm::radians(degrees);
        const glm::dvec3 out(std::cos(a), std::sin(a), 0.0);
        shape.quad({0, 0, 0}, out, out + glm::dvec3(0, 0, 1), {0, 0, 1});
    }
    const auto geometry = shape.geometry();
    EXPECT_EQ(EdgeAdjacency(*geometry).outlineEdges(*geometry).size(), 9u) << "three of each wing";
}

TEST(EdgeAdjacency, HollowEdgesOfSolidsAreLeftOutAndPartThem) {
    Shape shape;  // two boxes that share one side of the lower: an L
    shape.box({0, 0, 0}, {1, 1, 1});
    shape.box({1, 0, 0}, {2, 1, 1});
    shape.box({0, 0, 1}, {1, 1, 2});
    const auto geometry = shape.geometry();
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.defects().backToBack, 8u);
    std::size_t inside = 0;
    for (const OutlineEdge& edge : adjacency.outlineEdges(*geometry))
        inside += edge.a.x == 1.0f && edge.b.x == 1.0f && edge.a.z == 1.0f && edge.b.z == 1.0f;
    EXPECT_EQ(inside, 0u);
}

TEST(EdgeAdjacency, BodiesWithHolesAreSolidAndLeavesAreNot) {
    const auto tower = [](double height) {  // a unit square's walls and roof, open below
        Shape shape;
        shape.quad({0, 0, height}, {1, 0, height}, {1, 1, height}, {0, 1, height});
        const glm::dvec3 corner[5] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
        for (int i = 0; i < 4; ++i)
            shape.quad(corner[i], corner[i + 1], corner[i + 1] + glm::dvec3(0, 0, height),
                       corner[i] + glm::dvec3(0, 0, height));
        return shape.geometry();
    };
    // The hole of area 1 over 1 + 4 height of faces: a ninth, and a half.
    const auto high = tower(2.0), low = tower(0.25);
    const EdgeAdjacency solid(*high), sheet(*low);
    EXPECT_TRUE(solid.faces()[0].solid);
    EXPECT_FALSE(solid.faces()[0].closed);
    EXPECT_EQ(solid.defects().openEdges, 4u);
    EXPECT_FALSE(sheet.faces()[0].solid);
}

TEST(EdgeAdjacency, DegenerateTrianglesAreDropped) {
    Shape shape = cube();
    shape.quad({3, 0, 0}, {3, 0, 0}, {4, 0, 0}, {4, 1, 0});
    const auto geometry = shape.geometry();
    EXPECT_EQ(EdgeAdjacency(*geometry).defects().degenerate, 1u);
}

TEST(EdgeAdjacency, VerticesThatAreNowhereAreRefused) {
    auto geometry = std::make_shared<Geometry>(*cube().geometry());
    geometry->positions[3].y = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(EdgeAdjacency{*geometry}, Unsupported);
}

TEST(EdgeAdjacency, MovingPartsAreFollowedAndWeldedToThemselvesOnly) {
    Shape shape = cube();
    auto geometry = std::make_shared<Geometry>(*shape.geometry());
    Geometry other = *geometry;
    for (glm::vec3& p : other.positions) p.x += 1.0f;  // touches the first
    Part part = geometry->parts[0];
    part.moves = true;
    part.firstVertex = part.vertexCount;
    part.firstIndex = part.indexCount;
    geometry->parts.push_back(part);
    for (const std::uint32_t i : other.indices) geometry->indices.push_back(part.firstVertex + i);
    geometry->positions.insert(geometry->positions.end(), other.positions.begin(),
                               other.positions.end());
    const EdgeAdjacency adjacency(*geometry);
    EXPECT_EQ(adjacency.defects(), MeshDefects{}) << "the wall between them may open";
    EXPECT_EQ(adjacency.pieceCount(), 2u);

    Geometry later = *geometry;
    for (std::size_t i = part.firstVertex; i < later.positions.size(); ++i)
        later.positions[i] += glm::vec3(0.0f, 0.0f, 5.0f);
    ASSERT_TRUE(adjacency.describes(later));
    float most = 0.0f;
    for (const OutlineEdge& edge : adjacency.outlineEdges(later)) {
        most = std::max(most, edge.a.z);
        for (const glm::vec4& plane : edge.planes)
            EXPECT_NEAR(glm::dot(glm::vec3(plane), edge.a), plane.w, 1e-5);  // float at 6 metres
    }
    EXPECT_EQ(most, 6.0f);
    later.positions[0].x += 1.0f;
    EXPECT_FALSE(adjacency.describes(later)) << "that part does not move";
}

}  // namespace
}  // namespace penumbra
