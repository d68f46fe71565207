#pragma once

#include <exception>

namespace penumbra {

/// While it lives, the first SIGINT or SIGTERM asks this program to stop where nothing that is
/// begun is lost, and says so on standard error; a second one ends it at once with exit code 128 +
/// its number. A signal that was ignored before stays ignored. One at a time.
class Interruption {
  public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// The signal that asked to stop; 0: none.
    static int signal();
};

/// Thrown out of work that is not worth finishing once `signal` asked to stop; a command that ends so
/// has exit code 128 + signal.
struct Interrupted : std::exception {
    explicit Interrupted(int by) : signal(by) {}
    const char* what() const noexcept override { return "interrupted"; }
    int signal;
};

}  // namespace penumbra
