#include "harness/study/claims.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/run/settings.hpp"

namespace penumbra {
namespace {

const std::vector<std::string> kTimes = {"frame_ms", "build_ms", "shade_ms"};
const std::vector<std::string> kWork = {"draw_calls", "triangles",    "fragments",
                                        "maps",       "light_texels", "texture_mib"};
constexpr std::string_view kPenumbraWidth = "penumbra_width";

struct RelationName {
    const char* name;
    Relation relation;
    bool numeric;  ///< compares with the paper's number
};
constexpr std::array<RelationName, 5> kRelations = {{{"match", Relation::match, true},
                                                     {"at_least", Relation::at_least, true},
                                                     {"at_most", Relation::at_most, true},
                                                     {"above_one", Relation::above_one, false},
                                                     {"below_one", Relation::below_one, false}}};

bool contains(const std::vector<std::string>& list, std::string_view text) {
    return std::ranges::find(list, text) != list.end();
}

class Reader {
  public:
    Reader(const std::filesystem::path& file, const std::vector<std::string>& scenes)
        : file_(file), scenes_(scenes) {}

    Paper read() {
        toml::table root;
        try {
            root = toml::parse_file(file_.string());
        } catch (const toml::parse_error& e) {
            throw InputError(
                fmt::format("{}:{}: {}", file_.string(), e.source().begin.line, e.description()));
        }
        checkKeys(root, "a paper", {"citation", "claim"});
        Paper paper{file_.stem().string(), text(root, "citation"), {}};
        const toml::node* claims = root.get("claim");
        if (!claims || !claims->is_array_of_tables())
            fail(claims ? *claims : root, "claims are written as [[claim]], at least one");
        for (const toml::node& node : *claims->as_array())
            paper.claims.push_back(readClaim(*node.as_table()));
        return paper;
    }

  private:
    [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
        throw InputError(fmt::format("{}:{}: {}", file_.string(),
                                     std::max<unsigned>(node.source().begin.line, 1), what));
    }

    void checkKeys(const toml::table& table, const char* owner,
                   const std::vector<std::string>& valid) const {
        for (const auto& [key, node] : table)
            if (!contains(valid, key.str()))
                fail(node, fmt::format("unknown key '{}' in {}; valid keys are {}", key.str(),
                                       owner, fmt::join(valid, ", ")));
    }

    std::string text(const toml::table& table, const char* key) const {
        const toml::node* node = table.get(key);
        if (!node) fail(table, fmt::format("'{}' is missing", key));
        const auto value = node->value_exact<std::string>();
        if (!value || value->empty() || value->find_first_of("\r\n") != std::string::npos)
            fail(*node, fmt::format("{} must be a line of text", key));
        return *value;
    }

    double positive(const toml::node& node, const char* key) const {
        const auto value = node.value<double>();
        if (!node.is_number() || !std::isfinite(*value) || *value <= 0.0)
            fail(node, fmt::format("{} must be a finite number above 0", key));
        return *value;
    }

    int count(const toml::node& node, const char* key, int most) const {
        const auto value = node.value_exact<std::int64_t>();
        if (!value || *value < 0 || *value > most)
            fail(node, fmt::format("{} must be a whole number in 0..{}", key, most));
        return static_cast<int>(*value);
    }

    Claim readClaim(const toml::table& table) {
        checkKeys(
            table, "[[claim]]",
            {"id", "claim", "place", "not_implemented", "metric", "scene", "frame", "light_scale",
             "subdivisions", "a", "b", "paper", "expect", "factor", "why", "found"});
        Claim claim;
        claim.id = text(table, "id");
        if (!ids_.insert(claim.id).second)
            fail(*table.get("id"), fmt::format("a claim is called '{}' already", claim.id));
        claim.statement = text(table, "claim");
        claim.place = text(table, "place");
        if (table.contains("not_implemented")) {
            claim.technique = text(table, "not_implemented");
            checkKeys(table, "a claim that is not implemented here",
                      {"id", "claim", "place", "not_implemented", "paper"});
            if (const toml::node* ratio = table.get("paper"))
                claim.expected.ratio = positive(*ratio, "paper");
            return claim;
        }
        claim.metric = text(table, "metric");
        if (!contains(claimMetrics(), claim.metric))
            fail(*table.get("metric"), fmt::format("unknown metric '{}'; valid are {}",
                                                   claim.metric, fmt::join(claimMetrics(), ", ")));
        ClaimSide common;
        readPlace(table, common);
        claim.a = readSide(table, "a", common, claim.metric);
        claim.b = readSide(table, "b", common, claim.metric);
        if (claim.a == claim.b) fail(*table.get("b"), "b is the same as a");
        readExpectation(table, claim.expected);
        claim.why = text(table, "why");
        if (table.contains("found")) claim.found = text(table, "found");
        return claim;
    }

    /// What both a claim and its sides may say about where a setting is measured.
    void readPlace(const toml::table& table, ClaimSide& side) const {
        if (const toml::node* scene = table.get("scene")) {
            side.scene = text(table, "scene");
            if (!contains(scenes_, side.scene))
                fail(*scene, fmt::format("unknown scene '{}'; scenes are {}", side.scene,
                                         fmt::join(scenes_, ", ")));
        }
        if (const toml::node* frame = table.get("frame")) side.frame = count(*frame, "frame", 9999);
        if (const toml::node* scale = table.get("light_scale"))
            side.variation.lightScale = positive(*scale, "light_scale");
        if (const toml::node* times = table.get("subdivisions"))
            side.variation.subdivisions = count(*times, "subdivisions", 8);
    }

    ClaimSide readSide(const toml::table& table, const char* key, const ClaimSide& common,
                       const std::string& metric) const {
        const toml::node* node = table.get(key);
        if (!node) fail(table, fmt::format("'{}' is missing", key));
        ClaimSide side = common;
        const toml::node* setting = node;
        if (const toml::table* own = node->as_table()) {
            checkKeys(*own, "a side of a claim",
                      {"setting", "scene", "frame", "light_scale", "subdivisions"});
            setting = own->get("setting");
            if (!setting) fail(*node, "'setting' is missing");
            readPlace(*own, side);
        }
        const auto name = setting->value_exact<std::string>();
        if (!name) fail(*setting, fmt::format("{} must be a setting or a table with one", key));
        side.setting = *name;
        if (side.setting == kTruth) {
            if (metric != kPenumbraWidth)
                fail(*setting, fmt::format("{} has a {} only", kTruth, kPenumbraWidth));
        } else {
            try {
                parseSetting(key, side.setting);
            } catch (const InputError& e) {
                fail(*setting, e.what());
            }
        }
        if (side.scene.empty()) fail(*node, fmt::format("no scene is given for {}", key));
        return side;
    }

    void readExpectation(const toml::table& table, Expectation& expected) const {
        const std::string name = text(table, "expect");
        const auto known =
            std::ranges::find_if(kRelations, [&](const auto& r) { return r.name == name; });
        if (known == kRelations.end()) {
            std::vector<std::string> names;
            for (const RelationName& r : kRelations) names.emplace_back(r.name);
            fail(*table.get("expect"),
                 fmt::format("unknown relation '{}'; valid are {}", name, fmt::join(names, ", ")));
        }
        expected.relation = known->relation;
        const toml::node* ratio = table.get("paper");
        const toml::node* factor = table.get("factor");
        if (ratio) expected.ratio = positive(*ratio, "paper");
        if (known->numeric && !ratio)
            fail(table, fmt::format("expect = \"{}\" needs 'paper', its ratio", name));
        if (factor) expected.factor = positive(*factor, "factor");
        const bool match = known->relation == Relation::match;
        if (match != (expected.factor > 1.0))
            fail(factor ? *factor : table,
                 "'factor', above 1, goes with expect = \"match\" and with nothing else");
    }

    std::filesystem::path file_;
    const std::vector<std::string>& scenes_;
    std::set<std::string> ids_;
};

}  // namespace

const std::vector<std::string>& claimMetrics() {
    static const std::vector<std::string> kAll = [] {
        std::vector<std::string> list = kTimes;
        list.insert(list.end(), kWork.begin(), kWork.end());
        for (const MetricInfo& m : allMetrics())
            if (m.id != "flicker") list.emplace_back(m.id);  // which needs two frames
        list.emplace_back(kPenumbraWidth);
        return list;
    }();
    return kAll;
}

bool isTime(const std::string& metric) {
    return contains(kTimes, metric);
}

bool isOfImage(const std::string& metric) {
    return !isTime(metric) && !contains(kWork, metric);
}

std::vector<Paper> loadPapers(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".toml") files.push_back(entry.path());
    if (files.empty())
        throw InputError(fmt::format("{}: holds no .toml of a paper's claims", folder.string()));
    std::ranges::sort(files);
    const std::vector<std::string> scenes = SceneLibrary::standard().ids();
    std::vector<Paper> papers;
    for (const auto& file : files) papers.push_back(Reader(file, scenes).read());
    return papers;
}

}  // namespace penumbra
