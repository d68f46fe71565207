#include "harness/study/reproduce.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <tuple>

#include "core/error.hpp"
#include "core/sampling/sampling.hpp"
#include "harness/metrics/edge_scan.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/report/report.hpp"
#include "harness/run/files.hpp"
#include "harness/run/folder_lock.hpp"
#include "harness/run/progress.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/settings.hpp"
#include "harness/run/statistics.hpp"
#include "harness/run/thread_limit.hpp"
#include "harness/study/study_frame.hpp"

namespace penumbra {
namespace {

/// A number that is known to within a standard error; 0 for counts.
struct Estimate {
    double value = 0.0, standardError = 0.0;
};

/// a / b from independent estimates; the interval is that of the ratio's logarithm.
Interval ratioOf(const Estimate& a, const Estimate& b) {
    if (b.value == 0.0) return Interval::exact(std::numeric_limits<double>::infinity());
    const double ratio = a.value / b.value;
    if (ratio == 0.0) return Interval::exact(0.0);
    const double relative = 1.96 * std::hypot(a.standardError / a.value, b.standardError / b.value);
    return {ratio, ratio * std::exp(-relative), ratio * std::exp(relative)};
}

double timeOf(const std::string& metric, const SettingRun::Sample& sample) {
    return metric == "build_ms"   ? sample.buildMs
           : metric == "shade_ms" ? sample.shadeMs
                                  : sample.buildMs + sample.shadeMs;
}

/// Mean width of the scene's edges that the frame shows in both image and truth.
std::optional<double> penumbraWidthM(std::span<const float> visibility, const Frame& frame,
                                     const Reference& reference) {
    double sum = 0.0;
    int count = 0;
    for (const ShadowEdge& edge : frame.scene.edges) {
        const EdgeScan scan = scanEdge(edge, frame.gbuffer);
        if (!scan.measured(reference.visibility)) continue;
        const auto profile = scan.measured(visibility);
        if (!profile) return std::nullopt;
        sum += profile->widthM;
        ++count;
    }
    return count ? std::optional(sum / count) : std::nullopt;
}

/// Measures claims one after another.
class Measurement {
  public:
    explicit Measurement(const ReproduceOptions& options)
        : options_(options), library_(SceneLibrary::standard()) {}

    /// Fills in all but what comes from the paper. Throws what cannot be measured.
    void measure(ClaimResult& result) {
        const Claim& claim = result.claim;
        if (isTime(claim.metric))
            measureTimes(result);
        else
            measureOnce(result);
        result.verdict = judge(claim.expected, *result.ratio);
    }
    /// Drops the frames; those of one paper are often the same.
    void forgetFrames() { frames_.clear(); }

  private:
    const StudyFrame& frameOf(const ClaimSide& side) {
        const Place place{side.scene, side.frame, side.variation};
        auto& frame = frames_[place];
        if (!frame) {
            const auto scene = varied(loadScene(side.scene, library_), side.variation);
            if (side.frame >= scene->frameCount())
                throw InputError(fmt::format("scene '{}' has no frame {}", scene->id, side.frame));
            frame = std::make_unique<StudyFrame>(scene, side.frame, options_.width, options_.height,
                                                 options_.seed);
        }
        return *frame;
    }

    /// As measurePaired does, one side right after the other in an order drawn anew, but over two
    /// frames, and of the part of the time that the claim is about.
    void measureTimes(ClaimResult& result) {
        const Claim& claim = result.claim;
        const StudyFrame& frameA = frameOf(claim.a);
        const StudyFrame& frameB = frameOf(claim.b);
        const Setting settingA = parseSetting("a", claim.a.setting),
                      settingB = parseSetting("b", claim.b.setting);
        SettingRun a(settingA), b(settingB);
        frameA.warmUp(a);
        frameB.warmUp(b);
        std::vector<double> timesA, timesB, ratios;
        const auto timeA = [&] {
            timesA.push_back(timeOf(claim.metric, a.timed(frameA.frame(), frameA.target())));
        };
        const auto timeB = [&] {
            timesB.push_back(timeOf(claim.metric, b.timed(frameB.frame(), frameB.target())));
        };
        for (int pair = 0; pair < options_.pairs; ++pair) {
            const bool aFirst = hash(options_.seed, static_cast<std::uint32_t>(pair)) & 1;
            if (aFirst) timeA();
            timeB();
            if (!aFirst) timeA();
            ratios.push_back(timesA.back() / timesB.back());
        }
        const MedianInterval ratio = signTestInterval(std::move(ratios));
        result.a = median(std::move(timesA));
        result.b = median(std::move(timesB));
        result.ratio = {ratio.median, ratio.low, ratio.high};
    }

    void measureOnce(ClaimResult& result) {
        const Estimate a = estimate(result.claim.a, result.claim.metric),
                       b = estimate(result.claim.b, result.claim.metric);
        result.a = a.value;
        result.b = b.value;
        if (a.value == 0.0 && b.value == 0.0)
            throw std::runtime_error(fmt::format("{} is 0 on both sides", result.claim.metric));
        result.ratio = ratioOf(a, b);
    }

    Estimate estimate(const ClaimSide& side, const std::string& metric) {
        const StudyFrame& staged = frameOf(side);
        const Frame& frame = staged.frame();
        if (side.setting == kTruth)
            return known(penumbraWidthM(staged.reference(options_).visibility, frame,
                                        staged.reference(options_)),
                         side, metric);
        const Setting setting = parseSetting("setting", side.setting);
        SettingRun run(setting);
        Row row = staged.warmUp(run);
        Estimate out;
        if (isOfImage(metric)) {
            const Reference& reference = staged.reference(options_);
            if (metric == "penumbra_width")
                return known(penumbraWidthM(run.visibility(), frame, reference), side, metric);
            row.metrics =
                Scorer(reference, frame.gbuffer, frame.scene.edges).score(run.visibility());
            if (metric == "rmse" || metric == "rmse_corrected")
                out.standardError = rmseStandardError(run.visibility(), reference, frame.gbuffer);
        }
        const nlohmann::json value = nlohmann::json::parse(toJson(row))[metric];
        out.value =
            known(value.is_null() ? std::nullopt : std::optional(value.get<double>()), side, metric)
                .value;
        return out;
    }

    /// Signed metrics are compared by magnitude.
    static Estimate known(const std::optional<double>& value, const ClaimSide& side,
                          const std::string& metric) {
        if (!value)
            throw std::runtime_error(
                fmt::format("{} on {} has no {}", side.setting, side.scene, metric));
        return {std::abs(*value), 0.0};
    }

    using Place = std::tuple<std::string, int, Variation>;
    const ReproduceOptions& options_;
    SceneLibrary library_;
    std::map<Place, std::unique_ptr<StudyFrame>> frames_;
};

std::vector<Paper> chosenPapers(const ReproduceOptions& options) {
    std::vector<Paper> papers = loadPapers(
        options.claims.empty() ? SceneLibrary::standard().scripts / "papers" : options.claims);
    if (options.paper.empty()) return papers;
    std::vector<std::string> ids;
    for (Paper& paper : papers) {
        if (paper.id == options.paper) return {std::move(paper)};
        ids.push_back(paper.id);
    }
    throw InputError(
        fmt::format("unknown paper '{}'; the papers are {}", options.paper, fmt::join(ids, ", ")));
}

/// What the page says of the machine, taken before anything is measured.
std::vector<std::string> headingOf(const ReproduceOptions& options, const gl::Context& context) {
    const Provenance from = gatherProvenance(context, options.threadCount());
    double load = 0.0;
    getloadavg(&load, 1);
    return {
        "# Claims",
        "",
        fmt::format("The papers' claims as ratios measured here, by `{}`.", options.command),
        fmt::format("A ratio of times is the median of {} interleaved pairs, in brackets its 95 % "
                    "interval; a ratio of",
                    options.pairs),
        "rmse has the interval that the reference's standard error leaves; counts and rates have "
        "none. A verdict",
        "is computed from the interval: *holds* if all of it agrees with the claim, *does not "
        "hold* if none of it does.",
        "",
        fmt::format("{}, {}, {} threads, {}x{}, commit {}, {}. Load when it began: {:.1f} on {} "
                    "processors.",
                    from.cpu, from.renderer, from.threads, options.width, options.height,
                    from.commit, from.started, load, std::thread::hardware_concurrency()),
    };
}

}  // namespace

double rmseStandardError(std::span<const float> visibility, const Reference& reference,
                         const GBuffer& gbuffer) {
    double squares = 0.0, variance = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored || !std::isfinite(visibility[i])) continue;
        ++count;
        const double truth = reference.visibility[i], d = visibility[i] - truth;
        squares += d * d;
        if (truth <= 0.0 || truth >= 1.0) continue;
        const double s2 = std::pow(reference.standardError[i], 2);
        variance += 4.0 * d * d * s2 + 2.0 * s2 * s2;
    }
    // d sqrt(m) = dm / (2 sqrt(m)) with m = squares / count
    return squares > 0.0 ? std::sqrt(variance) / (2.0 * std::sqrt(squares * double(count))) : 0.0;
}

int reproduce(const ReproduceOptions& options) {
    const std::vector<Paper> papers = chosenPapers(options);
    const ThreadLimit limit(options.threadCount());
    const auto context = gl::Context::create(options.context);
    const RunFolder folder = options.out.empty() ? RunFolder::makeNew() : RunFolder(options.out);
    folder.create();
    const FolderLock lock(folder.root());
    const std::vector<std::string> heading = headingOf(options, *context);

    std::size_t total = 0;
    for (const Paper& paper : papers) total += paper.claims.size();
    ProgressLine progress(total);
    std::vector<ClaimResult> results;
    bool someCouldNot = false;
    Measurement measurement(options);
    for (const Paper& paper : papers) {
        for (const Claim& claim : paper.claims) {
            ClaimResult result;
            result.paper = paper.id;
            result.citation = paper.citation;
            result.claim = claim;
            progress.step(results.size(), paper.id + " " + claim.id);
            if (!claim.technique.empty()) {
                result.verdict = Verdict::not_implemented;
            } else {
                try {
                    measurement.measure(result);
                } catch (const std::exception& e) {
                    gl::takeErrors();
                    result.message = e.what();
                    someCouldNot = true;
                    progress.note(
                        fmt::format("{} {}: could not run: {}", paper.id, claim.id, e.what()));
                }
            }
            results.push_back(std::move(result));
        }
        measurement.forgetFrames();
    }

    const std::string page = claimsMarkdown(results, heading);
    writeFileAtomically(folder.root() / "claims.csv", claimsCsv(results));
    writeFileAtomically(folder.root() / "claims.md", page);
    if (std::filesystem::exists(folder.summary())) writeArtefacts(folder);
    fmt::print(
        "{}",
        options.markdown
            ? page
            : fmt::format("{}{}\n", claimsText(results),
                          std::filesystem::absolute(folder.root()).lexically_normal().string()));
    return someCouldNot ? 3 : 0;
}

}  // namespace penumbra
