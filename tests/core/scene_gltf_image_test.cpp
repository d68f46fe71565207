#include <tuple>

#include "core/scene/gltf_image.hpp"
#include "core/scene/supported_input.hpp"
#include "tests/core/scene_files.hpp"

/// Images of assets: what their texels are, and what damaged and hostile ones say. Nothing may be
/// printed on the way.
namespace penumbra::testing {
namespace {

using scene_detail::MemoryBudget;
using Texels = std::vector<int>;

std::string fromBase64(const std::string& text) {
    std::string out;
    unsigned bits = 0, count = 0;
    for (const char c : text) {
        const auto digit =
            std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
        if (digit == std::string::npos) break;
        bits = bits << 6 | static_cast<unsigned>(digit);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        out += static_cast<char>(bits >> count & 255);
    }
    return out;
}

TextureImage decode(const std::string& bytes,
                    std::uint64_t maxMemoryBytes = kDefaultMaxMemoryBytes) {
    MemoryBudget budget("a.gltf", maxMemoryBytes);
    return scene_detail::decodeImage(
        {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, "a.gltf", "/images/0",
        budget);
}

Texels texels(const std::string& bytes) {
    const TextureImage image = decode(bytes);
    EXPECT_EQ(image.rgba.size(), std::size_t(4) * image.width * image.height);
    return {image.rgba.begin(), image.rgba.end()};
}

/// What refusing says; nothing where it does not. Whatever decoders print fails the test.
std::string refusal(const std::string& bytes,
                    std::uint64_t maxMemoryBytes = kDefaultMaxMemoryBytes) {
    std::string message;
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    try {
        decode(bytes, maxMemoryBytes);
    } catch (const InputError& e) {
        message = e.what();
    }
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_TRUE(message.empty() || message.starts_with("a.gltf: /images/0: ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
}

const std::string kPngRgba = fromBase64(kRgbaPng.substr(kRgbaPng.find(',') + 1));

// Each written by Python's zlib with the samples in the comment.
const std::string kPngGrey1 = fromBase64(  // of 1 bit: 1 0 1
    "iVBORw0KGgoAAAANSUhEUgAAAAMAAAABAQAAAAAzmykZAAAACklEQVR42mNYAAAAogChcQXLQQAAAABJRU5ErkJggg==");
const std::string kPngPalette = fromBase64(  // entries 1 and 2 of three; alpha of the first two
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABAgMAAACJTJcZAAAACVBMVEUJCQkKFB4oMjzVawxFAAAAAnRSTlMBAoGGnVUA"
    "AAAKSURBVHjaY0gAAABiAGEcEAN/AAAAAElFTkSuQmCC");
const std::string kPngRgb16 = fromBase64(  // 0xFFFF, 0x0080, 0x1234
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABEAIAAADA54+dAAAAD0lEQVR42mP4/5+hQcgEAAzUAsUxsgIcAAAAAElFTk"
    "SuQmCC");
const std::string kPngGreyAlpha = fromBase64(  // interlaced: 7, alpha 200
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAHCGzyUAAAAC0lEQVR42mNgPwEAANkA0EQCVdsAAAAASUVORK5CYII=");
const std::string kPngKey = fromBase64(  // 1 2 3, 4 5 6; 1 2 3 is transparent
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAABnRSTlMAAQACAAPJS6v1AAAAD0lEQVR42mNgZGJmYWUD"
    "AAA/ABaYwWgTAAAAAElFTkSuQmCC");
const std::string kPngLinear = fromBase64(  // 1 2 3, alpha 4; gamma 1 and a colour profile of noise
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAABGdBTUEAAYagMeiWXwAAAA1pQ0NQeAAAbm8gcHJvZmls"
    "ZWnJeIcAAAANSURBVHjaY2BkYmYBAAAZAAs4BFS0AAAAAElFTkSuQmCC");

/// A grey JPEG of one value: every coefficient is 0, so that all texels are 128. Progressive ones
/// refine the same coefficients in every scan after the first.
std::string jpeg(int width, int height, bool progressive, int scans) {
    std::string out = "\xFF\xD8";
    const auto segment = [&](char marker, const std::string& content) {
        const std::size_t length = content.size() + 2;
        out += std::string("\xFF") + marker + static_cast<char>(length >> 8) +
               static_cast<char>(length) + content;
    };
    const auto u16 = [](int value) {
        return std::string{static_cast<char>(value >> 8), static_cast<char>(value)};
    };
    segment('\xDB', '\0' + std::string(64, '\1'));  // quantisation
    segment(progressive ? '\xC2' : '\xC0',
            '\10' + u16(height) + u16(width) + std::string("\1\1\x11\0", 4));
    for (const char table : {'\0', '\x10'})  // one Huffman code: the bit 0 stands for symbol 0
        segment('\xC4', table + std::string("\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", 17));
    const int blocks = (width + 7) / 8 * ((height + 7) / 8);
    for (int scan = 0; scan < scans; ++scan) {
        const char first = progressive && scan > 0 ? '\1' : '\0';
        const char last = !progressive || scan > 0 ? '\x3F' : '\0';
        segment('\xDA', std::string("\1\1\0", 3) + first + last + '\0');
        const int bits = progressive ? blocks : 2 * blocks;
        out += std::string(static_cast<std::size_t>(bits / 8), '\0');
        if (bits % 8 != 0) out += static_cast<char>(0xFF >> bits % 8);
    }
    return out + "\xFF\xD9";
}

TEST(SceneGltfImage, EveryKindOfPngBecomesRgba) {
    EXPECT_EQ(texels(kPngGrey1), (Texels{255, 255, 255, 255, 0, 0, 0, 255, 255, 255, 255, 255}));
    EXPECT_EQ(texels(kPngPalette), (Texels{10, 20, 30, 2, 40, 50, 60, 255}));
    EXPECT_EQ(texels(kPngRgb16), (Texels{255, 0, 18, 255}));  // 0x1234 / 257 is 18.1
    EXPECT_EQ(texels(kPngGreyAlpha), (Texels{7, 7, 7, 200}));
    EXPECT_EQ(texels(kPngKey), (Texels{1, 2, 3, 0, 4, 5, 6, 255}));
}

TEST(SceneGltfImage, ColourSpacesAreIgnored) {
    EXPECT_EQ(texels(kPngLinear), (Texels{1, 2, 3, 4}));
    EXPECT_EQ(refusal(kPngLinear), "");  // which also says that no warning is printed
}

TEST(SceneGltfImage, JpegBecomesRgba) {
    for (const auto& [progressive, scans] : {std::pair(false, 1), std::pair(true, 2)}) {
        const TextureImage image = decode(jpeg(9, 5, progressive, scans));
        EXPECT_EQ(std::tuple(image.width, image.height), std::tuple(9, 5));
        Texels grey;
        for (int i = 0; i < 9 * 5; ++i) grey.insert(grey.end(), {128, 128, 128, 255});
        EXPECT_EQ(Texels(image.rgba.begin(), image.rgba.end()), grey) << progressive;
    }
}

TEST(SceneGltfImage, EveryTruncationIsRefusedInOneLine) {
    for (std::size_t size = 0; size < kPngRgba.size(); ++size)
        EXPECT_NE(refusal(kPngRgba.substr(0, size)), "") << size;
    for (const bool progressive : {false, true}) {
        const std::string whole = jpeg(64, 64, progressive, progressive ? 2 : 1);
        for (std::size_t size = 0; size < whole.size(); ++size)
            EXPECT_NE(refusal(whole.substr(0, size)), "") << progressive << " " << size;
    }
}

TEST(SceneGltfImage, ChangedBytesAreReadOrRefusedInOneLine) {
    int refused = 0;
    for (const std::string& whole :
         {kPngRgba, kPngPalette, kPngGreyAlpha, jpeg(16, 16, false, 1), jpeg(16, 16, true, 3)}) {
        for (std::size_t i = 0; i < whole.size(); ++i) {
            for (const int change : {0x01, 0x80, 0xFF}) {
                std::string changed = whole;
                changed[i] = static_cast<char>(changed[i] ^ change);
                refused += !refusal(changed, 64 << 20).empty();
            }
        }
    }
    EXPECT_GT(refused, 1000);  // in a PNG every byte is under a checksum
}

TEST(SceneGltfImage, ALargeHeaderAllocatesNothing) {
    // A decoder that started would need 25 GB.
    EXPECT_EQ(
        refusal(jpeg(65500, 65500, true, 1).substr(0, 200)),
        "a.gltf: /images/0: is an image of 65500 x 65500 texels; at most 268435456 texels are "
        "read");
    const std::string fits = refusal(jpeg(16000, 16000, true, 1), 100 << 20);
    EXPECT_NE(fits.find("decoding the image would need"), std::string::npos) << fits;
    EXPECT_NE(fits.find("--max-memory is 100 MiB"), std::string::npos) << fits;
}

TEST(SceneGltfImage, ScansOfAJpegAreBounded) {
    EXPECT_EQ(refusal(jpeg(8, 8, true, 100)), "");
    const std::string message = refusal(jpeg(8, 8, true, 102));
    EXPECT_NE(message.find("cannot be decoded: it has more than 100 scans"), std::string::npos)
        << message;
}

}  // namespace
}  // namespace penumbra::testing
