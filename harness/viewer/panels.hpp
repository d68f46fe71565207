#pragma once

#include "harness/viewer/picture.hpp"
#include "harness/viewer/viewer_state.hpp"

/// The window's panels: each draws into the current ImGui window and acts on what is clicked there.
namespace penumbra {

void drawTopBar(ViewerState& state);
void drawScenePanel(ViewerState& state);
void drawMethodPanel(ViewerState& state);
void drawScorePanel(ViewerState& state);
void drawTimesPanel(ViewerState& state);
void drawEffectsPanel(ViewerState& state);
void drawSavePanel(ViewerState& state);
/// Moves the tracks on by `elapsedS` while they play.
void drawTimelineBar(ViewerState& state, double elapsedS);

/// The intermediate textures of a method; reads back the one that is looked at.
class TexturePanel {
  public:
    void draw(ViewerState& state);

  private:
    std::size_t slot_ = 0;
    std::string name_;
    int layer_ = 0, channel_ = 0;
    bool ownRange_ = true;  ///< black and white are the least and greatest value
    Picture picture_;
    std::string caption_, error_;
    std::uint64_t shown_ = 0;  ///< hash of what the picture is of
};

}  // namespace penumbra
