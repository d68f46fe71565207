#include "harness/run/fill_flicker.hpp"

#include <tbb/parallel_for_each.h>

#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "harness/metrics/flicker.hpp"
#include "harness/run/files.hpp"
#include "harness/run/row.hpp"

namespace penumbra {

namespace {

/// What all settings of a frame share.
struct Truth {
    int frame;
    GBuffer gbuffer;
    Reference reference;

    Truth(const RunFolder& folder, const std::string& scene, int index)
        : frame(index),
          gbuffer(folder.readGBuffer(scene, index)),
          reference(folder.readReference(scene, index)) {}
};

}  // namespace

void fillFlicker(const RunFolder& folder) {
    std::vector<Row> rows = readCsv(folder.results());
    std::map<std::pair<std::string, int>, std::vector<Row*>> frames;  // each scene's in order
    for (Row& row : rows) {
        if (row.status == "ok" && row.frame > 0 && !row.metrics.flicker &&
            std::filesystem::exists(folder.setting(row.scene, row.frame - 1, row.setting)))
            frames[{row.scene, row.frame}].push_back(&row);
    }
    if (frames.empty()) return;

    std::optional<Truth> before, now;
    std::string scene;
    for (auto& [key, cells] : frames) {
        const int frame = key.second;
        const bool follows = scene == key.first && now && now->frame == frame - 1;
        scene = key.first;
        if (follows)
            before = std::move(now);
        else
            before.emplace(folder, scene, frame - 1);
        now.emplace(folder, scene, frame);
        tbb::parallel_for_each(cells, [&](Row* row) {
            const auto image = [&](int index) {
                return folder.readVisibility(scene, index, row->setting);
            };
            const std::vector<float> then = image(frame - 1), current = image(frame);
            row->metrics.flicker = flicker({before->gbuffer, before->reference, then},
                                           {now->gbuffer, now->reference, current});
        });
    }
    std::string text = csvHeader() + "\n";
    for (const Row& row : rows) text += toCsv(row) + "\n";
    writeFileAtomically(folder.results(), text);
}

}  // namespace penumbra
