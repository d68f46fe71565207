#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "harness/run/settings.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// How two images share the view.
enum class Display { single, side, split, difference };
/// What is on the right, or subtracted.
enum class Against { method, reference };

struct DisplayName {
    Display display;
    const char* id;
    const char* title;
};
inline constexpr DisplayName kDisplays[] = {{Display::single, "single", "Single"},
                                            {Display::side, "side", "Side by side"},
                                            {Display::split, "split", "Split"},
                                            {Display::difference, "difference", "Difference"}};

/// What `penumbra view` was asked for, and what a copied command line says.
struct ViewOptions : TruthOptions {
    std::string scene = "fence";
    int frame = 0;
    std::vector<std::string> methods;  ///< as parseSetting() reads them; at most two
    std::vector<std::string> sets;     ///< "ID.P=V"
    std::string effects = "auto";
    Display display = Display::single;
    Against against = Against::method;
    int windowWidth = 1600, windowHeight = 940;
    std::string screenshot;  ///< PNG of the window once it shows all; then the window closes
    double settleS = 0.0;    ///< what a screenshot waits for the reference

    /// The methods with `sets` applied, spelled; one or two. Throws InputError.
    std::vector<std::string> settings() const;
};

/// As entered, before it is checked.
struct EnteredView {
    ViewOptions options;
    std::optional<std::string> size, window;
    std::string display, against;

    /// Throws InputError.
    ViewOptions finish() const;
};
/// Declares the options of `penumbra view` on `command`.
void addViewOptions(CLI::App& command, EnteredView& entered);

/// A command line that someone pasted, of `view` or of `compare`.
struct PastedLine {
    ViewOptions options;
    bool hasScene = false, hasFrame = false, hasMethod = false, hasSet = false, hasEffects = false,
         hasSize = false, hasDisplay = false;
    std::vector<std::string> unused;  ///< options of `compare` that a view has no use for
};
/// Throws InputError, also for a line that is none of penumbra's.
PastedLine parseCommandLine(const std::string& line);

/// `penumbra view ...` that shows this again; what is at its default is left out.
std::string viewLine(const ViewOptions& options);
/// `penumbra compare ...` with the same scene, settings, effects and size.
std::string compareLine(const ViewOptions& options);

}  // namespace penumbra
