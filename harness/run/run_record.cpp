#include "harness/run/run_record.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "harness/run/files.hpp"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

Json pairsToJson(const std::vector<std::pair<std::string, std::string>>& pairs) {
    Json object = Json::object();
    for (const auto& [key, value] : pairs) object[key] = value;
    return object;
}

std::vector<std::pair<std::string, std::string>> pairsFromJson(const Json& object) {
    std::vector<std::pair<std::string, std::string>> pairs;
    for (const auto& [key, value] : object.items())
        pairs.emplace_back(key, value.get<std::string>());
    return pairs;
}

Json effectsToJson(const EffectsRecord& record) {
    Json effects = Json::object();
    for (const EffectInfo& info : allEffects()) {
        const EffectFinding& finding = record.findings[info.effect];
        effects[std::string(info.id)] = {{"called_for", finding.calledFor},
                                         {"evidence", finding.evidence}};
    }
    return {{"scene", record.scene},
            {"frame", record.frame},
            {"load_ms", record.loadMs},
            {"analysis_ms", record.analysisMs},
            {"effects", effects}};
}

EffectsRecord effectsFromJson(const Json& object) {
    EffectsRecord record;
    object.at("scene").get_to(record.scene);
    object.at("frame").get_to(record.frame);
    object.at("load_ms").get_to(record.loadMs);
    object.at("analysis_ms").get_to(record.analysisMs);
    for (const EffectInfo& info : allEffects()) {
        const Json& finding = object.at("effects").at(std::string(info.id));
        record.findings[info.effect] = {finding.at("called_for").get<bool>(),
                                        finding.at("evidence").get<std::string>()};
    }
    return record;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunRecord::SceneEntry, id, shows, figure, source, frames, chosen)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunRecord::SettingEntry, name, method, params)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Certificate, pixels, covered, squaredError, squaredStandardised,
                                   worst)
// With defaults: records of earlier versions lack `checked`.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ReferenceStats, scene, frame, rays, seconds, cached,
                                                penumbraPixels, scoredPixels, uniformEquivalentRays,
                                                checked)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PhaseTime, name, seconds)

std::string RunRecord::provenanceOf(std::string_view name) const {
    for (const auto& [key, value] : provenance)
        if (key == name) return value;
    return "";
}

void RunRecord::write(const std::filesystem::path& path) const {
    Json j;
    j["command"] = command;
    j["finished"] = finished;
    j["width"] = width;
    j["height"] = height;
    j["repeats"] = repeats;
    j["seed"] = seed;
    j["reference"] = reference;
    j["reference_se"] = referenceSe;
    j["effects"] = effects;
    j["cache"] = cache;
    j["asset_scene"] = assetScene;
    j["camera"] = camera;
    j["provenance"] = pairsToJson(provenance);
    j["clock_self_test"] = {{"fenced_ms", fencedClockMs},
                            {"timer_query_ms", queryClockMs},
                            {"timer_queries_trusted", timerQueriesTrusted}};
    j["fetch_throughput"] = {{"nearest_per_s", fetches.nearestPerS},
                             {"compare_per_s", fetches.comparePerS}};
    j["curve_metric"] = curveMetric;
    j["scenes"] = nlohmann::json(scenes);
    j["settings"] = nlohmann::json(settings);
    j["references"] = nlohmann::json(references);
    j["analysis"] = Json::array();
    for (const EffectsRecord& record : analysis) j["analysis"].push_back(effectsToJson(record));
    j["phases"] = nlohmann::json(phases);
    j["skipped_scenes"] = pairsToJson(skippedScenes);
    // A path in the command may be no UTF-8.
    writeFileAtomically(path, j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

RunRecord RunRecord::read(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file) throw InputError(fmt::format("{}: not a run folder, cannot be read", path.string()));
    try {
        const Json j = Json::parse(file);
        RunRecord r;
        j.at("command").get_to(r.command);
        j.at("finished").get_to(r.finished);
        j.at("width").get_to(r.width);
        j.at("height").get_to(r.height);
        j.at("repeats").get_to(r.repeats);
        j.at("seed").get_to(r.seed);
        j.at("reference").get_to(r.reference);
        j.at("reference_se").get_to(r.referenceSe);
        j.at("effects").get_to(r.effects);
        j.at("cache").get_to(r.cache);
        j.at("asset_scene").get_to(r.assetScene);
        j.at("camera").get_to(r.camera);
        r.provenance = pairsFromJson(j.at("provenance"));
        const Json& clock = j.at("clock_self_test");
        clock.at("fenced_ms").get_to(r.fencedClockMs);
        clock.at("timer_query_ms").get_to(r.queryClockMs);
        clock.at("timer_queries_trusted").get_to(r.timerQueriesTrusted);
        const Json& fetches = j.at("fetch_throughput");
        fetches.at("nearest_per_s").get_to(r.fetches.nearestPerS);
        fetches.at("compare_per_s").get_to(r.fetches.comparePerS);
        j.at("curve_metric").get_to(r.curveMetric);
        const nlohmann::json lists = j;
        lists.at("scenes").get_to(r.scenes);
        lists.at("settings").get_to(r.settings);
        lists.at("references").get_to(r.references);
        for (const Json& record : j.at("analysis")) r.analysis.push_back(effectsFromJson(record));
        lists.at("phases").get_to(r.phases);
        r.skippedScenes = pairsFromJson(j.at("skipped_scenes"));
        return r;
    } catch (const nlohmann::json::out_of_range& e) {
        throw InputError(fmt::format("{}: of another version of Penumbra, run `compare` again ({})",
                                     path.string(), e.what()));
    } catch (const nlohmann::json::exception& e) {
        throw InputError(fmt::format("{}: {}", path.string(), e.what()));
    }
}

}  // namespace penumbra
