#include "harness/run/compare_input.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "core/error.hpp"
#include "harness/reference/exact.hpp"
#include "harness/run/suite.hpp"
#include "harness/study/paired_report.hpp"

namespace penumbra {
namespace {

std::vector<Setting> pairedSettings(const CompareOptions& options) {
    const SettingChoice& choice = options.settings;
    if (!choice.methods.empty() || !choice.sets.empty() || !choice.sweeps.empty() || choice.ladder)
        throw InputError(
            "--paired: names both settings itself, as in --paired pcf 'pcss:blocker_taps=25'; "
            "--method, --set, --sweep and --ladder cannot be combined with it");
    if (options.resume || options.shards > 1)
        throw InputError(
            "--paired: pairs are timed in one go; --resume and --shard cannot be combined with it");
    if (options.repeats < static_cast<int>(kFewestForSignTest))
        throw InputError(fmt::format("--repeats {}: a 95 % interval needs at least {} pairs",
                                     options.repeats, kFewestForSignTest));
    std::vector<Setting> settings;
    for (const std::string& text : options.paired) {
        Setting setting = parseSetting("--paired", text);
        if (settings.empty() || settings.front().name != setting.name)
            settings.push_back(std::move(setting));
    }
    return settings;
}

}  // namespace

LoadedScenes loadScenes(const CompareOptions& options) {
    const SceneLibrary library = SceneLibrary::standard();
    std::vector<std::string> wanted;
    if (!options.suite.empty() || options.scenes.empty())
        wanted = loadSuite(options.suite.empty() ? "standard" : options.suite, library).scenes;
    wanted.insert(wanted.end(), options.scenes.begin(), options.scenes.end());

    LoadedScenes loaded;
    std::map<std::string, std::filesystem::path> sources;
    for (const std::string& name : wanted) {
        try {
            const auto start = std::chrono::steady_clock::now();
            const auto scene = loadScene(name, library, options.load);
            const std::chrono::duration<double, std::milli> took =
                std::chrono::steady_clock::now() - start;
            loaded.milliseconds.emplace(scene->id, took.count());
            const auto [at, isNew] = sources.emplace(scene->id, scene->source);
            if (!isNew && at->second != scene->source)
                throw InputError(fmt::format("two scenes are called '{}': {} and {}", scene->id,
                                             at->second.string(), scene->source.string()));
            if (isNew) loaded.scenes.push_back(scene);
        } catch (const AssetAbsent& e) {
            loaded.skipped.emplace_back(name, e.what());
        }
    }
    if (options.reference == "exact")
        for (const auto& scene : loaded.scenes)
            refuseMasked(*scene->frame(0).geometry, scene->materials);
    if (loaded.scenes.empty())
        throw InputError("nothing to render: " +
                         (loaded.skipped.empty() ? "no scene" : loaded.skipped.front().second));
    return loaded;
}

void requireEffectsTable(const CompareOptions& options) {
    if (!options.effects.automatic)
        throw InputError(
            "--effects-table: compares plans with that of auto; --effects cannot be combined with "
            "it");
    if (!options.paired.empty() || options.resume || options.shards > 1)
        throw InputError(
            "--effects-table: plans are timed in one go; --paired, --resume and --shard cannot be "
            "combined with it");
}

std::vector<Setting> settingsOf(const CompareOptions& options) {
    if (!options.paired.empty()) return pairedSettings(options);
    if (!options.again) return expandSettings(options.settings);
    std::vector<Setting> settings;
    for (const std::string& text : options.again->settings)
        settings.push_back(parseSetting("setting", text));
    return settings;
}

}  // namespace penumbra
