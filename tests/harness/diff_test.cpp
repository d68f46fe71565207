#include "harness/metrics/diff.hpp"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "harness/run/row.hpp"

namespace penumbra {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Image filled(int width, int height, std::vector<std::string> channels, float value) {
    Image image = Image::withChannels(width, height, std::move(channels));
    std::fill(image.pixels.begin(), image.pixels.end(), value);
    return image;
}
const std::vector<std::string> kRgb = {"R", "G", "B"}, kV = {"visibility"};

DiffImage inMemory(Image image, std::string name = "image") {
    return {std::move(name), std::move(image), ""};
}

class DiffFiles : public testing::Test {
  protected:
    DiffFiles()
        : folder_(std::filesystem::temp_directory_path() /
                  ("penumbra_diff_" + std::to_string(getpid()) +
                   testing::UnitTest::GetInstance()->current_test_info()->name())) {
        std::filesystem::create_directories(folder_);
    }
    ~DiffFiles() override { std::filesystem::remove_all(folder_); }

    /// A file of 3 x 2 pixels, each with these channel values, stored as `type`.
    std::filesystem::path write(const std::string& name, const std::vector<float>& pixel,
                                OIIO::TypeDesc type, std::vector<std::string> channels = {}) {
        const std::filesystem::path path = folder_ / name;
        OIIO::ImageSpec spec(3, 2, static_cast<int>(pixel.size()), type);
        spec.attribute("oiio:UnassociatedAlpha", 1);
        if (!channels.empty()) spec.channelnames = std::move(channels);
        std::vector<float> values;
        for (int i = 0; i < 6; ++i) values.insert(values.end(), pixel.begin(), pixel.end());
        const auto output = OIIO::ImageOutput::create(path.string());
        EXPECT_TRUE(output && output->open(path.string(), spec) &&
                    output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
        return path;
    }
    std::filesystem::path path(const std::string& name) const { return folder_ / name; }

  private:
    std::filesystem::path folder_;
};

std::string messageOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& e) {
        return e.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

// ---- the numbers -------------------------------------------------------------------------------

TEST(Diff, VisibilityByHand) {
    Image truth = filled(2, 2, kV, 0.5F), drawn = truth;
    drawn.pixels = {0.5F, 1.0F, 0.25F, 1.5F};  // errors 0, 1/2, -1/4, 1
    const Diff d = diff(inMemory(truth), inMemory(drawn));
    EXPECT_DOUBLE_EQ(d.rmse.value(), std::sqrt((0.25 + 0.0625 + 1) / 4));
    EXPECT_DOUBLE_EQ(d.mae.value(), 1.75 / 4);
    EXPECT_DOUBLE_EQ(d.bias.value(), 1.25 / 4);
    EXPECT_DOUBLE_EQ(d.p99.value(), 1.0);
    EXPECT_DOUBLE_EQ(d.maxError.value(), 1.0);
    EXPECT_EQ(d.nonfinite, 0U);
    EXPECT_EQ(d.outOfRange, 1U);
    EXPECT_FALSE(d.ssim) << "no window fits";
    EXPECT_EQ(d.errorMap, (std::vector<float>{0, 0.5F, -0.25F, 1}));
}

TEST(Diff, ColourErrorsAreTakenPerChannel) {
    Image truth = filled(1, 2, kRgb, 0.5F), drawn = truth;
    drawn.pixels = {0.5F, 0.25F, 0.625F, 0.5F, 0.5F, 1.25F};  // -1/4, 1/8; 3/4
    const Diff d = diff(inMemory(truth), inMemory(drawn));
    EXPECT_DOUBLE_EQ(d.rmse.value(), std::sqrt((0.0625 + 0.015625 + 0.5625) / 6));
    EXPECT_DOUBLE_EQ(d.mae.value(), (0.25 + 0.125 + 0.75) / 6);
    EXPECT_DOUBLE_EQ(d.bias.value(), (-0.25 + 0.125 + 0.75) / 6);
    EXPECT_EQ(d.outOfRange, 1U) << "pixels, not channels";
    EXPECT_EQ(d.errorMap, (std::vector<float>{-0.25F, 0.75F}));
}

TEST(Diff, BlackAgainstWhite) {
    for (const auto& channels : {kRgb, kV}) {
        const Diff d =
            diff(inMemory(filled(16, 16, channels, 0)), inMemory(filled(16, 16, channels, 1)));
        EXPECT_EQ(d.rmse, 1.0);
        EXPECT_NEAR(d.flip.value(), 0.967380, 1e-5);  // published
        // C1 / (1 + C1); the luminance of white is 1 to float precision.
        EXPECT_NEAR(d.ssim.value(), 1e-4 / (1 + 1e-4), 1e-10);
    }
}

TEST(Diff, SsimOfColoursIsOfEncodedLuminance) {
    // Linear 0.2140411 is sRGB 1/2; both constant: (2 a b + C1) / (a^2 + b^2 + C1). 1e-6: float.
    const Diff d =
        diff(inMemory(filled(11, 11, kRgb, 0.21404114F)), inMemory(filled(11, 11, kRgb, 1)));
    EXPECT_NEAR(d.ssim.value(), (1 + 1e-4) / (1.25 + 1e-4), 1e-6);
}

TEST(Diff, IdentityAndSymmetry) {
    Image a = filled(20, 15, kRgb, 0), b = a;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        a.pixels[i] = static_cast<float>(i * 37 % 101) / 101.0F;
        b.pixels[i] = static_cast<float>(i * 53 % 89) / 89.0F;
    }
    const Diff same = diff(inMemory(a), inMemory(a));
    EXPECT_EQ(same.rmse, 0.0);
    EXPECT_EQ(same.flip, 0.0);
    EXPECT_NEAR(same.ssim.value(), 1.0, 1e-12);
    const Diff ab = diff(inMemory(a), inMemory(b)), ba = diff(inMemory(b), inMemory(a));
    EXPECT_EQ(ab.rmse, ba.rmse);
    EXPECT_EQ(ab.flip, ba.flip);
    EXPECT_EQ(ab.ssim, ba.ssim);
    EXPECT_EQ(ab.bias.value(), -ba.bias.value());
}

TEST(Diff, NonfinitePixelsOfEitherImageAreCountedAndLeftOut) {
    Image truth = filled(12, 12, kV, 0.25F), drawn = filled(12, 12, kV, 0.5F);
    const Diff clean = diff(inMemory(truth), inMemory(drawn));
    drawn.pixels[5 * 12 + 5] = kNan;
    truth.pixels[0] = std::numeric_limits<float>::infinity();
    truth.pixels[1] = drawn.pixels[1] = kNan;
    const Diff d = diff(inMemory(truth), inMemory(drawn));
    EXPECT_EQ(d.nonfinite, 3U);
    EXPECT_EQ(d.rmse, clean.rmse);
    EXPECT_EQ(d.maxError, clean.maxError);
    EXPECT_TRUE(std::isfinite(d.flip.value()));
    EXPECT_TRUE(std::isfinite(d.ssim.value()));
    EXPECT_TRUE(std::isnan(d.errorMap[0]));

    const Diff none = diff(inMemory(filled(12, 12, kRgb, kNan)), inMemory(filled(12, 12, kRgb, 0)));
    EXPECT_EQ(none.nonfinite, 144U);
    EXPECT_FALSE(none.rmse || none.p99 || none.maxError || none.ssim || none.flip);
}

TEST(Diff, DifferentSizesAndKindsAreNamed) {
    const std::string sizes = messageOf([] {
        diff(inMemory(filled(4, 5, kV, 0), "ref.exr"), inMemory(filled(6, 7, kV, 0), "mine.exr"));
    });
    EXPECT_EQ(sizes, "ref.exr has 4 x 5 pixels, mine.exr has 6 x 7: the sizes must agree");
    const std::string kinds = messageOf([] {
        diff(inMemory(filled(4, 5, kV, 0), "ref.exr"), inMemory(filled(4, 5, kRgb, 0), "mine.exr"));
    });
    EXPECT_EQ(kinds, "ref.exr is one channel, mine.exr is colour: they cannot be compared");
}

TEST(Diff, JsonHasTheCsvsNames) {
    const Diff d = diff(inMemory(filled(2, 2, kV, 0.25F)), inMemory(filled(2, 2, kV, 0.5F)));
    const auto json = nlohmann::json::parse(diffJson(d));
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    EXPECT_EQ(keys, (std::vector<std::string>{"bias", "flip", "mae", "max_error", "nonfinite",
                                              "out_of_range", "p99", "rmse", "ssim"}));
    EXPECT_EQ(json["rmse"], 0.25);
    EXPECT_TRUE(json["ssim"].is_null());
    EXPECT_TRUE(diffText(d).starts_with("rmse         0.25\n")) << diffText(d);
    EXPECT_NE(diffText(d).find("ssim         -\n"), std::string::npos) << diffText(d);
}

TEST(Diff, EveryKeyIsAColumnOfTheCsv) {
    const Diff d = diff(inMemory(filled(2, 2, kV, 0.25F)), inMemory(filled(2, 2, kV, 0.5F)));
    const std::string header = "," + csvHeader() + ",";
    const auto json = nlohmann::ordered_json::parse(diffJson(d));
    std::size_t last = 0;
    for (const auto& [key, value] : json.items()) {
        const std::size_t at = header.find("," + key + ",");
        EXPECT_NE(at, std::string::npos) << key;
        EXPECT_GE(at, last) << key << " is in the CSV's order";
        last = at;
    }
}

TEST(Diff, ImagesSmallerThanEveryWindow) {
    for (const auto& channels : {kRgb, kV})
        for (const int size : {1, 2, 5, 10}) {
            const Diff d = diff(inMemory(filled(size, 1, channels, 0.25F)),
                                inMemory(filled(size, 1, channels, 0.75F)));
            EXPECT_EQ(d.rmse, 0.5);
            EXPECT_EQ(d.p99, 0.5);
            EXPECT_FALSE(d.ssim) << size;
            EXPECT_GT(d.flip.value(), 0.0) << size;
            EXPECT_LE(d.flip.value(), 1.0) << size;
        }
}

TEST(Diff, ErrorPictureUsesTheColoursOfEveryErrorMap) {
    Image truth = filled(3, 1, kV, 0.5F), drawn = truth;
    drawn.pixels = {0.5F, 1.0F, 0.0F};
    const Image picture = errorPicture(diff(inMemory(truth), inMemory(drawn)), 3, 1);
    EXPECT_EQ(picture.at(0, 0, 0), 1.0F);
    EXPECT_EQ(picture.at(0, 0, 2), 1.0F);
    EXPECT_GT(picture.at(1, 0, 0), picture.at(1, 0, 2)) << "too bright is red";
    EXPECT_LT(picture.at(2, 0, 0), picture.at(2, 0, 2)) << "too dark is blue";
}

// ---- the files ---------------------------------------------------------------------------------

TEST_F(DiffFiles, FloatFilesAreLinearAndIntegerFilesSrgb) {
    // 8 bits store 0.5 as 128/255 = 0.50196, which sRGB decodes to 0.215861.
    const auto exr = write("a.exr", {0.5F, 0.5F, 0.5F}, OIIO::TypeDesc::FLOAT);
    const auto half = write("h.exr", {0.5F, 0.5F, 0.5F}, OIIO::TypeDesc::HALF);
    const auto png = write("a.png", {0.5F, 0.5F, 0.5F}, OIIO::TypeDesc::UINT8);
    EXPECT_EQ(readForDiff(exr).image.pixels[0], 0.5F);
    EXPECT_EQ(readForDiff(half).image.pixels[0], 0.5F);
    EXPECT_NEAR(readForDiff(png).image.pixels[0], 0.215861, 1e-6);
    EXPECT_NEAR(readForDiff(png, Transfer::linear).image.pixels[0], 128.0 / 255, 1e-6);
    EXPECT_NEAR(readForDiff(exr, Transfer::srgb).image.pixels[0], 0.214041, 1e-6);
    const auto deep = write("b.png", {0.25F, 0.5F, 1}, OIIO::TypeDesc::UINT16);
    EXPECT_NEAR(readForDiff(deep).image.pixels[1], 0.214041, 2e-5) << "half of a 16-bit step";
}

TEST_F(DiffFiles, AlphaIsIgnoredWithANote) {
    const DiffImage rgba = readForDiff(write("a.png", {1, 0, 1, 0.25F}, OIIO::TypeDesc::UINT8));
    EXPECT_TRUE(rgba.colour());
    EXPECT_EQ(rgba.image.pixels[0], 1.0F);
    EXPECT_TRUE(rgba.note.ends_with("a.png: R, G, B compared, A ignored")) << rgba.note;
    const DiffImage grey = readForDiff(write("b.png", {1, 0.25F}, OIIO::TypeDesc::UINT8));
    EXPECT_FALSE(grey.colour());
    EXPECT_EQ(grey.image.pixels, std::vector<float>(6, 1.0F));
    EXPECT_TRUE(grey.note.ends_with("A ignored")) << grey.note;
}

TEST_F(DiffFiles, VisibilityIsPickedByName) {
    const DiffImage setting =
        readForDiff(write("a.exr", {0.5F, 0.125F}, OIIO::TypeDesc::FLOAT, {"error", "visibility"}));
    EXPECT_FALSE(setting.colour());
    EXPECT_EQ(setting.image.pixels[0], 0.125F);
    EXPECT_TRUE(setting.note.ends_with("visibility compared, error ignored")) << setting.note;
    const DiffImage one = readForDiff(write("b.exr", {0.75F}, OIIO::TypeDesc::HALF, {"Z"}));
    EXPECT_EQ(one.image.pixels[0], 0.75F);
    EXPECT_EQ(one.note, "");
}

TEST_F(DiffFiles, ColourByNameElseTheFirstThree) {
    EXPECT_EQ(readForDiff(write("a.exr", {1, 2, 3}, OIIO::TypeDesc::FLOAT, {"B", "G", "R"}))
                  .image.pixels[0],
              3.0F);
    const DiffImage other =
        readForDiff(write("b.exr", {1, 2, 3}, OIIO::TypeDesc::FLOAT, {"u", "v", "w"}));
    EXPECT_EQ(other.image.pixels[2], 3.0F);
    EXPECT_EQ(other.image.channels, kRgb);
}

TEST_F(DiffFiles, ManyChannelsNeedOneCalledVisibility) {
    std::vector<float> pixel(16, 0.0F);
    std::vector<std::string> names;
    for (int i = 0; i < 16; ++i) names.push_back("layer" + std::to_string(10 + i));
    const std::string message =
        messageOf([&] { readForDiff(write("a.exr", pixel, OIIO::TypeDesc::FLOAT, names)); });
    EXPECT_NE(message.find("16 channels (layer10, layer11"), std::string::npos) << message;
    EXPECT_NE(message.find("layer25"), std::string::npos) << message;
    names[7] = "visibility";
    pixel[7] = 0.5F;
    const DiffImage picked = readForDiff(write("b.exr", pixel, OIIO::TypeDesc::FLOAT, names));
    EXPECT_EQ(picked.image.pixels, std::vector<float>(6, 0.5F));
}

TEST_F(DiffFiles, EveryUsualFormatIsRead) {
    struct Case {
        const char* name;
        OIIO::TypeDesc type;
        double tolerance;
    };
    // 0.75 in 8 bits is 191/255; JPEG's colour conversion costs two steps more.
    for (const Case& c : {Case{"a.png", OIIO::TypeDesc::UINT8, 0.0011},
                          {"b.png", OIIO::TypeDesc::UINT16, 1e-5},
                          {"a.tif", OIIO::TypeDesc::UINT8, 0.0011},
                          {"b.tif", OIIO::TypeDesc::UINT16, 1e-5},
                          {"c.tif", OIIO::TypeDesc::FLOAT, 0.0},
                          {"a.jpg", OIIO::TypeDesc::UINT8, 0.009},
                          {"a.exr", OIIO::TypeDesc::HALF, 0.0},
                          {"b.exr", OIIO::TypeDesc::FLOAT, 0.0}})
        for (const std::vector<float>& pixel : {std::vector<float>{0.75F}, {0.75F, 0.75F, 0.75F}}) {
            const DiffImage image = readForDiff(write(c.name, pixel, c.type), Transfer::linear);
            EXPECT_EQ(image.image.pixels.size(), 6 * pixel.size()) << c.name;
            EXPECT_NEAR(image.image.pixels[0], 0.75, c.tolerance) << c.name;
            EXPECT_EQ(image.note, "") << c.name;
        }
}

TEST_F(DiffFiles, NansInAFileAreCounted) {
    const auto nan = write("a.exr", {kNan}, OIIO::TypeDesc::FLOAT);
    const auto half = write("b.exr", {0.5F}, OIIO::TypeDesc::HALF);
    EXPECT_EQ(diff(readForDiff(half), readForDiff(nan)).nonfinite, 6U);
}

TEST_F(DiffFiles, CoverageIsReadBesideTheImage) {
    const DiffImage alpha = readForDiff(write("a.png", {1, 0, 1, 0.2F}, OIIO::TypeDesc::UINT8));
    EXPECT_EQ(alpha.coverageChannel, "A");
    ASSERT_EQ(alpha.coverage.size(), 6U);
    EXPECT_NEAR(alpha.coverage[5], 0.2, 1e-6) << "51 of 255, not decoded";
    EXPECT_TRUE(alpha.decoded);
    const DiffImage mask =
        readForDiff(write("b.exr", {3, 0.5F}, OIIO::TypeDesc::FLOAT, {"mask", "Y"}));
    EXPECT_EQ(mask.coverageChannel, "mask");
    EXPECT_EQ(mask.coverage[0], 3.0F);
    EXPECT_EQ(mask.image.pixels[0], 0.5F);
    EXPECT_FALSE(mask.decoded);
    const DiffImage five = readForDiff(
        write("c.exr", {1, 2, 3, 1, 1}, OIIO::TypeDesc::FLOAT, {"R", "G", "B", "A", "mask"}));
    EXPECT_TRUE(five.colour());
    EXPECT_EQ(five.image.pixels[2], 3.0F);
    const DiffImage only = readForDiff(write("d.exr", {0.5F}, OIIO::TypeDesc::FLOAT, {"A"}));
    EXPECT_EQ(only.image.pixels[0], 0.5F);
    EXPECT_TRUE(only.coverage.empty());
}

TEST_F(DiffFiles, OfSeveralPartsTheFirstIsReadWithANote) {
    for (const char* name : {"a.exr", "a.tif"}) {
        std::vector<OIIO::ImageSpec> specs(2, OIIO::ImageSpec(3, 2, 1, OIIO::TypeDesc::FLOAT));
        for (std::size_t i = 0; i < 2; ++i)
            specs[i].attribute("oiio:subimagename", i == 0 ? "first" : "second");
        const auto output = OIIO::ImageOutput::create(path(name).string());
        ASSERT_TRUE(output && output->open(path(name).string(), 2, specs.data()));
        for (int part = 0; part < 2; ++part) {
            const std::vector<float> values(6, part == 0 ? 0.25F : 0.75F);
            ASSERT_TRUE(part == 0 || output->open(path(name).string(), specs[1],
                                                  OIIO::ImageOutput::AppendSubimage));
            ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
        }
        ASSERT_TRUE(output->close());
        const DiffImage image = readForDiff(path(name));
        EXPECT_EQ(image.image.pixels, std::vector<float>(6, 0.25F)) << name;
        EXPECT_TRUE(image.note.ends_with("further parts of the file ignored")) << image.note;
    }
}

TEST_F(DiffFiles, APartOfAPictureIsRefusedWithItsPlace) {
    OIIO::ImageSpec spec(3, 2, 1, OIIO::TypeDesc::FLOAT);
    spec.x = 4;
    spec.y = 5;
    spec.full_width = spec.full_height = 16;
    const std::vector<float> values(6, 0.5F);
    const auto output = OIIO::ImageOutput::create(path("a.exr").string());
    ASSERT_TRUE(output->open(path("a.exr").string(), spec) &&
                output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
    EXPECT_TRUE(messageOf([&] { readForDiff(path("a.exr")); })
                    .ends_with("a.exr: holds 3 x 2 pixels from (4, 5) of a picture of 16 x 16 from "
                               "(0, 0): a whole picture is needed"));
}

TEST_F(DiffFiles, BrokenFilesAreOneLine) {
    write("whole.exr", {0.5F}, OIIO::TypeDesc::FLOAT);
    write("whole.tif", {0.5F}, OIIO::TypeDesc::FLOAT);
    write("whole.jpg", {0.5F}, OIIO::TypeDesc::UINT8);
    write("whole.png", {0.5F}, OIIO::TypeDesc::UINT8);
    std::vector<std::string> names = {"text.exr", "text.png", "text.tif", "text.jpg", "text.xyz"};
    for (const std::string& name : names) std::ofstream(path(name)) << "no image";
    for (const std::string end : {"exr", "tif", "jpg", "png"}) {
        std::ifstream in(path("whole." + end), std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        std::ofstream(path("half." + end), std::ios::binary) << bytes.substr(0, bytes.size() / 2);
        std::ofstream(path("empty." + end), std::ios::binary);
        names.push_back("half." + end);
        names.push_back("empty." + end);
    }
    std::filesystem::create_directories(path("folder.exr"));
    names.push_back("folder.exr");
    for (const std::string& name : names) {
        testing::internal::CaptureStderr();  // libpng speaks for itself
        const std::string message = messageOf([&] { readForDiff(path(name)); });
        testing::internal::GetCapturedStderr();
        EXPECT_TRUE(message.starts_with(path(name).string() + ": ")) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

TEST_F(DiffFiles, AbsentFilesAreNamed) {
    EXPECT_NE(messageOf([&] { readForDiff(path("none.exr")); }).find("none.exr: no such file"),
              std::string::npos);
}

}  // namespace
}  // namespace penumbra
