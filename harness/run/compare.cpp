#include "harness/run/compare.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for_each.h>

#include <chrono>
#include <map>
#include <set>

#include "core/error.hpp"
#include "harness/reference/certificate.hpp"
#include "harness/reference/exact.hpp"
#include "harness/report/report.hpp"
#include "harness/run/cells.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/fill_flicker.hpp"
#include "harness/run/progress.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"
#include "harness/run/scene_stage.hpp"
#include "harness/run/separation.hpp"
#include "harness/run/suite.hpp"
#include "harness/run/thread_limit.hpp"
#include "harness/study/effects_table.hpp"
#include "harness/study/paired_report.hpp"

namespace penumbra {
namespace {

/// Penumbra pixels of a frame whose reference is checked against exact visibility: enough for a
/// coverage known to 1 %, few enough to cost next to nothing.
constexpr std::size_t kCheckedPixels = 500;

/// Where the time of a run goes.
class PhaseClock {
  public:
    template <class Work>
    auto measure(const std::string& phase, const Work& work) {
        struct Guard {
            double& total;
            std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
            ~Guard() {
                total +=
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            }
        } guard{seconds_[phase]};
        return work();
    }
    void add(const std::string& phase, double seconds) { seconds_[phase] += seconds; }
    std::vector<PhaseTime> phases() const {
        std::vector<PhaseTime> list;
        for (const auto& [name, seconds] : seconds_) list.push_back({name, seconds});
        return list;
    }

  private:
    std::map<std::string, double> seconds_;
};

struct LoadedScenes {
    std::vector<std::shared_ptr<const Scene>> scenes;
    std::map<std::string, double> milliseconds;  ///< that reading them took, by id
    std::vector<std::pair<std::string, std::string>> skipped;
};

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

/// A and B of `--paired`, or one where they are the same.
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

std::vector<Setting> settingsOf(const CompareOptions& options) {
    if (!options.paired.empty()) return pairedSettings(options);
    if (!options.again) return expandSettings(options.settings);
    std::vector<Setting> settings;
    for (const std::string& text : options.again->settings)
        settings.push_back(parseSetting("setting", text));
    return settings;
}

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
    /// Runs every cell that has no row yet. Returns the exit code.
    int cells();

  private:
    std::size_t countFrames() const;
    void writeRecord(bool finished);
    void runScene(std::size_t sceneIndex);
    void recordEffects(SceneStage& stage, double loadMs);
    void runFrame(SceneStage& stage, const Pending& pending);
    using Finished = std::vector<std::pair<Row, std::vector<float>>>;
    Finished pairedCells(const Frame& frame, const CellOptions& options,
                         const TextureTarget& target);
    Reference referenceFor(const Scene& scene, const Frame& frame);
    bool mine(std::size_t cell) const {
        return cell % static_cast<std::size_t>(options_.shards) ==
               static_cast<std::size_t>(options_.shard - 1);
    }

    const CompareOptions& options_;
    RunFolder folder_;
    LoadedScenes loaded_;
    std::vector<Setting> settings_;
    Provenance provenance_;
    ProgressLine progress_;
    PhaseClock clock_;
    RunRecord record_;
    std::set<std::string> done_;  ///< Row::key of finished cells
    std::unique_ptr<CsvAppender> csv_;
    std::vector<PairedFrame> pairs_;
    std::vector<EffectsCell> effectsCells_;
    std::size_t framesDone_ = 0, cellsBefore_ = 0;
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

/// What a kill left of files that were being written beside their names.
void removeTornFiles(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> torn;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".tmp") torn.push_back(entry.path());
    for (const auto& path : torn) std::filesystem::remove(path);
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

    const bool used = std::filesystem::exists(folder_.results());
    if (used && !options_.resume)
        throw InputError(
            fmt::format("--out {}: holds a run already; continue it with --resume or "
                        "choose another folder",
                        folder_.root().string()));
    if (used) {
        const RunRecord before = RunRecord::read(folder_.record());
        if (before.width != record_.width || before.height != record_.height ||
            before.seed != record_.seed || before.reference != record_.reference ||
            before.referenceSe != record_.referenceSe || before.effects != record_.effects ||
            before.assetScene != record_.assetScene || before.camera != record_.camera)
            throw InputError(fmt::format(
                "--resume {}: the run there has --size {}x{} --seed {} --reference {} "
                "--reference-se {} --effects '{}' --asset-scene '{}' --camera '{}'; a "
                "resumed run must have the same",
                folder_.root().string(), before.width, before.height, before.seed, before.reference,
                before.referenceSe, before.effects, before.assetScene, before.camera));
        record_.references = before.references;
        record_.analysis = before.analysis;
        removeTornFiles(folder_.root());
        // Failed cells are tried again, so their rows go; the file is replaced in one step.
        std::string kept = csvHeader() + "\n";
        for (const Row& row : readCsv(folder_.results())) {
            if (row.status == "failed") continue;
            done_.insert(row.key());
            kept += toCsv(row) + "\n";
        }
        writeFileAtomically(folder_.results(), kept);
    }
    folder_.create();
    writeRecord(false);  // before the first row: rows without a record could not be resumed
    csv_ = std::make_unique<CsvAppender>(folder_.results());
}

void Run::writeRecord(bool finished) {
    record_.finished = finished;
    record_.phases = clock_.phases();
    record_.write(folder_.record());
}

int Run::cells() {
    for (const auto& [scene, reason] : loaded_.skipped) progress_.note(reason);
    for (std::size_t i = 0; i < loaded_.scenes.size(); ++i) runScene(i);
    csv_.reset();
    clock_.measure("metrics", [&] { fillFlicker(folder_); });
    orderRows(folder_, record_);
    writeRecord(true);
    clock_.measure("images", [&] { writeArtefacts(folder_); });
    writeRecord(true);
    writeSummary(folder_);
    if (!options_.again) appendToStepSummary(readTextFile(folder_.summary()));
    return failed_ ? 3 : 0;
}

void Run::runScene(std::size_t sceneIndex) {
    const Scene& scene = *loaded_.scenes[sceneIndex];
    for (const std::string& choice : scene.chosen)
        progress_.note(fmt::format("{}: {}", scene.id, choice));
    std::vector<SettingRun> runs(settings_.begin(), settings_.end());
    std::unique_ptr<SceneStage> stage;  // made for the first frame that has something to do

    for (int index = 0; index < scene.frameCount(); ++index, ++framesDone_) {
        Pending pending;
        for (SettingRun& run : runs) {
            Row cell;
            cell.scene = scene.id;
            cell.frame = index;
            cell.setting = run.setting().name;
            if (!mine(cellsBefore_++) || done_.contains(cell.key())) continue;
            if (options_.again && !options_.again->keys.contains(cell.key())) continue;
            if (run.setting().isSeparation())
                pending.separation = true;
            else
                pending.methods.push_back(&run);
        }
        if (pending.methods.empty() && !pending.separation) continue;
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
    ObtainedReference obtained =
        obtainReference(scene, frame.index, frame.tracer, frame.gbuffer, frame.light, options_,
                        [&](double fraction) { progress_.within(fraction); });
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
    RunFolder folder(options.out.empty() ? resultsFolder() / utcNow("%Y%m%d-%H%M%S") : options.out);
    Run run(options, folder, std::move(loaded), std::move(settings), *context, threads);
    run.clock().add("load", loadSeconds);
    run.clock().measure("self-test", [&] {
        const gl::ClockSelfTest test = gl::runClockSelfTest();
        run.record().fencedClockMs = test.fencedMs;
        run.record().queryClockMs = test.queryMs;
        run.record().timerQueriesTrusted = test.timerQueriesTrusted;
        run.record().fetches = measureFetchThroughput();
    });
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
