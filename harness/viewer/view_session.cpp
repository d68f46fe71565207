#include "harness/viewer/view_session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "harness/metrics/error_sums.hpp"

namespace penumbra {
namespace {

Timeline loadForView(const std::string& scene) {
    try {
        return loadTimeline(scene, SceneLibrary::standard());
    } catch (const AssetAbsent& e) {
        throw InputError(e.what());
    }
}

int listedFrame(const Timeline& timeline, int frame) {
    const int last = static_cast<int>(timeline.listed.size()) - 1;
    if (frame < 0 || frame > last)
        throw InputError(
            fmt::format("--frame {}: scene '{}' has {}", frame, timeline.scene->id,
                        last == 0 ? "only frame 0" : fmt::format("frames 0 to {}", last)));
    return timeline.listed[static_cast<std::size_t>(frame)];
}

std::optional<LiveScore> scoreOf(const std::vector<float>& visibility, const Reference& reference,
                                 const GBuffer& gbuffer) {
    if (visibility.size() != reference.visibility.size()) return {};
    ErrorSums errors;
    double noise = 0.0;
    for (std::size_t i = 0; i < visibility.size(); ++i) {
        if (gbuffer.mask[i] != PixelClass::scored || !std::isfinite(visibility[i])) continue;
        errors.add(static_cast<double>(visibility[i]) - reference.visibility[i]);
        noise += static_cast<double>(reference.standardError[i]) * reference.standardError[i];
    }
    const std::optional<double> rmse = errors.rms();
    if (!rmse) return {};
    return LiveScore{
        *rmse,
        std::sqrt(std::max(0.0, errors.sumSquares - noise) / static_cast<double>(errors.count)),
        *errors.mean(errors.sum)};
}

}  // namespace

ViewSession::ViewSession(const ViewOptions& options)
    : options_(options), timeline_(loadForView(options.scene)), reference_(options) {
    index_ = listedFrame(timeline_, options.frame);
    const std::vector<std::string> settings = options.settings();
    for (std::size_t slot = 0; slot < settings.size(); ++slot) setMethod(slot, settings[slot]);
    evaluate();
}

void ViewSession::open(const std::string& scene) {
    Timeline timeline = loadForView(scene);
    options_.scene = scene;
    useTimeline(std::move(timeline));
}

void ViewSession::useTimeline(Timeline timeline) {
    timeline_ = std::move(timeline);
    index_ = timeline_.listed.front();
    camera_.reset();
    light_.reset();
    for (const auto& method : methods_)
        if (method) method->restart();
    evaluate();
}

std::string ViewSession::take(const PastedLine& pasted) {
    const ViewOptions& o = pasted.options;
    // All that can be refused comes first.
    std::optional<Timeline> timeline;
    if (pasted.hasScene && o.scene != options_.scene) timeline = loadForView(o.scene);
    std::optional<int> index;
    if (pasted.hasFrame) index = listedFrame(timeline ? *timeline : timeline_, o.frame);
    std::vector<std::string> settings;
    if (pasted.hasMethod) {
        settings = o.settings();
    } else if (pasted.hasSet) {
        ViewOptions here = described(Display::single, Against::method);
        here.sets = o.sets;
        settings = here.settings();
    }
    for (std::size_t slot = 0; slot < settings.size(); ++slot) setMethod(slot, settings[slot]);
    if (pasted.hasMethod && settings.size() < 2) dropSecondMethod();
    if (timeline) {
        options_.scene = o.scene;
        useTimeline(*std::move(timeline));
    }
    if (index) showFrame(*index);
    if (pasted.hasEffects) setEffects(o.effects);
    if (pasted.hasSize) resize(o.width, o.height);
    return pasted.unused.empty() ? "" : fmt::format("not used: {}", fmt::join(pasted.unused, " "));
}

void ViewSession::showFrame(int index) {
    index = std::clamp(index, 0, static_cast<int>(timeline_.timesS.size()) - 1);
    if (index == index_) return;
    index_ = index;
    evaluate();
}

void ViewSession::setCamera(const Camera& camera) {
    if (camera == state_.camera) return;
    camera_ = camera;
    evaluate();
}

void ViewSession::setLight(const AreaLight& light) {
    if (light == state_.light) return;
    light_ = light;
    evaluate();
}

void ViewSession::resetCamera() {
    camera_.reset();
    evaluate();
}

void ViewSession::resetLight() {
    light_.reset();
    evaluate();
}

void ViewSession::resize(int width, int height) {
    if (width == options_.width && height == options_.height) return;
    options_.width = width;
    options_.height = height;
    for (const auto& method : methods_)
        if (method) method->restart();
    stale_ = true;
}

void ViewSession::evaluate() {
    state_ = timeline_.scene->frame(index_);
    if (camera_) state_.camera = *camera_;
    if (light_) state_.light = *light_;
    stale_ = true;
}

void ViewSession::setMethod(std::size_t slot, const std::string& text) {
    methods_.at(slot) = std::make_unique<LiveMethod>(text);
    scores_[slot].reset();
    scored_[slot] = {};
}

void ViewSession::dropSecondMethod() {
    methods_[1].reset();
    scores_[1].reset();
}

void ViewSession::setEffects(const std::string& text) {
    EffectChoice::parse(text);
    options_.effects = text;
}

void ViewSession::switchEffect(Effect effect, bool on) {
    EffectSet set = wanted();
    if (on)
        set.add(effect);
    else
        set = set - EffectSet{effect};
    std::string text = set.text();
    std::ranges::replace(text, ' ', ',');
    setEffects(text.empty() ? "none" : text);
}

EffectSet ViewSession::wanted() const {
    const EffectChoice choice = EffectChoice::parse(options_.effects);
    return choice.automatic ? findings().calledFor() : choice.forced;
}

bool ViewSession::update(bool measure) {
    bool shown = false;
    if (stale_) {
        stale_ = false;
        ++version_;
        if (!target_ || target_->width() != width() || target_->height() != height())
            target_.emplace(width(), height());
        stage_.stage(timeline_.scene, index_, state_, width(), height(), options_.seed);
        const bool listed = std::ranges::find(timeline_.listed, index_) != timeline_.listed.end();
        reference_.ask({timeline_.scene, index_, stage_.tracer(), stage_.gbuffer(), state_.light,
                        listed && !cameraEdited() && !lightEdited()});
        estimate_.reset();
        scores_ = {};
        scored_ = {};
        shown = true;
    }
    still_ = true;
    if (!stage_.staged()) return shown;  // staging threw; only a change can mend that
    const EffectChoice effects = EffectChoice::parse(options_.effects);
    for (const auto& method : methods_) {
        if (!method) continue;
        const Plan plan = planFor(effects, findings().calledFor(), method->simulates());
        shown |= method->render(frame(), version_, plan, *target_, measure);
    }
    still_ = !shown;
    if (still_) {
        for (const auto& method : methods_)
            if (method && method->count(frame(), *target_)) {
                shown = true;
                break;  // one for each update, so that the window answers in between
            }
    }
    if (const auto latest = reference_.latest(); latest != estimate_ && latest) {
        estimate_ = latest;
        ++referenceVersion_;
        shown = true;
    }
    scoreImages();
    return shown;
}

void ViewSession::scoreImages() {
    for (std::size_t slot = 0; slot < methods_.size(); ++slot) {
        const LiveMethod* method = methods_[slot].get();
        if (!method || !estimate_) {
            scores_[slot].reset();
            continue;
        }
        const auto now = std::pair(method->imageVersion(), referenceVersion_);
        if (scored_[slot] == now) continue;
        scored_[slot] = now;
        scores_[slot] = scoreOf(method->visibility(), estimate_->reference, *stage_.gbuffer());
    }
}

ViewOptions ViewSession::described(Display display, Against against) const {
    ViewOptions o = options_;
    o.sets.clear();
    o.methods.clear();
    for (const auto& method : methods_)
        if (method) o.methods.push_back(spelled(method->setting()));
    const auto listed = std::ranges::find(timeline_.listed, index_);
    o.frame =
        listed == timeline_.listed.end() ? 0 : static_cast<int>(listed - timeline_.listed.begin());
    o.display = display;
    o.against = against;
    return o;
}

}  // namespace penumbra
