#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/scene/supported_input.hpp"
#include "harness/cli/commands.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/run/suite.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

/// Every list is an array of flat objects whose first field names the entry; a method has its
/// parameters as a nested array.
Json listMethods() {
    Json list = Json::array();
    for (const MethodInfo& info : methodRegistry()) {
        const auto method = info.make();
        Json entry = {{"id", info.id},
                      {"title", info.title},
                      {"source", info.source},
                      {"simulates", method->traits().simulates.text()}};
        entry["parameters"] = Json::array();
        for (const Parameter* p : method->parameters())
            entry["parameters"].push_back({{"id", p->id()},
                                           {"type", p->type()},
                                           {"default", p->defaultText()},
                                           {"range", p->range()},
                                           {"unit", p->unit()},
                                           {"doc", p->doc()}});
        list.push_back(std::move(entry));
    }
    return list;
}

Json listScenes() {
    Json list = Json::array();
    const SceneLibrary library = SceneLibrary::standard();
    for (const std::string& id : library.ids()) {
        try {
            const auto scene = loadScene(id, library);
            list.push_back({{"id", id},
                            {"shows", scene->shows},
                            {"figure", scene->figure},
                            {"frames", scene->frameCount()}});
        } catch (const AssetAbsent& e) {
            list.push_back({{"id", id}, {"shows", e.what()}, {"figure", ""}, {"frames", 0}});
        }
    }
    return list;
}

Json listSuites() {
    Json list = Json::array();
    const SceneLibrary library = SceneLibrary::standard();
    for (const std::string& id : suiteIds(library)) {
        const Suite suite = loadSuite(id, library);
        list.push_back({{"id", id}, {"shows", suite.shows}, {"scenes", suite.scenes}});
    }
    return list;
}

Json listMetrics() {
    Json list = Json::array();
    for (const MetricInfo& m : allMetrics())
        list.push_back({{"id", m.id}, {"unit", m.unit}, {"doc", m.doc}});
    return list;
}

Json listEffects() {
    Json list = Json::array();
    for (const EffectInfo& e : allEffects()) list.push_back({{"id", e.id}, {"doc", e.doc}});
    return list;
}

/// What the loader reads, ignores, refuses and bounds.
Json listInputs() {
    Json list = Json::array();
    for (const SupportedInput& input : supportedInputs())
        list.push_back({{"id", input.id}, {"kind", input.kindName()}, {"doc", input.doc}});
    return list;
}

std::string cell(const Json& value) {
    if (!value.is_string()) return value.dump();
    std::string text;
    for (char c : value.get<std::string>()) text += c == '|' ? "\\|" : std::string(1, c);
    return text;
}

std::string markdownTable(const Json& list) {
    std::string head = "|", rule = "|", body;
    if (list.empty()) return "";
    for (const auto& [key, value] : list[0].items()) {
        if (value.is_array() && !value.empty() && value[0].is_object()) continue;
        head += " " + key + " |";
        rule += " --- |";
    }
    for (const Json& entry : list) {
        body += "|";
        for (const auto& [key, value] : entry.items())
            if (!(value.is_array() && !value.empty() && value[0].is_object()))
                body += " " + cell(value) + " |";
        body += "\n";
    }
    return head + "\n" + rule + "\n" + body;
}

std::string markdown(const Json& list) {
    std::string text = markdownTable(list);
    for (const Json& entry : list)
        if (entry.contains("parameters"))
            text +=
                fmt::format("\n### {}: {}\n\n{}\n\n{}", entry["id"].get<std::string>(),
                            entry["title"].get<std::string>(), entry["source"].get<std::string>(),
                            markdownTable(entry["parameters"]));
    return text;
}

std::string plain(const Json& list) {
    std::string text;
    for (const Json& entry : list) {
        const char* line = entry.contains("title")   ? "title"
                           : entry.contains("shows") ? "shows"
                                                     : "doc";
        text += fmt::format("{:<22} {}\n", entry["id"].get<std::string>(),
                            entry[line].get<std::string>());
        if (!entry.contains("parameters")) continue;
        for (const Json& p : entry["parameters"])
            text += fmt::format("    {:<18} {} = {} {} in {}: {}\n", p["id"].get<std::string>(),
                                p["type"].get<std::string>(), p["default"].get<std::string>(),
                                p["unit"].get<std::string>(), p["range"].get<std::string>(),
                                p["doc"].get<std::string>());
    }
    return text;
}

}  // namespace

void addListCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("list", "What there is to choose from");
    struct Choice {
        std::string kind;
        bool json = false, markdown = false;
    };
    auto choice = std::make_shared<Choice>();
    command
        ->add_option("kind", choice->kind, "methods | scenes | suites | metrics | effects | inputs")
        ->required()
        ->check(CLI::IsMember({"methods", "scenes", "suites", "metrics", "effects", "inputs"}));
    auto* json = command->add_flag("--json", choice->json, "as JSON");
    command->add_flag("--markdown", choice->markdown, "as Markdown tables")->excludes(json);
    command->callback([choice, &action] {
        action = [choice] {
            const Json list = choice->kind == "methods"   ? listMethods()
                              : choice->kind == "scenes"  ? listScenes()
                              : choice->kind == "suites"  ? listSuites()
                              : choice->kind == "metrics" ? listMetrics()
                              : choice->kind == "effects" ? listEffects()
                                                          : listInputs();
            fmt::print("{}", choice->json       ? list.dump(2) + "\n"
                             : choice->markdown ? markdown(list)
                                                : plain(list));
            return 0;
        };
    });
}

}  // namespace penumbra
