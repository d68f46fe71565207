#pragma once

#include <memory>
#include <string>
#include <vector>

#include "methods/shadow_method.hpp"

namespace penumbra {

/// One method with one full set of parameter values.
struct Setting {
    std::string method;
    std::string name;         ///< the id at defaults, else `<id>-<8 hex of its parameters>`
    std::string params;       ///< Parameters::text of the full set
    Assignments assignments;  ///< what differs from the defaults

    /// Whether this is the row of the separation (harness/run/separation.hpp), which no method
    /// renders.
    bool isSeparation() const;
    /// A fresh instance with the assignments applied; not of the separation.
    std::unique_ptr<ShadowMethod> make() const;
};

/// What the command line says about settings.
struct SettingChoice {
    std::vector<std::string> methods{};  ///< ids; empty: all registered and the separation
    std::vector<std::string> sets{};     ///< "ID.P=V": applies to every setting of method ID
    /// "ID.P=V1,V2": one setting per value, crossed with the others of ID
    std::vector<std::string> sweeps{};
    bool ladder = false;  ///< every method's ladder instead of its defaults
};

/// Every setting asked for, without repetition, in the order of the methods, the separation last.
/// Throws InputError for an unknown method (a --set or --sweep for a method that is not run
/// included), parameter or value.
std::vector<Setting> expandSettings(const SettingChoice& choice);

/// One setting spelled as METHOD or METHOD:PARAMETER=VALUE;PARAMETER=VALUE..., as the CSV's method
/// and params columns say it; what is not given is at its default. `option` names the place in
/// errors. Throws InputError for anything else, an unknown method, parameter or value included.
Setting parseSetting(const std::string& option, const std::string& text);

/// What parseSetting reads as this setting, the shortest there is.
std::string spelled(const Setting& setting);

}  // namespace penumbra
