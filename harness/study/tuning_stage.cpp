#include "harness/study/tuning_stage.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <optional>

#include "core/error.hpp"
#include "core/gl/program.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"

namespace penumbra {
namespace {

std::string digestOf(const std::string& text) {
    const XXH128_hash_t digest = XXH3_128bits(text.data(), text.size());
    return fmt::format("{:016x}{:016x}", digest.high64, digest.low64);
}

/// Of everything that can change what a method does: this program and its shaders.
const std::string& programDigest() {
    static const std::string kDigest = [] {
        std::vector<std::filesystem::path> files = {"/proc/self/exe"};
        for (const auto& entry : std::filesystem::recursive_directory_iterator(gl::shaderFolder()))
            if (entry.is_regular_file()) files.push_back(entry.path());
        std::ranges::sort(files);
        std::string all;
        for (const auto& file : files) all += file.string() + digestOf(readTextFile(file));
        return digestOf(all);
    }();
    return kDigest;
}

/// The rows on disk, if they are those of `settings`.
std::optional<std::vector<Row>> load(const std::filesystem::path& path,
                                     const std::vector<Setting>& settings) {
    if (!std::filesystem::exists(path)) return std::nullopt;
    try {
        std::vector<Row> rows = readCsv(path);
        if (std::ranges::equal(rows, settings, {}, &Row::setting, &Setting::name)) return rows;
    } catch (const InputError&) {
        // What a file system broke is measured again.
    }
    return std::nullopt;
}

}  // namespace

TuningStage::TuningStage(std::shared_ptr<const Scene> scene, int index, int width, int height,
                         const TruthOptions& truth, const std::string& machine, bool remeasure,
                         const Progress& progress)
    : staged_(std::move(scene), index, width, height, truth.seed),
      reference_(obtainReference(*staged_.traced.scene, index, *staged_.traced.tracer,
                                 staged_.traced.gbuffer, staged_.traced.frame.light, truth,
                                 progress)
                     .reference),
      scorer_(reference_, staged_.traced.gbuffer, staged_.traced.scene->edges),
      target_(width, height),
      folder_((truth.cache.empty() ? ReferenceCache::defaultFolder() : truth.cache) / "tuning"),
      remeasure_(remeasure) {
    ReferenceOptions tracing;
    tracing.targetStandardError = truth.referenceSe;
    tracing.seed = truth.seed;
    key_ = fmt::format(
        "{}\n{}\n{}\n{}\n{}\n", machine, truth.threadCount(), programDigest(), truth.reference,
        ReferenceCache::key(*staged_.traced.frame.geometry, staged_.traced.scene->materials,
                            staged_.traced.scene->images, staged_.traced.gbuffer,
                            staged_.traced.frame.light, tracing));
}

std::vector<Row> TuningStage::measure(const std::vector<Setting>& settings, int repeats) const {
    if (settings.empty()) return {};
    std::string key = key_ + fmt::format("{}\n", repeats);
    for (const Setting& setting : settings) key += setting.method + ":" + setting.params + "\n";
    const std::filesystem::path path = folder_ / (digestOf(key) + ".csv");
    if (!remeasure_)
        if (auto rows = load(path, settings)) return *std::move(rows);

    std::vector<Row> rows = measureAnew(settings, repeats);
    std::string text = csvHeader() + "\n";
    for (const Row& row : rows) text += toCsv(row) + "\n";
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw InputError(fmt::format("--cache {}: {}", folder_.string(), error.message()));
    writeFileAtomically(path, text);
    return rows;
}

std::vector<Row> TuningStage::measureAnew(const std::vector<Setting>& settings, int repeats) const {
    std::vector<SettingRun> runs(settings.begin(), settings.end());
    std::vector<SettingRun*> pointers;
    for (SettingRun& run : runs) pointers.push_back(&run);
    std::vector<Row> rows(settings.size());
    CellOptions options;
    options.calledFor = staged_.analysis.calledFor();
    options.repeats = repeats;
    runCells(staged_.frame, options, pointers, target_,
             [&](std::size_t run, Row&& row, const std::vector<float>& visibility) {
                 if (row.status == "ok") row.metrics = scorer_.score(visibility);
                 rows[run] = std::move(row);
             });
    return rows;
}

}  // namespace penumbra
