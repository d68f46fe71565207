#include "harness/study/stress/output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "harness/report/escape.hpp"
#include "harness/run/files.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/study/stress/invariants.hpp"

namespace penumbra::stress {
namespace {

std::string replaced(const std::string& text, const std::map<char, std::string>& by) {
    std::string out;
    for (const char c : text) {
        const auto at = by.find(c);
        out += at == by.end() ? std::string(1, c) : at->second;
    }
    return out;
}

std::string markdown(const std::string& text) {
    return replaced(text, {{'|', "\\|"}, {'<', "&lt;"}});
}

std::string csv(const std::string& text) {
    return text.find_first_of(",\"\n") == std::string::npos
               ? text
               : "\"" + replaced(text, {{'"', "\"\""}}) + "\"";
}

std::string figure(double value) {
    return std::isinf(value) ? "not finite" : fmt::format("{:.3g}", value);
}

std::string sentence(const Cell& cell) {
    if (cell.status == Status::notApplicable) return cell.note;
    return fmt::format("{} deviates by {}, bound {}{}{}", cell.invariant, figure(cell.deviation),
                       figure(cell.bound), cell.note.empty() ? "" : "; ", cell.note);
}

std::string numbersOf(const HardCase& c) {
    return fmt::format("{}", fmt::join(c.numbers, ", "));
}

/// The cell of an invariant that comes nearest to its bound, or is farthest beyond it, for those
/// `counts` says to look at; null if there is none.
template <class Counts>
const Cell* worstOf(const Matrix& matrix, const std::string& invariant, const Counts& counts) {
    const Cell* worst = nullptr;
    for (const Cell& cell : matrix.cells)
        if (cell.invariant == invariant && counts(cell) &&
            (!worst || cell.deviation > worst->deviation))
            worst = &cell;
    return worst;
}

std::string worstTable(const Matrix& matrix) {
    std::string text =
        "| invariant | what must hold | cells | worst that passes | bound there | case, method | "
        "worst that is known |\n| --- | --- | --- | --- | --- | --- | --- |\n";
    for (const Invariant& invariant : allInvariants()) {
        const auto passing = [](const Cell& c) { return c.status == Status::pass; };
        const auto known = [](const Cell& c) { return c.status == Status::known; };
        const Cell* pass = worstOf(matrix, invariant.id, passing);
        const Cell* explained = worstOf(matrix, invariant.id, known);
        const auto cells = std::ranges::count_if(matrix.cells, [&](const Cell& c) {
            return c.status != Status::notApplicable &&
                   (c.invariant == invariant.id || invariant.id == "range");
        });
        text += fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", invariant.id,
                            markdown(invariant.doc), cells, pass ? figure(pass->deviation) : "",
                            pass ? figure(pass->bound) : "",
                            pass ? pass->hardCase + ", " + pass->method : "",
                            explained ? fmt::format("{}: {}, {}", figure(explained->deviation),
                                                    explained->hardCase, explained->method)
                                      : "");
    }
    return text;
}

std::string matrixTable(const Matrix& matrix) {
    std::string text = "| case |", rule = "| --- |";
    for (const std::string& method : matrix.methods) {
        text += " " + method + " |";
        rule += " --- |";
    }
    text += "\n" + rule + "\n";
    for (const HardCase& c : matrix.cases) {
        text += "| " + c.id + " |";
        for (const std::string& method : matrix.methods) {
            const Cell& cell = *matrix.find(c.id, method);
            text += cell.status == Status::notApplicable
                        ? " n/a |"
                        : fmt::format(" {} {} |", nameOf(cell.status), figure(cell.deviation));
        }
        text += "\n";
    }
    return text;
}

std::string elsewhereTable(const Matrix& matrix) {
    if (matrix.elsewhere.empty()) return "";
    std::string text =
        "\n## Hard cases that are held elsewhere\n\n"
        "The other numbers of METHODS.md (scenes/stress/elsewhere.toml): what none of the images "
        "above would show, and the tests that hold it; without a test, nothing is registered that "
        "the case is about.\n\n"
        "| METHODS.md | what | why it is no case | tests |\n| --- | --- | --- | --- |\n";
    for (const Elsewhere& e : matrix.elsewhere)
        text += fmt::format("| {} | {} | {} | {} |\n", e.number, markdown(e.what),
                            markdown(e.because), fmt::join(e.tests, ", "));
    return text;
}

template <class Counts, class Line>
void section(std::string& text, const Matrix& matrix, const std::string& title,
             const Counts& counts, const Line& line) {
    std::string lines;
    for (const Cell& cell : matrix.cells)
        if (counts(cell)) lines += line(cell);
    if (!lines.empty()) text += "\n" + title + "\n" + lines;
}

}  // namespace

std::string tableText(const Matrix& matrix) {
    std::size_t width = 4;
    for (const HardCase& c : matrix.cases) width = std::max(width, c.id.size());
    std::string text = fmt::format("{:<{}}", "", width);
    for (const std::string& method : matrix.methods)
        text += fmt::format("  {:>8}", method.substr(0, 8));
    text += "\n";
    for (const HardCase& c : matrix.cases) {
        text += fmt::format("{:<{}}", c.id, width);
        for (const std::string& method : matrix.methods)
            text += fmt::format("  {:>8}", nameOf(matrix.find(c.id, method)->status));
        text += "\n";
    }
    const auto line = [](const Cell& cell) {
        return fmt::format("  {} with {}: {}\n", cell.hardCase, cell.setting, sentence(cell));
    };
    const auto ofStatus = [](Status status) {
        return [status](const Cell& cell) { return cell.status == status; };
    };
    section(text, matrix, "Failed:", ofStatus(Status::fail), line);
    section(text, matrix, "Mended, to be removed from known.toml:", ofStatus(Status::mended), line);
    section(text, matrix, "Known limitations:", ofStatus(Status::known), line);
    const auto count = [&](Status status) {
        return std::ranges::count(matrix.cells, status, &Cell::status);
    };
    text += fmt::format("\n{} cells: {} pass, {} known, {} failed, {} mended, {} not applicable\n",
                        matrix.cells.size(), count(Status::pass), count(Status::known),
                        count(Status::fail), count(Status::mended), count(Status::notApplicable));
    return text;
}

std::string csvText(const Matrix& matrix) {
    std::string text = "case,method,setting,invariant,status,deviation,bound,note\n";
    for (const Cell& cell : matrix.cells)
        text += fmt::format("{},{},{},{},{},{},{},{}\n", cell.hardCase, cell.method, cell.setting,
                            cell.invariant, nameOf(cell.status), cell.deviation, cell.bound,
                            csv(cell.note));
    return text;
}

std::string junitText(const Matrix& matrix) {
    const auto count = [&](const auto& predicate) {
        return std::ranges::count_if(matrix.cells, predicate);
    };
    std::string text = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"stress\" "
        "tests=\"{}\" failures=\"{}\" skipped=\"{}\">\n",
        matrix.cells.size(), count([](const Cell& c) { return c.wrong(); }),
        count([](const Cell& c) { return c.status == Status::notApplicable; }));
    for (const Cell& cell : matrix.cells) {
        text += fmt::format("<testcase classname=\"stress.{}\" name=\"{}\"", xmlEscaped(cell.hardCase),
                            xmlEscaped(cell.method));
        const std::string what = xmlEscaped(sentence(cell));
        if (cell.wrong())
            text += fmt::format("><failure message=\"{}\"/></testcase>\n", what);
        else if (cell.status == Status::notApplicable)
            text += fmt::format("><skipped message=\"{}\"/></testcase>\n", what);
        else
            text += fmt::format("><system-out>{}</system-out></testcase>\n", what);
    }
    return text + "</testsuite>\n</testsuites>\n";
}

std::string markdownText(const Matrix& matrix) {
    std::string text =
        "# Stability\n\n"
        "What `./run stress --markdown` printed: every hard case of scenes/stress on every method, "
        "small images, each against an invariant whose bound comes from reasoning (it stands in "
        "the "
        "case's file). A deviation is the worst over all pixels, frames and variants of the case; "
        "in unchanged and exact cases a share of the pixels, given in the file, may lie on an edge "
        "and is spared. `known` fails as scenes/stress/known.toml predicts, `n/a` is refused by "
        "the "
        "method or not about it.\n\n"
        "## Worst deviation of each invariant\n\n";
    text += worstTable(matrix) +
            "\n## Cases\n\n| case | METHODS.md | invariant | bound | what |\n"
            "| --- | --- | --- | --- | --- |\n";
    for (const HardCase& c : matrix.cases)
        text += fmt::format("| {} | {} | {} | {} | {} |\n", c.id, numbersOf(c), c.invariant,
                            figure(c.bound), markdown(c.shows));
    text += elsewhereTable(matrix) + "\n## Matrix\n\n" + matrixTable(matrix);
    section(
        text, matrix, "## Failures\n", [](const Cell& c) { return c.wrong(); },
        [](const Cell& c) {
            return fmt::format("- {} with {}: {}\n", c.hardCase, c.setting, markdown(sentence(c)));
        });
    section(
        text, matrix, "## Known limitations\n",
        [](const Cell& c) { return c.status == Status::known; },
        [&](const Cell& c) {
            const KnownLimitation& known = *findKnown(matrix.known, c.hardCase, c.method);
            return fmt::format("- {} with {}: predicted {} +- {}, measured {}. {}\n", c.hardCase,
                               c.method, figure(known.predicted), figure(known.tolerance),
                               figure(c.deviation), markdown(known.because));
        });
    section(
        text, matrix, "## Not applicable\n",
        [](const Cell& c) { return c.status == Status::notApplicable; },
        [](const Cell& c) {
            return fmt::format("- {} with {}: {}\n", c.hardCase, c.method, markdown(c.note));
        });
    return text;
}

void writeMatrix(const Matrix& matrix, const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw InputError(fmt::format("--out {}: {}", folder.string(), error.message()));
    writeFileAtomically(folder / "stress.csv", csvText(matrix));
    writeFileAtomically(folder / "junit.xml", junitText(matrix));
    writeFileAtomically(RunFolder(folder).stress(), markdownText(matrix));
}

}  // namespace penumbra::stress
