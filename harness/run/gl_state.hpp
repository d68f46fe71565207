#pragma once

namespace penumbra {

/// Puts the state of draws and transfers back to what a new context has (gl::Context), so that a
/// method finds the same whatever ran before it and however that ended. Textures stay bound: a
/// method binds those that it samples.
void resetGlState();

}  // namespace penumbra
