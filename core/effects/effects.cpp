#include "core/effects/effects.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace penumbra {
namespace {

std::string allIds() {
    std::string ids;
    for (const EffectInfo& info : allEffects())
        ids += (ids.empty() ? "" : ", ") + std::string(info.id);
    return ids;
}

Effect effectById(const std::string& id) {
    for (const EffectInfo& info : allEffects())
        if (info.id == id) return info.effect;
    throw InputError("unknown effect '" + id +
                     "'; valid are auto, all, none or a comma-separated list of " + allIds());
}

}  // namespace

const std::array<EffectInfo, kEffectCount>& allEffects() {
    static const std::array<EffectInfo, kEffectCount> effects = {{
        {Effect::penumbra, "penumbra", "the light has extent that shows as soft shadow edges"},
        {Effect::self_shadow, "self_shadow", "a caster throws a shadow on itself"},
        {Effect::thin_casters, "thin_casters",
         "casters without thickness, such as leaves or wings"},
        {Effect::layered_casters, "layered_casters",
         "a ray from the light meets more than one caster"},
        {Effect::alpha_mask, "alpha_mask", "a caster is cut out by its texture's alpha"},
        {Effect::moving_light, "moving_light", "the light changes between frames"},
        {Effect::moving_casters, "moving_casters", "geometry changes between frames"},
        {Effect::moving_camera, "moving_camera", "the camera changes between frames"},
    }};
    return effects;
}

std::string EffectSet::text() const {
    std::string ids;
    for (const EffectInfo& info : allEffects())
        if (has(info.effect)) ids += (ids.empty() ? "" : " ") + std::string(info.id);
    return ids;
}

EffectChoice EffectChoice::parse(const std::string& text) {
    if (text == "auto") return {};
    if (text == "all") return {false, EffectSet::all(), {}, true};
    if (text == "none") return {false, {}, {}, false};
    EffectChoice choice{false, {}, {}, false};
    std::size_t begin = 0;
    while (true) {
        const std::size_t comma = text.find(',', begin);
        choice.forced.add(effectById(text.substr(begin, comma - begin)));
        if (comma == std::string::npos) return choice;
        begin = comma + 1;
    }
}

EffectSet EffectFindings::calledFor() const {
    EffectSet effects;
    for (const EffectInfo& info : allEffects())
        if ((*this)[info.effect].calledFor) effects.add(info.effect);
    return effects;
}

Plan planFor(const EffectChoice& choice, const EffectSet& calledFor, const EffectSet& canSimulate) {
    const EffectSet called = choice.automatic ? calledFor - choice.leftOut : choice.forced;
    return {called & canSimulate, canSimulate - called, called - canSimulate, choice.everyPixel};
}

}  // namespace penumbra
