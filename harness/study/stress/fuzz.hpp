#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "harness/study/stress/random_draw.hpp"

namespace penumbra::stress {

struct FuzzOptions {
    std::uint32_t seed = 1;
    std::uint32_t draws = 200;
    std::vector<std::string> methods;  ///< ids; empty: all
    std::filesystem::path out;         ///< where failures are written
};

struct FuzzFailure {
    std::uint32_t index = 0;
    Draw draw;  ///< shrunk
    DrawFailure failure;
    std::filesystem::path script;  ///< that reproduces it
};

struct FuzzResult {
    std::uint32_t checked = 0, refused = 0, invalid = 0;  ///< invalid: no scene at all
    std::vector<FuzzFailure> failures;
};

/// Checks `draws` random draws (random_draw.hpp) in the current context. Each failure is shrunk and
/// written to `out` as draw-<seed>-<index>.toml and .glb, with the command that shows it; the
/// folder is made only then. `starts` is told of each draw before it begins. Throws InputError for
/// an unknown method.
FuzzResult fuzz(const FuzzOptions& options, const TruthBounds& bounds,
                const std::function<void(std::uint32_t)>& starts);

std::string fuzzText(const FuzzOptions& options, const FuzzResult& result);

}  // namespace penumbra::stress
