#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/viewer/view_session.hpp"

namespace penumbra {

/// Writes what the session shows as a scene script of one frame: `loadScene(path)` has in frame 0
/// its geometry at this time, its light and its camera. The script refers to the scene's own asset
/// where it can say all there is to say about it. Where it cannot, because a light that belongs to
/// the asset was moved or a ground plate goes with it, the frame is written as a .glb beside it.
/// Returns the files written, the script first. Throws InputError for a path that is no .toml or an
/// orthographic camera that was moved, std::runtime_error where it cannot be written.
std::vector<std::filesystem::path> saveView(const ViewSession& session,
                                            const std::filesystem::path& path);

/// Adds `sceneId` to scenes/suites/<suite>.toml in `library`, after all that is in its list; a
/// suite that does not exist is made. Comments and order stay. The file is replaced as a whole, or,
/// where this throws InputError (a bad name, a scene the suite has or the library lacks, a suite
/// that does not load), not at all.
void addToSuite(const SceneLibrary& library, const std::string& suite, const std::string& sceneId);

}  // namespace penumbra
