#pragma once

#include <filesystem>
#include <string>

namespace penumbra {

/// An ECMAScript module and all that it imports as one script, for a page that has nowhere to load
/// others from. Every file is there once, after what it imports and in a scope of its own; what it
/// exports is read when it has run, so that an exported `let` does not follow later changes.
///
/// Understood are `import {a, b} from "./name.js";` at the start of a line, on several lines too,
/// and `export` before a declaration, without renaming. Throws std::runtime_error with file:line
/// for any other form of either, and for a file that is not there.
std::string joinModules(const std::filesystem::path& folder, const std::string& entry);

}  // namespace penumbra
