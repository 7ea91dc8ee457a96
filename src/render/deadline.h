/// A point in time at which work must end.
#pragma once

#include <chrono>
#include <limits>

namespace kagero {

class Deadline {
public:
    /// Sets the deadline to `seconds` from now; infinity: there is no deadline.
    explicit Deadline(double seconds = std::numeric_limits<double>::infinity()) : seconds_(seconds) {}
    double remaining_seconds() const {
        return seconds_ - std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    }
    bool passed() const { return remaining_seconds() <= 0; }

private:
    double seconds_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace kagero
