#include "harness/study/pareto.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "core/error.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/separation.hpp"

namespace penumbra {
namespace {

/// Times of different renderers are no more comparable than those of different frames.
using Place = std::tuple<std::string, int, std::string>;

Place placeOf(const Row& row) {
    return {row.scene, row.frame, row.renderer};
}

struct Sample {
    double error, ms, lowMs, highMs;
};
using Samples = std::map<Place, Sample>;

struct Subject {
    std::string method, params;
    Samples samples;
};
using Subjects = std::map<std::string, Subject>;  ///< by setting

const std::set<std::string_view>& signedMetrics() {
    static const std::set<std::string_view> kSigned = {"bias", "penumbra_width_error",
                                                       "penumbra_shift"};
    return kSigned;
}

std::optional<double> errorOf(const Row& row, const std::string& metric) {
    const std::optional<double> value = numberInColumn(row, metric);
    if (!value) return std::nullopt;
    if (metric == "ssim") return 1.0 - *value;
    return signedMetrics().contains(metric) ? std::abs(*value) : *value;
}

bool isTimed(const Row& row) {
    return row.status == "ok" && !isSeparation(row) && row.renderer != kExternalRenderer &&
           row.frameMs && *row.frameMs > 0.0;
}

Subjects subjectsOf(const std::vector<Row>& rows, const std::string& metric) {
    Subjects subjects;
    for (const Row& row : rows) {
        const std::optional<double> error = errorOf(row, metric);
        if (!isTimed(row) || !error) continue;
        Subject& subject = subjects[row.setting];
        subject.method = row.method;
        subject.params = row.params;
        subject.samples[placeOf(row)] = {*error, *row.frameMs,
                                         row.frameMsLow.value_or(*row.frameMs),
                                         row.frameMsHigh.value_or(*row.frameMs)};
    }
    return subjects;
}

/// `samples` at the places of `at`, all of which it has.
CostPoint aggregate(const Samples& samples, const Samples& at, bool suite) {
    CostPoint point;
    std::set<std::string> scenes;
    for (const auto& [place, ignored] : at) {
        const Sample& s = samples.at(place);
        point.error += suite ? s.error * s.error : s.error;
        point.ms += s.ms;
        point.lowMs += s.lowMs;
        point.highMs += s.highMs;
        scenes.insert(std::get<0>(place));
    }
    const auto n = static_cast<double>(at.size());
    point.error = suite ? std::sqrt(point.error / n) : point.error / n;
    point.ms /= n;
    point.lowMs /= n;
    point.highMs /= n;
    point.frames = at.size();
    point.scenes = scenes.size();
    return point;
}

/// Whether `fast` takes less time than `slow` over the frames of `at`, beyond what noise explains:
/// the lower 95 % bound of the difference of the two means is above 0. Zou & Donner 2008
/// ("Construction of confidence limits about effect measures: a general approach", Statistics in
/// Medicine 27), equation 3, applied to a sum: the distances of the values that take part from the
/// ends of their own intervals that lie towards no difference, added in squares.
bool surelyFaster(const Samples& fast, const Samples& slow, const Samples& at) {
    double difference = 0.0, square = 0.0;
    for (const auto& [place, ignored] : at) {
        const Sample &f = fast.at(place), &s = slow.at(place);
        difference += s.ms - f.ms;
        square += (s.ms - s.lowMs) * (s.ms - s.lowMs) + (f.highMs - f.ms) * (f.highMs - f.ms);
    }
    return difference > std::sqrt(square);
}

bool keepsOffTheFront(const Samples& other, const Samples& own, bool suite) {
    const double error = aggregate(own, own, suite).error,
                 otherError = aggregate(other, own, suite).error;
    if (otherError == error) return surelyFaster(other, own, own);
    return otherError < error && !surelyFaster(own, other, own);
}

bool hasAllOf(const Samples& samples, const Samples& at) {
    return std::ranges::includes(samples, at, {}, &Samples::value_type::first,
                                 &Samples::value_type::first);
}

std::optional<double> floorAt(const Row& row, const std::string& metric) {
    const Metrics& m = row.metrics;
    if (metric == "rmse_penumbra") return m.referenceSe;
    // rmse_corrected 0 says only that the noise is no less than rmse.
    if (metric != "rmse" || !m.rmse || m.rmseCorrected.value_or(0.0) == 0.0) return std::nullopt;
    return std::sqrt(std::max(0.0, *m.rmse * *m.rmse - *m.rmseCorrected * *m.rmseCorrected));
}

/// As the errors are aggregated, over the frames where the rows tell.
std::optional<double> floorOf(const std::vector<Row>& rows, const std::string& metric,
                              const std::function<bool(const Place&)>& within, bool suite) {
    // Every row of a frame tells the same but for rounding, which is least where rmse is.
    std::map<Place, std::pair<double, double>> floors;  // rmse, floor
    for (const Row& row : rows) {
        const auto floor = floorAt(row, metric);
        if (!floor || !within(placeOf(row))) continue;
        const std::pair here{row.metrics.rmse.value_or(0.0), *floor};
        const auto [at, isNew] = floors.emplace(placeOf(row), here);
        if (!isNew) at->second = std::min(at->second, here);
    }
    if (floors.empty()) return std::nullopt;
    double sum = 0.0;
    for (const auto& [place, floor] : floors)
        sum += suite ? floor.second * floor.second : floor.second;
    sum /= static_cast<double>(floors.size());
    return suite ? std::sqrt(sum) : sum;
}

CostStudy studyOf(const Subjects& subjects, const std::string& name, bool suite) {
    CostStudy study;
    study.scene = name;
    std::set<Place> places;
    std::set<std::string> scenes;
    for (const auto& [setting, subject] : subjects)
        for (const auto& [place, sample] : subject.samples) {
            places.insert(place);
            scenes.insert(std::get<0>(place));
        }
    study.frames = places.size();
    study.scenes = scenes.size();
    for (const auto& [setting, subject] : subjects) {
        CostPoint point = aggregate(subject.samples, subject.samples, suite);
        point.method = subject.method;
        point.setting = setting;
        point.params = subject.params;
        point.onFront = std::ranges::none_of(subjects, [&](const auto& entry) {
            const Samples& others = entry.second.samples;
            return entry.first != setting && hasAllOf(others, subject.samples) &&
                   keepsOffTheFront(others, subject.samples, suite);
        });
        study.points.push_back(std::move(point));
    }
    std::ranges::sort(study.points, {}, [](const CostPoint& p) {
        return std::tie(p.method, p.ms, p.error, p.setting);
    });
    return study;
}

const std::vector<std::string_view>& costMetrics() {
    static const auto kMetrics = [] {
        std::vector<std::string_view> ids;
        for (const MetricInfo& metric : allMetrics())
            if (metric.unit != "pixels" && metric.id != "reference_se") ids.push_back(metric.id);
        return ids;
    }();
    return kMetrics;
}

}  // namespace

bool hasCurve(const std::vector<Row>& rows) {
    std::map<std::string, std::string> settingOf;
    return std::ranges::any_of(rows, [&](const Row& row) {
        return isTimed(row) &&
               settingOf.emplace(row.method, row.setting).first->second != row.setting;
    });
}

std::vector<CostStudy> costStudies(const std::vector<Row>& rows, const std::string& metric) {
    requireCostMetric(metric);
    const Subjects all = subjectsOf(rows, metric);
    std::map<std::string, Subjects> byScene;
    for (const auto& [setting, subject] : all)
        for (const auto& [place, sample] : subject.samples) {
            Subject& part = byScene[std::get<0>(place)][setting];
            part.method = subject.method;
            part.params = subject.params;
            part.samples.emplace(place, sample);
        }
    std::vector<CostStudy> studies;
    for (const auto& [scene, subjects] : byScene) {
        studies.push_back(studyOf(subjects, scene, false));
        studies.back().floor = floorOf(
            rows, metric, [&scene](const Place& place) { return std::get<0>(place) == scene; },
            false);
    }
    if (byScene.size() > 1) {
        studies.push_back(studyOf(all, std::string(kWholeSuite), true));
        studies.back().floor = floorOf(
            rows, metric, [](const Place&) { return true; }, true);
    }
    return studies;
}

void requireCostMetric(const std::string& metric) {
    if (std::ranges::find(costMetrics(), metric) == costMetrics().end())
        throw InputError(fmt::format("--curve-metric {}: expected one of {}", metric,
                                     fmt::join(costMetrics(), ", ")));
}

std::string errorName(const std::string& metric) {
    if (metric == "ssim") return "1 - ssim";
    return signedMetrics().contains(metric) ? "|" + metric + "|" : metric;
}

const CostPoint* cheapestReaching(const CostStudy& study, double error, const std::string& method) {
    const CostPoint* best = nullptr;
    for (const CostPoint& p : study.points)
        if (study.covers(p) && p.error <= error && (method.empty() || p.method == method) &&
            (!best || std::tie(p.ms, p.error) < std::tie(best->ms, best->error)))
            best = &p;
    return best;
}

const CostPoint* bestWithin(const CostStudy& study, double ms) {
    const CostPoint* best = nullptr;
    for (const CostPoint& p : study.points)
        if (study.covers(p) && p.ms <= ms &&
            (!best || std::tie(p.error, p.ms) < std::tie(best->error, best->ms)))
            best = &p;
    return best;
}

const CostPoint* costUnit(const CostStudy& study) {
    const CostPoint* unit = nullptr;
    for (const CostPoint& p : study.points) {
        if (!study.covers(p) || p.method != kCostUnit) continue;
        if (p.setting == kCostUnit) return &p;
        if (!unit || p.ms < unit->ms) unit = &p;
    }
    return unit;
}

std::string paretoCsv(const std::vector<CostStudy>& studies, const std::string& metric) {
    std::string text =
        "scene,method,setting,params,metric,error,frame_ms,frame_ms_low,frame_ms_high,on_front,"
        "frames,frames_of,scenes,scenes_of\n";
    for (const CostStudy& study : studies)
        for (const CostPoint& p : study.points)
            text +=
                fmt::format("{},{},{},{},{},{},{},{},{},{:d},{},{},{},{}\n", csvQuoted(study.scene),
                            csvQuoted(p.method), csvQuoted(p.setting), csvQuoted(p.params),
                            csvQuoted(errorName(metric)), p.error, p.ms, p.lowMs, p.highMs,
                            p.onFront, p.frames, study.frames, p.scenes, study.scenes);
    return text;
}

}  // namespace penumbra
