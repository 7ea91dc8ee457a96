/// Messages and progress on stderr.
#pragma once

#include "cli/arguments.h"

#include <functional>
#include <iosfwd>
#include <mutex>
#include <string>

namespace kagero {

/// Prints messages with the prefix "kagero: ", in colour if this is selected.
class Terminal {
public:
    explicit Terminal(const Arguments& arguments);
    void error(const std::string& message) const;
    void warning(const std::string& message) const;  ///< Prints nothing with --quiet.
    void note(const std::string& message) const;     ///< Prints nothing with --quiet.
    void detail(const std::string& message) const;   ///< Prints only with --verbose.
    bool quiet() const { return quiet_; }
    bool interactive() const { return interactive_; }  ///< Returns true if stderr is a terminal.

private:
    void print(const char* color, const char* kind, const std::string& message) const;
    bool quiet_, verbose_, interactive_, color_;
};

/// The progress of a run. On a terminal it is one line that is overwritten; elsewhere it is a line for each 10 %, at
/// most every two seconds. All functions may be called from any thread.
class ProgressLine {
public:
    /// `subject` is printed after the percentage, for example " of the trial rays".
    explicit ProgressLine(const Terminal& terminal, std::string subject = "")
        : terminal_(terminal), subject_(std::move(subject)) {}
    ~ProgressLine() { clear(); }
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;
    /// Shows the finished share (0…1) and an estimate of the remaining time; `seconds` have passed since the start.
    void show(double done, double seconds);
    /// Erases the line.
    void clear();
    /// Erases the line and calls `print`, which may print messages.
    void print_message(const std::function<void()>& print);

private:
    void erase();

    const Terminal& terminal_;
    const std::string subject_;
    std::mutex writing_;
    bool visible_ = false;
    int tenths_ = 0;          ///< Finished tenths of the work that the last printed line states.
    double drawn_at_ = -1e9;  ///< Time at which the line was last drawn, in seconds since the start.
};

}  // namespace kagero
