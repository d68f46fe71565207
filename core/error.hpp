#pragma once

#include <stdexcept>
#include <string>

namespace penumbra {

/// Bad input from outside: an asset, a script, a command line. The message is one line that says
/// what is wrong, where (`file:line` or a JSON pointer) and which values would be valid.
/// `main` prints it and exits with 2; nothing has been written by then.
class InputError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A method cannot do what this scene asks and says why. The row becomes `unsupported`, the
/// message its reason; the other methods go on.
class Unsupported : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

}  // namespace penumbra
