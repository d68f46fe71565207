#include "harness/study/verdict.hpp"

#include <fmt/format.h>

namespace penumbra {

bool Expectation::allows(double measured) const {
    switch (relation) {
        case Relation::match:
            return measured >= *ratio / factor && measured <= *ratio * factor;
        case Relation::at_least:
            return measured >= *ratio;
        case Relation::at_most:
            return measured <= *ratio;
        case Relation::above_one:
            return measured > 1.0;
        case Relation::below_one:
            return measured < 1.0;
    }
    return false;
}

std::string Expectation::text() const {
    switch (relation) {
        case Relation::match:
            return fmt::format("{:.3g} (within {:.3g}×)", *ratio, factor);
        case Relation::at_least:
            return fmt::format("at least {:.3g}", *ratio);
        case Relation::at_most:
            return fmt::format("at most {:.3g}", *ratio);
        case Relation::above_one:
            return "> 1";
        case Relation::below_one:
            return "< 1";
    }
    return "";
}

const char* textOf(Verdict verdict) {
    switch (verdict) {
        case Verdict::holds:
            return "holds";
        case Verdict::does_not_hold:
            return "does not hold";
        case Verdict::undecided:
            return "undecided";
        case Verdict::could_not_run:
            return "could not run";
        case Verdict::not_implemented:
            return "not implemented here";
    }
    return "";
}

Verdict judge(const Expectation& expected, const Interval& measured) {
    const bool low = expected.allows(measured.low), high = expected.allows(measured.high);
    if (low && high) return Verdict::holds;  // what agrees is one range
    // An interval may reach beyond both ends of a narrow range.
    const bool around = expected.relation == Relation::match && measured.low < *expected.ratio &&
                        measured.high > *expected.ratio;
    if (low || high || around) return Verdict::undecided;
    return Verdict::does_not_hold;
}

}  // namespace penumbra
