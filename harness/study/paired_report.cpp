#include "harness/study/paired_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/error.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"

namespace penumbra {
namespace {

constexpr const char* kHeader = "scene,frame,a,b,pair,first,a_ms,b_ms,speedup\n";

/// Factors below this are told as "the same".
constexpr double kSameRmse = 5e-4;

std::optional<double> ratioOf(const std::optional<double>& a, const std::optional<double>& b) {
    if (!a || !b || !(*b > 0.0)) return std::nullopt;
    return *a / *b;
}

/// Of a setting over the frames of a scene that were paired.
std::optional<double> rmseOver(const std::vector<const PairedFrame*>& frames,
                               std::string PairedFrame::*setting, const std::vector<Row>& rows) {
    double squares = 0.0;
    for (const PairedFrame* frame : frames) {
        const auto row = std::ranges::find_if(rows, [&](const Row& r) {
            return r.scene == frame->scene && r.frame == frame->frame &&
                   r.setting == frame->*setting;
        });
        if (row == rows.end() || !row->metrics.rmse) return std::nullopt;
        squares += *row->metrics.rmse * *row->metrics.rmse;
    }
    return std::sqrt(squares / static_cast<double>(frames.size()));
}

std::string errorPart(const std::optional<double>& rmseRatio) {
    if (!rmseRatio) return "";
    const double change = *rmseRatio - 1.0;
    if (std::abs(change) < kSameRmse) return " at the same rmse";
    if (*rmseRatio >= 2.0) return fmt::format(" at {:.2f}x the rmse", *rmseRatio);
    return fmt::format(" at {:.1f} % {} rmse", 100.0 * std::abs(change),
                       change > 0.0 ? "higher" : "lower");
}

template <class Number>
bool parse(const std::string& text, Number& value) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && stop == end;
}

std::string code(const std::optional<double>& value) {
    return value ? fmt::format("{:.4f}", *value) : "";
}

}  // namespace

void writePairedCsv(const std::filesystem::path& path, const std::vector<PairedFrame>& frames) {
    std::string text = kHeader;
    for (const PairedFrame& f : frames)
        for (std::size_t i = 0; i < f.pairs.size(); ++i) {
            const PairSample& p = f.pairs[i];
            text += fmt::format("{},{},{},{},{},{},{},{},{}\n", csvQuoted(f.scene), f.frame,
                                csvQuoted(f.a), csvQuoted(f.b), i, p.aFirst ? "a" : "b", p.aMs,
                                p.bMs, p.bMs / p.aMs);
        }
    writeFileAtomically(path, text);
}

std::vector<PairedFrame> readPairedCsv(const std::filesystem::path& path) {
    const std::string text = readTextFile(path);
    if (!text.starts_with(kHeader))
        throw InputError(fmt::format("{}:1: expected the columns {}", path.string(), kHeader));
    std::vector<PairedFrame> frames;
    const CsvRecords records = splitCsv(text, path.string());
    for (std::size_t i = 1; i < records.complete.size(); ++i) {
        const auto& [line, fields] = records.complete[i];
        PairedFrame f;
        PairSample pair;
        if (fields.size() != 9 || !parse(fields[1], f.frame) || !parse(fields[6], pair.aMs) ||
            !parse(fields[7], pair.bMs) || !(pair.aMs > 0.0) || !(pair.bMs > 0.0) ||
            (fields[5] != "a" && fields[5] != "b"))
            throw InputError(fmt::format("{}:{}: no pair of frames", path.string(), line));
        pair.aFirst = fields[5] == "a";
        f.scene = fields[0], f.a = fields[2], f.b = fields[3];
        if (frames.empty() || frames.back().scene != f.scene || frames.back().frame != f.frame)
            frames.push_back(std::move(f));
        frames.back().pairs.push_back(pair);
    }
    return frames;
}

std::string PairedFinding::sentence() const {
    if (!interval)
        return fmt::format("A is {:.2f}x as fast as B{} ({} scenes are too few for an interval)",
                           speedup, errorPart(rmseRatio), frames);
    const PairedVerdict verdict = verdictOf(*interval);
    if (verdict == PairedVerdict::indistinguishable)
        return fmt::format("A and B are indistinguishable in time: {:.2f}x ({:.2f}-{:.2f}){}",
                           speedup, interval->low, interval->high, errorPart(rmseRatio));
    const bool faster = verdict == PairedVerdict::faster;
    return fmt::format("A is {:.2f}x ({:.2f}-{:.2f}) {} than B{}", faster ? speedup : 1.0 / speedup,
                       faster ? interval->low : 1.0 / interval->high,
                       faster ? interval->high : 1.0 / interval->low, faster ? "faster" : "slower",
                       errorPart(rmseRatio));
}

std::vector<PairedFinding> pairedFindings(const std::vector<PairedFrame>& frames,
                                          const std::vector<Row>& rows) {
    std::vector<std::string> scenes;
    for (const PairedFrame& frame : frames)
        if (std::ranges::find(scenes, frame.scene) == scenes.end()) scenes.push_back(frame.scene);

    std::vector<PairedFinding> findings;
    std::vector<double> speedups, rmseRatios;
    for (const std::string& scene : scenes) {
        std::vector<const PairedFrame*> ofScene;
        std::vector<PairSample> pairs;
        for (const PairedFrame& frame : frames)
            if (frame.scene == scene) {
                ofScene.push_back(&frame);
                pairs.insert(pairs.end(), frame.pairs.begin(), frame.pairs.end());
            }
        const PairedTiming timing = judgePairs(pairs);
        PairedFinding f{
            scene, ofScene.size(), pairs.size(), timing.speedup.median, timing.speedup, {}, {}, {}};
        f.rmseA = rmseOver(ofScene, &PairedFrame::a, rows);
        f.rmseB = rmseOver(ofScene, &PairedFrame::b, rows);
        f.rmseRatio = ratioOf(f.rmseA, f.rmseB);
        speedups.push_back(f.speedup);
        if (f.rmseRatio) rmseRatios.push_back(*f.rmseRatio);
        findings.push_back(std::move(f));
    }
    if (scenes.size() < 2) return findings;

    PairedFinding overall;
    overall.scene = "overall";
    overall.frames = scenes.size();
    for (const PairedFinding& f : findings) overall.pairs += f.pairs;
    // Of logarithms, so that neither of two settings is favoured by being called A.
    for (std::vector<double>* ratios : {&speedups, &rmseRatios})
        for (double& r : *ratios) r = std::log(r);
    overall.speedup = std::exp(median(speedups));
    if (!rmseRatios.empty()) overall.rmseRatio = std::exp(median(rmseRatios));
    if (speedups.size() >= kFewestForSignTest) {
        const MedianInterval logs = signTestInterval(speedups);
        overall.interval = {std::exp(logs.median), std::exp(logs.low), std::exp(logs.high)};
    }
    findings.push_back(std::move(overall));
    return findings;
}

std::string pairedMarkdown(const std::vector<PairedFrame>& frames, const std::vector<Row>& rows,
                           const std::vector<RunRecord::SettingEntry>& settings) {
    std::string out = "\n## A against B\n\n";
    if (frames.empty()) return out + "No frame was rendered by both settings.\n\n";
    const auto describe = [&](const char* letter, const std::string& name) {
        const auto at = std::ranges::find(settings, name, &RunRecord::SettingEntry::name);
        const std::string params = at == settings.end() ? "" : at->params;
        return fmt::format("- {}: `{}`{}\n", letter, name,
                           params.empty() ? "" : fmt::format(", `{}`", params));
    };
    out += describe("A", frames.front().a) + describe("B", frames.front().b) +
           "\nSpeedup: B's frame time over A's, median over pairs of frames timed one right after "
           "the other in random order, with the sign test's 95 % interval. Overall: median over "
           "scenes of their speedups, with the interval that the scenes leave it.\n\n"
           "| scene | pairs | speedup | low | high | rmse A | rmse B | |\n"
           "|:--|--:|--:|--:|--:|--:|--:|:--|\n";
    for (const PairedFinding& f : pairedFindings(frames, rows)) {
        std::string scene;
        for (const char c : f.scene) scene += c == '|' ? "\\|" : std::string(1, c);
        out += fmt::format("| {} | {} | {:.3f} | {} | {} | {} | {} | {} |\n", scene, f.pairs,
                           f.speedup, f.interval ? fmt::format("{:.3f}", f.interval->low) : "",
                           f.interval ? fmt::format("{:.3f}", f.interval->high) : "", code(f.rmseA),
                           code(f.rmseB), f.sentence());
    }
    return out + "\n";
}

}  // namespace penumbra
