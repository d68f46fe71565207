#pragma once

#include <exception>
#include <functional>
#include <string>

#include "harness/viewer/view_session.hpp"

namespace penumbra {

/// What the window's parts share besides the session: how it is looked at, and what was said last.
struct ViewerState {
    explicit ViewerState(ViewSession& shown) : session(shown) {}

    ViewSession& session;
    Display display = Display::single;
    Against against = Against::method;
    float split = 0.5f;     ///< where the line is, as a share of the image's width
    float exposure = 0.0f;  ///< stops
    bool handles = true;    ///< the light's are shown
    bool fit = false;       ///< the image is rendered as large as it is shown
    bool measure = false;   ///< frames are timed although nothing changes
    bool playing = false;
    double playS = 0.0;  ///< where the tracks are while playing
    double speed = 1.0;
    std::string savePath, suite = "views";
    std::string screenshot;  ///< to be written after this frame
    std::string notice;
    bool noticeIsError = false;
    float scale = 1.0f;  ///< of everything, for dense displays

    void say(const std::string& text) { notice = text, noticeIsError = false; }
    void complain(const std::string& text) { notice = text, noticeIsError = true; }
    /// Runs `work`; what it throws is said, and the window lives on.
    template <class Work>
    void attempt(const Work& work) {
        try {
            work();
        } catch (const std::exception& e) {
            complain(e.what());
        }
    }
    /// What is on the right or subtracted, as a visibility image; empty where there is none yet.
    const std::vector<float>& other() const {
        static const std::vector<float> none;
        if (against == Against::reference)
            return session.reference() ? session.reference()->reference.visibility : none;
        return session.method(1) ? session.method(1)->visibility() : none;
    }
    /// Opens a scene, an asset or a script; what is wrong with it is said.
    void open(const std::string& scene) {
        attempt([&] {
            session.open(scene);
            playing = false;
            playS = session.timeS();
            savePath = session.scene().id + "_view.toml";
            say("opened " + scene);
        });
    }
};

}  // namespace penumbra
