/// The choices of a caller that are not part of a scene.
#pragma once

#include "kernels/abi.h"

#include <optional>
#include <string>

namespace kagero {

/// In which pieces, and in which order, a picture is worked on. No pixel depends on it.
enum class Schedule {
    scanline,   ///< line by line, as in Satoh (2003): bands as wide as the picture, or as a thread holds rays, and as
                ///< high as a packet, from the top
    tiles,      ///< squares, row by row
    predicted,  ///< squares, the costliest first, by a sparse first pass
};

/// The purpose of tracing: the pixels of the scene's camera, or a list of rays without a picture.
enum class Purpose { picture, ray_list };

/// Where an option is empty, or 0, the program chooses.
struct Options {
    std::string isa = "auto";           ///< a name of find_isas()
    std::optional<Strategy> strategy;
    std::optional<Precision> precision;
    std::optional<Schedule> schedule;
    unsigned threads = 0;               ///< 0: one for each processor
    Tile crop{};                        ///< pixels of the film, half-open; all 0: the whole film
    std::optional<ObserverKind>
        observer;  ///< in whose rest frame the directions of a ray list are given; empty: in coordinates
    bool energy_error = false;          ///< measure the error in H along every ray
    bool parameter = false;             ///< compute λ at the ends of listed rays
};

}  // namespace kagero
