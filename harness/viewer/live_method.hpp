#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "harness/run/cells.hpp"

namespace penumbra {

/// One of the window's methods with its parameters, and what it made of the frame last shown to it.
/// A method that throws is failed until something changes.
class LiveMethod {
  public:
    /// `spelled` as parseSetting() reads it; throws what that throws.
    explicit LiveMethod(const std::string& spelled);

    const Setting& setting() const { return *setting_; }
    /// The declarations with the values in use; set through setParameter().
    const std::vector<Parameter*>& parameters() const { return declared_->parameters(); }
    bool atDefaults() const { return declared_->atDefaults(); }
    /// Throws InputError for a value out of range.
    void setParameter(const std::string& id, const std::string& value);
    void resetParameters();
    EffectSet simulates() const { return declared_->traits().simulates; }

    /// Renders and times `frame` unless it has that image already; true if it did. `version` names
    /// what `frame` shows: scene, time, camera, light and size; with `again` it is rendered anyway.
    bool render(const Frame& frame, std::uint64_t version, const Plan& plan,
                const TextureTarget& target, bool again);
    /// Counts the work of the image it has, by rendering it once more, and then times it with its
    /// maps. Nothing if that is known or there is no image; true if it rendered.
    bool count(const Frame& frame, const TextureTarget& target);
    /// Makes the method anew for the next frame: for another scene or size.
    void restart();

    /// ok | failed | unsupported, and why.
    const std::string& status() const { return status_; }
    const std::string& message() const { return message_; }
    const Plan& plan() const { return plan_; }
    /// Of the last frame; empty if there is none or it failed.
    const std::vector<float>& visibility() const { return visibility_; }
    /// Counts up with every image.
    std::uint64_t imageVersion() const { return imageVersion_; }
    /// Whether the last frame kept the light-space maps.
    bool keptMaps() const { return keptMaps_; }
    /// Times of the last frames, latest last; at most kHistory. Not of a method's first frame, in
    /// which drivers compile.
    const std::deque<SettingRun::Sample>& times() const { return times_; }
    static constexpr std::size_t kHistory = 160;
    /// Work counters of the image, where count() has been here.
    const std::optional<Row>& work() const { return work_; }
    std::vector<NamedTexture> textures() const;

  private:
    template <class Work>
    void guarded(const Work& work);
    void changed();
    void remember(const SettingRun::Sample& sample);

    std::unique_ptr<ShadowMethod> declared_;  ///< never rendered with
    std::unique_ptr<Setting> setting_;        ///< stays where it is: the run refers to it
    std::unique_ptr<SettingRun> run_;
    std::string status_ = "ok", message_;
    Plan plan_;
    std::optional<std::uint64_t> version_;  ///< of the frame that was rendered
    std::vector<float> visibility_;
    std::uint64_t imageVersion_ = 0;
    bool keptMaps_ = false;
    std::deque<SettingRun::Sample> times_;
    std::optional<Row> work_;
};

}  // namespace penumbra
