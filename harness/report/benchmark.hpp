#pragma once

#include <string>
#include <vector>

#include "harness/run/row.hpp"

namespace penumbra {

/// benchmark.json: [{name, unit, value, range, extra}] with frame time and rmse of every row that
/// has them, as dashboards of benchmarks take it (smaller is better).
std::string benchmarkJson(const std::vector<Row>& rows);

}  // namespace penumbra
