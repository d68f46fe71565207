#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/scene/material.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// A traced reference held against the truth.
struct Certificate {
    int pixels = 0;   ///< penumbra pixels among those compared: more than 1/255 from 0 and 1
    int covered = 0;  ///< penumbra pixels within their 95 % interval
    double squaredError = 0.0;         ///< summed over penumbra pixels
    double squaredStandardised = 0.0;  ///< (error / standard error)^2, summed over penumbra pixels
    double worst = 0.0;                ///< greatest error of any pixel compared

    /// Student's t of 15 degrees of freedom (16 replicates): half the width of a 95 % interval in
    /// standard errors, and the mean of t^2.
    static constexpr double kInterval = 2.131, kMeanSquare = 15.0 / 13.0;
    /// What a sound reference keeps: coverage of its 95 % intervals, rmse over its target, worst.
    static constexpr double kLeastCoverage = 0.93, kMostCoverage = 0.99, kMostRmse = 1.2,
                            kMostError = 8e-3;

    void add(double truth, double traced, double standardError);
    void add(const Certificate& other);

    double coverage() const { return static_cast<double>(covered) / pixels; }
    double rmse() const;
    double meanSquare() const { return squaredStandardised / pixels; }

    bool operator==(const Certificate&) const = default;
};

/// `traced` against exact visibility at `sample` pixels or fewer, evenly spread over those that it
/// sees in penumbra (in the order of image rows), each traced the ordinary way; pixels that are too
/// cluttered for `exact` are left out. Empty for scenes with alpha-masked casters and lights
/// without extent.
Certificate certify(const Reference& traced, const Tracer& tracer,
                    const std::vector<Material>& materials, const GBuffer& gbuffer,
                    const AreaLight& light, std::size_t sample);

}  // namespace penumbra
