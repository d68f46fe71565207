#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "methods/shadow_method.hpp"

namespace penumbra::stress {

/// How far a method may be from the exact visibility of a random scene, over the pixels asked
/// (on the horizon only where methods sample the light).
struct TruthBound {
    /// Of methods that sample the light: rms error at most `rmsFactor` / sqrt(parameter `samples`).
    std::string samples;
    double rmsFactor = 0.0;
    /// Of others: mean absolute error at most that of the light centre's hard shadow and this.
    double meanBeyondHard = 0.0;
    std::string because;
};

/// What scenes/stress/random.toml says: one bound for whom it does not name, and some methods' own.
struct TruthBounds {
    TruthBound general;
    std::map<std::string, TruthBound> own;

    const TruthBound& of(const std::string& method) const;
    /// Throws InputError "file:line: what; valid choices".
    static TruthBounds read(const std::filesystem::path& file);
};

}  // namespace penumbra::stress
