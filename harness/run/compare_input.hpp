#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "harness/run/compare.hpp"

/// What `penumbra compare` works on, from its options. All throw InputError.
namespace penumbra {

struct LoadedScenes {
    std::vector<std::shared_ptr<const Scene>> scenes;
    std::map<std::string, double> milliseconds;  ///< that reading them took, by id
    std::vector<std::pair<std::string, std::string>> skipped;
};

/// Those of the suite, then those that were named; one at least.
LoadedScenes loadScenes(const CompareOptions& options);

/// Both of `--paired`, one where they are the same; otherwise all that were asked for.
std::vector<Setting> settingsOf(const CompareOptions& options);

/// Refuses what `--effects-table` cannot be combined with.
void requireEffectsTable(const CompareOptions& options);

}  // namespace penumbra
