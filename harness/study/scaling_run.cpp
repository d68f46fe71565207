// What a scaling study measures and writes; the statistics are in scaling.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <thread>

#include "core/error.hpp"
#include "core/sampling/sampling.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/folder_lock.hpp"
#include "harness/run/progress.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/suite.hpp"
#include "harness/run/thread_limit.hpp"
#include "harness/study/curve.hpp"
#include "harness/study/scaling.hpp"
#include "harness/study/study_frame.hpp"
#include "harness/study/varied_scene.hpp"

namespace penumbra {
namespace {

/// One setting at one x.
struct Point {
    double x = 0.0;
    const StudyFrame* frame = nullptr;
    Setting setting;
    std::string status = "ok", message;
    std::vector<SettingRun::Sample> samples;  ///< one per round
};

/// One setting along the axis on one scene.
struct Series {
    std::string scene;
    Setting setting;
    std::vector<Point> points;     ///< none where not applicable
    std::vector<const Point*> ok;  ///< those that were measured
    std::optional<Growth> frame, build, shade;
};

struct Staged {
    double x = 0.0;
    std::unique_ptr<StudyFrame> frame;
};

bool variesSetting(ScalingAxis axis) {
    return axis == ScalingAxis::map_size || axis == ScalingAxis::slices;
}

/// The frames along the axis; one, at x = 0, where it is the setting that varies.
std::vector<Staged> stage(const std::shared_ptr<const Scene>& scene, const CompareOptions& o,
                          ScalingAxis axis) {
    std::vector<Staged> list;
    const auto add = [&](double x, const std::shared_ptr<const Scene>& of, int width, int height) {
        list.push_back({x, std::make_unique<StudyFrame>(of, 0, width, height, o.seed)});
    };
    if (axis == ScalingAxis::triangles) {
        std::size_t count = scene->frame(0).geometry->triangleCount();
        for (int times = 0; times < 4 && count <= kMostTriangles; ++times, count *= 4)
            add(static_cast<double>(count), varied(scene, {.subdivisions = times}), o.width,
                o.height);
    } else if (axis == ScalingAxis::pixels) {
        for (const double scale : {0.25, 0.5, 1.0, 2.0}) {
            const auto side = [&](int full) {
                return std::max(1, static_cast<int>(std::lround(full * scale)));
            };
            const int width = side(o.width), height = side(o.height);
            add(static_cast<double>(width) * height, scene, width, height);
        }
    } else if (axis == ScalingAxis::light_size) {
        for (const double scale : {0.25, 0.5, 1.0, 2.0})
            add(scale, varied(scene, {.lightScale = scale}), o.width, o.height);
    } else {
        add(0.0, scene, o.width, o.height);
    }
    return list;
}

/// A quarter, half, once and twice what `setting` has, as far as the parameter's range goes; none
/// where the method has no such parameter.
std::vector<Point> withParameter(const Setting& setting, const std::string& id,
                                 const StudyFrame& frame) {
    const auto method = setting.make();
    const auto& list = method->parameters();
    const auto known =
        std::ranges::find_if(list, [&](const Parameter* p) { return p->id() == id; });
    if (known == list.end()) return {};
    SettingChoice choice;
    choice.methods = {setting.method};
    for (const auto& [parameter, value] : setting.assignments)
        choice.sets.push_back(fmt::format("{}.{}={}", setting.method, parameter, value));
    choice.sets.emplace_back();
    std::vector<Point> points;
    for (const double factor : {0.25, 0.5, 1.0, 2.0}) {
        const int value = static_cast<int>(std::lround((*known)->number() * factor));
        choice.sets.back() = fmt::format("{}.{}={}", setting.method, id, value);
        try {
            Point point;
            point.x = value;
            point.frame = &frame;
            point.setting = expandSettings(choice).front();
            points.push_back(std::move(point));
        } catch (const InputError&) {  // beyond the range
        }
    }
    return points;
}

std::vector<Point> pointsOf(const Setting& setting, const std::vector<Staged>& frames,
                            ScalingAxis axis) {
    if (variesSetting(axis)) return withParameter(setting, nameOf(axis), *frames.front().frame);
    std::vector<Point> points;
    for (const Staged& staged : frames) {
        Point point;
        point.x = staged.x;
        point.frame = staged.frame.get();
        point.setting = setting;
        points.push_back(std::move(point));
    }
    return points;
}

/// Times all points of a series, in rounds. A point that throws says so and drops out.
void measure(Series& series, const CompareOptions& o) {
    std::vector<std::unique_ptr<SettingRun>> runs;
    const auto guarded = [](Point& point, const auto& work) {
        try {
            work();
        } catch (const std::exception& e) {
            point.status = dynamic_cast<const Unsupported*>(&e) ? "unsupported" : "failed";
            point.message = e.what();
            gl::takeErrors();
        }
    };
    for (Point& point : series.points) {
        runs.push_back(std::make_unique<SettingRun>(point.setting));
        guarded(point, [&] { point.frame->warmUp(*runs.back(), o.effects); });
    }
    for (int round = 0; round < o.repeats; ++round) {
        std::vector<std::pair<std::uint32_t, std::size_t>> order;
        for (std::size_t i = 0; i < runs.size(); ++i)
            order.emplace_back(
                hash(o.seed, static_cast<std::uint32_t>(round), static_cast<std::uint32_t>(i)), i);
        std::ranges::sort(order);
        for (const auto& [key, i] : order) {
            Point& point = series.points[i];
            if (point.status != "ok") continue;
            guarded(point, [&] {
                point.samples.push_back(
                    runs[i]->timed(point.frame->frame(), point.frame->target()));
            });
        }
    }
    for (const Point& point : series.points)
        if (point.status == "ok") series.ok.push_back(&point);
}

double frameMs(const SettingRun::Sample& s) {
    return s.buildMs + s.shadeMs;
}
double buildMs(const SettingRun::Sample& s) {
    return s.buildMs;
}
double shadeMs(const SettingRun::Sample& s) {
    return s.shadeMs;
}
using Part = double (*)(const SettingRun::Sample&);

double medianOf(const Point& point, Part part) {
    std::vector<double> times;
    for (const SettingRun::Sample& s : point.samples) times.push_back(part(s));
    return median(std::move(times));
}

/// Absent for a part that is nowhere a hundredth of the frame: the build of what has none takes
/// some microseconds whose growth says nothing.
std::optional<Growth> growth(const Series& series, Part part, const CompareOptions& o) {
    if (std::ranges::none_of(series.ok, [&](const Point* p) {
            return medianOf(*p, part) >= 0.01 * medianOf(*p, frameMs);
        }))
        return std::nullopt;
    std::vector<double> x;
    for (const Point* p : series.ok) x.push_back(p->x);
    std::vector<std::vector<double>> rounds;
    for (std::size_t r = 0; r < static_cast<std::size_t>(o.repeats); ++r) {
        rounds.emplace_back();
        for (const Point* p : series.ok) rounds.back().push_back(part(p->samples[r]));
    }
    return growthOf(x, rounds, o.seed);
}

std::string text(const std::optional<Growth>& g) {
    return g ? fmt::format("{:.2f} ({:.2f} to {:.2f})", g->exponent.median, g->exponent.low,
                           g->exponent.high)
             : "";
}

std::string csvOf(const std::vector<Series>& all, ScalingAxis axis) {
    std::string csv =
        "scene,method,setting,axis,x,status,frame_ms,build_ms,shade_ms,exponent,exponent_low,"
        "exponent_high,build_exponent,shade_exponent,fit_within\n";
    for (const Series& series : all)
        for (const Point& point : series.points) {
            csv += fmt::format("{},{},{},{},{},{}", csvQuoted(series.scene), series.setting.method,
                               point.setting.name, nameOf(axis), point.x, point.status);
            for (const Part part : {frameMs, buildMs, shadeMs})
                csv += point.status == "ok" ? fmt::format(",{}", medianOf(point, part)) : ",";
            csv += series.frame
                       ? fmt::format(",{},{},{}", series.frame->exponent.median,
                                     series.frame->exponent.low, series.frame->exponent.high)
                       : ",,,";
            for (const auto* g : {&series.build, &series.shade})
                csv += *g ? fmt::format(",{}", (*g)->exponent.median) : ",";
            csv += series.frame ? fmt::format(",{}\n", series.frame->worstFactor) : ",\n";
        }
    return csv;
}

std::string tableRow(const Series& series, ScalingAxis axis) {
    std::string row = fmt::format("| {} |", series.setting.name);
    if (series.points.empty())
        return row + fmt::format(" not applicable: has no {} | | | | | |\n", nameOf(axis));
    if (series.ok.empty())
        return row + fmt::format(" {}: {} | | | | | |\n", series.points.front().status,
                                 series.points.front().message);
    const Point &first = *series.ok.front(), &last = *series.ok.back();
    row += fmt::format(" {} to {} | {:.3g} to {:.3g} | {} | {} | {} | {} |", first.x, last.x,
                       medianOf(first, frameMs), medianOf(last, frameMs), text(series.frame),
                       text(series.build), text(series.shade),
                       series.frame ? fmt::format("{:.2f}×", series.frame->worstFactor) : "");
    std::size_t missing = series.points.size() - series.ok.size();
    return row + (missing ? fmt::format(" {} of {} points missing\n", missing, series.points.size())
                          : "\n");
}

std::string summaryOf(const std::vector<Series>& all, ScalingAxis axis, const CompareOptions& o,
                      const Provenance& from, double load) {
    std::string page = fmt::format(
        "# Growth with {}\n\n`{}`\n\n{}, {}, {} threads, {} rounds, commit {}, {}. Load when it "
        "began: {:.1f} on {} processors.\n\nTime grows as {} to the power of the exponent, the "
        "median over rounds with its 95 % interval; the last column is how far the medians lie "
        "off that curve.\n",
        nameOf(axis), o.command, from.cpu, from.renderer, from.threads, o.repeats, from.commit,
        from.started, load, std::thread::hardware_concurrency(), nameOf(axis));
    std::string scene;
    for (const Series& series : all) {
        if (series.scene != scene) {
            scene = series.scene;
            page += fmt::format(
                "\n## {}\n\n| setting | {} | frame ms | frame exponent | build exponent | shade "
                "exponent | within |\n| --- | --- | --- | --- | --- | --- | --- |\n",
                scene, nameOf(axis));
        }
        page += tableRow(series, axis);
    }
    return page;
}

/// Frame time against what grows, a series per setting with its exponent.
Plot plotOf(const std::vector<Series>& all, const std::string& scene, ScalingAxis axis) {
    const std::map<std::string, int> styles = methodStyles({});
    Plot plot;
    plot.title = fmt::format("Growth with {}: {}", nameOf(axis), scene);
    plot.note = "Medians; beside each the exponent of its power law.";
    plot.xLabel = nameOf(axis);
    plot.yLabel = "frame time (ms)";
    for (const Series& s : all) {
        if (s.scene != scene || s.ok.empty()) continue;
        PlotSeries series;
        series.label = s.frame ? fmt::format("{} {:.2f}", s.setting.name, s.frame->exponent.median)
                               : s.setting.name;
        series.style = styles.at(s.setting.method);
        for (const Point* p : s.ok) {
            series.points.push_back({p->x, medianOf(*p, frameMs), p->x, p->x, true});
            series.line.emplace_back(p->x, medianOf(*p, frameMs));
        }
        plot.series.push_back(std::move(series));
    }
    return plot;
}

std::vector<std::shared_ptr<const Scene>> scenesOf(const CompareOptions& o) {
    const SceneLibrary library = SceneLibrary::standard();
    std::vector<std::string> names = o.scenes;
    if (!o.suite.empty() || names.empty()) {
        const Suite suite = loadSuite(o.suite.empty() ? "standard" : o.suite, library);
        names.insert(names.begin(), suite.scenes.begin(), suite.scenes.end());
    }
    std::vector<std::shared_ptr<const Scene>> scenes;
    for (const std::string& name : names) {
        try {
            scenes.push_back(loadScene(name, library, o.load));
        } catch (const AssetAbsent& e) {
            fmt::print(stderr, "{}\n", e.what());
        }
    }
    if (scenes.empty()) throw InputError("nothing to render: no scene");
    return scenes;
}

}  // namespace

int scaling(const CompareOptions& o, ScalingAxis axis) {
    std::vector<Setting> settings = expandSettings(o.settings);
    std::erase_if(settings, &Setting::isSeparation);
    if (settings.empty()) throw InputError("--scaling: no method to time");
    const auto scenes = scenesOf(o);
    const RunFolder folder = o.out.empty() ? RunFolder::makeNew() : RunFolder(o.out);
    folder.create();
    const FolderLock lock(folder.root());
    const ThreadLimit limit(o.threadCount());
    const auto context = gl::Context::create(o.context);
    double load = 0.0;
    getloadavg(&load, 1);
    const Provenance provenance = gatherProvenance(*context, o.threadCount());

    ProgressLine progress(scenes.size() * settings.size());
    std::vector<Series> all;
    bool failed = false;
    for (const auto& scene : scenes) {
        const std::vector<Staged> frames = stage(scene, o, axis);
        for (const Setting& setting : settings) {
            progress.step(all.size(), scene->id + " " + setting.name);
            Series series{scene->id, setting, pointsOf(setting, frames, axis), {}, {}, {}, {}};
            measure(series, o);
            series.frame = growth(series, frameMs, o);
            series.build = growth(series, buildMs, o);
            series.shade = growth(series, shadeMs, o);
            for (const Point& point : series.points) {
                failed |= point.status == "failed";
                if (point.status != "ok")
                    progress.note(fmt::format("{} {} at {} {}: {}: {}", scene->id, setting.name,
                                              nameOf(axis), point.x, point.status, point.message));
            }
            all.push_back(std::move(series));
        }
    }
    const std::string summary = summaryOf(all, axis, o, provenance, load);
    writeFileAtomically(folder.root() / "scaling.csv", csvOf(all, axis));
    writeFileAtomically(folder.summary(), summary);
    std::filesystem::create_directories(folder.root() / "scaling");
    for (const auto& scene : scenes) {
        const Plot plot = plotOf(all, scene->id, axis);
        if (plot.series.empty()) continue;
        writeFileAtomically(folder.root() / "scaling" / (scene->id + ".svg"), plotSvg(plot));
        writeFileAtomically(folder.root() / "scaling" / (scene->id + ".png"), plotPng(plot));
    }
    fmt::print("{}\n", std::filesystem::absolute(folder.root()).lexically_normal().string());
    return failed ? 3 : 0;
}

}  // namespace penumbra
