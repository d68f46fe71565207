#pragma once

#include <optional>

#include "harness/run/row.hpp"

namespace penumbra {

/// What the machine's texture units (or the renderer that stands in for them) can do at most:
/// fetches from a float depth map by a shader that does nothing else
/// (shaders/common/bare_fetches.glsl), the best of a few. 0: not measured.
struct FetchThroughput {
    double nearestPerS = 0.0;  ///< texelFetch
    double comparePerS = 0.0;  ///< hardware comparison with bilinear filtering, four texels each
};

/// Takes 100 to 200 ms. Needs a current context.
FetchThroughput measureFetchThroughput();

/// What shading cost in a unit that two machines share: so many bare nearest fetches would have
/// taken as long, per pixel that the frame asks for (scored and horizon). Absent where nothing was
/// shaded, timed or asked for.
std::optional<double> shadeFetchesPerPixel(const Row& row, const FetchThroughput& throughput);

}  // namespace penumbra
