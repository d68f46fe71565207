#include "harness/viewer/live_method.hpp"

#include "core/error.hpp"
#include "core/gl/context.hpp"

namespace penumbra {

LiveMethod::LiveMethod(const std::string& text)
    : setting_(std::make_unique<Setting>(parseSetting("--method", text))) {
    declared_ = setting_->make();
    restart();
}

void LiveMethod::setParameter(const std::string& id, const std::string& value) {
    declared_->set(setting_->method, id, value);
    changed();
}

void LiveMethod::resetParameters() {
    for (Parameter* p : declared_->parameters()) p->setText(p->defaultText());
    changed();
}

void LiveMethod::changed() {
    std::string text = setting_->method;
    for (const Parameter* p : declared_->parameters())
        text += (text.size() == setting_->method.size() ? ':' : ';') + p->id() + '=' + p->text();
    auto setting = std::make_unique<Setting>(parseSetting("--method", text));
    if (setting->name == setting_->name) return;
    run_.reset();
    setting_ = std::move(setting);
    restart();
}

void LiveMethod::restart() {
    run_ = std::make_unique<SettingRun>(*setting_);
    version_.reset();
    times_.clear();
}

template <class Work>
void LiveMethod::guarded(const Work& work) {
    status_ = "ok";
    message_.clear();
    try {
        work();
        return;
    } catch (const Unsupported& e) {
        status_ = "unsupported";
        message_ = e.what();
    } catch (const std::exception& e) {
        status_ = "failed";
        message_ = e.what();
    }
    gl::takeErrors();
    run_->forget();
    visibility_.clear();
    times_.clear();
    work_.reset();
    ++imageVersion_;
}

bool LiveMethod::render(const Frame& frame, std::uint64_t version, const Plan& plan,
                        const TextureTarget& target, bool again) {
    const bool fresh = version_ == version && plan_ == plan;
    if (fresh && !(again && status_ == "ok")) return false;
    // What compiles its shaders on the way is no time of a frame.
    const bool timed = run_->method() && plan_ == plan;
    plan_ = plan;
    version_ = version;
    if (!fresh) work_.reset();
    guarded([&] {
        const SettingRun::Sample sample = run_->live(frame, plan, target);
        if (timed) remember(sample);
        visibility_ = run_->visibility();
        keptMaps_ = run_->kept();
        ++imageVersion_;
    });
    return true;
}

void LiveMethod::remember(const SettingRun::Sample& sample) {
    times_.push_back(sample);
    if (times_.size() > kHistory) times_.pop_front();
}

bool LiveMethod::count(const Frame& frame, const TextureTarget& target) {
    if (work_ || !version_ || status_ != "ok") return false;
    guarded([&] {
        Row row;
        run_->warmUp(frame, plan_, /*keepMaps=*/false, target, row);
        work_ = std::move(row);
        remember(run_->timed(frame, target));
        keptMaps_ = run_->kept();
    });
    return true;
}

std::vector<NamedTexture> LiveMethod::textures() const {
    const ShadowMethod* method = run_ ? run_->method() : nullptr;
    if (!method || !version_ || status_ != "ok") return {};
    std::vector<NamedTexture> list = method->textures();
    std::erase_if(list, [](const NamedTexture& t) { return t.texture && !*t.texture; });
    return list;
}

}  // namespace penumbra
