#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/effects/effects.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/supported_input.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/run/suite.hpp"
#include "methods/shadow_method.hpp"
#include "tests/cli/in_process.hpp"

namespace penumbra {
namespace {

using Texts = std::vector<std::string>;

const Texts kKinds = {"methods", "scenes", "suites", "metrics", "effects", "inputs"};

/// The ids that `kind` must list, as the libraries know them.
Texts idsOf(const std::string& kind) {
    Texts ids;
    const auto add = [&](const auto& list) {
        for (const auto& entry : list) ids.emplace_back(entry.id);
    };
    if (kind == "methods") add(methodRegistry());
    if (kind == "scenes") return SceneLibrary::standard().ids();
    if (kind == "suites") return suiteIds(SceneLibrary::standard());
    if (kind == "metrics") add(allMetrics());
    if (kind == "effects") add(allEffects());
    if (kind == "inputs") add(supportedInputs());
    return ids;
}

test::Finished list(const Texts& arguments) {
    Texts all = {"list"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    test::Finished done = test::penumbraInProcess(all);
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return done;
}

TEST(List, AsJson) {
    for (const std::string& kind : kKinds) {
        const auto entries = nlohmann::json::parse(list({kind, "--json"}).out);
        ASSERT_TRUE(entries.is_array()) << kind;
        Texts ids;
        for (const auto& entry : entries) {
            ids.push_back(entry.at("id").get<std::string>());
            const char* what = kind == "methods"                      ? "title"
                               : kind == "scenes" || kind == "suites" ? "shows"
                                                                      : "doc";
            EXPECT_FALSE(entry.at(what).get<std::string>().empty()) << ids.back();
            if (kind == "methods") {
                for (const auto& parameter : entry.at("parameters"))
                    for (const char* field : {"id", "type", "default", "range", "unit", "doc"})
                        EXPECT_TRUE(parameter.at(field).is_string()) << ids.back();
            }
        }
        EXPECT_EQ(ids, idsOf(kind));
    }
}

TEST(List, AsText) {
    for (const std::string& kind : kKinds) {
        Texts ids;
        for (const std::string& line : test::lines(list({kind}).out))
            if (!line.starts_with(' ')) ids.push_back(line.substr(0, line.find(' ')));
        EXPECT_EQ(ids, idsOf(kind));
    }
    const std::string methods = list({"methods"}).out;
    EXPECT_NE(methods.find("map_size"), std::string::npos) << "parameters follow their method";
}

TEST(List, AsMarkdown) {
    for (const std::string& kind : kKinds) {
        const Texts lines = test::lines(list({kind, "--markdown"}).out);
        ASSERT_GE(lines.size(), 3u) << kind;
        EXPECT_TRUE(lines[0].starts_with("| id |")) << kind << ": " << lines[0];
        EXPECT_TRUE(lines[1].starts_with("| --- |")) << kind << ": " << lines[1];
        // Every table has the same number of cells in every line.
        Texts ids;
        std::size_t columns = 0;
        bool first = true;
        for (const std::string& line : lines) {
            std::size_t bars = 0;
            for (std::size_t i = 0; i < line.size(); ++i)
                bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
            if (bars == 0) {
                columns = 0;
                first = false;
                continue;
            }
            EXPECT_TRUE(columns == 0 || bars == columns) << kind << ": " << line;
            columns = bars;
            if (first) ids.push_back(line.substr(2, line.find(' ', 2) - 2));
        }
        ids.erase(ids.begin(), ids.begin() + 2);
        EXPECT_EQ(ids, idsOf(kind));
    }
}

TEST(List, ByTheProgram) {
    const test::Finished done = test::penumbra({"list", "methods", "--json"});
    EXPECT_EQ(done.exitCode, 0);
    EXPECT_EQ(done.err, "");
    EXPECT_EQ(nlohmann::json::parse(done.out).size(), methodRegistry().size());
}

TEST(Help, IsNoError) {
    EXPECT_EQ(test::penumbra({"--help"}).exitCode, 0);
    std::vector<Texts> commands = {{"--help"}, {"-h"}};
    for (const char* command :
         {"compare", "list", "report", "merge", "diff", "score", "export", "stress"})
        commands.push_back({command, "--help"});
    for (const Texts& command : commands) {
        const test::Finished done = test::penumbraInProcess(command);
        EXPECT_EQ(done.exitCode, 0) << command[0];
        EXPECT_EQ(done.err, "") << command[0];
        EXPECT_NE(done.out.find("Usage"), std::string::npos) << command[0];
    }
    const std::string compare = test::penumbraInProcess({"compare", "--help"}).out;
    for (const char* option :
         {"--suite", "--scene", "--method", "--set", "--sweep", "--ladder", "--effects", "--size",
          "--repeats", "--seed", "--threads", "--context", "--reference", "--reference-se",
          "--cache", "--out", "--resume", "--shard"})
        EXPECT_NE(compare.find(option), std::string::npos) << option;
}

}  // namespace
}  // namespace penumbra
