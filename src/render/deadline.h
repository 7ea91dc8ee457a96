/// A time by which work is to end.
#pragma once

#include <chrono>
#include <limits>

namespace kagero {

class Deadline {
public:
    /// So many seconds from now; infinity: never.
    explicit Deadline(double seconds = std::numeric_limits<double>::infinity()) : seconds_(seconds) {}
    /// Seconds.
    double left() const {
        return seconds_ - std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    }
    bool passed() const { return left() <= 0; }

private:
    double seconds_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace kagero
