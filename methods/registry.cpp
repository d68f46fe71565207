#include <algorithm>

#include "core/error.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

std::vector<MethodInfo>& registry() {
    static std::vector<MethodInfo> entries;
    return entries;
}

}  // namespace

void registerMethod(MethodInfo info) {
    auto& entries = registry();
    const auto at = std::ranges::lower_bound(entries, info.id, {}, &MethodInfo::id);
    entries.insert(at, std::move(info));
}

const std::vector<MethodInfo>& methodRegistry() {
    return registry();
}

const MethodInfo& findMethod(const std::string& id) {
    std::string known;
    for (const MethodInfo& m : registry()) {
        if (m.id == id) return m;
        known += (known.empty() ? "" : ", ") + m.id;
    }
    throw InputError("unknown method '" + id + "'; the methods are " + known);
}

}  // namespace penumbra
