#pragma once

#include <memory>

#include "core/gl/context.hpp"

/// What the three ways of getting a context share. Only core/gl/*.cpp include this.
namespace penumbra::gl {

using EntryPoint = void (*)();
using GetEntryPoint = EntryPoint (*)(const char* name);

/// Each returns a context that is current and initialised, or throws InputError with the reason.
std::unique_ptr<Context> createOsmesa();
/// With `hardwareOnly` a software renderer counts as none.
std::unique_ptr<Context> createEgl(bool hardwareOnly);
std::unique_ptr<Context> createGlfw();

/// Whether a GL_RENDERER string names one of Mesa's software renderers.
bool isSoftwareRenderer(const std::string& renderer);

/// Loads all entry points, requires OpenGL 4.5 and sets the state every pass relies on (see
/// Context). `what` names the context in error messages.
void initialise(GetEntryPoint getEntryPoint, const std::string& what);

/// Starts collecting the current context's debug messages for takeErrors(), dropping older ones.
void collectDebugMessages();

}  // namespace penumbra::gl
