#pragma once

#include "harness/viewer/view_options.hpp"

namespace penumbra {

/// `penumbra view`: opens the window and lives until it is closed, or, with a screenshot asked for,
/// until that is written. Returns the exit code. Throws InputError where there is no display, with
/// what is missing, and for a scene or method that is not to be had.
int runViewer(const ViewOptions& options);

}  // namespace penumbra
