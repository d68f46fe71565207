#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/scene.hpp"
#include "core/trace/tracer.hpp"
#include "harness/reference/reference.hpp"
#include "harness/report/summary.hpp"

namespace penumbra {

/// What decides the points of a frame and the truth about them, whoever is scored against it.
struct TruthOptions {
    int width = 512, height = 512;
    std::uint32_t seed = 0;
    int threads = 0;  ///< 0: all
    std::string reference = "embree";
    double referenceSe = 1.0 / 1024;
    std::filesystem::path cache;  ///< empty: the user's cache folder
    LoadOptions load;

    int threadCount() const;
};

struct ObtainedReference {
    Reference reference;
    ReferenceStats stats;
    std::vector<std::string> notes;  ///< what a user should know about it
};

/// The reference of a scene's frame `index` by the options' kind, from the cache where it is known
/// there.
ObtainedReference obtainReference(const Scene& scene, int index, const Tracer& tracer,
                                  const GBuffer& gbuffer, const AreaLight& light,
                                  const TruthOptions& options, const Progress& progress = {});

/// One frame of a scene without any OpenGL.
struct TracedFrame {
    std::shared_ptr<const Scene> scene;
    int index = 0;
    SceneFrame frame;
    std::unique_ptr<const Tracer> tracer;  ///< keeps references to the scene
    GBuffer gbuffer;
};

/// Loads `scene` (an id, script or asset), which must have a frame `index` that the options'
/// reference can be made for. Throws InputError otherwise, with the frames that there are.
std::shared_ptr<const Scene> loadForFrame(const std::string& scene, int index,
                                          const TruthOptions& options);
TracedFrame traceFrame(std::shared_ptr<const Scene> scene, int index, int width, int height);

}  // namespace penumbra
