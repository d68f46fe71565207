#include "harness/study/stress/matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/scene/input_text.hpp"
#include "harness/study/stress/invariants.hpp"

namespace penumbra::stress {
namespace {

/// The scenes of a case, made once for all methods.
struct Stages {
    std::vector<std::unique_ptr<Stage>> list;

    Stages(const HardCase& c, std::uint32_t seed) {
        const auto add = [&](const SmallScene& scene) {
            list.push_back(std::make_unique<Stage>(scene.build(), c.size, seed));
        };
        add(c.scene);
        for (const Variant& variant : c.variants) add(variant.scene);
    }
};

std::vector<Setting> settingsOf(const HardCase& c, const std::string& method) {
    if (const auto own = c.settings.find(method); own != c.settings.end()) return own->second;
    if (!c.others) return {};
    if (!c.cheapest) return expandSettings({{method}, {}, {}, false});
    SettingChoice choice{{method}, {}, {}, false};
    const std::vector<Assignments> ladder = findMethod(method).make()->ladder();
    for (const auto& [parameter, value] : ladder.at(0))
        choice.sets.push_back(fmt::format("{}.{}={}", method, parameter, value));
    return expandSettings(choice);
}

/// The case's own invariant, or the range of all images where that is left.
Cell measure(const HardCase& c, const Setting& setting, const Stages& stages) {
    Trial trial{c, {}, {}, {}};
    for (const auto& stage : stages.list) {
        trial.stages.push_back(stage.get());
        trial.images.push_back(render(setting, *stage));
    }
    trial.again = [&] { return render(setting, *stages.list[0]); };
    Cell cell{c.id, setting.method, "range", setting.name, Status::pass, 0.0, 0.0, ""};
    Finding finding = findInvariant("range").measure(trial);
    if (finding.deviation == 0.0) {
        cell.invariant = c.invariant;
        cell.bound = c.bound;
        finding = findInvariant(c.invariant).measure(trial);
    }
    cell.deviation = finding.deviation;
    cell.note = finding.where;
    return cell;
}

Cell runCell(const HardCase& c, const std::string& method, const Stages& stages,
             const KnownLimitation* known) {
    const auto notApplicable = [&](const std::string& reason) {
        return Cell{c.id, method, c.invariant, method, Status::notApplicable, 0.0, 0.0, reason};
    };
    const EffectSet lacking = c.needs - findMethod(method).make()->traits().simulates;
    if (!lacking.empty()) return notApplicable("does not simulate " + lacking.text());
    const std::vector<Setting> settings = settingsOf(c, method);
    if (settings.empty()) return notApplicable("the case is about settings of other methods");
    Cell worst;
    for (const Setting& setting : settings) {
        Cell cell;
        try {
            cell = measure(c, setting, stages);
        } catch (const Unsupported& e) {
            return notApplicable(e.what());
        } catch (const InputError&) {
            throw;  // of the case's file
        } catch (const std::exception& e) {
            constexpr double kInfinity = std::numeric_limits<double>::infinity();
            cell = {c.id,         method,    "range", setting.name,
                    Status::fail, kInfinity, 0.0,     scene_detail::oneLine(e.what())};
        }
        // Beyond its bound, else nearest to it.
        if (worst.method.empty() || cell.deviation - cell.bound > worst.deviation - worst.bound)
            worst = cell;
    }
    worst.status = judge(worst.deviation, worst.bound, known);
    if (known && worst.status == Status::fail)
        worst.note += fmt::format("; {} predicts {:.4g} +- {:.2g}", known->place, known->predicted,
                                  known->tolerance);
    if (worst.status == Status::mended)
        worst.note = fmt::format("{} predicts {:.4g}, but it passes: remove the entry",
                                 known->place, known->predicted);
    return worst;
}

std::vector<std::string> chosen(const std::vector<std::string>& wanted,
                                const std::vector<std::string>& all, const char* what) {
    for (const std::string& id : wanted)
        if (std::ranges::find(all, id) == all.end())
            throw InputError(fmt::format("unknown {0} '{1}'; the {0}s are {2}", what,
                                         scene_detail::oneLine(id, 60), scene_detail::listed(all)));
    return wanted.empty() ? all : wanted;
}

}  // namespace

const char* nameOf(Status status) {
    switch (status) {
        case Status::pass:
            return "pass";
        case Status::fail:
            return "FAIL";
        case Status::known:
            return "known";
        case Status::mended:
            return "MENDED";
        case Status::notApplicable:
            break;
    }
    return "n/a";
}

Status judge(double deviation, double bound, const KnownLimitation* known) {
    if (deviation <= bound) return known ? Status::mended : Status::pass;
    const bool asPredicted = known && std::abs(deviation - known->predicted) <= known->tolerance;
    return asPredicted ? Status::known : Status::fail;
}

const Cell* Matrix::find(const std::string& hardCase, const std::string& method) const {
    for (const Cell& cell : cells)
        if (cell.hardCase == hardCase && cell.method == method) return &cell;
    return nullptr;
}

bool Matrix::wrong() const {
    return std::ranges::any_of(cells, &Cell::wrong);
}

std::vector<Cell> runCase(const HardCase& c, const std::vector<std::string>& methods,
                          const std::vector<KnownLimitation>& known, std::uint32_t seed) {
    const Stages stages(c, seed);
    std::vector<Cell> cells;
    for (const std::string& method : methods)
        cells.push_back(runCell(c, method, stages, findKnown(known, c.id, method)));
    return cells;
}

Matrix runMatrix(const CaseLibrary& library, const MatrixOptions& options,
                 const std::function<void(std::size_t, std::size_t, const std::string&)>& starts) {
    Matrix matrix;
    std::vector<std::string> methods;
    for (const MethodInfo& info : methodRegistry()) methods.push_back(info.id);
    matrix.methods = chosen(options.methods, methods, "method");
    const std::vector<std::string> cases = library.ids();
    for (const std::string& id : chosen(options.cases, cases, "case"))
        matrix.cases.push_back(library.load(id));
    matrix.known = readKnown(library.folder / "known.toml", cases);
    matrix.elsewhere = readElsewhere(library.folder / "elsewhere.toml");
    for (std::size_t i = 0; i < matrix.cases.size(); ++i) {
        const HardCase& c = matrix.cases[i];
        starts(i, matrix.cases.size(), c.id);
        for (Cell& cell : runCase(c, matrix.methods, matrix.known, options.seed))
            matrix.cells.push_back(std::move(cell));
    }
    return matrix;
}

}  // namespace penumbra::stress
