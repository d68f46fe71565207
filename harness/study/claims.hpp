#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/study/varied_scene.hpp"
#include "harness/study/verdict.hpp"

namespace penumbra {

/// Where one side of a claim is measured, and what.
struct ClaimSide {
    std::string setting;  ///< METHOD or METHOD:PARAMETER=VALUE;...; or kTruth
    std::string scene;    ///< id
    int frame = 0;
    Variation variation;

    bool operator==(const ClaimSide&) const = default;
};

/// The side of a claim that is the reference's own image instead of a method's.
inline constexpr std::string_view kTruth = "reference";

/// A paper's claim as a ratio of one number measured twice: side a over side b.
struct Claim {
    std::string id;         ///< within its paper
    std::string statement;  ///< the claim in words
    std::string place;      ///< where in the paper
    std::string technique;  ///< what the claim is about and is not implemented here; else empty,
                            ///< and only then the rest means something
    ClaimSide a, b;
    std::string metric;  ///< one of claimMetrics()
    Expectation expected;
    std::string why;    ///< why ours should match or exceed the paper's
    std::string found;  ///< why it does not hold here, printed where it does not; may be empty
};

/// scenes/papers/<id>.toml
struct Paper {
    std::string id;        ///< the file's stem
    std::string citation;  ///< authors, year, title
    std::vector<Claim> claims;
};

/// What a claim may measure: times (frame_ms, build_ms, shade_ms), work counters and the metrics of
/// results.csv, and penumbra_width: metres across the scene's shadow edges ([[edge]] of its
/// script), the mean over those that the frame shows.
const std::vector<std::string>& claimMetrics();
/// Whether a metric is a time, to be measured again and again.
bool isTime(const std::string& metric);
/// Whether a metric is of the image, which needs the reference.
bool isOfImage(const std::string& metric);

/// Reads every .toml of `folder`, sorted by name. Throws InputError "file:line: what; valid
/// choices" for anything that is not as described here, settings and scenes that do not exist
/// included.
std::vector<Paper> loadPapers(const std::filesystem::path& folder);

}  // namespace penumbra
