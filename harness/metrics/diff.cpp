#include "harness/metrics/diff.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "harness/metrics/error_sums.hpp"
#include "harness/metrics/flip.hpp"
#include "harness/metrics/ssim.hpp"
#include "harness/report/shade.hpp"

namespace penumbra {

namespace {

const std::vector<std::string> kRgb = {"R", "G", "B"};

/// IEC 61966-2-1, mirrored below 0.
float srgbDecoded(float encoded) {
    const float x = std::abs(encoded);
    const float linear = x <= 0.04045F ? x / 12.92F : std::pow((x + 0.055F) / 1.055F, 2.4F);
    return std::copysign(linear, encoded);
}

float srgbEncoded(float linear) {
    return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}

bool isAlpha(const std::string& channel) {
    return channel == "A" || channel == "alpha" || channel == "Alpha";
}

/// The channel that says where a picture shows something; empty if none does.
std::string coverageAmong(const std::vector<std::string>& channels) {
    if (channels.size() < 2) return "";
    auto found = std::ranges::find(channels, "mask");
    if (found == channels.end()) found = std::ranges::find_if(channels, isAlpha);
    return found == channels.end() ? "" : *found;
}

/// The channels to compare, in order; empty if the file does not say which.
std::vector<std::string> channelsToCompare(std::vector<std::string> channels) {
    const auto has = [&](const std::string& name) {
        return std::ranges::find(channels, name) != channels.end();
    };
    if (has("visibility")) return {"visibility"};
    if (channels.size() == 1) return channels;
    std::erase_if(channels, [](const std::string& c) { return isAlpha(c) || c == "mask"; });
    if (channels.size() == 1) return channels;
    if (channels.size() != 3 && channels.size() != 4) return {};
    if (std::ranges::all_of(kRgb, has)) return kRgb;
    return {channels[0], channels[1], channels[2]};
}

/// Display luminance of a linear RGB pixel, sRGB-encoded: near enough to even steps for the eye.
float luma(const float* rgb) {
    const auto shown = [](float v) { return std::clamp(v, 0.0F, 1.0F); };
    return srgbEncoded(0.2126F * shown(rgb[0]) + 0.7152F * shown(rgb[1]) + 0.0722F * shown(rgb[2]));
}

SsimImage prepareForSsim(const Image& image) {
    std::vector<float> values = image.pixels;
    if (image.channelCount() == 3) {
        values.resize(image.pixels.size() / 3);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = luma(&image.pixels[3 * i]);
    }
    return prepareSsim(image.width, image.height, std::move(values));
}

FlipImage prepareForFlip(const Image& image) {
    if (image.channelCount() == 3) return prepareFlip(image);
    Image grey = Image::withChannels(image.width, image.height, kRgb);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        std::fill_n(&grey.pixels[3 * i], 3, image.pixels[i]);
    }
    return prepareFlip(grey);
}

/// The numbers in the order of results.csv.
nlohmann::ordered_json numbers(const Diff& diff) {
    nlohmann::ordered_json json;
    const auto put = [&](const char* name, const std::optional<double>& value) {
        json[name] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
    };
    put("rmse", diff.rmse);
    put("mae", diff.mae);
    put("bias", diff.bias);
    put("p99", diff.p99);
    put("max_error", diff.maxError);
    put("ssim", diff.ssim);
    put("flip", diff.flip);
    json["nonfinite"] = diff.nonfinite;
    json["out_of_range"] = diff.outOfRange;
    return json;
}

}  // namespace

DiffImage readForDiff(const std::filesystem::path& path, Transfer transfer) {
    const Image file = readImage(path);
    const std::vector<std::string> chosen = channelsToCompare(file.channels);
    if (chosen.empty()) {
        throw InputError(
            fmt::format("{}: {} channels ({}); needed is one named visibility, or one to four of "
                        "which the first "
                        "are grey or red, green and blue",
                        path.string(), file.channelCount(), fmt::join(file.channels, ", ")));
    }
    DiffImage out{path.string(), {}, ""};
    out.image =
        Image::withChannels(file.width, file.height,
                            chosen.size() == 3 ? kRgb : std::vector<std::string>{"visibility"});
    for (std::size_t c = 0; c < chosen.size(); ++c) {
        out.image.setChannel(out.image.channels[c], file.channel(chosen[c]));
    }
    out.coverageChannel = coverageAmong(file.channels);
    if (!out.coverageChannel.empty()) out.coverage = file.channel(out.coverageChannel);
    std::vector<std::string> ignored;
    std::ranges::copy_if(file.channels, std::back_inserter(ignored), [&](const std::string& name) {
        return std::ranges::find(chosen, name) == chosen.end();
    });
    if (file.furtherParts) ignored.push_back("further parts of the file");
    if (!ignored.empty()) {
        out.note = fmt::format("{}: {} compared, {} ignored", out.name, fmt::join(chosen, ", "),
                               fmt::join(ignored, ", "));
    }
    out.decoded = transfer == Transfer::srgb || (transfer == Transfer::byFile && file.integers);
    if (out.decoded) {
        std::ranges::transform(out.image.pixels, out.image.pixels.begin(), srgbDecoded);
    }
    return out;
}

Diff diff(const DiffImage& reference, const DiffImage& image) {
    if (reference.image.width != image.image.width ||
        reference.image.height != image.image.height) {
        throw InputError(fmt::format("{} has {} x {} pixels, {} has {} x {}: the sizes must agree",
                                     reference.name, reference.image.width, reference.image.height,
                                     image.name, image.image.width, image.image.height));
    }
    if (reference.colour() != image.colour()) {
        const auto kind = [](const DiffImage& i) { return i.colour() ? "colour" : "one channel"; };
        throw InputError(fmt::format("{} is {}, {} is {}: they cannot be compared", reference.name,
                                     kind(reference), image.name, kind(image)));
    }

    Diff out;
    Image a = reference.image, b = image.image;
    const std::size_t channels = a.channelCount(), pixels = a.pixels.size() / channels;
    std::vector<std::uint8_t> counted(pixels, 1);
    ErrorSums errors;
    std::vector<double> absoluteErrors;
    absoluteErrors.reserve(a.pixels.size());
    out.errorMap.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        float* const truth = &a.pixels[i * channels];
        float* const drawn = &b.pixels[i * channels];
        const auto finite = [channels](const float* values) {
            return std::all_of(values, values + channels, [](float v) { return std::isfinite(v); });
        };
        if (!finite(truth) || !finite(drawn)) {
            counted[i] = 0;
            ++out.nonfinite;
            out.errorMap[i] = std::numeric_limits<float>::quiet_NaN();
            // Both get the same, so that the hole does not show in its neighbours' numbers.
            if (finite(drawn)) {
                std::copy_n(drawn, channels, truth);
            } else {
                if (!finite(truth)) std::fill_n(truth, channels, 0.0F);
                std::copy_n(truth, channels, drawn);
            }
            continue;
        }
        out.outOfRange +=
            std::any_of(drawn, drawn + channels, [](float v) { return v < 0.0F || v > 1.0F; });
        double largest = 0;
        for (std::size_t c = 0; c < channels; ++c) {
            const double error = static_cast<double>(drawn[c]) - truth[c];
            errors.add(error);
            absoluteErrors.push_back(std::abs(error));
            if (std::abs(error) > std::abs(largest)) largest = error;
        }
        out.errorMap[i] = static_cast<float>(largest);
    }

    out.rmse = errors.rms();
    out.mae = errors.mean(errors.sumAbs);
    out.bias = errors.mean(errors.sum);
    if (!absoluteErrors.empty()) {
        out.p99 = percentile99(absoluteErrors);
        out.maxError = *std::ranges::max_element(absoluteErrors);
    }
    out.ssim = ssim(prepareForSsim(a), prepareForSsim(b), counted);
    out.flip = meanWhere(flipErrors(prepareForFlip(a), prepareForFlip(b)), counted);
    return out;
}

Image errorPicture(const Diff& diff, int width, int height) {
    Image picture = Image::withChannels(width, height, kRgb);
    for (std::size_t i = 0; i < diff.errorMap.size(); ++i) {
        const glm::vec3 rgb = errorColour(diff.errorMap[i]);
        std::copy_n(&rgb[0], 3, &picture.pixels[3 * i]);
    }
    return picture;
}

std::string diffText(const Diff& diff) {
    const auto all = numbers(diff);
    std::string text;
    for (const auto& [name, value] : all.items()) {
        text += fmt::format("{:<13}{}\n", name, value.is_null() ? "-" : value.dump());
    }
    return text;
}

std::string diffJson(const Diff& diff) {
    return numbers(diff).dump(2) + "\n";
}

}  // namespace penumbra
