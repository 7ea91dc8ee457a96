/// What the program says to people, on stderr.
#pragma once

#include "cli/arguments.h"

#include <functional>
#include <iosfwd>
#include <mutex>
#include <string>

namespace kagero {

class Terminal {
public:
    explicit Terminal(const Arguments& arguments);
    void error(const std::string& message) const;
    void warning(const std::string& message) const;  ///< unless --quiet
    void note(const std::string& message) const;     ///< unless --quiet
    void detail(const std::string& message) const;   ///< only with --verbose
    bool quiet() const { return quiet_; }
    bool interactive() const { return interactive_; }

private:
    void say(const char* color, const char* kind, const std::string& message) const;
    bool quiet_, verbose_, interactive_, color_;
};

/// The progress of a render: a line that overwrites itself on a terminal, else a line for each 10 %. Any thread may
/// call it.
class ProgressLine {
public:
    /// `of_what` follows the per cent, where that is not the work that was asked for.
    explicit ProgressLine(const Terminal& terminal, const char* of_what = "")
        : terminal_(terminal), of_what_(of_what) {}
    ~ProgressLine() { clear(); }
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;
    void show(double done, double seconds);
    void clear();
    /// Calls `say`, which may write lines of its own, where the line has made room.
    void aside(const std::function<void()>& say);

private:
    void wipe();

    const Terminal& terminal_;
    const char* of_what_;
    std::mutex writing_;
    bool drawn_ = false;
    int tenths_ = 0;          ///< last one told
    double drawn_at_ = -1e9;  ///< seconds
};

}  // namespace kagero
