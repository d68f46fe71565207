#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/report/summary.hpp"
#include "harness/run/effects_record.hpp"
#include "harness/run/fetch_throughput.hpp"

namespace penumbra {

/// run.json: what a run is, apart from its rows.
struct RunRecord {
    struct SceneEntry {
        std::string id, shows, figure, source;
        int frames = 0;
        std::vector<std::string> chosen;  ///< what was placed because the input did not say
    };
    struct SettingEntry {
        std::string name, method, params;
    };

    std::string command;  ///< as typed
    bool finished = false;
    int width = 0, height = 0, repeats = 0;
    unsigned seed = 0;
    double referenceSe = 0.0;
    std::string reference = "embree";
    std::string effects = "auto";    ///< auto, all, or the ids asked for joined with ' '
    std::string cache;               ///< folder of cached references; empty: the user's own
    std::string assetScene, camera;  ///< as asked for, mostly empty
    std::vector<std::pair<std::string, std::string>> provenance;
    std::vector<SceneEntry> scenes;      ///< in order of the suite
    std::vector<SettingEntry> settings;  ///< in order of the columns
    std::vector<ReferenceStats> references;
    std::vector<EffectsRecord> analysis;  ///< by scene as they ran, then by frame
    std::vector<PhaseTime> phases;
    std::vector<std::pair<std::string, std::string>> skippedScenes;
    double fencedClockMs = 0.0, queryClockMs = 0.0;  ///< the clock self-test
    bool timerQueriesTrusted = false;
    FetchThroughput fetches;           ///< of the machine that ran it
    std::string curveMetric = "rmse";  ///< on the error axis of curves and cost tables

    /// The value in `provenance`; empty where there is none of this name.
    std::string provenanceOf(std::string_view name) const;
    /// Written to a temporary name and renamed.
    void write(const std::filesystem::path& path) const;
    /// Throws InputError with the file and what is wrong.
    static RunRecord read(const std::filesystem::path& path);
};

}  // namespace penumbra
