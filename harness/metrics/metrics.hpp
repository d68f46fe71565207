#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// Scores of one visibility image. Error is visibility - reference over scored pixels, so a positive
/// bias is leaked light. Absent where no pixel of that kind exists.
struct Metrics {
    std::optional<double> rmse, mae, bias, p99, maxError;
    std::optional<double> rmseLit, rmsePenumbra, rmseUmbra;
    std::optional<double> leakRate;         ///< fraction of umbra pixels with V > 0.05
    std::optional<double> falseShadowRate;  ///< fraction of lit pixels with V < 0.95
    std::size_t scoredPixels = 0, horizonPixels = 0;
    std::size_t nonfinite = 0;   ///< scored or horizon pixels that are NaN or infinite; left out of all means
    std::size_t outOfRange = 0;  ///< scored or horizon pixels outside [0,1], counted among the means as they are
    std::optional<double> referenceSe;  ///< rms standard error of the reference over its penumbra pixels

    bool operator==(const Metrics&) const = default;
};

Metrics score(std::span<const float> visibility, const Reference& reference, const GBuffer& gbuffer);

struct MetricInfo {
    std::string_view id;  ///< CSV column
    std::string_view unit;
    std::string_view doc;  ///< what it sees and what it is blind to
};
/// For `penumbra list metrics` and the documents, in CSV order.
const std::vector<MetricInfo>& allMetrics();

}  // namespace penumbra
