#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// gbuffer.exr of a run, positions in world metres: `origin` is added. Throws std::runtime_error.
void writeGBuffer(const std::filesystem::path& path, const GBuffer& gbuffer,
                  const glm::dvec3& origin);
/// reference.exr of a run. Throws std::runtime_error.
void writeReference(const std::filesystem::path& path, const Reference& reference);

/// Names and images of a run folder (DESIGN.md section 10; the layout is in docs/ARCHITECTURE.md).
class RunFolder {
  public:
    explicit RunFolder(std::filesystem::path root) : root_(std::move(root)) {}
    /// Makes results/<time>, or with a number behind it where another process has just taken that.
    static RunFolder makeNew();

    const std::filesystem::path& root() const { return root_; }
    std::filesystem::path record() const { return root_ / "run.json"; }
    std::filesystem::path results() const { return root_ / "results.csv"; }
    /// Only in a run of `compare --paired`.
    std::filesystem::path paired() const { return root_ / "paired.csv"; }
    /// Only in a run of `compare --effects-table`.
    std::filesystem::path effectsCsv() const { return root_ / "effects.csv"; }
    std::filesystem::path effectsTable() const { return root_ / "effects.md"; }
    /// Only where `stress --out` was pointed here: a section of summary().
    std::filesystem::path stress() const { return root_ / "stress.md"; }
    /// Only where `check` judged the run: a section of summary().
    std::filesystem::path gate() const { return root_ / "gate.md"; }
    std::filesystem::path junit() const { return root_ / "junit.xml"; }
    std::filesystem::path benchmark() const { return root_ / "benchmark.json"; }
    /// Run folder of the cells that `check` measured again.
    std::filesystem::path remeasured() const { return root_ / "remeasured"; }
    std::filesystem::path summary() const { return root_ / "summary.md"; }
    std::filesystem::path page() const { return root_ / "report.html"; }
    std::filesystem::path grid(const std::string& scene) const {
        return root_ / "grid" / (scene + ".png");
    }
    std::filesystem::path pareto() const { return root_ / "pareto.csv"; }
    /// Without extension: there is an SVG and a PNG.
    std::filesystem::path curve(const std::string& scene) const { return root_ / "curve" / scene; }
    /// images/<scene>/<frame as 0000>
    std::filesystem::path images(const std::string& scene, int frame) const;
    std::filesystem::path setting(const std::string& scene, int frame,
                                  const std::string& name) const {
        return images(scene, frame) / (name + ".exr");
    }

    /// Makes the folder, or throws InputError if that is not possible or it cannot be written to.
    void create() const;

    /// gbuffer.exr and reference.exr; positions are written in world metres, `origin` added.
    void writeTruth(const std::string& scene, int frame, const GBuffer& gbuffer,
                    const Reference& reference, const glm::dvec3& origin) const;
    void writeVisibility(const std::string& scene, int frame, const std::string& setting,
                         const std::vector<float>& visibility, const Reference& reference) const;

    /// What writeTruth wrote of a G-buffer; positions stay in world metres, rounded to float.
    GBuffer readGBuffer(const std::string& scene, int frame) const;
    Reference readReference(const std::string& scene, int frame) const;
    std::vector<float> readVisibility(const std::string& scene, int frame,
                                      const std::string& setting) const;

  private:
    std::filesystem::path root_;
};

}  // namespace penumbra
