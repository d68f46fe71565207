#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "harness/run/settings.hpp"
#include "harness/study/stress/small_scene.hpp"

namespace penumbra::stress {

/// The base scene again with something changed: what "[[variant]]" of a case says.
struct Variant {
    std::string name;  ///< "offset 100000 0 0", for messages
    SmallScene scene;
    bool mirrored() const { return scene.placement.mirror; }
};

/// Where an invariant holds: a box in the base scene's coordinates.
struct Region {
    glm::dvec3 lo{-1e300}, hi{1e300};
};

/// One hard case: a file scenes/stress/<id>.toml. The bound comes from reasoning, which stands
/// beside it, never from what was measured.
struct HardCase {
    std::string id;
    std::filesystem::path file;
    std::string shows;              ///< input and what must hold, in words
    std::vector<int> numbers;       ///< in METHODS.md, "NUMERICAL HARD CASES"; may be empty
    std::string invariant;          ///< id (invariants.hpp)
    double bound = 0.0;             ///< greatest deviation that passes
    double allowed = 0.0;           ///< share of the pixels asked that may deviate by more
    std::string because;            ///< why this bound
    double value = 0.0;             ///< of the invariants that compare with one number
    double edgeM = 0.02;            ///< of `hard`: how near to an edge nothing is certain
    glm::dvec3 direction{1, 0, 0};  ///< of `monotone`: where it gets lighter
    Region region;
    int size = 64;          ///< pixels, square
    EffectSet needs;        ///< methods that do not simulate all of these are left out
    bool cheapest = false;  ///< every method at its cheapest rung: the scene itself is dear
    bool others = true;     ///< whether methods without a setting of their own run at defaults
    SmallScene scene;
    std::vector<Variant> variants;
    std::map<std::string, std::vector<Setting>> settings;  ///< by method, instead of defaults
};

/// Where the cases are: `folder`/*.toml but elsewhere.toml, known.toml and random.toml; scenes that
/// several share are in `folder`/base.
struct CaseLibrary {
    std::filesystem::path folder;
    /// The source tree's scenes/stress, or that of $PENUMBRA_SCENES.
    static CaseLibrary standard();
    /// Sorted.
    std::vector<std::string> ids() const;
    /// Throws InputError "file:line: what; valid choices".
    HardCase load(const std::string& id) const;
};

}  // namespace penumbra::stress
