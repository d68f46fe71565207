#include "harness/viewer/timeline.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/scene/asset.hpp"
#include "core/scene/scene_builder.hpp"
#include "core/scene/script.hpp"

namespace penumbra {
namespace {

using namespace scene_detail;

constexpr double kStepsPerSecond = 30.0;

/// From the first time to the last and what is listed.
std::vector<double> denseTimes(const std::vector<double>& listedS) {
    const double begin = listedS.front(), span = listedS.back() - begin;
    const int steps = static_cast<int>(
        std::clamp(std::ceil(kStepsPerSecond * span), 1.0, double{Timeline::kMostSteps}));
    std::set<double> times(listedS.begin(), listedS.end());
    for (int i = 0; i < steps; ++i) times.insert(begin + span * i / steps);
    return {times.begin(), times.end()};
}

/// First and last key of an asset's animations; one time where it has none.
std::vector<double> keySpan(const std::vector<NodeTrack>& tracks) {
    std::set<double> times;
    for (const NodeTrack& track : tracks) {
        times.insert(track.curve.times.front());
        times.insert(track.curve.times.back());
    }
    if (times.empty()) return {0.0};
    return {*times.begin(), *times.rbegin()};
}

std::vector<double> frameTimes(const Scene& scene) {
    std::vector<double> times;
    for (int i = 0; i < scene.frameCount(); ++i) times.push_back(scene.frame(i).timeS);
    return times;
}

}  // namespace

int Timeline::frameAt(double timeS) const {
    const auto after = std::ranges::lower_bound(timesS, timeS);
    if (after == timesS.begin()) return 0;
    if (after == timesS.end()) return static_cast<int>(timesS.size()) - 1;
    const auto before = after - 1;
    const auto nearest = timeS - *before <= *after - timeS ? before : after;
    return static_cast<int>(nearest - timesS.begin());
}

Timeline loadTimeline(const std::string& idOrPath, const SceneLibrary& library) {
    const auto scene = loadScene(idOrPath, library);
    const bool scripted = scene->source != scene->asset;
    std::vector<double> listedS = frameTimes(*scene);
    if (scripted && listedS.size() < 2) return {scene, listedS, {0}};

    Asset asset = loadAsset(scene->asset, LoadOptions{});
    std::optional<Script> script;
    if (scripted) {
        script = readScript(scene->source);
    } else {
        listedS = keySpan(asset.tracks);
        if (listedS.size() < 2 || listedS.front() == listedS.back())
            return {scene, frameTimes(*scene), {0}};
        script.emplace();
        script->file = scene->source;
        script->ground = std::ranges::any_of(
            scene->chosen, [](const std::string& note) { return note.starts_with("ground:"); });
    }
    Timeline out;
    script->timesS = out.timesS = denseTimes(listedS);
    out.scene = buildScene(std::move(asset), script);
    for (const double timeS : listedS) out.listed.push_back(out.frameAt(timeS));
    return out;
}

}  // namespace penumbra
