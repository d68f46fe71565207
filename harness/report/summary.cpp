#include "harness/report/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

#include "harness/report/markdown.hpp"
#include "harness/report/summary_cost.hpp"
#include "harness/report/summary_effects.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/separation.hpp"

namespace penumbra {

using namespace markdown;

namespace {

std::string place(const Row& row) {
    return fmt::format("{}, frame {}, {}", escaped(row.scene), row.frame, escaped(row.setting));
}

// ---- sections --------------------------------------------------------------------------------

std::string provenance(const SummaryInput& input) {
    std::string out;
    for (const auto& [name, value] : input.provenance) {
        out += fmt::format("- {}: {}\n", escaped(name), escaped(value));
    }
    return out.empty() ? out : out + '\n';
}

/// `title` and one line per entry; long lists keep their first lines and the number of the others.
std::string warningList(std::string_view title, const std::vector<std::string>& entries) {
    constexpr std::size_t kMostShown = 20;
    if (entries.empty()) return {};
    std::string out = fmt::format("**{}: {}**\n\n", title, entries.size());
    for (std::size_t i = 0; i < std::min(entries.size(), kMostShown); ++i) {
        out += fmt::format("- {}\n", entries[i]);
    }
    if (entries.size() > kMostShown) {
        out += fmt::format("- … and {} more in results.csv\n", entries.size() - kMostShown);
    }
    return out + '\n';
}

std::string warnings(const SummaryInput& input) {
    std::vector<std::string> failed, unsupported, poisoned, unstable, missing, skipped;
    for (const Row& row : input.rows) {
        const std::string where = place(row);
        if (row.status == "unsupported") {
            unsupported.push_back(where + ": " + escaped(row.message));
        } else if (row.status != "ok") {
            failed.push_back(
                fmt::format("{}: {} {}", where, escaped(row.status), escaped(row.message)));
        }
        if (row.metrics.nonfinite > 0) {
            poisoned.push_back(fmt::format("{}: {} pixels", where, row.metrics.nonfinite));
        }
        if (row.unstable) {
            unstable.push_back(fmt::format("{}: {} ms [{}, {}]", where, number(row.frameMs),
                                           number(row.frameMsLow), number(row.frameMsHigh)));
        }
        if (!row.effectsMissing.empty()) {
            missing.push_back(where + ": " + escaped(row.effectsMissing));
        }
    }
    for (const auto& [scene, reason] : input.skippedScenes) {
        skipped.push_back(escaped(scene) + ": " + escaped(reason));
    }
    const std::string out = warningList("Failed cells", failed) +
                            warningList("Unsupported cells", unsupported) +
                            warningList("Skipped scenes", skipped) +
                            warningList("Pixels that are not finite", poisoned) +
                            warningList("Effects the scene calls for, beyond the method", missing) +
                            warningList("Unstable times", unstable);
    return "## Warnings\n\n" + (out.empty() ? "None.\n\n" : out);
}

struct Mean {
    double sum = 0;
    std::size_t n = 0;

    void add(const Number& value) {
        if (!value) return;
        sum += *value;
        ++n;
    }
    Number value() const { return n ? Number(sum / static_cast<double>(n)) : std::nullopt; }
};

struct Overview {
    std::string method, params;
    std::set<std::string> scenes;
    std::size_t cells = 0, good = 0;
    Mean rmse, rmsePenumbra, bias, leakRate, falseShadowRate, logRelativeTime, shadeFetches;
};

/// Times are comparable only within a scene, a frame and a renderer, and not where it is unknown.
using TimeGroup = std::tuple<std::string, int, std::string>;

TimeGroup timeGroup(const Row& row) {
    return {row.scene, row.frame, row.renderer};
}

bool isTimed(const Row& row) {
    return row.status == "ok" && row.frameMs && *row.frameMs > 0 &&
           row.renderer != kExternalRenderer;
}

std::map<TimeGroup, double> fastestTimes(const std::vector<Row>& rows) {
    std::map<TimeGroup, double> fastest;
    for (const Row& row : rows) {
        if (!isTimed(row)) continue;
        const auto [entry, isNew] = fastest.try_emplace(timeGroup(row), *row.frameMs);
        if (!isNew) entry->second = std::min(entry->second, *row.frameMs);
    }
    return fastest;
}

std::string overview(const SummaryInput& input) {
    const std::map<TimeGroup, double> fastest = fastestTimes(input.rows);
    std::map<std::string, Overview> settings;
    std::vector<std::string> order;
    for (const Row& row : input.rows) {
        if (isSeparation(row)) continue;
        const auto [entry, isNew] = settings.try_emplace(row.setting);
        if (isNew) order.push_back(row.setting);
        Overview& o = entry->second;
        o.method = row.method;
        o.params = row.params;
        ++o.cells;
        if (row.status != "ok") continue;
        ++o.good;
        o.scenes.insert(row.scene);
        o.rmse.add(row.metrics.rmse);
        o.rmsePenumbra.add(row.metrics.rmsePenumbra);
        o.bias.add(row.metrics.bias);
        o.leakRate.add(row.metrics.leakRate);
        o.falseShadowRate.add(row.metrics.falseShadowRate);
        o.shadeFetches.add(row.shadeFetchesPerPixel);
        if (isTimed(row)) {
            o.logRelativeTime.add(std::log(*row.frameMs / fastest.at(timeGroup(row))));
        }
    }
    if (order.empty()) return {};
    std::stable_sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
        return settings[a].rmse.value().value_or(HUGE_VAL) <
               settings[b].rmse.value().value_or(HUGE_VAL);
    });

    std::vector<Cells> lines;
    for (const std::string& name : order) {
        const Overview& o = settings[name];
        const Number logTime = o.logRelativeTime.value();
        lines.push_back(
            {escaped(name), name == o.method ? "" : escaped(o.params),
             fmt::format("{}", o.scenes.size()), fmt::format("{}/{}", o.good, o.cells),
             number(o.rmse.value()), number(o.rmsePenumbra.value()), number(o.bias.value()),
             percent(o.leakRate.value()), percent(o.falseShadowRate.value()),
             logTime ? number(std::exp(*logTime)) : "", number(o.shadeFetches.value())});
    }
    return "## Settings over all scenes\n\n"
           "Means over good cells, best rmse first. Time is the geometric mean of the frame time "
           "over that of the fastest setting in the same scene and frame. A setting with fewer "
           "good cells was averaged over other scenes: compare it in the scenes' own tables. Shade "
           "fetches / pixel: so many bare nearest fetches would take this machine as long as "
           "shading "
           "does.\n\n" +
           table({"setting", "parameters", "scenes", "good cells", "rmse", "rmse penumbra", "bias",
                  "leak rate", "false shadow rate", "time / fastest", "shade fetches / pixel"},
                 2, lines);
}

std::string withError(const Number& value, const Number& error) {
    return error && value ? number(value) + " ± " + number(error) : number(value);
}

std::string withInterval(const Row& row) {
    if (!row.frameMs || !row.frameMsLow || !row.frameMsHigh) return number(row.frameMs);
    return fmt::format("{} [{}, {}]{}", number(row.frameMs), number(row.frameMsLow),
                       number(row.frameMsHigh), row.unstable ? " unstable" : "");
}

std::string scenes(const SummaryInput& input) {
    std::map<std::string, std::vector<const Row*>> byScene;
    for (const Row& row : input.rows)
        if (!isSeparation(row)) byScene[row.scene].push_back(&row);
    if (byScene.empty()) return {};

    std::string out =
        "## Scenes\n\nrmse ± the reference's own standard error in penumbrae; errors of V, above 0 "
        "in bias is leaked light. Times in ms: median [95 % interval].\n\n";
    for (auto& [scene, rows] : byScene) {
        // Rows were measured in random order.
        std::sort(rows.begin(), rows.end(), [](const Row* a, const Row* b) {
            return std::tie(a->frame, a->method, a->setting) <
                   std::tie(b->frame, b->method, b->setting);
        });
        std::vector<Cells> lines;
        for (const Row* row : rows) {
            const Metrics& m = row->metrics;
            lines.push_back({fmt::format("{}", row->frame), escaped(row->setting),
                             escaped(row->status), withError(m.rmse, m.referenceSe),
                             number(m.rmsePenumbra), number(m.bias), number(m.p99),
                             number(m.maxError), percent(m.leakRate), percent(m.falseShadowRate),
                             withInterval(*row), number(row->buildMs), number(row->shadeMs),
                             whole(row->maps), whole(row->drawCalls)});
        }
        out += fmt::format("### {}\n\n", escaped(scene)) +
               table({"frame", "setting", "status", "rmse ± reference SE", "rmse penumbra", "bias",
                      "p99", "max", "leak rate", "false shadow rate", "frame ms", "build ms",
                      "shade ms", "maps", "draw calls"},
                     3, lines);
    }
    return out;
}

/// The method whose rmse over `frames` of a scene is least, of those that have all of them.
std::optional<std::pair<std::string, double>> bestMethod(const std::vector<Row>& rows,
                                                         const std::string& scene,
                                                         const std::set<int>& frames) {
    std::map<std::string, Mean> settings;
    for (const Row& row : rows)
        if (row.scene == scene && !isSeparation(row) && row.status == "ok" &&
            frames.contains(row.frame))
            settings[row.setting].add(row.metrics.rmse);
    std::optional<std::pair<std::string, double>> best;
    for (const auto& [setting, rmse] : settings)
        if (rmse.n == frames.size() && (!best || *rmse.value() < best->second))
            best = {setting, *rmse.value()};
    return best;
}

std::string separation(const SummaryInput& input) {
    struct Cost {
        std::set<int> frames;
        Mean rmse, rmsePenumbra, p99, bias;
        Number maxError;
    };
    std::map<std::string, Cost> scenes;
    for (const Row& row : input.rows) {
        if (!isSeparation(row) || !row.metrics.rmse) continue;
        Cost& cost = scenes[row.scene];
        cost.frames.insert(row.frame);
        cost.rmse.add(row.metrics.rmse);
        cost.rmsePenumbra.add(row.metrics.rmsePenumbra);
        cost.p99.add(row.metrics.p99);
        cost.bias.add(row.metrics.bias);
        cost.maxError = std::max(cost.maxError, row.metrics.maxError);
    }
    if (scenes.empty()) return {};
    std::vector<Cells> lines;
    for (const auto& [scene, cost] : scenes) {
        const Number rmse = cost.rmse.value();
        const auto best = bestMethod(input.rows, scene, cost.frames);
        lines.push_back({escaped(scene), fmt::format("{}", cost.frames.size()), number(rmse),
                         number(cost.rmsePenumbra.value()), number(cost.p99.value()),
                         number(cost.maxError), number(cost.bias.value()),
                         best ? escaped(best->first) : "",
                         best ? percent(ratio(*rmse, best->second)) : ""});
    }
    return "## What separating shading from visibility costs\n\n"
           "Every method multiplies the unshadowed irradiance by V; in truth visibility is inside "
           "the light integral. Error: coupled over unshadowed irradiance, less V. Above 0 in bias "
           "the truth is brighter than the product. Means over a scene's frames, of max the "
           "largest. The share is of the least rmse that a method has against V: at 100 % the "
           "product itself is as wrong as the best V in it.\n\n" +
           table({"scene", "frames", "rmse", "rmse penumbra", "p99", "max", "bias", "best method",
                  "share of its rmse"},
                 1, lines);
}

std::string shadowEdges(const SummaryInput& input) {
    std::vector<const Row*> rows;
    for (const Row& row : input.rows)
        if (row.metrics.penumbraWidthError) rows.push_back(&row);
    if (rows.empty()) return {};
    std::ranges::stable_sort(rows, {}, [](const Row* row) {
        return std::tie(row->scene, row->frame, row->method, row->setting);
    });
    std::vector<Cells> lines;
    for (const Row* row : rows)
        lines.push_back({escaped(row->scene), fmt::format("{}", row->frame), escaped(row->setting),
                         percent(row->metrics.penumbraWidthError),
                         percent(row->metrics.penumbraShift)});
    return "## Penumbrae on straight edges\n\n"
           "In shares of the reference's penumbra width, means over a scene's edges. Width: above "
           "0 too wide, -100 % a hard shadow. Shift: above 0 the shadow is too large.\n\n" +
           table({"scene", "frame", "setting", "width error", "centre shift"}, 3, lines);
}

/// Spent rays over those of uniform sampling, where the latter are known.
Number adaptiveRatio(const std::vector<ReferenceStats>& references) {
    double spent = 0, uniform = 0;
    for (const ReferenceStats& r : references) {
        if (!(r.uniformEquivalentRays > 0)) continue;
        spent += r.rays;
        uniform += r.uniformEquivalentRays;
    }
    return ratio(spent, uniform);
}

std::string references(const SummaryInput& input) {
    if (input.references.empty()) return {};
    std::vector<Cells> lines;
    for (const ReferenceStats& r : input.references) {
        // Seconds of a cached reference are those of loading it: no rate.
        const Number rate = r.cached ? std::nullopt : ratio(r.rays, r.seconds);
        lines.push_back({escaped(r.scene), fmt::format("{}", r.frame),
                         r.cached ? "cached" : "traced", count(r.rays), rate ? count(*rate) : "",
                         seconds(r.seconds),
                         percent(ratio(static_cast<double>(r.penumbraPixels),
                                       static_cast<double>(r.scoredPixels))),
                         number(adaptiveRatio({r}))});
    }
    return "## References\n\nAdaptive / uniform: rays spent over the rays that the same count for "
           "every pixel would have spent at the same worst standard error.\n\n" +
           table({"scene", "frame", "source", "rays", "rays/s", "time", "penumbra pixels",
                  "adaptive / uniform"},
                 3, lines);
}

std::string certification(const SummaryInput& input) {
    std::vector<Cells> lines;
    Certificate all;
    const auto cells = [](const std::string& scene, const std::string& frame,
                          const Certificate& c) {
        return Cells{scene,
                     frame,
                     fmt::format("{}", c.pixels),
                     fmt::format("{:.1f} %", 100.0 * c.coverage()),
                     number(c.rmse()),
                     number(std::sqrt(c.meanSquare())),
                     number(c.worst)};
    };
    for (const ReferenceStats& r : input.references) {
        if (r.checked.pixels == 0) continue;
        lines.push_back(cells(escaped(r.scene), fmt::format("{}", r.frame), r.checked));
        all.add(r.checked);
    }
    if (lines.empty()) return {};
    lines.push_back(cells("all", "", all));
    const bool sound = all.coverage() >= Certificate::kLeastCoverage &&
                       all.coverage() <= Certificate::kMostCoverage;
    return "## Is the reference right?\n\nA sample of its penumbra pixels against exact visibility "
           "(scenes with alpha-masked casters have none). Coverage: the share of pixels whose 95 % "
           "interval holds the exact value; 93 to 99 % over the run is right. Standardised: root "
           "mean square of error over standard error; " +
           number(std::sqrt(Certificate::kMeanSquare)) + " is expected of 16 replicates.\n\n" +
           table({"scene", "frame", "pixels", "coverage", "rmse", "standardised", "worst"}, 2,
                 lines) +
           (sound ? "" : "**The error bars of the reference are wrong in this run.**\n\n");
}

std::string phases(const SummaryInput& input) {
    if (input.phases.empty()) return {};
    double total = 0, overhead = 0;
    for (const PhaseTime& phase : input.phases) {
        total += phase.seconds;
        const bool work =
            phase.name == "reference" || phase.name == "methods" || phase.name == "images";
        if (!work) overhead += phase.seconds;
    }
    std::vector<Cells> lines;
    for (const PhaseTime& phase : input.phases) {
        lines.push_back(
            {escaped(phase.name), seconds(phase.seconds), percent(ratio(phase.seconds, total))});
    }
    lines.push_back({"total", seconds(total), ""});
    return "## Where the time went\n\n" + table({"phase", "time", "share"}, 1, lines) +
           fmt::format("Outside reference, methods and images: {} of the run.\n\n",
                       percent(ratio(overhead, total)));
}

std::string ratios(const SummaryInput& input) {
    double rays = 0, time = 0;
    for (const ReferenceStats& r : input.references) {
        if (r.cached) continue;
        rays += r.rays;
        time += r.seconds;
    }
    std::string out;
    if (const Number rate = ratio(rays, time)) {
        out += fmt::format("- Reference rays per second over the run: {}\n", count(*rate));
    }
    if (const Number adaptive = adaptiveRatio(input.references)) {
        out += fmt::format("- Reference rays, adaptive / uniform, over the run: {}\n",
                           number(adaptive));
    }
    return out;
}

}  // namespace

std::string summaryMarkdown(const SummaryInput& input) {
    return fmt::format("# {}\n\n", escaped(input.title)) + provenance(input) + warnings(input) +
           overview(input) + costMarkdown(input.studies, input.costMetric) + scenes(input) +
           shadowEdges(input) + effectsMarkdown(input.analysis) + capabilityMarkdown(input.rows) +
           separation(input) + references(input) + certification(input) + phases(input) +
           ratios(input);
}

}  // namespace penumbra
