#include "core/frame/caster_facts.hpp"

#include <gtest/gtest.h>

#include "tests/support/test_scene.hpp"

namespace penumbra {
namespace {

using test::joined;

Shape box() {
    Shape shape;
    shape.box({0, 0, 0}, {1, 2, 3});
    return shape;
}

Shape sheet() {
    Shape shape;
    shape.rectangle({4, 0}, {5, 1}, 0.1);
    return shape;
}

std::vector<bool> thinParts(const Geometry& geometry,
                            const std::vector<Material>& materials = test::kOpaque) {
    std::vector<bool> thin;
    for (const PartFacts& facts :
         CasterFacts::find(geometry, materials, Casters::find(geometry)).parts) {
        thin.push_back(facts.thin);
        EXPECT_TRUE(facts.casts);  // until something shows that it does not
    }
    return thin;
}

TEST(CasterFacts, OpenSurfacesAreThinAndClosedOnesAreNot) {
    EXPECT_EQ(thinParts(*joined({{box(), 0}, {sheet(), 0}})), (std::vector<bool>{false, true}));
}

TEST(CasterFacts, ASheetThatIsThereFromBothSidesIsThin) {
    Shape both = sheet();
    both.quad({4, 0, 0.1}, {4, 1, 0.1}, {5, 1, 0.1}, {5, 0, 0.1});
    EXPECT_EQ(thinParts(*joined({{both, 0}})), std::vector<bool>{true});
}

TEST(CasterFacts, ABodyMayBeMadeOfSeveralParts) {
    Shape lid, pot;
    const auto at = [](int x, int y, int z) { return glm::dvec3(x, y, z); };
    lid.quad(at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
    pot.quad(at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
    pot.quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    pot.quad(at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0));
    pot.quad(at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0));
    pot.quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
    EXPECT_EQ(thinParts(*joined({{pot, 0}})), std::vector<bool>{true});
    EXPECT_EQ(thinParts(*joined({{pot, 0}, {lid, 0}})), (std::vector<bool>{false, false}));
}

TEST(CasterFacts, WhatAlphaCutsOutIsThin) {
    std::vector<Material> materials(2);
    materials[1].masked = true;
    EXPECT_EQ(thinParts(*joined({{box(), 0}, {box(), 1}}), materials),
              (std::vector<bool>{false, true}));
}

}  // namespace
}  // namespace penumbra
