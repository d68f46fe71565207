#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "harness/viewer/frame_stage.hpp"
#include "harness/viewer/live_method.hpp"
#include "harness/viewer/progressive_reference.hpp"
#include "harness/viewer/timeline.hpp"
#include "harness/viewer/view_options.hpp"

namespace penumbra {

/// How far an image is from the reference, over the scored pixels (Metrics::rmse).
struct LiveScore {
    double rmse = 0.0;
    double rmseCorrected = 0.0;  ///< without what the reference's own noise adds
    double bias = 0.0;
};

/// Everything that the window shows, without the window: a scene at a time, camera and light, one
/// or two methods with their images, and the reference. Changes are told by the setters and take
/// effect with the next update(). Needs a context.
class ViewSession {
  public:
    /// Throws InputError for a scene, frame or method that is not to be had.
    explicit ViewSession(const ViewOptions& options);

    /// Shows another scene. Throws InputError with the loader's line and keeps the old scene.
    void open(const std::string& scene);
    /// A pasted command line: what it says is taken over, all else stays. Throws InputError and
    /// changes nothing; returns a note about what was not used, or "".
    std::string take(const PastedLine& line);

    const Scene& scene() const { return *timeline_.scene; }
    const std::string& sceneName() const { return options_.scene; }  ///< as loadScene() takes it
    const Timeline& timeline() const { return timeline_; }
    int frameIndex() const { return index_; }
    double timeS() const { return timeline_.timesS[static_cast<std::size_t>(index_)]; }
    void showFrame(int index);

    /// The frame's with what was changed by hand, which stays while the time goes on.
    const Camera& camera() const { return state_.camera; }
    const AreaLight& light() const { return state_.light; }
    void setCamera(const Camera& camera);
    void setLight(const AreaLight& light);
    bool cameraEdited() const { return camera_.has_value(); }
    bool lightEdited() const { return light_.has_value(); }
    void resetCamera();
    void resetLight();
    const SceneFrame& state() const { return state_; }

    int width() const { return options_.width; }
    int height() const { return options_.height; }
    void resize(int width, int height);

    /// Method 0 is always there, method 1 may be null.
    LiveMethod* method(std::size_t slot) { return methods_[slot].get(); }
    const LiveMethod* method(std::size_t slot) const { return methods_[slot].get(); }
    /// Throws InputError for what parseSetting() refuses.
    void setMethod(std::size_t slot, const std::string& spelled);
    void dropSecondMethod();

    /// `--effects` as text.
    const std::string& effects() const { return options_.effects; }
    void setEffects(const std::string& text);
    /// Switches one effect by hand, from what is planned for now.
    void switchEffect(Effect effect, bool on);
    /// What the frame calls for, and why.
    const EffectFindings& findings() const { return stage_.findings(); }
    /// What the methods are asked for: called for, or switched on by hand.
    EffectSet wanted() const;

    /// Makes what is not up to date: the frame, the images, the scores. Once nothing has changed
    /// any more, the work is counted. `measure`: renders and times again what is up to date.
    /// Returns whether anything new is to be shown.
    bool update(bool measure = false);
    /// Whether update() would find nothing to do but the reference.
    bool still() const { return still_; }

    /// Whether there is a frame, as there is from the first update() on that did not throw.
    bool shown() const { return stage_.staged(); }
    const Frame& frame() const { return stage_.frame(); }
    const ProgressiveReference& tracing() const { return reference_; }
    /// Null until the first estimate.
    const ProgressiveReference::Estimate* reference() const { return estimate_.get(); }
    /// Counts up with every estimate.
    std::uint64_t referenceVersion() const { return referenceVersion_; }
    std::uint64_t frameVersion() const { return version_; }
    const std::optional<LiveScore>& score(std::size_t slot) const { return scores_[slot]; }

    /// What a command line would have to say to show this again, but for an edited camera or light.
    ViewOptions described(Display display, Against against) const;

  private:
    void useTimeline(Timeline timeline);
    void evaluate();
    void scoreImages();

    ViewOptions options_;
    Timeline timeline_;
    int index_ = 0;
    SceneFrame state_;
    std::optional<Camera> camera_;
    std::optional<AreaLight> light_;
    std::array<std::unique_ptr<LiveMethod>, 2> methods_;
    FrameStage stage_;
    std::optional<TextureTarget> target_;
    bool stale_ = true, still_ = false;
    std::uint64_t version_ = 0;  ///< of the staged frame
    ProgressiveReference reference_;
    std::shared_ptr<const ProgressiveReference::Estimate> estimate_;
    std::uint64_t referenceVersion_ = 0;
    std::array<std::optional<LiveScore>, 2> scores_;
    std::array<std::pair<std::uint64_t, std::uint64_t>, 2> scored_{};  ///< image, reference
};

}  // namespace penumbra
