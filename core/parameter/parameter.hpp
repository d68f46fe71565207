#pragma once

#include <string>
#include <utility>
#include <vector>

namespace penumbra {

class Parameters;

/// One declared parameter of a method: everything anyone needs to know about it, said once. The
/// command line, sweeps, the CSV, the viewer, the GLSL uniform `p_<id>` and the generated documents
/// all read this declaration.
class Parameter {
  public:
    virtual ~Parameter() = default;
    Parameter(const Parameter&) = delete;
    Parameter& operator=(const Parameter&) = delete;

    const std::string& id() const { return id_; }      ///< snake_case
    const std::string& unit() const { return unit_; }  ///< "" for a pure number
    const std::string& doc() const { return doc_; }    ///< one line
    virtual std::string type() const = 0;              ///< int | float | bool | choice
    virtual std::string range() const = 0;             ///< valid values, for people
    virtual std::string text() const = 0;              ///< current value, canonical
    virtual std::string defaultText() const = 0;
    /// Canonical texts of the smallest and largest value, or of every choice: what contract tests
    /// set in turn.
    virtual std::vector<std::string> extremes() const = 0;
    /// Throws std::invalid_argument with the valid values.
    virtual void setText(const std::string& value) = 0;
    /// As the GLSL uniform p_<id>.
    virtual bool isFloat() const { return false; }
    virtual double number() const = 0;

  protected:
    Parameter(Parameters* owner, std::string id, std::string unit, std::string doc);

  private:
    std::string id_, unit_, doc_;
};

class IntParameter : public Parameter {
  public:
    IntParameter(Parameters* owner, std::string id, int value, int lo, int hi, std::string unit,
                 std::string doc);
    operator int() const { return value_; }
    std::string type() const override { return "int"; }
    std::string range() const override;
    std::string text() const override { return std::to_string(value_); }
    std::string defaultText() const override { return std::to_string(default_); }
    std::vector<std::string> extremes() const override;
    void setText(const std::string& value) override;
    double number() const override { return value_; }

  private:
    int value_, default_, lo_, hi_;
};

class FloatParameter : public Parameter {
  public:
    FloatParameter(Parameters* owner, std::string id, double value, double lo, double hi,
                   std::string unit, std::string doc);
    operator double() const { return value_; }
    std::string type() const override { return "float"; }
    std::string range() const override;
    std::string text() const override;
    std::string defaultText() const override;
    std::vector<std::string> extremes() const override;
    void setText(const std::string& value) override;
    bool isFloat() const override { return true; }
    double number() const override { return value_; }

  private:
    double value_, default_, lo_, hi_;
};

class BoolParameter : public Parameter {
  public:
    BoolParameter(Parameters* owner, std::string id, bool value, std::string doc);
    operator bool() const { return value_; }
    std::string type() const override { return "bool"; }
    std::string range() const override { return "true|false"; }
    std::string text() const override { return value_ ? "true" : "false"; }
    std::string defaultText() const override { return default_ ? "true" : "false"; }
    std::vector<std::string> extremes() const override { return {"false", "true"}; }
    void setText(const std::string& value) override;
    double number() const override { return value_; }

  private:
    bool value_, default_;
};

class ChoiceParameter : public Parameter {
  public:
    /// `choices` are listed in the order of their GLSL index; the first is the default.
    ChoiceParameter(Parameters* owner, std::string id, std::vector<std::string> choices,
                    std::string doc);
    int index() const { return index_; }
    bool is(const char* choice) const {
        return choices_[static_cast<std::size_t>(index_)] == choice;
    }
    std::string type() const override { return "choice"; }
    std::string range() const override;
    std::string text() const override { return choices_[static_cast<std::size_t>(index_)]; }
    std::string defaultText() const override { return choices_[0]; }
    std::vector<std::string> extremes() const override { return choices_; }
    void setText(const std::string& value) override;
    double number() const override { return index_; }

  private:
    std::vector<std::string> choices_;
    int index_ = 0;
};

/// (parameter id, value) pairs, as written after `--set ID.`.
using Assignments = std::vector<std::pair<std::string, std::string>>;

/// Owner of declared parameters: a class derives from it and has Parameter members.
class Parameters {
  public:
    Parameters() = default;
    virtual ~Parameters() = default;
    Parameters(const Parameters&) = delete;
    Parameters& operator=(const Parameters&) = delete;

    const std::vector<Parameter*>& parameters() const { return list_; }
    /// Sets one parameter. Throws InputError: an unknown id lists the known ones, a bad value the
    /// valid range. `owner` names the method in the message.
    void set(const std::string& owner, const std::string& id, const std::string& value);
    /// "a=1;b=2" of all parameters in order of declaration.
    std::string text() const;
    bool atDefaults() const;

  private:
    friend class Parameter;
    std::vector<Parameter*> list_;
};

}  // namespace penumbra
