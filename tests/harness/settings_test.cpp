#include "harness/run/settings.hpp"

#include <gtest/gtest.h>

#include <regex>

#include "core/error.hpp"

namespace penumbra {
namespace {

/// A method of which only the parameters matter.
class Probe : public ShadowMethod {
    IntParameter taps_{this, "taps", 4, 1, 64, "", "an integer"};
    FloatParameter width_{this, "width", 0.5, 0.0, 2.0, "m", "a number"};
    ChoiceParameter shape_{this, "shape", {"disc", "square"}, "a choice"};

  public:
    Traits traits() const override { return {}; }
    std::vector<Assignments> ladder() const override {
        return {{{"taps", "1"}}, {{"taps", "4"}}, {{"taps", "16"}, {"shape", "square"}}};
    }
    void prepare(const Scene&, const Plan&) override {}
    void build(const Frame&, const Plan&) override {}
    void shade(const Frame&, const Plan&, const VisibilityTarget&) override {}
};
const Register<Probe> kProbe{"probe", "Parameters to set", "this test"};
const Register<Probe> kOther{"probe_other", "The same again", "this test"};

std::vector<std::string> paramsOf(const SettingChoice& choice) {
    std::vector<std::string> list;
    for (const Setting& s : expandSettings(choice)) list.push_back(s.params);
    return list;
}
std::vector<std::string> namesOf(const SettingChoice& choice) {
    std::vector<std::string> list;
    for (const Setting& s : expandSettings(choice)) list.push_back(s.name);
    return list;
}
std::string errorOf(const SettingChoice& choice) {
    try {
        expandSettings(choice);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}
using Texts = std::vector<std::string>;
const std::string kDefaults = "taps=4;width=0.5;shape=disc";

TEST(Settings, NoChoiceIsEveryMethodAtItsDefaultsAndTheSeparation) {
    const std::vector<Setting> settings = expandSettings({});
    ASSERT_EQ(settings.size(), methodRegistry().size() + 1);
    EXPECT_TRUE(settings.back().isSeparation());
    for (std::size_t i = 0; i + 1 < settings.size(); ++i) {
        EXPECT_FALSE(settings[i].isSeparation());
        EXPECT_EQ(settings[i].method, methodRegistry()[i].id);
        EXPECT_EQ(settings[i].name, settings[i].method);
        EXPECT_EQ(settings[i].params, methodRegistry()[i].make()->text());
        EXPECT_TRUE(settings[i].assignments.empty());
    }
}

TEST(Settings, MethodsComeInTheOrderAskedForAndOnce) {
    EXPECT_EQ(namesOf({.methods = {"probe_other", "probe", "probe_other"}}),
              (Texts{"probe_other", "probe"}));
}

TEST(Settings, TheSeparationIsThereWhenNamedOnceAndLast) {
    EXPECT_EQ(namesOf({.methods = {"separation"}}), Texts{"separation"});
    EXPECT_EQ(
        namesOf({.methods = {"separation", "probe", "separation"}, .sweeps = {"probe.taps=2,4"}})
            .back(),
        "separation");
    EXPECT_EQ(namesOf({.methods = {"probe", "separation"}, .ladder = true}).size(), 4u);
    EXPECT_EQ(namesOf({.methods = {"probe"}}), Texts{"probe"});
    EXPECT_EQ(errorOf({.sets = {"separation.x=1"}}),
              "--set separation.x: separation has no parameters");
    EXPECT_EQ(errorOf({.sweeps = {"separation.x=1,2"}}),
              "--sweep separation.x: separation has no parameters");
}

TEST(Settings, AChangedParameterNamesTheSetting) {
    const std::vector<Setting> settings =
        expandSettings({.methods = {"probe", "probe_other"}, .sets = {"probe.taps=8"}});
    ASSERT_EQ(settings.size(), 2u);
    EXPECT_TRUE(std::regex_match(settings[0].name, std::regex("probe-[0-9a-f]{8}")))
        << settings[0].name;
    EXPECT_EQ(settings[0].params, "taps=8;width=0.5;shape=disc");
    EXPECT_EQ(settings[0].assignments, (Assignments{{"taps", "8"}}));
    EXPECT_EQ(settings[0].make()->text(), settings[0].params);
    EXPECT_EQ(settings[1].name, "probe_other") << "--set is for one method";
}

TEST(Settings, NamesFollowValuesNotSpelling) {
    const auto nameWith = [](const Texts& sets) {
        return namesOf({.methods = {"probe"}, .sets = sets}).at(0);
    };
    EXPECT_EQ(nameWith({"probe.width=0.25"}), nameWith({"probe.width=2.5e-1"}));
    EXPECT_EQ(nameWith({"probe.taps=8", "probe.width=1"}),
              nameWith({"probe.width=1", "probe.taps=8"}));
    EXPECT_NE(nameWith({"probe.taps=8"}), nameWith({"probe.taps=9"}));
    EXPECT_EQ(nameWith({"probe.taps=4"}), "probe") << "the default, said aloud";
    EXPECT_EQ(nameWith({"probe.taps=8", "probe.taps=4"}), "probe") << "the last word counts";
    // Files of earlier runs are found by name, so a name may not change from version to version.
    EXPECT_EQ(nameWith({"probe.taps=8"}), "probe-e3989d2f");
}

TEST(Settings, SweepsAreCrossed) {
    EXPECT_EQ(paramsOf({.methods = {"probe"},
                        .sets = {"probe.width=1"},
                        .sweeps = {"probe.taps=2,4", "probe.shape=disc,square"}}),
              (Texts{"taps=2;width=1;shape=disc", "taps=2;width=1;shape=square",
                     "taps=4;width=1;shape=disc", "taps=4;width=1;shape=square"}));
    EXPECT_EQ(
        paramsOf({.methods = {"probe"}, .sets = {"probe.taps=64"}, .sweeps = {"probe.taps=2"}}),
        Texts{"taps=2;width=0.5;shape=disc"})
        << "a sweep is of that parameter, whatever it was set to";
}

TEST(Settings, DuplicatesCollapse) {
    EXPECT_EQ(paramsOf({.methods = {"probe"}, .sweeps = {"probe.width=0.5,0.50,5e-1,1"}}),
              (Texts{kDefaults, "taps=4;width=1;shape=disc"}));
    EXPECT_EQ(namesOf({.methods = {"probe"}, .sweeps = {"probe.taps=4,4"}}), Texts{"probe"});
}

TEST(Settings, TheLadderIsWalkedFromTheBottom) {
    EXPECT_EQ(paramsOf({.methods = {"probe"}, .ladder = true}),
              (Texts{"taps=1;width=0.5;shape=disc", kDefaults, "taps=16;width=0.5;shape=square"}));
    EXPECT_EQ(paramsOf({.methods = {"probe"}, .sweeps = {"probe.width=0,1"}, .ladder = true}),
              (Texts{"taps=1;width=0;shape=disc", "taps=1;width=1;shape=disc",
                     "taps=4;width=0;shape=disc", "taps=4;width=1;shape=disc",
                     "taps=16;width=0;shape=square", "taps=16;width=1;shape=square"}));
    EXPECT_EQ(paramsOf({.methods = {"probe"}, .sets = {"probe.taps=4"}, .ladder = true}),
              (Texts{kDefaults, "taps=4;width=0.5;shape=square"}))
        << "rungs that a --set makes equal are one";
}

TEST(Settings, EveryLadderOfEveryMethodIsValid) {
    const std::vector<Setting> settings = expandSettings({.ladder = true});
    EXPECT_GT(settings.size(), methodRegistry().size());
    for (const Setting& s : settings) EXPECT_EQ(s.isSeparation() ? "" : s.make()->text(), s.params);
}

TEST(Settings, MalformedAssignmentsAreErrors) {
    for (const char* text :
         {"", "probe", "probe.taps", "probe=1", ".taps=1", "probe.=1", "=", ".=", "probe=1.5"}) {
        EXPECT_EQ(errorOf({.sets = {text}}),
                  std::string("--set ") + text + ": expected METHOD.PARAMETER=VALUE");
        EXPECT_EQ(errorOf({.sweeps = {text}}),
                  std::string("--sweep ") + text + ": expected METHOD.PARAMETER=VALUE");
    }
}

TEST(Settings, UnknownNamesAndValuesListTheValidOnes) {
    std::string known;
    for (const MethodInfo& m : methodRegistry()) known += (known.empty() ? "" : ", ") + m.id;
    const std::string unknown = "unknown method 'nope'; the methods are " + known + ", separation";
    EXPECT_EQ(errorOf({.methods = {"probe", "nope"}}), unknown);
    EXPECT_EQ(errorOf({.sets = {"nope.taps=1"}}), unknown);
    EXPECT_EQ(errorOf({.sweeps = {"nope.taps=1"}}), unknown);

    const std::string absent = "probe.taps: probe is not among the methods of this run";
    EXPECT_EQ(errorOf({.methods = {"probe_other"}, .sets = {"probe.taps=1"}}), "--set " + absent);
    EXPECT_EQ(errorOf({.methods = {"probe_other"}, .sweeps = {"probe.taps=1"}}),
              "--sweep " + absent);

    EXPECT_EQ(errorOf({.sets = {"probe.tap=1"}}),
              "probe has no parameter 'tap'; it has taps, width, shape");
    EXPECT_EQ(errorOf({.sets = {"probe.taps=0"}}), "probe.taps: '0' is not in 1..64");
    EXPECT_EQ(errorOf({.sets = {"probe.width=wide"}}),
              "probe.width: 'wide' is not a number in 0..2 (m)");
    EXPECT_EQ(errorOf({.sweeps = {"probe.taps=1,,2"}}),
              "probe.taps: '' is not an integer in 1..64");
    EXPECT_EQ(errorOf({.sweeps = {"probe.shape=disc,round"}}),
              "probe.shape: 'round' is not one of disc|square");
}

TEST(ParseSetting, ReadsWhatSpelledWritesAndTheCsvHolds) {
    EXPECT_EQ(parseSetting("--paired", "hard").name, "hard");
    const Setting s = parseSetting("--paired", "pcf:taps=9;map_size=512");
    EXPECT_EQ(s.make()->text(), s.params);
    EXPECT_EQ(spelled(s), "pcf:map_size=512;taps=9");
    EXPECT_EQ(parseSetting("--paired", spelled(s)).name, s.name);
    EXPECT_EQ(parseSetting("--paired", s.method + ":" + s.params).name, s.name);
    EXPECT_EQ(spelled(parseSetting("--paired", "pcf:taps=49")), "pcf") << "49 is the default";
}

TEST(ParseSetting, RefusesTheRestSayingWhatIsValid) {
    const auto expectRefused = [](const std::string& text, const std::string& said) {
        try {
            parseSetting("--paired", text);
            ADD_FAILURE() << text;
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find(said), std::string::npos) << e.what();
        }
    };
    for (const char* text : {"", ":taps=9", "pcf:", "pcf:taps", "pcf:=9", "pcf:taps=9;"})
        expectRefused(text, "METHOD:PARAMETER=VALUE");
    expectRefused("nope", "pcf");
    expectRefused("pcf:nope=1", "taps");
    expectRefused("pcf:taps=0", "1..1024");
    expectRefused("pcf:taps=9;taps=9", "twice");
    expectRefused("separation", "pcf");
}

}  // namespace
}  // namespace penumbra
