#include "harness/run/suite.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>

#include "core/error.hpp"

namespace penumbra {

std::vector<std::string> suiteIds(const SceneLibrary& library) {
    std::vector<std::string> ids;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(library.scripts / "suites", error))
        if (entry.path().extension() == ".toml") ids.push_back(entry.path().stem());
    std::ranges::sort(ids);
    return ids;
}

Suite loadSuite(const std::string& id, const SceneLibrary& library) {
    const std::vector<std::string> known = suiteIds(library);
    if (std::ranges::find(known, id) == known.end())
        throw InputError(
            fmt::format("unknown suite '{}'; the suites are {}", id, fmt::join(known, ", ")));
    const std::string file = (library.scripts / "suites" / (id + ".toml")).string();
    const auto fail = [&](const toml::node* node, const std::string& what) -> InputError {
        return InputError(
            fmt::format("{}:{}: {}", file, node ? node->source().begin.line : 1, what));
    };
    toml::table table;
    try {
        table = toml::parse_file(file);
    } catch (const toml::parse_error& e) {
        throw InputError(fmt::format("{}:{}: {}", file, e.source().begin.line, e.description()));
    }
    for (const auto& [key, node] : table)
        if (key != "shows" && key != "scenes")
            throw fail(&node,
                       fmt::format("unknown key '{}'; valid keys are shows, scenes", key.str()));
    const toml::node* shows = table.get("shows");
    if (shows && !shows->is_string()) throw fail(shows, "'shows' must be a string");
    Suite suite{id, table["shows"].value_or(std::string()), {}};
    const std::vector<std::string> sceneIds = library.ids();
    const toml::array* scenes = table["scenes"].as_array();
    if (!scenes || scenes->empty())
        throw fail(table.get("scenes"), "'scenes' must be a list of scene ids");
    for (const toml::node& scene : *scenes) {
        const auto name = scene.value<std::string>();
        if (!name) throw fail(&scene, "'scenes' must be a list of scene ids");
        if (std::ranges::find(sceneIds, *name) == sceneIds.end())
            throw fail(&scene, fmt::format("unknown scene '{}'; scenes are {}", *name,
                                           fmt::join(sceneIds, ", ")));
        suite.scenes.push_back(*name);
    }
    return suite;
}

}  // namespace penumbra
