// Cached references that were cut, altered, left half-written or written by several at once.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "harness/reference/reference.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

const std::string kKey = "0123456789abcdef0123456789abcdef";

/// Noise, which no compression makes smaller: such blocks are stored as they are, and nothing in an
/// EXR would notice another bit in them.
Reference noise(int side, std::uint32_t seed) {
    Reference r;
    r.width = r.height = side;
    std::mt19937 random(seed);
    for (std::vector<float>* channel :
         {&r.visibility, &r.standardError, &r.rays, &r.irradiance, &r.irradianceUnshadowed})
        for (int i = 0; i < side * side; ++i)
            channel->push_back(static_cast<float>(random()) * 0x1p-32f);
    return r;
}

class CacheDamage : public ::testing::Test {
  protected:
    void write(const std::string& bytes) const { std::ofstream(file, std::ios::binary) << bytes; }
    /// What load says is wrong; empty if it loads.
    std::string damage() const {
        std::string said;
        const bool loaded = cache.load(kKey, 8, 8, &said).has_value();
        EXPECT_EQ(loaded, said.empty()) << said;
        return said;
    }

    testing::TempFolder folder;
    ReferenceCache cache{folder.path()};
    std::filesystem::path file = folder.path() / (kKey + ".exr");
};

TEST_F(CacheDamage, AnyBitAndAnyLengthIsNoticed) {
    cache.store(kKey, noise(8, 1));
    const std::string whole = test::readText(file);
    ASSERT_EQ(damage(), "");
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string flipped = whole;
        flipped[i] = static_cast<char>(flipped[i] ^ 1 << i % 8);
        write(flipped);
        ASSERT_TRUE(damage().starts_with(file.string() + ": ")) << "bit " << i % 8 << " of " << i;
        write(whole.substr(0, i));
        ASSERT_NE(damage(), "") << "cut to " << i;
    }
    write(whole + "x");
    EXPECT_NE(damage(), "");
    write(whole);
    EXPECT_EQ(damage(), "");
    std::filesystem::remove(file);
    std::string said;
    EXPECT_FALSE(cache.load(kKey, 8, 8, &said));
    EXPECT_EQ(said, "") << "an entry that is not there is not damaged";
}

TEST_F(CacheDamage, ADamagedEntryIsReplaced) {
    write("not an image at all");
    ASSERT_NE(damage(), "");
    cache.store(kKey, noise(8, 2));
    EXPECT_EQ(cache.load(kKey, 8, 8)->visibility, noise(8, 2).visibility);
}

TEST_F(CacheDamage, WhatAKillLeftGoesAndNothingElse) {
    const auto aged = [&](const std::string& name, std::chrono::minutes age) {
        std::filesystem::last_write_time(folder.write(name, "half"),
                                         std::filesystem::file_time_type::clock::now() - age);
    };
    const std::string temporary = kKey + ".exr.0011223344556677.tmp";
    const std::string younger = kKey + ".exr.8899aabbccddeeff.tmp";
    aged(temporary, std::chrono::minutes(61));
    aged(younger, std::chrono::minutes(50));  // 10 minutes for a slow machine
    aged("notes.0011223344556677.tmp", std::chrono::minutes(1000));
    aged("notes.tmp", std::chrono::minutes(1000));
    cache.store(kKey, noise(8, 3));
    std::vector<std::string> left;
    for (const auto& [name, bytes] : test::filesBelow(folder.path())) left.push_back(name);
    EXPECT_EQ(left, (std::vector<std::string>{kKey + ".exr", younger, "notes.0011223344556677.tmp",
                                              "notes.tmp"}));
}

TEST_F(CacheDamage, ReadersAndWritersAtOnceSeeWholeEntries) {
    cache.store(kKey, noise(8, 0));
    std::vector<std::thread> threads;
    for (std::uint32_t writer = 0; writer < 2; ++writer)
        threads.emplace_back([&, writer] {
            for (int i = 0; i < 100; ++i) cache.store(kKey, noise(8, writer));
        });
    for (int i = 0; i < 200; ++i) {
        std::string said;
        const auto loaded = cache.load(kKey, 8, 8, &said);
        EXPECT_TRUE(loaded) << said;
        if (!loaded) break;
        const bool first = loaded->rays == noise(8, 0).rays;
        EXPECT_TRUE(first || loaded->rays == noise(8, 1).rays);
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(test::filesBelow(folder.path()).size(), 1u);
}

}  // namespace
}  // namespace penumbra
