#include "harness/cli/truth_options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <tuple>

#include "core/error.hpp"

namespace penumbra {

std::pair<int, int> parsePair(const std::string& option, const std::string& text, char separator) {
    int a = 0, b = 0;
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, a);
    if (first.ec == std::errc() && first.ptr != end && *first.ptr == separator) {
        const auto second = std::from_chars(first.ptr + 1, end, b);
        if (second.ec == std::errc() && second.ptr == end && a > 0 && b > 0) return {a, b};
    }
    throw InputError(fmt::format("{} {}: expected two positive integers as in {}", option, text,
                                 separator == 'x' ? "512x512" : "1/4"));
}

void addTruthOptions(CLI::App& command, TruthOptions& o, std::optional<std::string>& size,
                     const std::string& sizeHelp) {
    command.add_option("--size", size, sizeHelp);
    command.add_option("--seed", o.seed, "of everything random");
    command.add_option("--threads", o.threads, "CPU threads (default: all)")
        ->check(CLI::Range(1, 1024));
    command
        .add_option("--reference", o.reference,
                    "embree | exact (polygon clipping; no noise, slow in clutter)")
        ->check(CLI::IsMember({"embree", "exact"}));
    command.add_option("--reference-se", o.referenceSe, "standard error to reach in every pixel");
    command.add_option("--cache", o.cache, "folder of cached references");
}

void addLoadOptions(CLI::App& command, LoadOptions& o) {
    command.add_option("--asset-scene", o.assetScene,
                       "glTF scene of the asset, index or name (default: the asset's own)");
    command.add_option("--camera", o.camera,
                       "camera of the asset, index or name; wins over a script's (default: the "
                       "script's, else the asset's first)");
    command
        .add_option("--max-memory", o.maxMemoryBytes,
                    "what an asset may make the loader allocate, as in 512MiB (default: 4GiB)")
        ->transform(CLI::AsSizeValue(false));
}

void finishTruthOptions(TruthOptions& o, const std::optional<std::string>& size) {
    if (size) {
        std::tie(o.width, o.height) = parsePair("--size", *size, 'x');
        if (o.width > 16384 || o.height > 16384)
            throw InputError(fmt::format("--size {}: at most 16384x16384", *size));
    }
    // Said here because CLI::Range lets NaN through.
    if (!(o.referenceSe >= 1e-5 && o.referenceSe <= 0.5))
        throw InputError(
            fmt::format("--reference-se {}: expected a number in 1e-05..0.5", o.referenceSe));
}

Progress referenceProgress(ProgressLine& line) {
    return [&line, begun = false](double fraction) mutable {
        if (!begun) line.step(0, "reference");
        begun = true;
        line.within(fraction);
    };
}

}  // namespace penumbra
