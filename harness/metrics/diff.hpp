#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image.hpp"

namespace penumbra {

/// How an image file's numbers stand for light.
enum class Transfer {
    byFile,  ///< float files are linear, integer files sRGB-encoded
    linear,
    srgb,
};

/// An image to compare: visibility (one channel) or linear RGB (three, named R, G, B).
struct DiffImage {
    std::string name;  ///< for messages: the path as given
    Image image;
    std::string note;      ///< what of the file was left out, in words; empty if nothing
    bool decoded = false;  ///< the file's numbers were taken as sRGB-encoded
    /// The alpha channel or the one named `mask`, as stored: where the picture shows something.
    /// Empty if the file has neither.
    std::vector<float> coverage{};
    std::string coverageChannel{};

    bool colour() const { return image.channelCount() == 3; }
};

/// Reads any image that OpenImageIO reads. A channel named `visibility` is visibility, and so is
/// the only channel (besides alpha and `mask`) of a grey image; else three or four channels are
/// colour: R, G and B by name or the first three. Throws InputError that lists the channels
/// otherwise.
DiffImage readForDiff(const std::filesystem::path& path, Transfer transfer = Transfer::byFile);

/// Every metric that two images alone allow, over the whole image; names as in results.csv. Absent
/// where no pixel allows it.
struct Diff {
    /// Of image - reference: visibility, or each channel of linear RGB as a value of its own.
    std::optional<double> rmse, mae, bias, p99, maxError;
    std::optional<double> ssim;   ///< of visibility, or of the sRGB-encoded luminance of colours
    std::optional<double> flip;   ///< of the images on a display; visibility as linear grey
    std::size_t nonfinite = 0;    ///< pixels not finite in either image; in none of the numbers
    std::size_t outOfRange = 0;   ///< finite pixels of the image (not the reference) outside [0,1]
    std::vector<float> errorMap;  ///< per pixel the signed error of largest size; NaN if not finite
};

/// Throws InputError for images of different sizes, or of visibility and of colour.
Diff diff(const DiffImage& reference, const DiffImage& image);

/// `errorMap` in the colours of every error map (errorColour): linear RGB.
Image errorPicture(const Diff& diff, int width, int height);

/// One metric a line, or a JSON object with null for what is absent.
std::string diffText(const Diff& diff);
std::string diffJson(const Diff& diff);

}  // namespace penumbra
