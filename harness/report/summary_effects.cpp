#include "harness/report/summary_effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "harness/report/markdown.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {

using namespace markdown;

namespace {

/// Frames of one scene, one after another, about which the same was found out.
struct Alike {
    const EffectsRecord* first;
    int last;

    std::string frames() const {
        return first->frame == last ? fmt::format("{}", last)
                                    : fmt::format("{} to {}", first->frame, last);
    }
};

/// Scene by scene as they come, frames in order, whatever order they ran in.
std::vector<EffectsRecord> ordered(std::vector<EffectsRecord> records) {
    std::vector<std::string> scenes;
    for (const EffectsRecord& r : records)
        if (std::ranges::find(scenes, r.scene) == scenes.end()) scenes.push_back(r.scene);
    std::ranges::stable_sort(records, {}, [&](const EffectsRecord& r) {
        return std::pair(std::ranges::find(scenes, r.scene) - scenes.begin(), r.frame);
    });
    return records;
}

std::vector<Alike> alike(const std::vector<EffectsRecord>& records) {
    std::vector<Alike> groups;
    for (const EffectsRecord& r : records) {
        if (!groups.empty() && groups.back().first->scene == r.scene &&
            groups.back().last + 1 == r.frame && groups.back().first->findings == r.findings)
            groups.back().last = r.frame;
        else
            groups.push_back({&r, r.frame});
    }
    return groups;
}

std::string evidence(const std::vector<EffectsRecord>& records) {
    std::vector<Cells> lines;
    for (const Alike& group : alike(records))
        for (const EffectInfo& info : allEffects()) {
            const EffectFinding& finding = group.first->findings[info.effect];
            lines.push_back({escaped(group.first->scene), group.frames(), std::string(info.id),
                             finding.calledFor ? "yes" : "no", escaped(finding.evidence)});
        }
    return "<details><summary>What each scene calls for, and why</summary>\n\n" +
           table({"scene", "frames", "effect", "called for", "evidence"}, 5, lines) +
           "</details>\n\n";
}

std::string cost(const std::vector<EffectsRecord>& records) {
    std::vector<Cells> lines;
    double load = 0.0, analysis = 0.0;
    for (const EffectsRecord& r : records) {
        lines.push_back({escaped(r.scene), fmt::format("{}", r.frame), number(r.loadMs),
                         number(r.analysisMs), percent(ratio(r.analysisMs, r.loadMs))});
        load += r.loadMs;
        analysis += r.analysisMs;
    }
    lines.push_back({"all", "", number(load), number(analysis), percent(ratio(analysis, load))});
    return "<details><summary>What analysis took</summary>\n\nLoad: reading the asset (in the "
           "first frame), geometry, BVH, upload and G-buffer.\n\n" +
           table({"scene", "frame", "load ms", "analysis ms", "share"}, 1, lines) +
           "</details>\n\n";
}

}  // namespace

std::string effectsMarkdown(const std::vector<EffectsRecord>& unordered) {
    if (unordered.empty()) return {};
    const std::vector<EffectsRecord> records = ordered(unordered);
    std::vector<Cells> lines;
    for (const Alike& group : alike(records)) {
        const std::string called = group.first->findings.calledFor().text();
        lines.push_back({escaped(group.first->scene), group.frames(),
                         called.empty() ? "nothing" : escaped(called)});
    }
    return "## Effects\n\n" + table({"scene", "frames", "called for"}, 3, lines) +
           evidence(records) + cost(records);
}

std::string capabilityMarkdown(const std::vector<Row>& rows) {
    std::set<std::string> used;
    for (const Row& row : rows) used.insert(row.method);
    Cells header = {"method"};
    for (const EffectInfo& info : allEffects()) header.emplace_back(info.id);
    std::vector<Cells> lines;
    for (const MethodInfo& method : methodRegistry()) {
        if (!used.contains(method.id)) continue;
        const EffectSet simulates = method.make()->traits().simulates;
        Cells line = {escaped(method.id)};
        for (const EffectInfo& info : allEffects())
            line.emplace_back(simulates.has(info.effect) ? "yes" : "**no**");
        lines.push_back(std::move(line));
    }
    if (lines.empty()) return {};
    return "## What methods can simulate\n\n" + table(header, header.size(), lines);
}

}  // namespace penumbra
