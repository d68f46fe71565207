#include "harness/exchange/export.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/gltf_export.hpp"
#include "harness/exchange/frame_json.hpp"
#include "harness/run/files.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/thread_limit.hpp"

namespace penumbra {
namespace {

/// Depth of the nearest surface point that a pixel shows; 0 if none shows any.
double nearestDepthM(const TracedFrame& traced) {
    const Camera& camera = traced.frame.camera;
    double nearest = 0.0;
    for (std::size_t i = 0; i < traced.gbuffer.size(); ++i) {
        if (traced.gbuffer.mask[i] == PixelClass::background) continue;
        const double depth =
            glm::dot(camera.position - glm::dvec3(traced.gbuffer.position[i]), camera.back);
        nearest = nearest == 0.0 ? depth : std::min(nearest, depth);
    }
    return nearest;
}

}  // namespace

std::vector<std::filesystem::path> exportFrame(const ExportOptions& options,
                                               const std::function<void(std::string)>& note,
                                               const Progress& progress) {
    const TruthOptions& truth = options.truth;
    const ThreadLimit limit(truth.threadCount());
    const auto scene = loadForFrame(options.scene, options.frame, truth);
    for (const std::string& choice : scene->chosen) note(fmt::format("{}: {}", scene->id, choice));
    const TracedFrame traced = traceFrame(scene, options.frame, truth.width, truth.height);
    const Camera camera = withClipPlanes(*scene, traced.frame, nearestDepthM(traced));
    const std::string glb =
        exportGltf(*scene, traced.frame, camera, static_cast<double>(truth.width) / truth.height);
    if (traced.frame.light.isPoint())
        note(
            fmt::format("{}: the light is a point, which has no rectangle: the .glb holds it as "
                        "KHR_lights_punctual, which penumbra reads back facing the scene's "
                        "centre; the .json has where it faces",
                        scene->id));
    const ObtainedReference obtained = obtainReference(
        *scene, options.frame, *traced.tracer, traced.gbuffer, traced.frame.light, truth, progress);
    for (const std::string& text : obtained.notes) note(text);

    RunFolder(options.out).create();
    const std::string stem = fmt::format("{}-{:04d}", scene->id, options.frame);
    const FrameFiles names{stem + ".glb", stem + "-gbuffer.exr", stem + "-reference.exr"};
    std::vector<std::filesystem::path> files;
    for (const std::string& name : {names.glb, stem + ".json", names.gbuffer, names.reference})
        files.push_back(options.out / name);
    writeFileAtomically(files[0], glb);
    writeFileAtomically(files[1], frameJson(traced, camera, truth, names));
    writeGBuffer(files[2], traced.gbuffer, scene->origin);
    writeReference(files[3], obtained.reference);
    return files;
}

}  // namespace penumbra
