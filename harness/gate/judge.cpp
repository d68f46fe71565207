#include "harness/gate/judge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "core/error.hpp"
#include "harness/gate/reference_noise.hpp"
#include "harness/report/markdown.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/run_folder.hpp"

namespace penumbra::gate {
namespace {

constexpr double kWithoutNumber = std::numeric_limits<double>::infinity();

std::string shown(const std::optional<double>& value) {
    return value ? fmt::format("{:.4g}", *value) : "none";
}

std::set<std::string> words(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), {}};
}

std::string listed(const std::vector<std::string>& names) {
    return fmt::format("{}", fmt::join(names, ", "));
}

bool contains(const std::vector<std::string>& list, std::string_view name) {
    return std::ranges::find(list, name) != list.end();
}

class Judge {
  public:
    Judge(const Baseline& baseline, const JudgedRun& run, const Thresholds& thresholds)
        : baseline_(baseline), run_(run), thresholds_(thresholds), machine_(machineOf(run.record)) {
        for (std::size_t i = 0; i < run.table.rows.size(); ++i)
            runRows_[run.table.rows[i].key()] = i;
        for (const ReferenceStats& stats : run.record.references)
            penumbraPixels_[{stats.scene, stats.frame}] = stats.penumbraPixels;
        for (const GatedMetric& metric : gatedMetrics())
            if (!contains(baseline.table.absent, metric.id) &&
                !contains(run.table.absent, metric.id))
                metrics_.push_back(&metric);
    }

    Verdict judge() {
        noteColumns(baseline_.file.string(), baseline_.table);
        noteColumns(RunFolder(run_.folder).results().string(), run_.table);
        std::set<std::string> known;
        for (std::size_t i = 0; i < baseline_.table.rows.size(); ++i) {
            const Row& before = baseline_.table.rows[i];
            known.insert(before.key());
            const auto at = runRows_.find(before.key());
            if (at == runRows_.end())
                judgeMissing(before);
            else
                judgeRow(before, baseline_.machines[i], baseline_.table.lines[i],
                         run_.table.rows[at->second], run_.table.lines[at->second]);
        }
        for (const Row& row : run_.table.rows)
            if (!known.contains(row.key())) judgeAdded(row);
        for (const auto& [why, rows] : uncompared_)
            verdict_.notes.push_back(fmt::format("{} rows: {}", rows, why));
        return std::move(verdict_);
    }

  private:
    void noteColumns(const std::string& file, const ResultsTable& table) {
        if (!table.absent.empty())
            verdict_.notes.push_back(
                fmt::format("{} lacks columns of this version, which are not compared: {}", file,
                            listed(table.absent)));
        std::vector<std::string> names;
        for (const auto& [name, fields] : table.unknown) names.push_back(name);
        if (!names.empty())
            verdict_.notes.push_back(
                fmt::format("{} has columns that this version does not know, which are ignored: {}",
                            file, listed(names)));
    }

    Gate& add(const Row& row, Kind kind) {
        Gate gate;
        gate.row = row;
        gate.kind = kind;
        return verdict_.gates.emplace_back(std::move(gate));
    }

    void judgeMissing(const Row& before) {
        Gate& gate = add(before, Kind::row);
        const Threshold rule = thresholds_.of(kRow, before);
        gate.state = rule.ignored ? State::missingKnown : State::missing;
        std::string why = "the run has no such row";
        for (const auto& [scene, reason] : run_.record.skippedScenes)
            if (scene == before.scene) why = fmt::format("the run skipped the scene: {}", reason);
        gate.note = rule.ignored ? fmt::format("{} (may vanish: {})", why, rule.reason) : why;
        if (!rule.ignored)
            gate.findings.push_back({std::string(kRow), "vanished: " + why,
                                     "every row of the baseline is measured again",
                                     kWithoutNumber});
    }

    void judgeAdded(const Row& row) {
        Gate& gate = add(row, Kind::row);
        gate.state = State::added;
        gate.note = "new: the baseline has no such row";
        if (row.status == "failed") failStatus(gate, "nothing", row);
    }

    static void failStatus(Gate& gate, const std::string& before, const Row& row) {
        gate.state = State::failed;
        gate.findings.push_back({"status",
                                 fmt::format("{} -> {}: {}", before, row.status, row.message),
                                 "a cell that could be measured still can", kWithoutNumber});
    }

    void judgeRow(const Row& before, const std::string& machine, std::size_t lineBefore,
                  const Row& row, std::size_t line) {
        refuseOtherSize(before, lineBefore, row, line);
        Gate& gate = add(row, Kind::row);
        if (row.status == "failed" || (before.status == "ok" && row.status != "ok"))
            failStatus(gate, before.status, row);
        if (before.status != "ok" || row.status != "ok") {
            if (row.status == "ok") gate.note = before.status + " in the baseline, ok now";
            return;
        }
        const bool sameRenderer = before.renderer == row.renderer;
        judgeMetrics(Kind::accuracy, before, row);
        if (timesCompare(before, machine, row)) judgeTime(before, row);
        if (sameRenderer)
            judgeMetrics(Kind::work, before, row);
        else
            ++uncompared_["work is not compared between different renderers"];
        if (!contains(baseline_.table.absent, kEffectsMissing) &&
            !contains(run_.table.absent, kEffectsMissing))
            judgeEffects(before, row);
    }

    void refuseOtherSize(const Row& before, std::size_t lineBefore, const Row& row,
                         std::size_t line) const {
        if (contains(baseline_.table.absent, "width") || contains(run_.table.absent, "width"))
            return;
        if (before.width == row.width && before.height == row.height) return;
        throw InputError(fmt::format(
            "{}:{}: the image is {}x{}, that of {}:{} is {}x{}; make the run with --size {}x{}",
            RunFolder(run_.folder).results().string(), line, row.width, row.height,
            baseline_.file.string(), lineBefore, before.width, before.height, before.width,
            before.height));
    }

    /// Counts why not, where the answer is no.
    bool timesCompare(const Row& before, const std::string& machine, const Row& row) {
        const auto no = [&](std::string why) {
            ++uncompared_["time is not compared: " + std::move(why)];
            return false;
        };
        // Rows that are never timed, the separation and images from outside, are no news.
        if (!before.frameMs || contains(run_.table.absent, "frame_ms")) return false;
        if (row.renderer == kExternalRenderer || before.renderer == kExternalRenderer) return false;
        if (contains(baseline_.table.absent, "renderer") ||
            contains(baseline_.table.absent, "threads") || machine.empty() || machine_.empty())
            return no("the baseline does not say on which machine it was measured");
        if (before.renderer != row.renderer)
            return no(fmt::format("the baseline's renderer is {}, the run's {}", before.renderer,
                                  row.renderer));
        if (before.threads != row.threads)
            return no(fmt::format("the baseline used {} threads, the run {}", before.threads,
                                  row.threads));
        if (machine != machine_)
            return no(fmt::format("the baseline's machine is {}, the run's {}", machine, machine_));
        if (!before.frameMsLow || !before.frameMsHigh) return no("the baseline has no intervals");
        return true;
    }

    void judgeTime(const Row& before, const Row& row) {
        Gate& gate = add(row, Kind::time);
        const GatedMetric& metric = **std::ranges::find(metrics_, Kind::time, &GatedMetric::kind);
        const Threshold threshold = thresholds_.of(metric, row);
        if (threshold.ignored) return;
        if (!row.frameMs || !row.frameMsLow || !row.frameMsHigh) {
            failValue(gate, metric, *before.frameMs);
            return;
        }
        const double a = *before.frameMs, b = *row.frameMs;
        if (a > 0.0) verdict_.timeRatios.push_back(b / a);
        const double limit = std::max(threshold.relative * a, threshold.absolute);
        const bool slower = *row.frameMsLow > *before.frameMsHigh;
        const bool faster = *row.frameMsHigh < *before.frameMsLow;
        if (faster && a - b > limit) ++verdict_.improvements;
        if (!slower || !(b - a > limit)) return;
        gate.state = State::failed;
        gate.findings.push_back(
            {std::string(metric.id),
             fmt::format("{} [{}, {}] -> {} [{}, {}] ms ({})", shown(a), shown(before.frameMsLow),
                         shown(before.frameMsHigh), shown(b), shown(row.frameMsLow),
                         shown(row.frameMsHigh), relativeChange(a, b)),
             fmt::format("allowed +{:.4g} ms beside overlapping intervals ({})", limit,
                         threshold.reason),
             limit > 0.0 ? (b - a) / limit : kWithoutNumber});
    }

    void judgeMetrics(Kind kind, const Row& before, const Row& row) {
        Gate& gate = add(row, kind);
        const auto pixels = penumbraPixels_.find({row.scene, row.frame});
        const std::size_t penumbra = pixels == penumbraPixels_.end() ? 0 : pixels->second;
        // One reference for both: what its image has in penumbra hardly differs between versions.
        const ReferenceNoise noiseBefore = ReferenceNoise::of(before, penumbra);
        const ReferenceNoise noise = ReferenceNoise::of(row, penumbra);
        const bool firstOfFrame =
            kind == Kind::accuracy && framesJudged_.emplace(row.scene, row.frame).second;
        for (const GatedMetric* metric : metrics_) {
            if (metric->kind != kind || (metric->ofFrame && !firstOfFrame)) continue;
            judgeMetric(gate, *metric, numberInColumn(before, metric->id),
                        numberInColumn(row, metric->id), noiseBefore, noise);
        }
        std::ranges::stable_sort(gate.findings, std::greater{}, &Finding::severity);
        if (!gate.findings.empty()) gate.state = State::failed;
    }

    void judgeMetric(Gate& gate, const GatedMetric& metric, const std::optional<double>& before,
                     const std::optional<double>& after, const ReferenceNoise& noiseBefore,
                     const ReferenceNoise& noise) {
        const Threshold threshold = thresholds_.of(metric, gate.row);
        if (threshold.ignored || !before) return;
        if (!after) {
            failValue(gate, metric, *before);
            return;
        }
        const double allowed =
            std::max(threshold.relative * scaleOf(metric, *before), threshold.absolute);
        const double explained = explainedByNoise(metric.noise, *before, noiseBefore, noise);
        const double limit = std::max(allowed, explained);
        const double worse = worsening(metric, *before, *after);
        if (metric.better != Better::unchanged && -worse > limit) ++verdict_.improvements;
        if (!(worse > limit)) return;
        std::string limits = fmt::format("allowed {:.3g} ({})", allowed, threshold.reason);
        if (metric.noise != Noise::none)
            limits += fmt::format("; the references' noise explains {:.3g}", explained);
        gate.findings.push_back({std::string(metric.id),
                                 fmt::format("{} -> {} ({})", shown(before), shown(after),
                                             relativeChange(*before, *after)),
                                 limits, limit > 0.0 ? worse / limit : kWithoutNumber});
    }

    static void failValue(Gate& gate, const GatedMetric& metric, double before) {
        gate.state = State::failed;
        gate.findings.push_back({std::string(metric.id), shown(before) + " -> none",
                                 "a value that could be measured still can", kWithoutNumber});
    }

    void judgeEffects(const Row& before, const Row& row) {
        Gate& gate = add(row, Kind::effects);
        if (thresholds_.of(kEffectsMissing, row).ignored) return;
        const std::set<std::string> known = words(before.effectsMissing);
        std::vector<std::string> missing;
        for (const std::string& effect : words(row.effectsMissing))
            if (!known.contains(effect)) missing.push_back(effect);
        if (missing.empty()) return;
        gate.state = State::failed;
        gate.findings.push_back({std::string(kEffectsMissing),
                                 fmt::format("no longer simulated: {}", listed(missing)),
                                 "what a method could simulate it still can", kWithoutNumber});
    }

    static std::string relativeChange(double before, double after) {
        if (before == 0.0) return fmt::format("{:+.3g}", after);
        const double percent = 100.0 * (after / before - 1.0);
        if (before < 0.0 || after < 0.0 || std::abs(percent) >= 1000.0)
            return fmt::format("{:+.3g}", after - before);
        return fmt::format("{:+.3g} %", percent);
    }

    const Baseline& baseline_;
    const JudgedRun& run_;
    const Thresholds& thresholds_;
    const std::string machine_;
    std::map<std::string, std::size_t> runRows_;
    std::map<std::pair<std::string, int>, std::size_t> penumbraPixels_;
    std::vector<const GatedMetric*> metrics_;
    std::set<std::pair<std::string, int>> framesJudged_;
    std::map<std::string, std::size_t> uncompared_;  ///< why, of how many rows
    Verdict verdict_;
};

}  // namespace

JudgedRun JudgedRun::read(const std::filesystem::path& folder) {
    const RunFolder run(folder);
    JudgedRun judged{folder, RunRecord::read(run.record()), readResultsTable(run.results())};
    if (!judged.record.finished)
        throw InputError(
            fmt::format("{}: the run is not finished; continue it with --resume", folder.string()));
    return judged;
}

std::string Gate::place() const {
    return fmt::format("{} frame {} {}", row.scene, row.frame, row.setting);
}

std::size_t Verdict::count(State state) const {
    return static_cast<std::size_t>(std::ranges::count(gates, state, &Gate::state));
}

bool Verdict::fails() const {
    return std::ranges::any_of(gates, &Gate::fails);
}

Verdict judge(const Baseline& baseline, const JudgedRun& run, const Thresholds& thresholds) {
    return Judge(baseline, run, thresholds).judge();
}

}  // namespace penumbra::gate
