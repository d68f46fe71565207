#include "core/image/image.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "core/error.hpp"
#include "core/image/image_channels.hpp"
#include "core/image/srgb.hpp"
#include "core/image/zipped_exr.hpp"

namespace penumbra {
namespace {

class ImageTest : public ::testing::Test {
  protected:
    void SetUp() override { std::filesystem::create_directories(folder_); }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path path(const std::string& name) const { return folder_ / name; }
    std::vector<std::string> names() const {
        std::vector<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(folder_))
            found.push_back(entry.path().filename());
        return found;
    }
    std::string bytes(const std::string& name) const {
        std::ifstream stream(path(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

  private:
    std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                    ("penumbra_image_test_" + std::to_string(getpid()));
};

/// Every channel a run folder holds, and values that a careless path would change.
Image awkwardImage() {
    Image image = Image::withChannels(
        5, 3,
        {"P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "mask", "visibility", "standard_error", "rays",
         "irradiance", "irradiance_unshadowed", "error"});
    const float awkward[] = {0.0f,
                             -0.0f,
                             1.0f / 3.0f,
                             -1e30f,
                             std::numeric_limits<float>::denorm_min(),
                             std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN(),
                             16777216.0f};
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = awkward[i % std::size(awkward)] + (i % 3 ? 0.0f : 0.125f * float(i));
    return image;
}

template <class Error, class Action>
std::string messageOf(Action action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

TEST_F(ImageTest, ExrKeepsNamesAndBits) {
    const Image written = awkwardImage();
    writeExr(path("a.exr"), written);
    const Image read = readImage(path("a.exr"));
    ASSERT_EQ(read.width, written.width);
    ASSERT_EQ(read.height, written.height);
    ASSERT_EQ(read.channelCount(), written.channelCount());
    for (const std::string& name : written.channels) {
        const std::vector<float> a = written.channel(name), b = read.channel(name);
        ASSERT_EQ(a.size(), b.size());
        EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0) << name;
    }
    EXPECT_EQ(names(), std::vector<std::string>{"a.exr"}) << "nothing temporary is left";
}

TEST_F(ImageTest, EqualImagesAreEqualFiles) {
    writeExr(path("a.exr"), awkwardImage());
    writeExr(path("b.exr"), awkwardImage());
    EXPECT_EQ(bytes("a.exr"), bytes("b.exr"));
    // OpenImageIO writes the time unless told otherwise: name, type and a length of zero.
    const std::string noDate("capDate\0string\0\0\0\0", 18);
    EXPECT_NE(bytes("a.exr").find(noDate), std::string::npos);
}

TEST_F(ImageTest, WritingReplacesAnOlderFile) {
    writeExr(path("a.exr"), awkwardImage());
    writeExr(path("a.exr"), Image::withChannels(1, 1, {"visibility"}));
    EXPECT_EQ(readImage(path("a.exr")).channels, std::vector<std::string>{"visibility"});
}

TEST_F(ImageTest, AFolderThatIsNotThereIsNamed) {
    const std::string message = messageOf<std::runtime_error>(
        [&] { writeExr(path("no_such_folder/a.exr"), awkwardImage()); });
    EXPECT_NE(message.find("no_such_folder"), std::string::npos) << message;
    EXPECT_NE(message.find("No such file or directory"), std::string::npos) << message;
}

/// A limit on file size fails in the middle of the file, as a full disk does.
TEST_F(ImageTest, AFileThatDoesNotFitLeavesTheOldOne) {
    writeExr(path("a.exr"), awkwardImage());
    const std::string before = bytes("a.exr");
    Image noise = Image::withChannels(64, 64, {"visibility"});
    for (std::size_t i = 0; i < noise.pixels.size(); ++i) noise.pixels[i] = std::sin(float(i * i));

    std::signal(SIGXFSZ, SIG_IGN);
    rlimit old{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
    const rlimit small{1024, old.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string message =
        messageOf<std::runtime_error>([&] { writeExr(path("a.exr"), noise); });
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
    std::signal(SIGXFSZ, SIG_DFL);

    EXPECT_NE(message.find("File too large"), std::string::npos) << message;
    EXPECT_EQ(bytes("a.exr"), before);
    EXPECT_EQ(names(), std::vector<std::string>{"a.exr"});
}

TEST_F(ImageTest, WhatCannotBeReadIsAnInputErrorInOneLine) {
    std::ofstream(path("text.exr")) << "not an image";
    std::ofstream(path("unknown.xyz")) << "not an image";
    std::ofstream(path("empty.png"));
    writeExr(path("whole.exr"), awkwardImage());
    std::ofstream(path("cut.exr"), std::ios::binary) << bytes("whole.exr").substr(0, 700);
    for (const char* name :
         {"absent.exr", "text.exr", "unknown.xyz", "empty.png", "cut.exr", "."}) {
        const std::string message = messageOf<InputError>([&] { readImage(path(name)); });
        EXPECT_NE(message.find(name), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

TEST_F(ImageTest, ChannelsAreReadInTheOrderAskedFor) {
    const Image image = awkwardImage();
    writeExr(path("a.exr"), image);
    const std::vector<std::string> names = {"rays", "P.X", "visibility", "N.Z"};
    const ImageChannels channels = readChannels(path("a.exr"), names);
    EXPECT_EQ(channels.width, image.width);
    EXPECT_EQ(channels.height, image.height);
    ASSERT_EQ(channels.values.size(), names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
        // Bits, for some are NaN.
        const std::vector<float> expected = image.channel(names[i]);
        ASSERT_EQ(channels.values[i].size(), expected.size());
        EXPECT_EQ(std::memcmp(channels.values[i].data(), expected.data(), 4 * expected.size()), 0)
            << names[i];
    }
    const std::string message = messageOf<InputError>([&] {
        readChannels(path("a.exr"), {"rays", "absent"});
    });
    EXPECT_NE(message.find("a.exr: no channel 'absent'; it has "), std::string::npos) << message;
    // What is not an EXR of zipped lines too.
    writePng(path("a.png"), Image::withChannels(3, 2, {"R", "G", "B"}));
    EXPECT_EQ(readChannels(path("a.png"), {"B"}).values.front(), std::vector<float>(6, 0.0f));
}

// Blocks of sixteen lines, the last of fewer; some that zipping makes no smaller are stored as they
// are; widths of which the predictor's eight bytes are no divisor.
TEST_F(ImageTest, ZippedLinesAreReadAsOpenImageIoReadsThem) {
    std::mt19937 random(7);
    for (const auto& [width, height] : {std::pair{1, 1}, {13, 16}, {37, 35}, {64, 33}}) {
        Image image = Image::withChannels(width, height, {"error", "noise", "visibility"});
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                image.at(x, y, 0) = static_cast<float>(x) / 8.0f - static_cast<float>(y);
                image.at(x, y, 1) = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
                image.at(x, y, 2) = y < 20 ? 1.0f : static_cast<float>(x % 3) / 2.0f;
            }
        for (const std::vector<std::string>& channels :
             {std::vector<std::string>{"error", "noise", "visibility"},
              {"noise"},
              {"visibility"}}) {
            Image some = Image::withChannels(width, height, channels);
            for (const std::string& name : channels) some.setChannel(name, image.channel(name));
            writeExr(path("a.exr"), some);
            const std::optional<ImageChannels> read = readZippedChannels(path("a.exr"), channels);
            ASSERT_TRUE(read) << width << 'x' << height;
            for (std::size_t i = 0; i < channels.size(); ++i) {
                const std::vector<float> expected = readImage(path("a.exr")).channel(channels[i]);
                ASSERT_EQ(read->values[i].size(), expected.size());
                EXPECT_EQ(std::memcmp(read->values[i].data(), expected.data(), 4 * expected.size()),
                          0)
                    << channels[i] << ' ' << width << 'x' << height;
            }
        }
    }
}

TEST_F(ImageTest, ABrokenExrIsNeverReadAsZippedLines) {
    writeExr(path("whole.exr"), awkwardImage());
    const std::string whole = bytes("whole.exr");
    std::mt19937 random(7);
    for (int i = 0; i < 400; ++i) {
        std::string broken = whole;
        if (i % 2) {
            broken.resize(random() % whole.size());
        } else {
            broken[random() % whole.size()] ^= static_cast<char>(1 + random() % 255);
        }
        std::ofstream(path("broken.exr"), std::ios::binary) << broken;
        const std::optional<ImageChannels> read =
            readZippedChannels(path("broken.exr"), {"visibility"});
        // A flipped byte may lie in what no check covers; a file cut short has lost its last block.
        if (i % 2) {
            EXPECT_FALSE(read) << i;
        }
    }
}

TEST_F(ImageTest, PngIsSrgbClampedAndTopRowFirst) {
    Image image = Image::withChannels(2, 2, {"R", "G", "B"});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    image.pixels = {0.0f, 0.5f, 1.0f, -1.0f, 2.0f, nan, 0.001f, 0.2f, 0.0f, 1.0f, 1.0f, 1.0f};
    writePng(path("a.png"), image);
    const Image read = readImage(path("a.png"));
    ASSERT_EQ(read.pixels.size(), 12u);
    // IEC 61966-2-1 by hand: 0.5 -> 188, 0.001 -> 12.92 * 0.255 = 3.3, 0.2 -> 124.
    const int expected[] = {0, 188, 255, 0, 255, 0, 3, 124, 0, 255, 255, 255};
    for (std::size_t i = 0; i < 12; ++i)
        EXPECT_EQ(std::lround(255 * read.pixels[i]), expected[i]) << i;
    EXPECT_EQ(names(), std::vector<std::string>{"a.png"});
    EXPECT_THROW(writePng(path("b.png"), Image::withChannels(1, 1, {"V"})), std::logic_error);
}

TEST(Image, ChannelsByName) {
    Image image = Image::withChannels(2, 1, {"a", "b"});
    const std::vector<float> values = {3.0f, 4.0f};
    image.setChannel("b", values);
    EXPECT_EQ(image.pixels, (std::vector<float>{0, 3, 0, 4}));
    EXPECT_EQ(image.at(1, 0, 1), 4.0f);
    EXPECT_EQ(image.channel("b"), values);
    EXPECT_EQ(messageOf<std::runtime_error>([&] { image.channel("c"); }),
              "the image has no channel 'c'; it has a, b");
    EXPECT_THROW(image.setChannel("c", values), std::runtime_error);
    EXPECT_THROW(image.setChannel("a", std::vector<float>(3)), std::logic_error);
}

struct Ink {
    int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
};

Ink inkOf(const Image& image) {
    Ink ink;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (image.at(x, y, 0) != 0.0f) {
                ink.left = std::min(ink.left, x), ink.right = std::max(ink.right, x);
                ink.top = std::min(ink.top, y), ink.bottom = std::max(ink.bottom, y);
            }
    return ink;
}

TEST(Text, InkLiesWithinItsWidthAndOnItsBaseline) {
    for (const char* text : {"rmse 0.0123", "jWq fj", "T", "pcf-1a2b3c4d"}) {
        for (const int sizePx : {12, 24}) {
            Image image = Image::withChannels(400, 80, {"R", "G", "B"});
            drawText(image, 50, 40, text, sizePx, 1, 1, 1);
            const int width = textWidth(text, sizePx);
            const Ink ink = inkOf(image);
            EXPECT_GE(ink.left, 50) << text;
            EXPECT_LT(ink.right, 50 + width) << text;
            EXPECT_GT(ink.right, 50 + width - sizePx) << text << ": the width is not far too large";
            EXPECT_GE(ink.top, 40 - sizePx) << text;
            EXPECT_LT(ink.top, 40) << text;
            EXPECT_LT(ink.bottom, 40 + sizePx / 2) << text << ": descenders only";
        }
    }
    EXPECT_EQ(textWidth("", 16), 0);
    EXPECT_GT(textWidth("wide text", 16), textWidth("wide", 16));
}

TEST(Text, IsBlendedInItsColourAndClipped) {
    Image image = Image::withChannels(60, 60, {"R", "G", "B"});
    std::ranges::fill(image.pixels, 0.5f);
    drawText(image, -20, 50, "clipped text", 40, 1.0f, 0.25f, 0.5f);
    bool full = false, partial = false;
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
        const float r = image.pixels[i], g = image.pixels[i + 1];
        const float coverage = (r - 0.5f) / 0.5f;
        ASSERT_GE(coverage, 0.0f);
        ASSERT_LE(coverage, 1.0f);
        ASSERT_NEAR(g, 0.5f - 0.25f * coverage, 1e-5f) << "one coverage for all channels";
        ASSERT_NEAR(image.pixels[i + 2], 0.5f, 1e-5f);
        full = full || coverage == 1.0f;
        partial = partial || (coverage > 0.0f && coverage < 1.0f);
    }
    EXPECT_TRUE(full);
    EXPECT_TRUE(partial) << "edges are smooth";
    const Image before = image;
    drawText(image, 1000, 1000, "outside", 20, 1, 1, 1);
    drawText(image, 10, 10, "", 20, 1, 1, 1);
    EXPECT_EQ(image.pixels, before.pixels);
}

TEST(Image, BytesAreThoseOfTheSrgbFormula) {
    const auto formula = [](float x) {
        return std::lround(
            255.0f * (x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f));
    };
    for (int i = 0; i <= 1'000'000; ++i) {
        const float x = static_cast<float>(i) / 1'000'000;
        ASSERT_EQ(srgb8(x), formula(x)) << x;
    }
    for (int byte = 0; byte < 256; ++byte)
        EXPECT_EQ(srgb8(linearOf(static_cast<std::uint8_t>(byte))), byte);
    EXPECT_EQ(srgb8(-1.0f), 0);
    EXPECT_EQ(srgb8(2.0f), 255);
    EXPECT_EQ(srgb8(std::numeric_limits<float>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace penumbra
