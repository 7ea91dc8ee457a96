/// The options of a run that are not part of a scene.
#pragma once

#include "kernels/abi.h"

#include <optional>
#include <string>

namespace kagero {

/// The shape of the tiles of a picture, and the order in which they are rendered. Pixels do not depend on the schedule.
enum class Schedule {
    scanline,   ///< Rows from top to bottom, as in Satoh (2003). A tile is as high as the highest packet, 8 pixels, and
                ///< as wide as the picture, but has at most 32768 rays.
    tiles,      ///< Squares, row by row.
    predicted,  ///< Squares in descending order of the cost that a sparse first pass predicts.
};

/// The purpose of tracing: the pixels of the scene's camera, or a list of rays without a picture.
enum class Purpose { picture, ray_list };

/// The options of a run. The program chooses the value of an option that is empty or 0.
struct Options {
    std::string isa = "auto";  ///< Instruction set: "auto" or a name that find_isas() returns.
    std::optional<Strategy> strategy;
    std::optional<Precision> precision;
    std::optional<Schedule> schedule;
    unsigned threads = 0;  ///< 0: one per processor.
    Tile crop{};           ///< Pixels of the film, half-open; all 0: the whole film.
    /// Observer in whose rest frame the directions of a ray list are given. Empty: they are given in coordinates.
    std::optional<ObserverKind> observer;
    /// Number of surfaces through which rays of a list continue; empty: they end at the first surface.
    std::optional<std::uint32_t> bounces;
    /// Value of λ at which the rays of a list end; empty: no limit.
    std::optional<double> parameter_limit;
    /// Interval of λ between the points of the paths of a list; empty: every step is a point.
    std::optional<double> path_interval;
    bool energy_error = false;  ///< True: the energy error is measured along every ray.
    bool parameter = false;     ///< True: λ is computed at the ends of a ray list.
    bool action = false;        ///< True: the action is computed along the rays of a list.
    bool time = false;          ///< True: the time is computed along the rays of a list.
    /// True: the scene has programs for the kernels that exist for comparison (IntegratedHamiltonian::programs).
    bool for_comparison = false;
};

}  // namespace kagero
