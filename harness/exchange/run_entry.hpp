#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "harness/run/folder_lock.hpp"
#include "harness/run/row.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// A run folder, existing or to be made, that takes the row of an image from outside.
class RunEntry {
  public:
    /// Refuses (InputError), writing nothing, what could not stand beside the run's own rows:
    /// another size, seed or reference, another scene of the same id, a name that is a registered
    /// method's or one of the run's settings that a method made, or that is no plain file name; and
    /// a folder in which another process works.
    RunEntry(const std::filesystem::path& folder, const std::string& name, const Scene& scene,
             const TruthOptions& truth, const std::string& command);

    /// Adds row, image and, where the run has not got them, the frame's G-buffer and reference;
    /// rebuilds the tables and the grids.
    void add(const Row& row, const std::vector<float>& visibility, const TracedFrame& traced,
             const ObtainedReference& obtained);

  private:
    void putRow(const Row& row);

    RunFolder folder_;
    std::optional<FolderLock> lock_;  ///< from the first look at a run that is there, or from add()
    RunRecord record_;
};

}  // namespace penumbra
