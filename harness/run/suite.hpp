#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace penumbra {

/// A named list of scenes: scenes/suites/<id>.toml.
struct Suite {
    std::string id, shows;
    std::vector<std::string> scenes;
};

/// Ids of all suites, sorted.
std::vector<std::string> suiteIds(const SceneLibrary& library);

/// Throws InputError: an unknown id lists the known ones, a bad file its file:line.
Suite loadSuite(const std::string& id, const SceneLibrary& library);

}  // namespace penumbra
