#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/gl/context.hpp"
#include "harness/run/truth.hpp"
#include "harness/study/claims_report.hpp"

namespace penumbra {

/// What `penumbra reproduce` was asked for.
struct ReproduceOptions : TruthOptions {
    std::string paper;             ///< id; empty: all
    std::filesystem::path claims;  ///< folder of papers; empty: that of the scene library
    int pairs = 15;                ///< of timings, for claims about time
    gl::ContextKind context = gl::ContextKind::osmesa;
    std::filesystem::path out;  ///< empty: results/<time>
    bool markdown = false;      ///< claims.md to stdout instead of the plain table
    std::string command;        ///< as typed, for the record
};

/// Measures every claim, prints the table and writes claims.csv and claims.md to the out folder.
/// Returns 0, or 3 when some claims could not run; one that does not hold is a result. Throws
/// InputError for bad input before anything is measured or written.
int reproduce(const ReproduceOptions& options);

/// Standard error of an image's rmse over scored pixels that comes from the reference's own: of
/// the sum of (d + e)^2 with e of variance s^2, pixel by pixel independent, s measured (pixels
/// whose rays all agree count as certain, as in rmse_corrected). 0 for an rmse of 0.
double rmseStandardError(std::span<const float> visibility, const Reference& reference,
                         const GBuffer& gbuffer);

}  // namespace penumbra
