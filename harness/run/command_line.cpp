#include "harness/run/command_line.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/scene/scene.hpp"
#include "harness/run/separation.hpp"
#include "harness/run/settings.hpp"

namespace penumbra {
namespace {

/// " --set METHOD.PARAMETER=VALUE" for what `row` has beside its method's defaults.
std::string assignmentsOf(const Row& row) {
    if (isSeparation(row) || row.params.empty()) return "";
    std::string text;
    try {
        for (const auto& [parameter, value] :
             parseSetting("params", row.method + ':' + row.params).assignments)
            text += " --set " + shellQuoted(row.method + '.' + parameter + '=' + value);
    } catch (const InputError&) {
        // A method or parameter that this version has not: the run's own words, for who has it.
        return " --set " + shellQuoted(row.method + '.' + row.params);
    }
    return text;
}

}  // namespace

std::string shellQuoted(const std::string& argument) {
    const bool plain = !argument.empty() && argument.find_first_not_of(
                                                "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRS"
                                                "TUVWXYZ0123456789_-+=.,:/@%") == std::string::npos;
    if (plain) return argument;
    std::string text = "'";
    for (const char c : argument) text += c == '\'' ? "'\\''" : std::string(1, c);
    return text + '\'';
}

std::string sceneArgument(const RunRecord& record, const std::string& scene) {
    const auto entry = std::ranges::find(record.scenes, scene, &RunRecord::SceneEntry::id);
    if (entry == record.scenes.end() || entry->source.empty()) return scene;
    const std::vector<std::string> known = SceneLibrary::standard().ids();
    return std::ranges::find(known, scene) != known.end() ? scene : entry->source;
}

std::string effectsArgument(const RunRecord& record) {
    if (record.effects.empty()) return "none";
    std::string list = record.effects;
    std::ranges::replace(list, ' ', ',');
    return list;
}

std::string reproducingCommand(const RunRecord& record, const Row& row) {
    const RunRecord defaults;
    std::string text =
        fmt::format("penumbra compare --scene {} --method {}{} --size {}x{} --repeats {}",
                    shellQuoted(sceneArgument(record, row.scene)), shellQuoted(row.method),
                    assignmentsOf(row), record.width, record.height, record.repeats);
    const auto add = [&](bool given, const char* option, const std::string& value) {
        if (given && !value.empty()) text += fmt::format(" {} {}", option, shellQuoted(value));
    };
    add(true, "--asset-scene", record.assetScene);
    add(true, "--camera", record.camera);
    add(record.seed != 0, "--seed", fmt::format("{}", record.seed));
    add(record.effects != defaults.effects, "--effects", effectsArgument(record));
    add(record.reference != defaults.reference, "--reference", record.reference);
    add(record.referenceSe != 1.0 / 1024, "--reference-se", fmt::format("{}", record.referenceSe));
    add(row.threads > 0, "--threads", fmt::format("{}", row.threads));
    const std::string context = record.provenanceOf("context");
    add(context != "osmesa" && context != "none", "--context", context);
    add(true, "--cache", record.cache);
    return text;
}

}  // namespace penumbra
