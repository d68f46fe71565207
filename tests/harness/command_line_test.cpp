#include "harness/run/command_line.hpp"

#include <gtest/gtest.h>

#include "core/effects/effects.hpp"
#include "harness/run/settings.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra {
namespace {

TEST(ShellQuoted, AShellReadsItBack) {
    for (const std::string& text :
         {std::string("plain"), std::string(""), std::string("a b"), std::string("it's $HOME `x`"),
          std::string("two\nlines"), std::string("\\\"*?"), std::string("-x;y=z")})
        EXPECT_EQ(test::Program({"/bin/sh", "-c", "printf %s " + shellQuoted(text)}).wait().out,
                  text);
    EXPECT_EQ(shellQuoted("pcf.taps=9"), "pcf.taps=9");
}

RunRecord record() {
    RunRecord r;
    r.width = 256;
    r.height = 128;
    r.repeats = 3;
    r.referenceSe = 1.0 / 1024;
    r.scenes = {{"fence", "", "", "elsewhere/fence.toml", 3, {}},
                {"my scene", "", "", "my scene.glb", 1, {}}};
    return r;
}

TEST(ReproducingCommand, NamesWhatIsNotTheDefault) {
    Row row;
    row.scene = "fence";
    row.method = row.setting = "pcf";
    row.params = parseSetting("", "pcf").params;
    RunRecord r = record();
    EXPECT_EQ(reproducingCommand(r, row),
              "penumbra compare --scene fence --method pcf --size 256x128 --repeats 3");

    row.scene = "my scene";
    row.params = parseSetting("", "pcf:taps=9").params;
    row.threads = 2;
    r.seed = 7;
    r.reference = "exact";
    r.referenceSe = 0.01;
    r.effects = "penumbra alpha_mask";
    r.cache = "/a cache";
    r.provenance = {{"context", "egl"}};
    EXPECT_EQ(reproducingCommand(r, row),
              "penumbra compare --scene 'my scene.glb' --method pcf --set pcf.taps=9 --size "
              "256x128 --repeats 3 --seed 7 --effects penumbra,alpha_mask --reference exact "
              "--reference-se 0.01 --threads 2 --context egl --cache '/a cache'");
}

TEST(ReproducingCommand, AMethodOfAnotherVersionKeepsItsWords) {
    Row row;
    row.scene = "fence";
    row.method = "no_such";
    row.params = "a=1;b=2";
    EXPECT_EQ(reproducingCommand(record(), row),
              "penumbra compare --scene fence --method no_such --set 'no_such.a=1;b=2' --size "
              "256x128 --repeats 3");
}

TEST(EffectsArgument, IsReadBackAsTheRecordSays) {
    RunRecord r;
    for (const std::string& text : {std::string("auto"), std::string("none"), std::string("all"),
                                    std::string("penumbra,alpha_mask")}) {
        const EffectChoice choice = EffectChoice::parse(text);
        r.effects = choice.automatic ? "auto" : choice.everyPixel ? "all" : choice.forced.text();
        EXPECT_EQ(effectsArgument(r), text);
    }
}

}  // namespace
}  // namespace penumbra
