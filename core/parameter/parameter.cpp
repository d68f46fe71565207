#include "core/parameter/parameter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/error.hpp"

namespace penumbra {
namespace {

/// The whole of `text` as a number, in the C locale; nullopt if it is anything else.
template <class Number>
std::optional<Number> parse(const std::string& text) {
    Number value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stop != end) return std::nullopt;
    return value;
}

template <class Number>
std::string interval(Number lo, Number hi) {
    return fmt::format("{}..{}", lo, hi);
}

template <class Number>
std::vector<std::string> ends(Number lo, Number hi) {
    if (lo == hi) return {fmt::format("{}", lo)};
    return {fmt::format("{}", lo), fmt::format("{}", hi)};
}

[[noreturn]] void reject(const Parameter& parameter, const std::string& value, const char* what) {
    throw std::invalid_argument(
        fmt::format("'{}' is not {} {}{}", value, what, parameter.range(),
                    parameter.unit().empty() ? "" : fmt::format(" ({})", parameter.unit())));
}

template <class Number>
void requireDefaultInRange(const std::string& id, Number value, Number lo, Number hi) {
    if (!(lo <= value && value <= hi))
        throw std::logic_error(
            fmt::format("parameter {}: its default {} is not in {}..{}", id, value, lo, hi));
}

}  // namespace

Parameter::Parameter(Parameters* owner, std::string id, std::string unit, std::string doc)
    : id_(std::move(id)), unit_(std::move(unit)), doc_(std::move(doc)) {
    for (const Parameter* other : owner->list_)
        if (other->id() == id_) throw std::logic_error("parameter " + id_ + " is declared twice");
    owner->list_.push_back(this);
}

IntParameter::IntParameter(Parameters* owner, std::string id, int value, int lo, int hi,
                           std::string unit, std::string doc)
    : Parameter(owner, std::move(id), std::move(unit), std::move(doc)),
      value_(value),
      default_(value),
      lo_(lo),
      hi_(hi) {
    requireDefaultInRange(this->id(), value, lo, hi);
}

std::string IntParameter::range() const {
    return interval(lo_, hi_);
}

std::vector<std::string> IntParameter::extremes() const {
    return ends(lo_, hi_);
}

void IntParameter::setText(const std::string& value) {
    const auto number = parse<int>(value);
    if (!number) reject(*this, value, "an integer in");
    if (*number < lo_ || *number > hi_) reject(*this, value, "in");
    value_ = *number;
}

FloatParameter::FloatParameter(Parameters* owner, std::string id, double value, double lo,
                               double hi, std::string unit, std::string doc)
    : Parameter(owner, std::move(id), std::move(unit), std::move(doc)),
      value_(value),
      default_(value),
      lo_(lo),
      hi_(hi) {
    requireDefaultInRange(this->id(), value, lo, hi);
}

std::string FloatParameter::range() const {
    return interval(lo_, hi_);
}

std::string FloatParameter::text() const {
    return fmt::format("{}", value_);
}

std::string FloatParameter::defaultText() const {
    return fmt::format("{}", default_);
}

std::vector<std::string> FloatParameter::extremes() const {
    return ends(lo_, hi_);
}

void FloatParameter::setText(const std::string& value) {
    const auto number = parse<double>(value);
    if (!number || !std::isfinite(*number)) reject(*this, value, "a number in");
    if (*number < lo_ || *number > hi_) reject(*this, value, "in");
    value_ = *number + 0.0;  // -0 becomes 0, so that equal values have one text
}

BoolParameter::BoolParameter(Parameters* owner, std::string id, bool value, std::string doc)
    : Parameter(owner, std::move(id), "", std::move(doc)), value_(value), default_(value) {}

void BoolParameter::setText(const std::string& value) {
    if (value != "true" && value != "false") reject(*this, value, "one of");
    value_ = value == "true";
}

ChoiceParameter::ChoiceParameter(Parameters* owner, std::string id,
                                 std::vector<std::string> choices, std::string doc)
    : Parameter(owner, std::move(id), "", std::move(doc)), choices_(std::move(choices)) {
    if (choices_.empty()) throw std::logic_error("parameter " + this->id() + " has no choices");
}

std::string ChoiceParameter::range() const {
    return fmt::format("{}", fmt::join(choices_, "|"));
}

void ChoiceParameter::setText(const std::string& value) {
    const auto at = std::ranges::find(choices_, value);
    if (at == choices_.end()) reject(*this, value, "one of");
    index_ = static_cast<int>(at - choices_.begin());
}

void Parameters::set(const std::string& owner, const std::string& id, const std::string& value) {
    const auto at = std::ranges::find(list_, id, &Parameter::id);
    if (at == list_.end()) {
        if (list_.empty()) throw InputError(owner + " has no parameters, not even '" + id + "'");
        std::string known;
        for (const Parameter* p : list_) known += (known.empty() ? "" : ", ") + p->id();
        throw InputError(fmt::format("{} has no parameter '{}'; it has {}", owner, id, known));
    }
    try {
        (*at)->setText(value);
    } catch (const std::invalid_argument& e) {
        throw InputError(fmt::format("{}.{}: {}", owner, id, e.what()));
    }
}

std::string Parameters::text() const {
    std::string all;
    for (const Parameter* p : list_) all += (all.empty() ? "" : ";") + p->id() + '=' + p->text();
    return all;
}

bool Parameters::atDefaults() const {
    return std::ranges::all_of(list_,
                               [](const Parameter* p) { return p->text() == p->defaultText(); });
}

}  // namespace penumbra
