#pragma once

#include <vector>

#include "core/analysis/receivers.hpp"
#include "core/frame/casters.hpp"

namespace penumbra {

/// What may lie between the light and the points that are asked about, from bounds that hold every
/// ray: what the survey does not find is not there.
struct ShaftSurvey {
    std::vector<char> casts;  ///< of each part: it may block a ray
    /// Of each part: it casts, or may block a ray that ends beside a point by up to `beside` along
    /// both of the light's sides and is nearer to the light by as much as the farther of them.
    std::vector<char> inTheWay;
    /// Of each part: it may come within the clearance of a point.
    std::vector<char> near;
    /// Of each part: it may rise above the plane of a point where a filter as wide as the clearance
    /// finds it, whether or not it blocks a ray: the next wall of a room does. Close: within the
    /// clearance.
    std::vector<char> rises, risesClose;
    bool layered = false;  ///< some ray may meet two casters, or one of them twice

    struct Questions {
        std::vector<char> casts;  ///< parts known to cast: they are not asked about
        bool near = true, layered = true;
        /// How far casters keep from a point to be clear of it, over the point's distance from the
        /// light's plane.
        double clearance = 0.0;
        double beside = 0.0;      ///< likewise, at most `clearance`
        double toleranceM = 0.0;  ///< by which positions may be off their planes
    };
    /// What is not asked for is true throughout; `near` asks for all but `casts` and `layered`.
    static ShaftSurvey make(const Geometry& geometry, const Receivers& receivers,
                            const Casters& bodies, const Questions& questions);
};

}  // namespace penumbra
