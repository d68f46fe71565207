#include "harness/study/tune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/progress.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/thread_limit.hpp"
#include "harness/study/tuning_stage.hpp"

namespace penumbra {
namespace {

/// Side of the small image over the full one's: a sixteenth of the pixels, but of a small image a
/// quarter, and no side below 64 where the full one has that.
int smallSide(int full) {
    const int part = full > 256 ? full / 4 : full / 2;
    return std::min(full, std::max(64, part));
}

std::string spelledRow(const Row& row) {
    return spelled(parseSetting("tune", row.method + (row.params.empty() ? "" : ":") + row.params));
}

std::string times(const Row& row) {
    return fmt::format("{:.2f} ms ({:.2f}-{:.2f})", *row.frameMs, *row.frameMsLow,
                       *row.frameMsHigh);
}

std::string csv(const TuneResult& result, const TuneGoal& goal) {
    std::string text =
        "order,phase,method,setting,params,width,height,status,message,rmse,frame_ms,frame_ms_low,"
        "frame_ms_high,repeats,meets\n";
    const auto number = [](const std::optional<double>& v) {
        return v ? fmt::format("{}", *v) : std::string();
    };
    for (std::size_t i = 0; i < result.trials.size(); ++i) {
        const auto& [phase, r] = result.trials[i];
        const bool known = r.metrics.rmse && r.frameMs;
        text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", i, phase, r.method,
                            r.setting, csvQuoted(r.params), r.width, r.height, r.status,
                            csvQuoted(r.message), number(r.metrics.rmse), number(r.frameMs),
                            number(r.frameMsLow), number(r.frameMsHigh), r.repeats,
                            known ? (goal.meets(*r.metrics.rmse, *r.frameMs) ? "1" : "0") : "");
    }
    return text;
}

/// One line per method: how many settings were tried and the best one at the greatest size tried.
void printTried(const TuneResult& result, const TuneGoal& goal,
                const std::vector<std::string>& methods) {
    fmt::print("{:<24}{:>6}  {:>8}{:>10}{:>10}  {}\n", "method", "tried", "rmse", "ms", "size",
               "its best setting");
    for (const std::string& method : methods) {
        std::vector<std::string> names;
        const Row* best = nullptr;
        const auto rank = [&](const Row& r) {
            return std::pair(-r.width, goal.merit(*r.metrics.rmse, *r.frameMs));
        };
        for (const TuneTrial& t : result.trials) {
            if (t.row.method != method) continue;
            if (std::ranges::find(names, t.row.setting) == names.end())
                names.push_back(t.row.setting);
            if (!t.row.metrics.rmse || !t.row.frameMs) continue;
            // Measured twice at one size, the later measurement had more repeats.
            if (!best || rank(t.row) < rank(*best) || t.row.setting == best->setting) best = &t.row;
        }
        if (best)
            fmt::print("{:<24}{:>6}  {:>8.5f}{:>10.2f}{:>10}  {}{}\n", method, names.size(),
                       *best->metrics.rmse, *best->frameMs,
                       fmt::format("{}x{}", best->width, best->height), spelledRow(*best),
                       goal.meets(*best->metrics.rmse, *best->frameMs) ? "" : "  (misses)");
        else
            fmt::print("{:<24}{:>6}  cannot render this frame\n", method, names.size());
    }
}

void printBest(const TuneOptions& o, const TuneGoal& goal, const Row& best) {
    const Setting setting = parseSetting("tune", spelledRow(best));
    const double over = o.maxMs ? *best.frameMs / *o.maxMs : *best.metrics.rmse / *o.maxRmse;
    fmt::print("\n{}: rmse {:.5f}, {}, {:.1f} % below {}{}\n", spelled(setting), *best.metrics.rmse,
               times(best), 100.0 * (1.0 - over), goal.text(),
               o.maxMs && *best.frameMsHigh > *o.maxMs
                   ? "; the interval of the time reaches over it"
                   : "");
    std::string line = fmt::format("penumbra compare --scene {} --method {}", o.scene, best.method);
    for (const auto& [parameter, value] : setting.assignments)
        line += fmt::format(" --set {}.{}={}", best.method, parameter, value);
    line += fmt::format(" --size {}x{} --seed {}", o.width, o.height, o.seed);
    fmt::print("{}\n", line);
}

}  // namespace

std::string TuneGoal::text() const {
    return maxMs ? fmt::format("{} ms", *maxMs) : fmt::format("rmse {}", *maxRmse);
}

int tune(const TuneOptions& o) {
    const TuneGoal goal{o.maxRmse, o.maxMs};
    std::vector<std::string> methods;
    for (const std::string& id : o.methods) {
        findMethod(id);
        if (std::ranges::find(methods, id) == methods.end()) methods.push_back(id);
    }
    if (o.methods.empty())
        for (const MethodInfo& info : methodRegistry()) methods.push_back(info.id);
    const auto scene = loadForFrame(o.scene, o.frame, o);
    const std::filesystem::path table = o.out / "tune.csv";
    if (!o.out.empty() && std::filesystem::exists(table))
        throw InputError(fmt::format("--out {}: holds a tune.csv already", o.out.string()));

    const int threads = o.threadCount();
    const ThreadLimit limit(threads);
    const auto context = gl::Context::create(o.context);
    const Provenance here = gatherProvenance(*context, threads);
    const std::string machine = here.renderer + "\n" + here.glVersion + "\n" + here.cpu;

    TuneResult result;
    {
        ProgressLine progress(2);
        progress.step(0, "references");
        const TuningStage small(scene, o.frame, smallSide(o.width), smallSide(o.height), o, machine,
                                o.remeasure);
        const TuningStage full(scene, o.frame, o.width, o.height, o, machine, o.remeasure,
                               [&](double fraction) { progress.within(fraction); });
        progress.step(1, "settings");
        result =
            searchSettings(methods, goal, full.pixels() / small.pixels(), o.seed, o.againstLadders,
                           [&](bool fullSize, const std::vector<Setting>& settings, int repeats) {
                               return (fullSize ? full : small).measure(settings, repeats);
                           });
    }
    if (!o.out.empty()) {
        std::error_code error;
        std::filesystem::create_directories(o.out, error);
        if (error) throw InputError(fmt::format("--out {}: {}", o.out.string(), error.message()));
        writeFileAtomically(table, csv(result, goal));
    }
    if (!result.best) {
        fmt::print(stderr, "penumbra: no setting reaches {}{}\n", goal.text(),
                   result.nearest
                       ? fmt::format(", the best found is {} with rmse {:.5f} and {}",
                                     spelledRow(*result.nearest), *result.nearest->metrics.rmse,
                                     times(*result.nearest))
                       : ": no method can render this frame");
        return 1;
    }
    printTried(result, goal, methods);
    printBest(o, goal, *result.best);
    if (o.againstLadders && !result.ladderBest)
        fmt::print("ladders: none of their settings meets it\n");
    if (result.ladderBest)
        fmt::print(
            "ladders: the best is {}, rmse {:.5f}, {}; beside it the found setting: rmse "
            "{:.5f}, {}; at least as good: {}\n",
            spelledRow(*result.ladderBest), *result.ladderBest->metrics.rmse,
            times(*result.ladderBest), *result.besideLadder->metrics.rmse,
            times(*result.besideLadder), result.atLeastAsGood ? "yes" : "no");
    return 0;
}

}  // namespace penumbra
