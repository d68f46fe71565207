#include "harness/run/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace penumbra {

using Clock = std::chrono::steady_clock;

ProgressLine::ProgressLine(std::size_t steps)
    : steps_(steps), terminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()) {}

ProgressLine::~ProgressLine() {
    if (open_) fmt::print(stderr, "\r\033[K");
}

void ProgressLine::step(std::size_t done, const std::string& what) {
    done_ = done;
    what_ = what;
    if (terminal_)
        show(0.0);
    else
        fmt::print(stderr, "[{}/{}] {}\n", done + 1, steps_, what);
}

void ProgressLine::within(double fraction) {
    if (terminal_ && Clock::now() - shown_ > std::chrono::milliseconds(200)) show(fraction);
}

void ProgressLine::note(const std::string& text) {
    if (open_) fmt::print(stderr, "\r\033[K");
    open_ = false;
    fmt::print(stderr, "{}\n", text);
}

void ProgressLine::show(double fraction) {
    shown_ = Clock::now();
    const double share = (static_cast<double>(done_) + fraction) / static_cast<double>(steps_);
    const double elapsed = std::chrono::duration<double>(shown_ - start_).count();
    const std::string left =
        share > 0.02 ? fmt::format(", {:.0f} s left", elapsed * (1.0 - share) / share) : "";
    fmt::print(stderr, "\r\033[K[{}/{}] {}{}", done_ + 1, steps_, what_, left);
    std::fflush(stderr);
    open_ = true;
}

}  // namespace penumbra
