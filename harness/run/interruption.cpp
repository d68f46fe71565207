#include "harness/run/interruption.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <string_view>

namespace penumbra {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM};
/// On a terminal the cursor stands behind the progress line.
constexpr std::string_view kMessage =
    "\npenumbra: interrupted: finishing the cells that are begun; once more to stop at once\n";

std::atomic<int> received{0};
std::atomic<bool> terminal{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "a signal handler may use them");
std::array<struct sigaction, kSignals.size()> before;

extern "C" void onSignal(int signal) {
    int none = 0;
    if (!received.compare_exchange_strong(none, signal)) _exit(128 + signal);
    const int error = errno;
    const std::string_view message = kMessage.substr(terminal ? 0 : 1);
    [[maybe_unused]] const ssize_t told = ::write(STDERR_FILENO, message.data(), message.size());
    errno = error;
}

}  // namespace

Interruption::Interruption() {
    received = 0;
    terminal = isatty(STDERR_FILENO) != 0;
    struct sigaction action {};
    action.sa_handler = onSignal;
    action.sa_flags = SA_RESTART;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
        sigaction(kSignals[i], nullptr, &before[i]);
        if (before[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &action, nullptr);
    }
}

Interruption::~Interruption() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before[i], nullptr);
    received = 0;
}

int Interruption::signal() {
    return received;
}

}  // namespace penumbra
