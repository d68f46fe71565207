#include "core/effects/effects.hpp"

#include <gtest/gtest.h>

#include <set>

#include "core/error.hpp"

namespace penumbra {
namespace {

TEST(Effects, TableIsInTheOrderOfTheEnumWithDistinctIds) {
    std::set<std::string_view> ids;
    for (std::size_t i = 0; i < kEffectCount; ++i) {
        const EffectInfo& info = allEffects()[i];
        EXPECT_EQ(static_cast<std::size_t>(info.effect), i);
        EXPECT_FALSE(info.doc.empty());
        ids.insert(info.id);
    }
    EXPECT_EQ(ids.size(), kEffectCount);
}

TEST(EffectSet, TextIsInTheOrderOfTheEnum) {
    EXPECT_EQ(EffectSet().text(), "");
    EXPECT_EQ((EffectSet{Effect::alpha_mask, Effect::penumbra}).text(), "penumbra alpha_mask");
    EXPECT_EQ(EffectSet::all().text(),
              "penumbra self_shadow thin_casters layered_casters alpha_mask moving_light "
              "moving_casters moving_camera");
}

TEST(EffectSet, Algebra) {
    const EffectSet a{Effect::penumbra, Effect::alpha_mask};
    const EffectSet b{Effect::penumbra, Effect::moving_light};
    EXPECT_EQ(a & b, EffectSet{Effect::penumbra});
    EXPECT_EQ(a - b, EffectSet{Effect::alpha_mask});
    EXPECT_TRUE((a - a).empty());
    EXPECT_TRUE(EffectSet(a).add(Effect::moving_light).has(Effect::moving_light));
}

TEST(EffectChoice, Parses) {
    EXPECT_TRUE(EffectChoice::parse("auto").automatic);
    const EffectChoice all = EffectChoice::parse("all");
    EXPECT_FALSE(all.automatic);
    EXPECT_EQ(all.forced, EffectSet::all());
    const EffectChoice none = EffectChoice::parse("none");
    EXPECT_FALSE(none.automatic);
    EXPECT_TRUE(none.forced.empty());
    const EffectChoice list = EffectChoice::parse("moving_light,penumbra");
    EXPECT_FALSE(list.automatic);
    EXPECT_EQ(list.forced, (EffectSet{Effect::penumbra, Effect::moving_light}));
}

TEST(EffectChoice, RefusesEverythingElseAndNamesTheIds) {
    for (const char* text : {"", "Penumbra", "penumbra,", ",penumbra", "penumbra alpha_mask",
                             "penumbra,auto", "penumbra, alpha_mask"}) {
        try {
            EffectChoice::parse(text);
            ADD_FAILURE() << "accepted '" << text << "'";
        } catch (const InputError& e) {
            const std::string message = e.what();
            EXPECT_NE(message.find("auto, all, none"), std::string::npos) << message;
            for (const EffectInfo& info : allEffects())
                EXPECT_NE(message.find(info.id), std::string::npos) << message;
        }
    }
}

TEST(EffectFindings, WhatIsCalledForIsTheSetOfThoseThatAre) {
    EffectFindings findings;
    for (const EffectInfo& info : allEffects()) findings[info.effect].calledFor = false;
    EXPECT_TRUE(findings.calledFor().empty());
    findings[Effect::alpha_mask] = {true, "a reason"};
    EXPECT_EQ(findings.calledFor(), EffectSet{Effect::alpha_mask});
}

TEST(Plan, IsCalledForAndPossible) {
    const EffectSet called{Effect::penumbra, Effect::alpha_mask};
    const EffectSet can{Effect::penumbra, Effect::self_shadow};
    const Plan plan = planFor(EffectChoice::parse("auto"), called, can);
    EXPECT_EQ(plan.simulated, EffectSet{Effect::penumbra});
    EXPECT_EQ(plan.skipped, EffectSet{Effect::self_shadow});
    EXPECT_EQ(plan.missing, EffectSet{Effect::alpha_mask});
    EXPECT_TRUE(plan.has(Effect::penumbra));
    EXPECT_FALSE(plan.has(Effect::alpha_mask));
}

TEST(Plan, ForcedEffectsReplaceWhatTheSceneCallsFor) {
    const EffectSet called{Effect::alpha_mask};
    const EffectSet can{Effect::penumbra, Effect::self_shadow};
    const Plan all = planFor(EffectChoice::parse("all"), called, can);
    EXPECT_EQ(all.simulated, can);
    EXPECT_TRUE(all.skipped.empty());
    EXPECT_EQ(all.missing, EffectSet::all() - can);
    const Plan none = planFor(EffectChoice::parse("none"), called, can);
    EXPECT_TRUE(none.simulated.empty());
    EXPECT_EQ(none.skipped, can);
    EXPECT_TRUE(none.missing.empty());
    const Plan list = planFor(EffectChoice::parse("penumbra,moving_light"), called, can);
    EXPECT_EQ(list.simulated, EffectSet{Effect::penumbra});
    EXPECT_EQ(list.skipped, EffectSet{Effect::self_shadow});
    EXPECT_EQ(list.missing, EffectSet{Effect::moving_light});
}

TEST(Plan, WhatIsLeftOutIsSkipped) {
    EffectChoice choice;
    choice.leftOut.add(Effect::penumbra);
    const EffectSet both{Effect::penumbra, Effect::self_shadow};
    const Plan plan = planFor(choice, both, both);
    EXPECT_EQ(plan.simulated, EffectSet{Effect::self_shadow});
    EXPECT_EQ(plan.skipped, EffectSet{Effect::penumbra});
    EXPECT_TRUE(plan.missing.empty());
}

}  // namespace
}  // namespace penumbra
