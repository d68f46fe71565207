#include "harness/report/benchmark.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace penumbra {

std::string benchmarkJson(const std::vector<Row>& rows) {
    using Json = nlohmann::ordered_json;
    Json list = Json::array();
    for (const Row& row : rows) {
        if (row.status != "ok") continue;
        const auto add = [&](const char* metric, const char* unit, double value,
                             const std::string& range) {
            list.push_back({{"name", fmt::format("{} frame {} {}: {}", row.scene, row.frame,
                                                 row.setting, metric)},
                            {"unit", unit},
                            {"value", value},
                            {"range", range},
                            {"extra", fmt::format("{}\n{}, {} threads, commit {}", row.params,
                                                  row.renderer, row.threads, row.commit)}});
        };
        if (row.frameMs)
            add("frame_ms", "ms", *row.frameMs,
                row.frameMsLow && row.frameMsHigh
                    ? fmt::format("{:.4g} .. {:.4g}", *row.frameMsLow, *row.frameMsHigh)
                    : "");
        if (row.metrics.rmse)
            add("rmse", "V", *row.metrics.rmse,
                row.metrics.referenceSe ? fmt::format("± {:.2g}", *row.metrics.referenceSe) : "");
    }
    // A name may be no UTF-8.
    return list.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace penumbra
