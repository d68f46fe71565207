// Which parts of the light are split: comparisons, criteria and views.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "harness/reference/exact.hpp"
#include "tests/methods/adaptive_light_sampled_support.hpp"

namespace penumbra {
namespace {

using namespace test;
using namespace test::adaptive;

/// A band in z = 1 that hides from the floor's points near the origin the light's corners TR and BL
/// alike, and what lies between them, but not TL and BR.
Room xorStrip() {
    Room room;
    // The diagonal of the light towards +u -v (axisV is -y): along x = y.
    const glm::dvec3 along(0.3, 0.3, 1.0), across(0.08, -0.08, 0.0);
    room.shape.quad(-along + glm::dvec3(0, 0, 2) - across, along - across, along + across,
                    -along + glm::dvec3(0, 0, 2) + across);
    return room;
}

TEST_F(AdaptiveLightSampled, XorStripIsMissedByOppositeCornersOnly) {
    // METHODS.md hard case 33: at a point under the band's middle the maps of both diagonals agree,
    // so the paper's test stops at four maps and says one half where the band hides a sixth or so.
    const Room room = xorStrip();
    const AreaLight& light = room.light;
    const World world{room.shape.geometry(), light};
    const TestFrame frame(
        world, planeGBuffer(16, 16, {-0.03, -0.03, 0}, {0.06, 0, 0}, {0, 0.06, 0}, light));
    const Assignments small = with(kThorough, {{"map_size", "512"}, {"epsilon", "0.005"}});
    const Outcome paper =
        outcome(frame, with(with(kPaper, small), {{"criterion", "compared_pixels"}}));
    EXPECT_EQ(paper.maps, 4);
    EXPECT_EQ(unequal(frame, paper.image, 0.5f), 0);
    EXPECT_EQ(mapsOf(frame, with(small, {{"pairs", "diagonals"}})), 4);

    const Outcome tight = outcome(frame, with(small, {{"max_depth", "4"}, {"max_maps", "256"}}));
    EXPECT_GT(tight.maps, 25);
    const Outcome centre = outcome(frame, with(small, {{"pairs", "diagonals"},
                                                       {"centre_test", "true"},
                                                       {"max_depth", "4"},
                                                       {"max_maps", "256"}}));
    EXPECT_GT(centre.maps, 25);
    const Reference exact = exactReference(frame->tracer, world.materials, frame->gbuffer, light);
    const auto rmse = [&](const Visibility& image) {
        double sum = 0.0;
        for (const std::size_t i : frame.asked())
            sum += std::pow(image[i] - exact.visibility[i], 2);
        return std::sqrt(sum / static_cast<double>(frame.asked().size()));
    };
    EXPECT_GT(rmse(paper.image), 0.1);
    EXPECT_LT(rmse(tight.image), 0.25 * rmse(paper.image));
    EXPECT_LT(rmse(centre.image), 0.25 * rmse(paper.image));
}

TEST_F(AdaptiveLightSampled, CastersBetweenTheCornersNeedTheCentreTest) {
    // METHODS.md hard case 34: a plate that hides the middle of the light from every point asked
    // and none of its corners. Without the centre the error is all that it hides.
    Room room;
    room.shape.rectangle({-0.1, -0.1}, {0.1, 0.1}, 1.0);
    const TestFrame frame(
        {room.shape.geometry(), room.light},
        planeGBuffer(16, 16, {-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, room.light));
    const Outcome corners = outcome(frame, kThorough);
    EXPECT_EQ(corners.maps, 4);
    EXPECT_EQ(unequal(frame, corners.image, 1.0f), 0);
    EXPECT_GT(mapsOf(frame, with(kThorough, {{"centre_test", "true"}, {"epsilon", "0.03"}})), 14);
}

TEST_F(AdaptiveLightSampled, ShadowsOfFewPixelsNeedTheWorstTile) {
    // METHODS.md hard case 35: a caster of six centimetres, some fifty pixels of penumbra among
    // 128 x 128: three thousandths of the image, a fifth of a tile.
    Room room;
    room.light = lightAbove(2.0, 0.4, 0.4);
    room.shape.rectangle({-0.03, -0.03}, {0.03, 0.03}, 0.2);
    const TestFrame frame = room.frame(128);
    const Assignments settings =
        with(kThorough, {{"tile", "16"}, {"epsilon", "0.02"}, {"map_size", "512"}});
    for (const char* whole : {"compared_pixels", "map_texels"})
        EXPECT_EQ(mapsOf(frame, with(settings, {{"criterion", whole}})), 4);
    for (const char* local : {"visibility", "worst_tile"})
        EXPECT_GT(mapsOf(frame, with(settings, {{"criterion", local}})), 4);
}

TEST_F(AdaptiveLightSampled, TheLiteralCriterionDependsOnTheMapsSize) {
    // Eq. 4 divides camera pixels by texels: 64 times the texels are a 64th of the quotient, though
    // the maps show the same. The normalised form stops within rounding of the same share.
    const TestFrame frame = box().frame();
    const auto at = [&](const char* criterion, const char* size) {
        return mapsOf(
            frame,
            with(kThorough, {{"criterion", criterion}, {"epsilon", "0.05"}, {"map_size", size}}));
    };
    EXPECT_GT(at("map_texels", "128"), 25);
    EXPECT_EQ(at("map_texels", "1024"), 4);
    EXPECT_GT(at("compared_pixels", "1024"), 25);
}

/// A floor that ends where the light's centre begins to be hidden: of the half plane's penumbra
/// only its inner part falls on it.
TestFrame innerPenumbra() {
    HalfPlane caster;
    const double casterEdgeM =
        caster.edgeM * (HalfPlane::kLightM - caster.heightM) / HalfPlane::kLightM;
    Shape shape;
    shape.rectangle({caster.edgeM + 0.005, -1.0}, {2.0, 1.0}, 0.0);
    shape.rectangle({casterEdgeM, -5.0}, {5.0, 5.0}, caster.heightM);
    const AreaLight light = lightAbove(HalfPlane::kLightM, 0.8, 0.0);
    return {{shape.geometry(), light},
            planeGBuffer(64, 64, {caster.edgeM + 0.01, -0.5, 0}, {0.5, 0, 0}, {0, 1, 0}, light)};
}

TEST_F(AdaptiveLightSampled, TheLightsCentreMissesInnerPenumbrae) {
    const TestFrame frame = innerPenumbra();
    for (const char* compare : {"tight", "relative"}) {
        const Assignments settings =
            with(kThorough,
                 {{"compare", compare}, {"criterion", "compared_pixels"}, {"epsilon", "0.02"}});
        EXPECT_EQ(mapsOf(frame, with(settings, {{"space", "light"}})), 2) << compare;
        EXPECT_GT(mapsOf(frame, settings), 4) << compare;
    }
}

TEST_F(AdaptiveLightSampled, TheLightsCentreDoesNotCareForTheCamera) {
    // The same receivers seen at half the resolution: as many maps.
    const Room room = box();
    const Assignments settings = with(kThorough, {{"space", "light"}, {"epsilon", "0.05"}});
    const int maps = mapsOf(room.frame(128), settings);
    EXPECT_GT(maps, 4);
    EXPECT_EQ(mapsOf(room.frame(64), settings), maps);
}

/// The same world with the light's axis u turned round: left is right.
TestFrame mirrored(const Room& room) {
    AreaLight light = room.light;
    light.axisU = -light.axisU;
    light.axisV = -light.axisV;
    return {{room.shape.geometry(), light},
            planeGBuffer(96, 96, {-0.8, -0.8, 0}, {1.6, 0, 0}, {0, 1.6, 0}, light)};
}

TEST_F(AdaptiveLightSampled, SymmetricFormDoesNotMindLeftAndRight) {
    // METHODS.md hard case 36. Turned by half a circle every diagonal swaps its ends. Depths of
    // floor and box differ by factors of 1 - 0.35 and 1 / 0.65 - 1, which gammas between separate.
    const Room room = box();
    const TestFrame one = room.frame(), other = mirrored(room);
    for (const char* gamma : {"0.001", "0.2", "0.3", "0.34", "0.4", "0.5"}) {
        const Assignments settings = with(
            kPaper, {{"compare", "symmetric"}, {"gamma", gamma}, {"criterion", "compared_pixels"}});
        EXPECT_EQ(mapsOf(one, settings), mapsOf(other, settings)) << gamma;
    }
}

TEST_F(AdaptiveLightSampled, EquationSevenMindsLeftAndRight) {
    // A floor seen from the linear light's left end, a caster at half its depth from the right one:
    // |1 - 2 / 1| is 1 and |1 - 1 / 2| a half.
    Room room;
    room.light = lightAbove(2.0, 0.8, 0.0);
    room.shape.rectangle({0.05, -3.0}, {5.0, 3.0}, 1.0);
    const GBuffer asked =
        planeGBuffer(32, 32, {-0.2, -0.3, 0}, {0.4, 0, 0}, {0, 0.6, 0}, room.light);
    AreaLight turned = room.light;
    turned.axisU = -turned.axisU;
    turned.axisV = -turned.axisV;
    const TestFrame one({room.shape.geometry(), room.light}, asked),
        other({room.shape.geometry(), turned}, asked);
    const auto maps = [](const TestFrame& frame, const char* compare, const char* gamma) {
        return mapsOf(frame, with(kPaper, {{"compare", compare},
                                           {"gamma", gamma},
                                           {"criterion", "compared_pixels"},
                                           {"max_depth", "1"}}));
    };
    EXPECT_NE(maps(one, "relative", "0.7"), maps(other, "relative", "0.7"));
    for (const char* gamma : {"0.4", "0.7"})
        EXPECT_EQ(maps(one, "symmetric", gamma), maps(other, "symmetric", gamma)) << gamma;
}

TEST_F(AdaptiveLightSampled, ClearedDepthsAreGuarded) {
    // Receivers without geometry: no map shows anything where they are, or in some of the maps the
    // caster only. All forms answer, and the empty floor alone is four maps.
    const AreaLight light = lightAbove(2.0, 0.8, 0.8);
    const GBuffer floor = planeGBuffer(64, 64, {-0.8, -0.8, 0}, {1.6, 0, 0}, {0, 1.6, 0}, light);
    Shape away, over;
    away.rectangle({5.0, 5.0}, {6.0, 6.0}, 0.5);
    over.rectangle({-0.2, -0.2}, {0.2, 0.2}, 0.5);
    const TestFrame nothing({away.geometry(), light}, floor), some({over.geometry(), light}, floor);
    for (const char* compare : {"absolute", "relative", "symmetric"}) {
        const Assignments settings = with(kPaper, {{"compare", compare}});
        // By itself the empty floor calls for no maps of an area light at all.
        const Outcome lit = outcome(nothing, settings, EffectChoice::parse("penumbra"));
        EXPECT_EQ(lit.maps, 4) << compare;
        EXPECT_EQ(unequal(nothing, lit.image, 1.0f), 0);
        const Outcome shadowed = outcome(some, settings);
        EXPECT_GT(shadowed.maps, 9) << compare;
        EXPECT_EQ(outOfRange(some, shadowed.image), 0);
    }
}

TEST_F(AdaptiveLightSampled, DepthsDifferInsideTheUmbra) {
    // METHODS.md 12: two maps that both hide a point behind a tilted caster show different depths
    // of it, which costs maps that change nothing; shadow tests agree.
    Room room;
    room.shape.quad({-3, -3, 0.3}, {3, -3, 1.2}, {3, 3, 1.2}, {-3, 3, 0.3});
    const TestFrame frame = room.frame();
    EXPECT_GT(mapsOf(frame, kPaper), 9);
    EXPECT_EQ(mapsOf(frame, kThorough), 4);
}

}  // namespace
}  // namespace penumbra
