#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace penumbra {

/// A scene whose tracks can be stopped at any time: besides the frames that its script lists it has
/// frames in between, 30 a second, at most kMostSteps. An animated asset without a script has them
/// from its first key to its last. A scene in which nothing moves has the one frame it has.
struct Timeline {
    std::shared_ptr<const Scene> scene;
    std::vector<double> timesS;  ///< of the scene's frames, increasing
    std::vector<int> listed;     ///< which of them the script lists, in its order

    static constexpr int kMostSteps = 240;

    bool moves() const { return timesS.size() > 1; }
    double beginS() const { return timesS.front(); }
    double endS() const { return timesS.back(); }
    /// The frame nearest to a time.
    int frameAt(double timeS) const;
};

/// Loads as loadScene() does and throws what that throws.
Timeline loadTimeline(const std::string& idOrPath, const SceneLibrary& library);

}  // namespace penumbra
