#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/study/stress/elsewhere.hpp"
#include "harness/study/stress/hard_case.hpp"
#include "harness/study/stress/known.hpp"

namespace penumbra::stress {

enum class Status {
    pass,
    fail,           ///< and nobody expected it
    known,          ///< fails as known.toml predicts
    mended,         ///< passes although known.toml says that it fails: the list is to be corrected
    notApplicable,  ///< the method refuses the scene, or the case is not about it
};
const char* nameOf(Status status);

/// One case with one method.
struct Cell {
    std::string hardCase, method;
    std::string invariant;  ///< the one that the deviation is of: the case's own, or range
    std::string setting;    ///< the one with the worst deviation, as results.csv names settings
    Status status = Status::pass;
    double deviation = 0.0, bound = 0.0;
    std::string note;  ///< where; or the reason
    /// What makes the command exit with 1.
    bool wrong() const { return status == Status::fail || status == Status::mended; }
};

/// What a cell is when its worst deviation is known.
Status judge(double deviation, double bound, const KnownLimitation* known);

struct MatrixOptions {
    std::vector<std::string> methods;  ///< ids; empty: all
    std::vector<std::string> cases;    ///< ids; empty: all
    std::uint32_t seed = 1;
};

struct Matrix {
    std::vector<HardCase> cases;
    std::vector<std::string> methods;
    std::vector<Cell> cells;  ///< case by case, methods in order
    std::vector<KnownLimitation> known;
    std::vector<Elsewhere> elsewhere;
    const Cell* find(const std::string& hardCase, const std::string& method) const;
    bool wrong() const;
};

/// Runs every case on every method in the current context. `starts` is told of each case before it
/// begins. Throws InputError for bad input before anything is rendered.
Matrix runMatrix(const CaseLibrary& library, const MatrixOptions& options,
                 const std::function<void(std::size_t, std::size_t, const std::string&)>& starts);

/// One case with some methods.
std::vector<Cell> runCase(const HardCase& hardCase, const std::vector<std::string>& methods,
                          const std::vector<KnownLimitation>& known, std::uint32_t seed);

}  // namespace penumbra::stress
