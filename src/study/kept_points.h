/// Finished points of an error study, so that an interrupted study can be continued.
#pragma once

#include "accuracy/error_curves.h"

#include <functional>
#include <vector>

namespace kagero {

/// A point of the study, and the times of its runs with and without surfaces.
struct TimedPoint {
    Variant variant;
    std::size_t curve, point;                ///< Index of the curve, and of the point on it.
    double estimate = 0;                     ///< Estimated seconds of one run with and one run without surfaces.
    unsigned repeats = 0;                    ///< Number of timed runs with surfaces, and of those without.
    std::uint32_t max_steps = 0;             ///< Limit of steps without surfaces.
    std::vector<double> with_surfaces{};     ///< Nanoseconds per ray of each run with surfaces.
    std::vector<double> without_surfaces{};  ///< Nanoseconds per ray of each run without surfaces.
};

/// The content of a point as numbers. It is valid only for the same build of the program.
using PointContent = std::vector<std::uint64_t>;

/// Storage of finished points by their names. Both functions are empty if the study is not stored.
struct PointStore {
    std::function<std::optional<PointContent>(const std::string& name)> find = {};
    std::function<void(const std::string& name, const PointContent&)> keep = {};
    bool has_times = true;  ///< False: points are stored without times, because other processes measure some of them.
};

/// Stores a point: its measurements, the estimate of its time, and the first time with and without surfaces.
void keep_point(const PointStore& store, const Plan& plan, const StudyPoint& point, const TimedPoint& timed);

/// Returns the stored point of `timed.variant`, and sets the times of `timed`. Returns nothing if it is not stored.
std::optional<StudyPoint> restore_point(const PointStore& store, const Plan& plan, TimedPoint& timed);

}  // namespace kagero
