#include "harness/run/compare.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for_each.h>

#include <chrono>
#include <optional>
#include <set>

#include "core/error.hpp"
#include "harness/reference/certificate.hpp"
#include "harness/report/report.hpp"
#include "harness/run/cells.hpp"
#include "harness/run/compare_input.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/fill_flicker.hpp"
#include "harness/run/folder_lock.hpp"
#include "harness/run/interruption.hpp"
#include "harness/run/phase_clock.hpp"
#include "harness/run/progress.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/resume.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"
#include "harness/run/scene_stage.hpp"
#include "harness/run/separation.hpp"
#include "harness/run/thread_limit.hpp"
#include "harness/study/effects_table.hpp"
#include "harness/study/paired_report.hpp"

namespace penumbra {
namespace {

/// Penumbra pixels of a frame whose reference is checked against exact visibility: enough for a
/// coverage known to 1 %, few enough to cost next to nothing.
constexpr std::size_t kCheckedPixels = 500;

/// A frame's cells that have no row yet.
struct Pending {
    std::vector<SettingRun*> methods;
    bool separation = false;
};

/// All that a run holds while its cells are done.
class Run {
  public:
    Run(const CompareOptions& options, RunFolder folder, LoadedScenes loaded,
        std::vector<Setting> settings, const gl::Context& context, int threads)
        : options_(options),
          folder_(std::move(folder)),
          loaded_(std::move(loaded)),
          settings_(std::move(settings)),
          provenance_(gatherProvenance(context, threads)),
          progress_(countFrames()) {}

    /// Reads what an earlier run left in the folder (`--resume`), or refuses a folder that is in
    /// use.
    void openFolder();
    /// Runs every cell that has no row yet, until a signal asks to stop. Returns the exit code.
    int cells();

  private:
    std::size_t countFrames() const;
    void writeRecord(bool finished);
    void runScene(const Scene& scene);
    void recordEffects(SceneStage& stage, double loadMs);
    void runFrame(SceneStage& stage, const Pending& pending);
    using Finished = std::vector<std::pair<Row, std::vector<float>>>;
    Finished pairedCells(const Frame& frame, const CellOptions& options,
                         const TextureTarget& target);
    Reference referenceFor(const Scene& scene, const Frame& frame);
    bool isOpen(const Scene& scene, int index, std::size_t frameNumber,
                std::size_t settingIndex) const;
    std::size_t openCells() const;
    /// Half of a pair or of a table of plans is of no use.
    bool isResumable() const { return options_.paired.empty() && !options_.effectsTable; }

    const CompareOptions& options_;
    RunFolder folder_;
    LoadedScenes loaded_;
    std::vector<Setting> settings_;
    Provenance provenance_;
    ProgressLine progress_;
    PhaseClock clock_;
    RunRecord record_;
    std::set<std::string> done_;  ///< Row::key of cells that have a row
    std::optional<FolderLock> lock_;
    std::unique_ptr<CsvAppender> csv_;
    std::vector<PairedFrame> pairs_;
    std::vector<EffectsCell> effectsCells_;
    std::size_t framesDone_ = 0;
    int failed_ = 0;

  public:
    PhaseClock& clock() { return clock_; }
    RunRecord& record() { return record_; }
};

std::size_t Run::countFrames() const {
    std::size_t frames = 0;
    for (const auto& scene : loaded_.scenes)
        frames += static_cast<std::size_t>(scene->frameCount());
    return frames;
}

void Run::openFolder() {
    record_.command = options_.command;
    record_.width = options_.width;
    record_.height = options_.height;
    record_.repeats = options_.repeats;
    record_.curveMetric = options_.curveMetric;
    record_.seed = options_.seed;
    record_.reference = options_.reference;
    record_.referenceSe = options_.referenceSe;
    record_.assetScene = options_.load.assetScene;
    record_.camera = options_.load.camera;
    record_.cache = options_.cache.string();
    record_.effects = options_.effects.automatic    ? "auto"
                      : options_.effects.everyPixel ? "all"
                                                    : options_.effects.forced.text();
    record_.provenance = provenance_.pairs();
    record_.skippedScenes = loaded_.skipped;
    for (const auto& scene : loaded_.scenes)
        record_.scenes.push_back({scene->id, scene->shows, scene->figure, scene->source.string(),
                                  scene->frameCount(), scene->chosen});
    for (const Setting& s : settings_) record_.settings.push_back({s.name, s.method, s.params});

    folder_.create();
    lock_.emplace(folder_.root());
    const bool used = std::filesystem::exists(folder_.results());
    if (used && !options_.resume)
        throw InputError(
            fmt::format("--out {}: holds a run already; continue it with --resume or "
                        "choose another folder",
                        folder_.root().string()));
    if (used)
        done_ = takeUpRun(folder_, record_);
    else
        removeTornBeginnings(folder_);
    writeRecord(false);  // before the first row: rows without a record could not be resumed
    csv_ = std::make_unique<CsvAppender>(folder_.results());
}

void Run::writeRecord(bool finished) {
    record_.finished = finished;
    record_.phases = clock_.phases();
    record_.write(folder_.record());
}

/// Whether a cell is this process's to do and has no row yet; `frameNumber` counts the frames of
/// all scenes.
bool Run::isOpen(const Scene& scene, int index, std::size_t frameNumber,
                 std::size_t settingIndex) const {
    const std::size_t cell = frameNumber * settings_.size() + settingIndex;
    if (cell % static_cast<std::size_t>(options_.shards) !=
        static_cast<std::size_t>(options_.shard - 1))
        return false;
    Row row;
    row.scene = scene.id;
    row.frame = index;
    row.setting = settings_[settingIndex].name;
    return !done_.contains(row.key()) &&
           (!options_.again || options_.again->keys.contains(row.key()));
}

std::size_t Run::openCells() const {
    std::size_t open = 0, frameNumber = 0;
    for (const auto& scene : loaded_.scenes)
        for (int index = 0; index < scene->frameCount(); ++index, ++frameNumber)
            for (std::size_t s = 0; s < settings_.size(); ++s)
                open += isOpen(*scene, index, frameNumber, s);
    return open;
}

int Run::cells() {
    for (const auto& [scene, reason] : loaded_.skipped) progress_.note(reason);
    try {
        for (const auto& scene : loaded_.scenes) runScene(*scene);
    } catch (const Interrupted&) {  // what there is by now is written all the same
    }
    csv_.reset();
    const std::size_t open = openCells();
    clock_.measure("metrics", [&] { fillFlicker(folder_); });
    orderRows(folder_, record_);
    writeRecord(open == 0);
    clock_.measure("images", [&] { writeArtefacts(folder_); });
    writeRecord(open == 0);
    writeSummary(folder_);
    if (open > 0)
        progress_.note(fmt::format(
            "interrupted: {} cells are left{}", open,
            isResumable() ? fmt::format("; --resume --out {} does them", folder_.root().string())
                          : ""));
    else if (!options_.again)
        appendToStepSummary(readTextFile(folder_.summary()));
    if (const int signal = Interruption::signal()) return 128 + signal;
    return failed_ ? 3 : 0;
}

void Run::runScene(const Scene& scene) {
    for (const std::string& choice : scene.chosen)
        progress_.note(fmt::format("{}: {}", scene.id, choice));
    std::vector<SettingRun> runs(settings_.begin(), settings_.end());
    std::unique_ptr<SceneStage> stage;  // made for the first frame that has something to do

    for (int index = 0; index < scene.frameCount(); ++index, ++framesDone_) {
        Pending pending;
        for (std::size_t s = 0; s < runs.size(); ++s) {
            if (!isOpen(scene, index, framesDone_, s)) continue;
            if (runs[s].setting().isSeparation())
                pending.separation = true;
            else
                pending.methods.push_back(&runs[s]);
        }
        if (pending.methods.empty() && !pending.separation) continue;
        if (const int signal = Interruption::signal()) throw Interrupted(signal);
        progress_.step(framesDone_, fmt::format("{} frame {}", scene.id, index));

        clock_.measure("frames", [&] {
            if (!stage)
                stage = std::make_unique<SceneStage>(scene, options_.width, options_.height,
                                                     options_.seed);
            const auto start = std::chrono::steady_clock::now();
            stage->enter(index);
            const std::chrono::duration<double, std::milli> took =
                std::chrono::steady_clock::now() - start;
            recordEffects(*stage,
                          took.count() + (index == 0 ? loaded_.milliseconds.at(scene.id) : 0.0));
        });
        runFrame(*stage, pending);
        writeRecord(false);
    }
}

void Run::recordEffects(SceneStage& stage, double loadMs) {
    EffectsRecord record;
    record.scene = stage.frame().scene.id;
    record.frame = stage.frame().index;
    record.findings = stage.analysis().findings;
    record.loadMs = loadMs;
    record.analysisMs = stage.analysisMs();
    std::erase_if(record_.analysis, [&](const EffectsRecord& r) {
        return r.scene == record.scene && r.frame == record.frame;
    });
    record_.analysis.push_back(std::move(record));
}

void Run::runFrame(SceneStage& stage, const Pending& pending) {
    const Frame& frame = stage.frame();
    const Scene& scene = frame.scene;
    const Reference reference =
        clock_.measure("reference", [&] { return referenceFor(scene, frame); });
    clock_.measure("images", [&] {
        folder_.writeTruth(scene.id, frame.index, frame.gbuffer, reference, scene.origin);
    });
    const TextureTarget target(frame.width(), frame.height());
    CellOptions cellOptions;
    cellOptions.effects = options_.effects;
    cellOptions.calledFor = stage.analysis().calledFor();
    cellOptions.frameFor = [&](const Plan& plan) -> const Frame& { return stage.frameFor(plan); };
    cellOptions.repeats = options_.repeats;
    if (options_.paired.empty()) cellOptions.enoughMs = kEnoughMs;  // a pair has two halves
    if (isResumable()) cellOptions.stop = [] { return Interruption::signal() != 0; };
    Finished finished;
    std::vector<VariantImage> variants;
    const auto keep = [&](std::size_t, Row&& row, const std::vector<float>& visibility) {
        finished.emplace_back(std::move(row), visibility);
    };
    clock_.measure("methods", [&] {
        if (!options_.paired.empty()) {
            finished = pairedCells(frame, cellOptions, target);
            return;
        }
        if (options_.effectsTable)
            variants = runVariants(frame, cellOptions, pending.methods, target, keep);
        else
            runCells(frame, cellOptions, pending.methods, target, keep);
    });
    if (pending.separation)
        finished.emplace_back(separationRow(frame), separationImage(reference, frame.gbuffer));
    clock_.measure("metrics", [&] {
        const Scorer scorer(reference, frame.gbuffer, scene.edges);
        tbb::parallel_for_each(finished, [&](auto& cell) {
            auto& [row, visibility] = cell;
            if (row.status == "ok") row.metrics = scorer.score(visibility);
            // The separation's image has the reference's noise in it: errors of the two cancel.
            if (isSeparation(row)) row.metrics.rmseCorrected.reset();
        });
        tbb::parallel_for_each(variants, [&](VariantImage& variant) {
            if (!variant.visibility.empty())
                variant.cell.rmse = scorer.score(variant.visibility).rmse;
        });
    });
    for (VariantImage& variant : variants) effectsCells_.push_back(std::move(variant.cell));
    if (options_.effectsTable) writeEffectsCsv(folder_.effectsCsv(), effectsCells_);
    clock_.measure("images", [&] {
        tbb::parallel_for_each(finished, [&](const auto& cell) {
            const auto& [row, visibility] = cell;
            if (row.status == "ok")
                folder_.writeVisibility(scene.id, frame.index, row.setting, visibility, reference);
        });
    });
    for (auto& [row, visibility] : finished) {
        row.renderer = provenance_.renderer;
        row.threads = provenance_.threads;
        row.commit = provenance_.commit;
        row.shadeFetchesPerPixel = shadeFetchesPerPixel(row, record_.fetches);
        if (row.status != "ok") {
            failed_ += row.status == "failed";
            progress_.note(fmt::format("{} frame {}: {} {}: {}", scene.id, frame.index, row.setting,
                                       row.status, row.message));
        }
        csv_->add(row);
        done_.insert(row.key());
    }
}

Run::Finished Run::pairedCells(const Frame& frame, const CellOptions& options,
                               const TextureTarget& target) {
    const Setting &a = settings_.front(), &b = settings_.back();
    PairedResult result = measurePaired(frame, options, a, b, target);
    if (result.ok())
        pairs_.push_back({frame.scene.id, frame.index, a.name, b.name, std::move(result.pairs)});
    writePairedCsv(folder_.paired(), pairs_);
    Finished finished;
    finished.emplace_back(std::move(result.a), std::move(result.visibilityA));
    if (a.name != b.name) finished.emplace_back(std::move(result.b), std::move(result.visibilityB));
    return finished;
}

Reference Run::referenceFor(const Scene& scene, const Frame& frame) {
    const auto progress = [&](double fraction) {
        if (const int signal = Interruption::signal()) throw Interrupted(signal);
        progress_.within(fraction);
    };
    ObtainedReference obtained = obtainReference(scene, frame.index, frame.tracer, frame.gbuffer,
                                                 frame.light, options_, progress);
    for (const std::string& note : obtained.notes) progress_.note(note);
    if (options_.reference != "exact")
        obtained.stats.checked = certify(obtained.reference, frame.tracer, scene.materials,
                                         frame.gbuffer, frame.light, kCheckedPixels);
    std::erase_if(record_.references, [&](const ReferenceStats& s) {
        return s.scene == obtained.stats.scene && s.frame == obtained.stats.frame;
    });
    record_.references.push_back(obtained.stats);
    return std::move(obtained.reference);
}

}  // namespace

int compare(const CompareOptions& options) {
    const int threads = options.threadCount();
    const ThreadLimit limit(threads);

    if (options.resume && options.out.empty())
        throw InputError("--resume: name the run folder to continue with --out");
    requireCostMetric(options.curveMetric);
    if (options.effectsTable) requireEffectsTable(options);
    const auto start = std::chrono::steady_clock::now();
    std::vector<Setting> settings = settingsOf(options);
    LoadedScenes loaded = loadScenes(options);
    const double loadSeconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

    const auto context = gl::Context::create(options.context);
    const RunFolder folder = options.out.empty() ? RunFolder::makeNew() : RunFolder(options.out);
    Run run(options, folder, std::move(loaded), std::move(settings), *context, threads);
    run.clock().add("load", loadSeconds);
    run.clock().measure("self-test", [&] {
        const gl::ClockSelfTest test = gl::runClockSelfTest();
        run.record().fencedClockMs = test.fencedMs;
        run.record().queryClockMs = test.queryMs;
        run.record().timerQueriesTrusted = test.timerQueriesTrusted;
        run.record().fetches = measureFetchThroughput();
    });
    const Interruption interruption;
    run.openFolder();
    const int code = run.cells();
    if (options.effectsTable) fmt::print("{}", readTextFile(folder.effectsTable()));
    if (!options.paired.empty())
        for (const PairedFinding& f :
             pairedFindings(readPairedCsv(folder.paired()), readCsv(folder.results())))
            fmt::print("{}: {}\n", f.scene, f.sentence());
    if (!options.again)
        fmt::print("{}\n", std::filesystem::absolute(folder.root()).lexically_normal().string());
    return code;
}

}  // namespace penumbra
