#include "harness/run/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "harness/report/report.hpp"
#include "harness/run/files.hpp"
#include "harness/run/fill_flicker.hpp"
#include "harness/run/folder_lock.hpp"

namespace penumbra {
namespace {

/// Adds to `list` what of `more` it does not hold yet, told apart by `member`.
template <class Entry, class Member>
void addNew(std::vector<Entry>& list, const std::vector<Entry>& more, Member member) {
    for (const Entry& entry : more)
        if (std::ranges::find(list, entry.*member, member) == list.end()) list.push_back(entry);
}

void addPhases(std::vector<PhaseTime>& phases, const std::vector<PhaseTime>& more) {
    for (const PhaseTime& phase : more) {
        const auto same = std::ranges::find(phases, phase.name, &PhaseTime::name);
        if (same == phases.end())
            phases.push_back(phase);
        else
            same->seconds += phase.seconds;
    }
}

void requireUnused(const RunFolder& folder) {
    if (std::filesystem::exists(folder.results()))
        throw InputError(fmt::format("{}: holds a run already", folder.root().string()));
}

}  // namespace

int mergeRuns(const std::filesystem::path& out, const std::vector<std::filesystem::path>& runs) {
    const RunFolder target(out);
    requireUnused(target);

    RunRecord record;
    std::map<std::string, std::filesystem::path> rowOf;
    std::string text = csvHeader() + "\n";
    bool failed = false;
    for (const auto& run : runs) {
        const RunFolder folder(run);
        const RunRecord part = RunRecord::read(folder.record());
        if (&run == &runs.front()) {
            record = part;
            record.references.clear();
            record.analysis.clear();
            record.phases.clear();
        }
        if (part.width != record.width || part.height != record.height ||
            part.seed != record.seed || part.reference != record.reference ||
            part.referenceSe != record.referenceSe || part.effects != record.effects)
            throw InputError(fmt::format("{} and {} differ in size, seed, reference or effects",
                                         runs.front().string(), run.string()));
        for (const Row& row : readCsv(folder.results())) {
            const auto [at, isNew] = rowOf.emplace(row.key(), run);
            if (!isNew)
                throw InputError(fmt::format("{} and {} both have {} frame {} {}",
                                             at->second.string(), run.string(), row.scene,
                                             row.frame, row.setting));
            failed |= row.status == "failed";
            text += toCsv(row) + "\n";
        }
        addNew(record.scenes, part.scenes, &RunRecord::SceneEntry::id);
        addNew(record.settings, part.settings, &RunRecord::SettingEntry::name);
        for (const ReferenceStats& stats : part.references)
            if (std::ranges::none_of(record.references, [&](const ReferenceStats& s) {
                    return s.scene == stats.scene && s.frame == stats.frame;
                }))
                record.references.push_back(stats);
        for (const EffectsRecord& effects : part.analysis)
            if (std::ranges::none_of(record.analysis, [&](const EffectsRecord& e) {
                    return e.scene == effects.scene && e.frame == effects.frame;
                }))
                record.analysis.push_back(effects);
        addPhases(record.phases, part.phases);
        record.finished = record.finished && part.finished;
    }

    target.create();
    const FolderLock lock(out);
    requireUnused(target);  // another process may have been quicker
    for (const auto& run : runs) {
        const std::filesystem::path images = run / "images";
        if (std::filesystem::exists(images))
            std::filesystem::copy(images, out / "images",
                                  std::filesystem::copy_options::recursive |
                                      std::filesystem::copy_options::overwrite_existing);
    }
    writeFileAtomically(target.results(), text);
    record.write(target.record());
    fillFlicker(target);
    orderRows(target, record);
    writeArtefacts(target);
    return failed ? 3 : 0;
}

}  // namespace penumbra
