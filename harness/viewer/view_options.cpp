#include "harness/viewer/view_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/error.hpp"
#include "harness/cli/truth_options.hpp"
#include "harness/run/command_line.hpp"

namespace penumbra {
namespace {

constexpr const char* kDefaultMethod = "pcss";

void append(std::string& line, const std::string& argument) {
    line += ' ' + shellQuoted(argument);
}

void append(std::string& line, const std::string& option, const std::string& value) {
    append(line, option);
    append(line, value);
}

/// What both lines say alike.
void appendCommon(std::string& line, const ViewOptions& o) {
    const ViewOptions defaults;
    if (o.effects != defaults.effects) append(line, "--effects", o.effects);
    if (o.width != defaults.width || o.height != defaults.height)
        append(line, "--size", fmt::format("{}x{}", o.width, o.height));
    if (o.seed != defaults.seed) append(line, "--seed", std::to_string(o.seed));
}

Display displayCalled(const std::string& id) {
    for (const DisplayName& name : kDisplays)
        if (id == name.id) return name.display;
    throw InputError(fmt::format("--display {}: expected single, side, split or difference", id));
}

void addOptions(CLI::App& command, EnteredView& entered) {
    ViewOptions& o = entered.options;
    command.add_option("--scene", o.scene,
                       "scene id, script (.toml) or asset (.glb, .gltf) (default: fence)");
    command.add_option("--set", o.sets, "METHOD.PARAMETER=VALUE");
    command.add_option("--effects", o.effects, "auto | all | none | a,b,... (see list effects)");
    addTruthOptions(command, o, entered.size, "image size WxH (default: 512x512)");
}

}  // namespace

std::vector<std::string> ViewOptions::settings() const {
    std::vector<std::string> spelledSettings = methods;
    if (spelledSettings.empty()) spelledSettings = {kDefaultMethod};
    if (spelledSettings.size() > 2)
        throw InputError(fmt::format("--method: at most two can be seen at once, {} are given",
                                     spelledSettings.size()));
    std::vector<Setting> parsed;
    for (const std::string& text : spelledSettings)
        parsed.push_back(parseSetting("--method", text));
    for (const std::string& text : sets) {
        SettingChoice choice;
        for (const Setting& setting : parsed) choice.methods.push_back(setting.method);
        choice.sets = {text};
        const std::vector<Setting> assigned = expandSettings(choice);  // refuses what is wrong
        for (Setting& setting : parsed)
            for (const Setting& with : assigned)
                for (const auto& [id, value] : with.assignments)
                    if (with.method == setting.method) {
                        std::erase_if(setting.assignments,
                                      [&](const auto& known) { return known.first == id; });
                        setting.assignments.emplace_back(id, value);
                    }
    }
    spelledSettings.clear();
    for (const Setting& setting : parsed) spelledSettings.push_back(spelled(setting));
    return spelledSettings;
}

ViewOptions EnteredView::finish() const {
    ViewOptions o = options;
    finishTruthOptions(o, size);
    if (window) std::tie(o.windowWidth, o.windowHeight) = parsePair("--window", *window, 'x');
    if (o.windowWidth > 16384 || o.windowHeight > 16384)
        throw InputError(fmt::format("--window {}: at most 16384x16384", *window));
    if (!display.empty()) o.display = displayCalled(display);
    o.against = against == "reference" ? Against::reference : Against::method;
    EffectChoice::parse(o.effects);
    return o;
}

void addViewOptions(CLI::App& command, EnteredView& entered) {
    addOptions(command, entered);
    ViewOptions& o = entered.options;
    command.add_option("--frame", o.frame, "which of the script's frames (default: 0)");
    command.add_option("--method", o.methods,
                       "one method or two, each METHOD or 'METHOD:PARAMETER=VALUE;...' (default: "
                       "pcss)");
    command.add_option("--display", entered.display,
                       "single | side | split | difference (default: single)");
    command
        .add_option("--against", entered.against,
                    "what the first method is seen beside: method (the second) | reference")
        ->check(CLI::IsMember({"method", "reference"}));
    command.add_option("--window", entered.window, "window size WxH (default: 1600x940)");
    command.add_option("--screenshot", o.screenshot,
                       "write the window's content as PNG once it shows all, and close");
    command
        .add_option("--settle", o.settleS,
                    "seconds that a screenshot waits at most for the reference to converge")
        ->check(CLI::Range(0.0, 3600.0));
}

PastedLine parseCommandLine(const std::string& line) {
    CLI::App app("", "penumbra");
    app.require_subcommand(1);
    EnteredView entered;
    CLI::App* const view = app.add_subcommand("view");
    addViewOptions(*view, entered);
    CLI::App* const compare = app.add_subcommand("compare");
    std::vector<std::string> scenes, paired;
    addOptions(*compare, entered);
    compare->remove_option(compare->get_option("--scene"));
    CLI::Option* const sceneList = compare->add_option("--scene", scenes);
    compare->add_option("--method", entered.options.methods);
    compare->add_option("--paired", paired)->expected(2);
    compare->allow_extras();
    try {
        std::string rest = line;
        const auto begin = rest.find_first_not_of(" \t\r\n$");
        rest.erase(0, begin == std::string::npos ? rest.size() : begin);
        const auto space = std::min(rest.find_first_of(" \t"), rest.size());
        const std::string program = rest.substr(0, space);
        if (program != "penumbra" && program != "./run" && !program.ends_with("/penumbra") &&
            !program.ends_with("/run"))
            throw InputError("not a command line of penumbra: it begins with '" + program + "'");
        rest.erase(0, space);
        for (char& c : rest)
            if (c == '\n' || c == '\r') c = ' ';
        app.parse(rest);
    } catch (const CLI::ParseError& e) {
        throw InputError(e.what());
    }
    CLI::App* const used = view->parsed() ? view : compare;
    if (!scenes.empty()) entered.options.scene = scenes.front();
    if (!paired.empty()) entered.options.methods = paired;
    PastedLine out;
    out.unused = compare->remaining();
    if (scenes.size() > 1) out.unused.insert(out.unused.end(), scenes.begin() + 1, scenes.end());
    auto& methods = entered.options.methods;
    while (methods.size() > 2) {
        out.unused.push_back(methods.back());
        methods.pop_back();
    }
    out.hasScene = used == compare ? sceneList->count() > 0 : view->count("--scene") > 0;
    out.hasFrame = used == view && view->count("--frame") > 0;
    out.hasMethod = !methods.empty();
    out.hasSet = used->count("--set") > 0;
    out.hasEffects = used->count("--effects") > 0;
    out.hasSize = used->count("--size") > 0;
    out.hasDisplay = used == view && view->count("--display") + view->count("--against") > 0;
    out.options = entered.finish();
    if (out.hasMethod) out.options.settings();
    return out;
}

std::string viewLine(const ViewOptions& o) {
    const ViewOptions defaults;
    std::string line = "penumbra view";
    append(line, "--scene", o.scene);
    if (o.frame != defaults.frame) append(line, "--frame", std::to_string(o.frame));
    append(line, "--method");
    for (const std::string& setting : o.settings()) append(line, setting);
    if (o.display != defaults.display)
        append(line, "--display", kDisplays[static_cast<std::size_t>(o.display)].id);
    if (o.against == Against::reference) append(line, "--against", "reference");
    appendCommon(line, o);
    return line;
}

std::string compareLine(const ViewOptions& o) {
    std::vector<Setting> settings;
    for (const std::string& text : o.settings()) settings.push_back(parseSetting("--method", text));
    std::string line = "penumbra compare";
    append(line, "--scene", o.scene);
    if (settings.size() == 2 && settings[0].method == settings[1].method &&
        settings[0].name != settings[1].name) {
        append(line, "--paired");
        for (const Setting& setting : settings) append(line, spelled(setting));
    } else {
        append(line, "--method");
        for (const Setting& setting : settings) append(line, setting.method);
        for (const Setting& setting : settings)
            for (const auto& [id, value] : setting.assignments)
                append(line, "--set", fmt::format("{}.{}={}", setting.method, id, value));
    }
    appendCommon(line, o);
    return line;
}

}  // namespace penumbra
