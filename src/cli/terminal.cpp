#include "cli/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>

namespace kagero {

namespace {

bool uses_color(const std::string& choice, bool interactive) {
    if (choice == "always") return true;
    if (choice == "never") return false;
    const char* no_color = std::getenv("NO_COLOR");
    return interactive && !(no_color && *no_color);
}

std::string time_text(double seconds) {
    const long whole = std::lround(std::ceil(seconds));
    if (whole < 60) return std::to_string(whole) + " s";
    if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
    return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
}

/// Returns a text such as ", 5 s left" with an estimate of the remaining time. Returns "" below 1 % of the work, where
/// the estimate is poor.
std::string time_left(double done, double seconds) {
    return done > 0.01 && done < 1 ? ", " + time_text(seconds * (1 - done) / done) + " left" : "";
}

}  // namespace

Terminal::Terminal(const Arguments& arguments)
    : quiet_(arguments.quiet), verbose_(arguments.verbose), interactive_(isatty(STDERR_FILENO) == 1),
      color_(uses_color(arguments.color, interactive_)) {}

void Terminal::print(const char* color, const char* kind, const std::string& message) const {
    std::cerr << "kagero: ";
    if (*kind) std::cerr << (color_ ? color : "") << kind << (color_ ? "\033[0m" : "");
    std::cerr << message << std::endl;
}

void Terminal::error(const std::string& message) const { print("\033[1;31m", "error: ", message); }
void Terminal::warning(const std::string& message) const {
    if (!quiet_) print("\033[1;33m", "warning: ", message);
}
void Terminal::note(const std::string& message) const {
    if (!quiet_) print("", "", message);
}
void Terminal::detail(const std::string& message) const {
    if (verbose_) print("", "", message);
}

void ProgressLine::show(double done, double seconds) {
    constexpr int width = 30;
    constexpr double least_interval = 0.1;  // seconds between two updates of the line
    if (terminal_.quiet()) return;
    done = std::clamp(done, 0.0, 1.0);
    const std::lock_guard lock(writing_);
    const int tenths = static_cast<int>(10 * done);
    if (!terminal_.interactive()) {
        constexpr double least_line_interval = 2;  // seconds between two lines
        if (tenths <= tenths_ || seconds - std::max(drawn_at_, 0.0) < least_line_interval) return;
        terminal_.note(std::to_string(10 * tenths) + " %" + subject_ + " done" + time_left(done, seconds));
        tenths_ = tenths;
        drawn_at_ = seconds;
        return;
    }
    if (seconds - drawn_at_ < least_interval) return;
    drawn_at_ = seconds;
    const int filled = static_cast<int>(width * done);
    std::cerr << "\r\033[K[" << std::string(filled, '#') << std::string(width - filled, '.') << "] "
              << static_cast<int>(100 * done) << " %" << subject_ << time_left(done, seconds) << std::flush;
    visible_ = true;
}

void ProgressLine::clear() {
    const std::lock_guard lock(writing_);
    erase();
}

void ProgressLine::print_message(const std::function<void()>& print) {
    const std::lock_guard lock(writing_);
    erase();
    print();
}

void ProgressLine::erase() {
    if (visible_) std::cerr << "\r\033[K" << std::flush;
    visible_ = false;
}

}  // namespace kagero
