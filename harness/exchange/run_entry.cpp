#include "harness/exchange/run_entry.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "harness/report/report.hpp"
#include "harness/run/files.hpp"
#include "harness/run/fill_flicker.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/separation.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

constexpr std::size_t kLongestName = 100;

/// The name becomes a file beside gbuffer.exr and reference.exr, a table cell and a label.
void requireFileName(const std::string& name) {
    const bool plain = std::ranges::all_of(
        name, [](unsigned char c) { return c > 0x20 && c != 0x7f && c != '/'; });
    if (name.empty() || name.size() > kLongestName || !plain || name.starts_with('.') ||
        name == "gbuffer" || name == "reference")
        throw InputError(fmt::format(
            "--name '{}': in a run it names a file: up to {} characters without spaces and '/', "
            "not beginning with '.', and neither gbuffer nor reference",
            name, kLongestName));
}

bool isMethod(const std::string& id) {
    const auto& methods = methodRegistry();
    return id == kSeparation || std::ranges::find(methods, id, &MethodInfo::id) != methods.end();
}

}  // namespace

RunEntry::RunEntry(const std::filesystem::path& folder, const std::string& name, const Scene& scene,
                   const TruthOptions& truth, const std::string& command)
    : folder_(folder) {
    requireFileName(name);
    if (isMethod(name))
        throw InputError(
            fmt::format("--name {}: is a method's; an image beside the methods of a run needs a "
                        "name of its own",
                        name));
    if (std::filesystem::is_directory(folder)) lock_.emplace(folder);
    if (std::filesystem::exists(folder_.results())) {
        record_ = RunRecord::read(folder_.record());
        if (record_.width != truth.width || record_.height != truth.height ||
            record_.seed != truth.seed || record_.reference != truth.reference ||
            record_.referenceSe != truth.referenceSe)
            throw InputError(fmt::format(
                "--out {}: the run there has --size {}x{} --seed {} --reference {} --reference-se "
                "{}; the image is scored with --size {}x{} --seed {} --reference {} --reference-se "
                "{}: they must be the same",
                folder.string(), record_.width, record_.height, record_.seed, record_.reference,
                record_.referenceSe, truth.width, truth.height, truth.seed, truth.reference,
                truth.referenceSe));
        for (const Row& row : readCsv(folder_.results()))
            if (row.setting == name && row.method != name)
                throw InputError(fmt::format("--name {}: is a setting of {} in {}; choose another",
                                             name, row.method, folder.string()));
    } else {
        record_.command = command;
        record_.finished = true;
        record_.width = truth.width;
        record_.height = truth.height;
        record_.seed = truth.seed;
        record_.reference = truth.reference;
        record_.referenceSe = truth.referenceSe;
        record_.provenance = gatherProvenance(truth.threadCount()).pairs();
    }
    const auto known = std::ranges::find(record_.scenes, scene.id, &RunRecord::SceneEntry::id);
    if (known == record_.scenes.end())
        record_.scenes.push_back({scene.id, scene.shows, scene.figure, scene.source.string(),
                                  scene.frameCount(), scene.chosen});
    else if (known->source != scene.source.string())
        throw InputError(fmt::format("--out {}: its scene '{}' is {}, not {}", folder.string(),
                                     scene.id, known->source, scene.source.string()));
    if (std::ranges::find(record_.settings, name, &RunRecord::SettingEntry::name) ==
        record_.settings.end())
        record_.settings.push_back({name, name, ""});
}

void RunEntry::putRow(const Row& row) {
    std::vector<Row> rows;
    if (std::filesystem::exists(folder_.results())) rows = readCsv(folder_.results());
    std::erase_if(rows, [&](const Row& other) { return other.key() == row.key(); });
    for (Row& next : rows)  // its flicker was against the image that is replaced now
        if (next.scene == row.scene && next.setting == row.setting && next.frame == row.frame + 1)
            next.metrics.flicker.reset();
    rows.push_back(row);
    std::string text = csvHeader() + "\n";
    for (const Row& kept : rows) text += toCsv(kept) + "\n";
    writeFileAtomically(folder_.results(), text);
}

void RunEntry::add(const Row& row, const std::vector<float>& visibility, const TracedFrame& traced,
                   const ObtainedReference& obtained) {
    folder_.create();
    if (!lock_) {
        lock_.emplace(folder_.root());
        if (std::filesystem::exists(folder_.results()))
            throw InputError(fmt::format("--out {}: another process has made a run here meanwhile",
                                         folder_.root().string()));
    }
    record_.write(folder_.record());  // before the first row: rows need a record
    if (!std::filesystem::exists(folder_.images(row.scene, row.frame) / "reference.exr")) {
        folder_.writeTruth(row.scene, row.frame, traced.gbuffer, obtained.reference,
                           traced.scene->origin);
        record_.references.push_back(obtained.stats);
        record_.write(folder_.record());
    }
    folder_.writeVisibility(row.scene, row.frame, row.setting, visibility, obtained.reference);
    putRow(row);
    fillFlicker(folder_);
    orderRows(folder_, record_);
    writeArtefacts(folder_);
}

}  // namespace penumbra
