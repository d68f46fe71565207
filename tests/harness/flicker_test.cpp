#include "harness/metrics/flicker.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>

#include "harness/run/files.hpp"
#include "harness/run/fill_flicker.hpp"
#include "harness/run/row.hpp"

namespace penumbra {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// One row of scored pixels a metre apart, so that the tolerance for four is 1.5e-5 m.
struct Shot {
    GBuffer gbuffer;
    Reference reference;
    std::vector<float> visibility;

    Shot(std::vector<float> truth, std::vector<float> drawn) : visibility(std::move(drawn)) {
        const std::size_t size = truth.size();
        gbuffer.width = reference.width = static_cast<int>(size);
        gbuffer.height = reference.height = 1;
        for (std::size_t i = 0; i < size; ++i) gbuffer.position.emplace_back(float(i), 0, 0);
        gbuffer.geometricNormal.assign(size, {0, 1, 0});
        gbuffer.shadingNormal = gbuffer.geometricNormal;
        gbuffer.albedo.assign(size, glm::vec3(0.5F));
        gbuffer.mask.assign(size, PixelClass::scored);
        gbuffer.irradianceUnshadowed.assign(size, 1.0F);
        reference.standardError.assign(size, 0.0F);
        reference.rays.assign(size, 1.0F);
        reference.irradiance = reference.irradianceUnshadowed = gbuffer.irradianceUnshadowed;
        reference.visibility = std::move(truth);
    }
    operator FlickerFrame() const { return {gbuffer, reference, visibility}; }
};

TEST(Flicker, ByHand) {
    const Shot before({0, 0.5F, 1, 1}, {0, 0.5F, 1, 0.5F});
    const Shot now({0.5F, 0.5F, 1, 0.5F}, {0.25F, 0.75F, 1, 0});
    // Changes of V: 1/4, 1/4, 0, -1/2; of the reference: 1/2, 0, 0, -1/2; apart by 1/4, 1/4, 0, 0.
    EXPECT_EQ(flicker(before, now), 0.125);
    EXPECT_EQ(flicker(now, before), 0.125);
}

TEST(Flicker, ErrorThatStandsStillIsNone) {
    const Shot before({0, 0.5F, 1, 1}, {0.25F, 0.75F, 0.5F, 1});
    const Shot now({0.5F, 0, 1, 0.5F}, {0.75F, 0.25F, 0.5F, 0.5F});
    EXPECT_EQ(flicker(before, now), 0.0);
}

TEST(Flicker, OnlyPixelsScoredAndFiniteInBothFramesCount) {
    Shot before({0, 0, 0, 0}, {0, 0, 0, kNan});
    Shot now({0, 0, 0, 0}, {0.5F, 1, 1, 1});
    before.gbuffer.mask[1] = PixelClass::horizon;
    now.gbuffer.mask[2] = PixelClass::facingAway;
    EXPECT_EQ(flicker(before, now), 0.5);
}

TEST(Flicker, PointsThatMovedAreLeftOut) {
    const Shot before({0, 0, 0, 0}, {0, 0, 0, 0});
    Shot now({0, 0, 0, 0}, {0.25F, 1, 0, 0});
    now.gbuffer.position[1].y = 1e-4F;  // over the tolerance
    now.gbuffer.position[2].y = 1e-6F;  // rounding
    EXPECT_DOUBLE_EQ(flicker(before, now).value(), 0.25 / 3);
}

TEST(Flicker, FramesOfAMovedCameraDoNotCorrespond) {
    const Shot before({0, 0, 0, 0, 0}, {0, 0, 0, 0, 0});
    Shot now = before;
    for (std::size_t i : {0U, 1U, 3U}) now.gbuffer.position[i].z += 0.5F;
    EXPECT_TRUE(flicker(before, now)) << "two of five points are still there";
    now.gbuffer.position[4].z += 0.5F;
    EXPECT_FALSE(flicker(before, now)) << "a fifth of the points says nothing";
}

TEST(Flicker, WithoutCommonPixelsThereIsNoNumber) {
    const Shot blind({0, 0}, {kNan, kNan}), seen({0, 0}, {0, 0});
    EXPECT_FALSE(flicker(blind, seen));
    EXPECT_FALSE(flicker(seen, Shot({0, 0, 0}, {0, 0, 0})));
}

/// A run folder with three frames of one scene and two settings.
class FillFlicker : public testing::Test {
  protected:
    FillFlicker()
        : root_(std::filesystem::temp_directory_path() /
                ("penumbra_flicker_" + std::to_string(getpid()) +
                 testing::UnitTest::GetInstance()->current_test_info()->name())),
          folder(root_) {
        folder.create();
    }
    ~FillFlicker() override { std::filesystem::remove_all(root_); }

    void add(int frame, const std::string& setting, const Shot& shot) {
        folder.writeTruth("scene", frame, shot.gbuffer, shot.reference, {10, 0, 0});
        folder.writeVisibility("scene", frame, setting, shot.visibility, shot.reference);
        Row row;
        row.scene = "scene";
        row.frame = frame;
        row.method = row.setting = setting;
        rows.push_back(row);
    }
    std::vector<Row> filled() {
        std::string text = csvHeader() + "\n";
        for (const Row& row : rows) text += toCsv(row) + "\n";
        writeFileAtomically(folder.results(), text);
        fillFlicker(folder);
        return readCsv(folder.results());
    }

  private:
    std::filesystem::path root_;

  protected:
    RunFolder folder;
    std::vector<Row> rows;
};

TEST_F(FillFlicker, FromTheFrameBeforeOfTheSameSetting) {
    add(0, "a", Shot({0, 0}, {0, 0}));
    add(0, "b", Shot({0, 0}, {0, 0}));
    add(1, "a", Shot({0, 0}, {0.5F, 0}));
    add(1, "b", Shot({0, 0}, {0.5F, 0.5F}));
    add(2, "a", Shot({0, 0}, {0.5F, 0}));
    const std::vector<Row> out = filled();
    EXPECT_FALSE(out[0].metrics.flicker);
    EXPECT_FALSE(out[1].metrics.flicker);
    EXPECT_EQ(out[2].metrics.flicker, 0.25);
    EXPECT_EQ(out[3].metrics.flicker, 0.5);
    EXPECT_EQ(out[4].metrics.flicker, 0.0);
}

TEST_F(FillFlicker, WhatIsMissingStaysEmptyAndWhatIsThereStays) {
    add(0, "a", Shot({0, 0}, {0, 0}));
    add(1, "a", Shot({0, 0}, {1, 1}));
    rows.back().metrics.flicker = 0.125;
    add(2, "b", Shot({0, 0}, {1, 1}));
    add(1, "c", Shot({0, 0}, {1, 1}));
    add(2, "c", Shot({0, 0}, {1, 1}));
    rows.back().status = "failed";
    const std::vector<Row> out = filled();
    EXPECT_EQ(out, rows);
}

}  // namespace
}  // namespace penumbra
