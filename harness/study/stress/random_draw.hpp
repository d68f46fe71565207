#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "harness/study/stress/small_scene.hpp"
#include "harness/study/stress/stage.hpp"
#include "harness/study/stress/truth_bounds.hpp"

namespace penumbra::stress {

/// One random small scene with one method and a random setting of it.
struct Draw {
    SmallScene scene;
    std::string method;
    Assignments assignments;  ///< what differs from the defaults
    int size = 32;            ///< pixels, square
    Setting setting() const;
};

/// Draw `index` of `seed`: the same one whatever was drawn before it. A floor, up to four boxes,
/// plates, balls and slivers; a light of any size from a point up, at any tilt; a camera; in half
/// of them a place, size and turn in the world; half of them with parameters of the method drawn,
/// too, within what costs a few times the default at most.
Draw drawRandom(std::uint32_t seed, std::uint32_t index, const std::vector<std::string>& methods);

/// What did not hold.
struct DrawFailure {
    std::string check;  ///< throws | range | repeats | lit | hard | truth
    double deviation = 0.0, bound = 0.0;
    std::string note;
};

struct DrawResult {
    std::optional<DrawFailure> failure;
    bool refused = false;  ///< the method does not take this scene
    std::string reason;
};

/// Renders a draw and checks, in this order: nothing is thrown; finite and in [0, 1]; the same bits
/// again; and at the method's defaults: 1 without any caster, a point light's hard limit, and the
/// method's bound against the exact reference. Needs a context. Throws InputError for a draw whose
/// scene is none.
DrawResult checkDraw(const Draw& draw, const TruthBounds& bounds);

}  // namespace penumbra::stress
