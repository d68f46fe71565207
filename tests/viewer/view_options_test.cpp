#include "harness/viewer/view_options.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace penumbra {
namespace {

std::string refusal(const std::string& line) {
    try {
        parseCommandLine(line);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(ViewOptions, WhatIsCopiedCanBePasted) {
    ViewOptions o;
    o.scene = "my scene.glb";
    o.frame = 2;
    o.methods = {"pcss:blocker_taps=25", "pcf"};
    o.effects = "penumbra,moving_light";
    o.display = Display::split;
    o.against = Against::reference;
    o.width = 320;
    o.height = 200;
    const PastedLine back = parseCommandLine(viewLine(o));
    EXPECT_EQ(back.options.scene, o.scene);
    EXPECT_EQ(back.options.frame, 2);
    EXPECT_EQ(back.options.settings(), o.settings());
    EXPECT_EQ(back.options.effects, o.effects);
    EXPECT_EQ(back.options.display, o.display);
    EXPECT_EQ(back.options.against, o.against);
    EXPECT_EQ(back.options.width, 320);
    EXPECT_EQ(back.options.height, 200);
    EXPECT_TRUE(back.hasScene && back.hasFrame && back.hasMethod && back.hasEffects &&
                back.hasSize);
    EXPECT_FALSE(back.hasSet);
    EXPECT_EQ(viewLine(back.options), viewLine(o));
}

TEST(ViewOptions, ACompareLineIsTakenOverAndWhatIsNotIsNamed) {
    const PastedLine pasted = parseCommandLine(
        "./run compare --scene fence --method pcss pcf vsm --set pcss.blocker_taps=36 "
        "--repeats 3 --size 128x64");
    EXPECT_EQ(pasted.options.scene, "fence");
    EXPECT_EQ(pasted.options.settings(), (std::vector<std::string>{"pcss:blocker_taps=36", "pcf"}));
    EXPECT_EQ(pasted.options.width, 128);
    EXPECT_EQ(pasted.options.height, 64);
    EXPECT_EQ(pasted.unused, (std::vector<std::string>{"--repeats", "3", "vsm"}));
}

TEST(ViewOptions, CompareLinesOfTwoSettingsOfOneMethodArePairs) {
    ViewOptions o;
    o.methods = {"pcss", "pcss:blocker_taps=25"};
    const std::string line = compareLine(o);
    EXPECT_EQ(line, "penumbra compare --scene fence --paired pcss pcss:blocker_taps=25");
    EXPECT_EQ(parseCommandLine(line).options.settings(), o.settings());
    o.methods = {"pcss:blocker_taps=25", "pcf"};
    EXPECT_EQ(compareLine(o),
              "penumbra compare --scene fence --method pcss pcf --set pcss.blocker_taps=25");
}

TEST(ViewOptions, SetAppliesToEverySettingOfItsMethod) {
    ViewOptions o;
    o.methods = {"pcss:filter_taps=9", "pcss"};
    o.sets = {"pcss.blocker_taps=36"};
    EXPECT_EQ(o.settings(), (std::vector<std::string>{"pcss:filter_taps=9;blocker_taps=36",
                                                      "pcss:blocker_taps=36"}));
}

TEST(ViewOptions, BadLinesAreRefusedWithTheReason) {
    EXPECT_NE(refusal("rm -rf x").find("not a command line of penumbra"), std::string::npos);
    EXPECT_NE(refusal(""), "");
    EXPECT_NE(refusal("penumbra view --method nope").find("unknown method 'nope'"),
              std::string::npos);
    EXPECT_NE(refusal("penumbra view --method pcf --set pcss.blocker_taps=4")
                  .find("not among the methods"),
              std::string::npos);
    EXPECT_NE(refusal("penumbra view --method pcf --set pcf.nope=4").find("no parameter 'nope'"),
              std::string::npos);
    EXPECT_EQ(refusal("penumbra view --set vsm.blur=1"), "") << "whose method is not said";
    EXPECT_NE(refusal("penumbra view --size 12").find("--size 12"), std::string::npos);
    EXPECT_NE(refusal("penumbra view --effects nope").find("unknown effect"), std::string::npos);
    EXPECT_NE(refusal("penumbra view --display nope").find("side, split"), std::string::npos);
    EXPECT_NE(refusal("penumbra view --nope"), "");
}

}  // namespace
}  // namespace penumbra
