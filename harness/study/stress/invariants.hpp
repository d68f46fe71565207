#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/study/stress/hard_case.hpp"
#include "harness/study/stress/stage.hpp"

namespace penumbra::stress {

/// What one method made of one case.
struct Trial {
    const HardCase& hardCase;
    std::vector<const Stage*> stages;           ///< the base scene, then the variants
    std::vector<std::vector<Image>> images;     ///< of the stages, one per frame
    std::function<std::vector<Image>()> again;  ///< the base scene's, by a new instance
};

/// How far the images are from what must hold, and where that was.
struct Finding {
    double deviation = 0.0;
    std::string where;
};

/// Something that must hold of a method's images. Every case has one; `range` is checked of all.
struct Invariant {
    std::string id;
    std::string doc;
    bool bounded = true;    ///< the case gives a bound; else it is 0
    bool variants = false;  ///< compares with [[variant]]s
    Finding (*measure)(const Trial&);
};

const std::vector<Invariant>& allInvariants();
/// Throws InputError with the invariants that there are.
const Invariant& findInvariant(const std::string& id);

}  // namespace penumbra::stress
