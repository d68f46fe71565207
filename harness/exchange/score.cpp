#include "harness/exchange/score.hpp"

#include <fmt/format.h>

#include <limits>

#include "core/error.hpp"
#include "harness/exchange/alignment.hpp"
#include "harness/exchange/outside_image.hpp"
#include "harness/exchange/run_entry.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/thread_limit.hpp"

namespace penumbra {
namespace {

OutsideImage read(const ScoreOptions& options) {
    return options.image.empty() ? readRatio(options.shadowed, options.unshadowed, options.transfer)
                                 : readVisibility(options.image, options.transfer);
}

/// What an image says of pixels that it does not cover is no visibility. Returns a sentence for the
/// row on the pixels that count in `nonfinite` and why; empty if there are none.
std::string maskOut(OutsideImage& image, const GBuffer& gbuffer) {
    std::size_t undivided = 0, uncovered = 0;
    for (std::size_t i = 0; i < gbuffer.size(); ++i) {
        if (!isAsked(gbuffer.mask[i])) continue;
        if (!image.masked.empty() && image.masked[i]) {
            ++undivided;
        } else if (!image.covered.empty() && !image.covered[i]) {
            ++uncovered;
            image.visibility[i] = std::numeric_limits<float>::quiet_NaN();
        }
    }
    std::string text;
    if (undivided > 0)
        text =
            fmt::format("{} pixels masked: unshadowed value 0, negative or not finite", undivided);
    if (uncovered > 0)
        text += fmt::format("{}{} pixels masked: not covered by the image",
                            text.empty() ? "" : "; ", uncovered);
    return text;
}

void requireAligned(const std::optional<std::string>& displacement) {
    if (displacement) throw InputError(*displacement);
}

}  // namespace

Row scoreImage(const ScoreOptions& options, const std::function<void(std::string)>& note,
               const Progress& progress) {
    TruthOptions truth = options.truth;
    const ThreadLimit limit(truth.threadCount());
    const auto scene = loadForFrame(options.scene, options.frame, truth);
    OutsideImage image = read(options);
    if (!options.sizeGiven) {
        truth.width = image.width;
        truth.height = image.height;
    }
    requireSize(image, truth.width, truth.height);
    const std::filesystem::path& named = options.image.empty() ? options.shadowed : options.image;
    const std::string name = options.name.empty() ? named.stem().string() : options.name;
    std::optional<RunEntry> entry;
    if (!options.run.empty()) entry.emplace(options.run, name, *scene, truth, options.command);
    for (const std::string& text : image.notes) note(text);

    const TracedFrame traced = traceFrame(scene, options.frame, truth.width, truth.height);
    requireAligned(coverageDisplacement(image, traced.gbuffer));
    const std::string message = maskOut(image, traced.gbuffer);
    const ObtainedReference obtained = obtainReference(
        *scene, options.frame, *traced.tracer, traced.gbuffer, traced.frame.light, truth, progress);
    for (const std::string& text : obtained.notes) note(text);
    requireAligned(visibilityDisplacement(image, traced.gbuffer, obtained.reference));

    const Provenance provenance = gatherProvenance(truth.threadCount());
    Row row;
    row.scene = scene->id;
    row.frame = options.frame;
    row.method = row.setting = name;
    row.width = truth.width;
    row.height = truth.height;
    row.message = message;
    row.frameMs = options.frameMs;
    row.metrics =
        Scorer(obtained.reference, traced.gbuffer, traced.scene->edges).score(image.visibility);
    row.renderer = provenance.renderer;
    row.commit = provenance.commit;
    if (entry) entry->add(row, image.visibility, traced, obtained);
    return row;
}

}  // namespace penumbra
