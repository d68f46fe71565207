#include "harness/run/settings.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "harness/run/separation.hpp"

namespace penumbra {
namespace {

struct Assigned {
    std::string method, parameter, value;
};

/// "ID.P=V" for an option named `option`.
Assigned parseAssignment(const std::string& option, const std::string& text) {
    const auto dot = text.find('.');
    const auto equals = text.find('=');
    if (dot == std::string::npos || equals == std::string::npos || dot == 0 || equals < dot + 2)
        throw InputError(fmt::format("{} {}: expected METHOD.PARAMETER=VALUE", option, text));
    return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1)};
}

std::vector<std::string> splitCommas(const std::string& text) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t comma; (comma = text.find(',', begin)) != std::string::npos; begin = comma + 1)
        parts.push_back(text.substr(begin, comma - begin));
    parts.push_back(text.substr(begin));
    return parts;
}

Setting makeSetting(const std::string& id, const Assignments& assignments) {
    Setting setting{id, id, "", {}};
    const auto method = findMethod(id).make();
    for (const auto& [parameter, value] : assignments) method->set(id, parameter, value);
    setting.params = method->text();
    if (!method->atDefaults()) {
        const auto digest = XXH3_64bits(setting.params.data(), setting.params.size());
        setting.name = fmt::format("{}-{:08x}", id, digest >> 32);
    }
    for (const Parameter* p : method->parameters())
        if (p->text() != p->defaultText()) setting.assignments.emplace_back(p->id(), p->text());
    return setting;
}

/// The method `id` of `--method`, or null for the separation.
const MethodInfo* findChosen(const std::string& id) {
    if (id == kSeparation) return nullptr;
    try {
        return &findMethod(id);
    } catch (const InputError& e) {
        throw InputError(fmt::format("{}, {}", e.what(), kSeparation));
    }
}

}  // namespace

bool Setting::isSeparation() const {
    return method == kSeparation;
}

std::unique_ptr<ShadowMethod> Setting::make() const {
    auto instance = findMethod(method).make();
    for (const auto& [parameter, value] : assignments) instance->set(method, parameter, value);
    return instance;
}

std::vector<Setting> expandSettings(const SettingChoice& choice) {
    std::vector<std::string> ids;
    bool separation = choice.methods.empty();
    for (const std::string& id : choice.methods) {
        const MethodInfo* info = findChosen(id);
        if (!info)
            separation = true;
        else if (std::ranges::find(ids, id) == ids.end())
            ids.push_back(id);
    }
    if (choice.methods.empty())
        for (const MethodInfo& info : methodRegistry()) ids.push_back(info.id);

    std::map<std::string, std::vector<Assignments>> variants;
    for (const std::string& id : ids)
        variants[id] =
            choice.ladder ? findMethod(id).make()->ladder() : std::vector<Assignments>{{}};
    const auto variantsOf = [&](const std::string& option, const Assigned& a) -> auto& {
        if (!findChosen(a.method))
            throw InputError(fmt::format("{} {}.{}: {} has no parameters", option, a.method,
                                         a.parameter, a.method));
        const auto it = variants.find(a.method);
        if (it == variants.end())
            throw InputError(fmt::format("{} {}.{}: {} is not among the methods of this run",
                                         option, a.method, a.parameter, a.method));
        return it->second;
    };
    for (const std::string& text : choice.sets) {
        const Assigned a = parseAssignment("--set", text);
        for (Assignments& v : variantsOf("--set", a)) v.emplace_back(a.parameter, a.value);
    }
    for (const std::string& text : choice.sweeps) {
        const Assigned a = parseAssignment("--sweep", text);
        auto& list = variantsOf("--sweep", a);
        std::vector<Assignments> crossed;
        for (const Assignments& v : list)
            for (const std::string& value : splitCommas(a.value)) {
                crossed.push_back(v);
                crossed.back().emplace_back(a.parameter, value);
            }
        list = std::move(crossed);
    }

    std::vector<Setting> settings;
    for (const std::string& id : ids)
        for (const Assignments& v : variants[id]) {
            Setting setting = makeSetting(id, v);
            if (std::ranges::find(settings, setting.name, &Setting::name) == settings.end())
                settings.push_back(std::move(setting));
        }
    if (separation) {
        const std::string name(kSeparation);
        settings.push_back({name, name, "", {}});
    }
    return settings;
}

Setting parseSetting(const std::string& option, const std::string& text) {
    const auto malformed = [&] {
        return InputError(fmt::format(
            "{} {}: expected METHOD or METHOD:PARAMETER=VALUE;PARAMETER=VALUE...", option, text));
    };
    const auto colon = text.find(':');
    const std::string id = text.substr(0, colon);
    if (id.empty()) throw malformed();
    findMethod(id);
    Assignments assignments;
    for (std::size_t begin = colon; begin < text.size();) {
        const std::size_t end = std::min(text.find(';', begin + 1), text.size());
        const std::string part = text.substr(begin + 1, end - begin - 1);
        const auto equals = part.find('=');
        if (equals == 0 || equals == std::string::npos) throw malformed();
        const std::string parameter = part.substr(0, equals);
        if (std::ranges::find(assignments, parameter, &Assignments::value_type::first) !=
            assignments.end())
            throw InputError(fmt::format("{} {}: {} is given twice", option, text, parameter));
        assignments.emplace_back(parameter, part.substr(equals + 1));
        begin = end;
    }
    return makeSetting(id, assignments);
}

std::string spelled(const Setting& setting) {
    std::string text = setting.method;
    for (const auto& [parameter, value] : setting.assignments)
        text += (text.size() == setting.method.size() ? ':' : ';') + parameter + '=' + value;
    return text;
}

}  // namespace penumbra
