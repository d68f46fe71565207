#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "harness/metrics/edge_scan.hpp"
#include "harness/metrics/flip.hpp"
#include "harness/metrics/ssim.hpp"
#include "harness/reference/reference.hpp"
#include "harness/report/shade.hpp"

namespace penumbra {

/// Scores of one visibility image. Error is visibility - reference over scored pixels, so a
/// positive bias is leaked light. Absent where no pixel of that kind exists.
struct Metrics {
    std::optional<double> rmse, mae, bias, p99, maxError;
    std::optional<double> ssim, flip;  ///< means over scored pixels
    std::optional<double> rmseLit, rmsePenumbra, rmseUmbra;
    std::optional<double> leakRate;         ///< fraction of umbra pixels with V > 0.05
    std::optional<double> falseShadowRate;  ///< fraction of lit pixels with V < 0.95
    std::optional<double> noise;            ///< high-frequency error inside penumbrae
    std::optional<double> flicker;          ///< against the frame before; not from score()
    std::size_t scoredPixels = 0, horizonPixels = 0;
    /// Scored or horizon pixels that are NaN or infinite; left out of all means.
    std::size_t nonfinite = 0;
    /// Scored or horizon pixels outside [0,1], counted among the means as they are.
    std::size_t outOfRange = 0;
    /// Root mean square standard error of the reference over its penumbra pixels.
    std::optional<double> referenceSe;
    /// rmse without what the reference's own noise adds: sqrt(rmse^2 - mean standard error^2) over
    /// the scored pixels, 0 where the noise explains all of it.
    std::optional<double> rmseCorrected;
    /// Means over the scene's shadow edges that the reference shows; absent where it shows none or
    /// the image lacks one of them (measureEdge).
    std::optional<double> penumbraWidthError;  ///< (W - Wref) / Wref
    std::optional<double> penumbraShift;       ///< in units of Wref, above 0 towards the light

    bool operator==(const Metrics&) const = default;
};

/// Scores the images of one frame; what does not depend on the image is prepared once. Keeps
/// references to reference and G-buffer. flicker, which needs two frames, stays absent.
class Scorer {
  public:
    /// `edges` in the G-buffer's coordinates, as Scene::edges are.
    Scorer(const Reference& reference, const GBuffer& gbuffer,
           std::span<const ShadowEdge> edges = {});
    /// Throws std::invalid_argument for an image of another size.
    Metrics score(std::span<const float> visibility) const;

  private:
    /// ssim, flip and noise: what looks at neighbourhoods.
    void scoreNeighbourhoods(std::span<const float> visibility, Metrics& metrics) const;
    void scoreEdges(std::span<const float> visibility, Metrics& metrics) const;

    struct Edge {
        EdgeScan scan;
        EdgeProfile truth;
    };
    const Reference& reference_;
    const GBuffer& gbuffer_;
    std::vector<LightClass> classes_;
    PictureLight light_;
    SsimImage ssim_;
    FlipImage flip_;
    std::vector<Edge> edges_;  ///< those that the reference shows
};

struct MetricInfo {
    std::string_view id;  ///< CSV column
    std::string_view unit;
    std::string_view doc;  ///< what it sees and what it is blind to
};
/// For `penumbra list metrics` and the documents, in CSV order.
const std::vector<MetricInfo>& allMetrics();

}  // namespace penumbra
