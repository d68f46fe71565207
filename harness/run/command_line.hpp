#pragma once

#include <string>

#include "harness/run/row.hpp"
#include "harness/run/run_record.hpp"

namespace penumbra {

/// `argument` as a POSIX shell reads it back.
std::string shellQuoted(const std::string& argument);

/// What `compare --scene` would read as this scene of a run: its id, or the file where the id is
/// not one of the library's.
std::string sceneArgument(const RunRecord& record, const std::string& scene);

/// What `compare --effects` reads as the run's choice.
std::string effectsArgument(const RunRecord& record);

/// `penumbra compare …` that does again what made `row` in the run of `record`: one scene, one
/// setting, and every option of the run that is not the default.
std::string reproducingCommand(const RunRecord& record, const Row& row);

}  // namespace penumbra
