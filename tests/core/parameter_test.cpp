#include "core/parameter/parameter.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/error.hpp"

namespace penumbra {
namespace {

struct Sample : Parameters {
    IntParameter taps{this, "taps", 16, 1, 64, "texels", "Taps across the kernel."};
    FloatParameter radius{this, "radius", 0.5, 0, 2.5, "", "Radius of the kernel."};
    BoolParameter fast{this, "fast", true, "Whether to be fast."};
    ChoiceParameter pattern{this, "pattern", {"grid", "vogel"}, "Where the taps lie."};
};

std::string inputError(Parameters& parameters, const char* id, const char* value) {
    try {
        parameters.set("pcf", id, value);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

TEST(Parameter, DeclarationsSayEverything) {
    const Sample s;
    ASSERT_EQ(s.parameters().size(), 4u);
    EXPECT_EQ(s.parameters()[0], &s.taps);
    EXPECT_EQ(s.parameters()[3], &s.pattern);

    EXPECT_EQ(s.taps.type(), "int");
    EXPECT_EQ(s.taps.range(), "1..64");
    EXPECT_EQ(s.taps.unit(), "texels");
    EXPECT_EQ(s.taps.doc(), "Taps across the kernel.");
    EXPECT_EQ(s.taps.defaultText(), "16");
    EXPECT_EQ(s.taps.extremes(), (std::vector<std::string>{"1", "64"}));
    EXPECT_FALSE(s.taps.isFloat());

    EXPECT_EQ(s.radius.type(), "float");
    EXPECT_EQ(s.radius.range(), "0..2.5");
    EXPECT_EQ(s.radius.extremes(), (std::vector<std::string>{"0", "2.5"}));
    EXPECT_TRUE(s.radius.isFloat());

    EXPECT_EQ(s.fast.type(), "bool");
    EXPECT_EQ(s.fast.range(), "true|false");
    EXPECT_EQ(s.fast.number(), 1.0);

    EXPECT_EQ(s.pattern.type(), "choice");
    EXPECT_EQ(s.pattern.range(), "grid|vogel");
    EXPECT_EQ(s.pattern.extremes(), (std::vector<std::string>{"grid", "vogel"}));
    EXPECT_EQ(s.pattern.defaultText(), "grid");
}

TEST(Parameter, EveryExtremeIsAcceptedAndRoundTrips) {
    Sample s;
    for (Parameter* p : s.parameters()) {
        for (const std::string& value : p->extremes()) {
            p->setText(value);
            EXPECT_EQ(p->text(), value) << p->id();
        }
    }
}

TEST(Parameter, AFixedValueHasOneExtreme) {
    struct : Parameters {
        IntParameter one{this, "one", 1, 1, 1, "", ""};
    } s;
    EXPECT_EQ(s.one.extremes(), std::vector<std::string>{"1"});
}

TEST(Parameter, TextIsCanonical) {
    Sample s;
    EXPECT_EQ(s.text(), "taps=16;radius=0.5;fast=true;pattern=grid");
    EXPECT_TRUE(s.atDefaults());
    s.set("pcf", "radius", "1.250");
    EXPECT_EQ(s.radius.text(), "1.25");
    EXPECT_FALSE(s.atDefaults());
    s.set("pcf", "radius", "1e-1");
    EXPECT_EQ(s.radius.text(), "0.1");
    EXPECT_EQ(double(s.radius), 0.1);
    s.set("pcf", "radius", "-0");
    EXPECT_EQ(s.radius.text(), "0");
    s.set("pcf", "radius", "0.50");
    s.set("pcf", "taps", "016");
    EXPECT_TRUE(s.atDefaults());
    s.set("pcf", "pattern", "vogel");
    s.set("pcf", "fast", "false");
    EXPECT_EQ(s.text(), "taps=16;radius=0.5;fast=false;pattern=vogel");
    EXPECT_EQ(s.pattern.index(), 1);
    EXPECT_TRUE(s.pattern.is("vogel"));
    EXPECT_FALSE(bool(s.fast));
}

TEST(Parameter, FloatTextRoundTripsEveryBit) {
    Sample s;
    const double third = 1.0 / 3.0;
    s.set("pcf", "radius", "0.3333333333333333");
    EXPECT_EQ(double(s.radius), third);
    EXPECT_EQ(s.radius.text(), "0.3333333333333333");
}

TEST(Parameter, OutOfRangeNamesTheRange) {
    Sample s;
    EXPECT_EQ(inputError(s, "taps", "0"), "pcf.taps: '0' is not in 1..64 (texels)");
    EXPECT_EQ(inputError(s, "taps", "65"), "pcf.taps: '65' is not in 1..64 (texels)");
    EXPECT_EQ(inputError(s, "radius", "-0.1"), "pcf.radius: '-0.1' is not in 0..2.5");
    EXPECT_EQ(inputError(s, "radius", "2.6"), "pcf.radius: '2.6' is not in 0..2.5");
    EXPECT_EQ(inputError(s, "fast", "1"), "pcf.fast: '1' is not one of true|false");
    EXPECT_EQ(inputError(s, "pattern", "Grid"), "pcf.pattern: 'Grid' is not one of grid|vogel");
    EXPECT_TRUE(s.atDefaults()) << "a refused value changes nothing";
}

TEST(Parameter, OnlyWholeNumbersInTheCLocaleAreRead) {
    Sample s;
    for (const char* value : {"", " 4", "4 ", "4.5", "4x", "x", "+4", "0x4", "99999999999", "1,0"})
        EXPECT_EQ(inputError(s, "taps", value),
                  "pcf.taps: '" + std::string(value) + "' is not an integer in 1..64 (texels)");
    for (const char* value :
         {"", " 1", "1 ", "1,5", "1x", "x", "+1", "nan", "inf", "-inf", "1e999", "0x1"})
        EXPECT_EQ(inputError(s, "radius", value),
                  "pcf.radius: '" + std::string(value) + "' is not a number in 0..2.5");
    EXPECT_TRUE(s.atDefaults());
}

TEST(Parameter, UnknownIdsListTheKnownOnes) {
    Sample s;
    EXPECT_EQ(inputError(s, "foo", "1"),
              "pcf has no parameter 'foo'; it has taps, radius, fast, pattern");
    Parameters none;
    EXPECT_EQ(inputError(none, "foo", "1"), "pcf has no parameters, not even 'foo'");
    EXPECT_EQ(none.text(), "");
    EXPECT_TRUE(none.atDefaults());
}

TEST(Parameter, SetTextThrowsInvalidArgument) {
    Sample s;
    EXPECT_THROW(s.taps.setText("0"), std::invalid_argument);
    EXPECT_THROW(s.radius.setText("nan"), std::invalid_argument);
    EXPECT_THROW(s.fast.setText("yes"), std::invalid_argument);
    EXPECT_THROW(s.pattern.setText(""), std::invalid_argument);
}

TEST(Parameter, MistakesInDeclarationsAreFound) {
    struct Twice : Parameters {
        IntParameter a{this, "same", 1, 0, 2, "", ""};
        IntParameter b{this, "same", 1, 0, 2, "", ""};
    };
    EXPECT_THROW(Twice(), std::logic_error);
    struct OutOfRange : Parameters {
        FloatParameter a{this, "a", 3, 0, 2, "", ""};
    };
    EXPECT_THROW(OutOfRange(), std::logic_error);
    struct NoChoice : Parameters {
        ChoiceParameter a{this, "a", {}, ""};
    };
    EXPECT_THROW(NoChoice(), std::logic_error);
}

}  // namespace
}  // namespace penumbra
