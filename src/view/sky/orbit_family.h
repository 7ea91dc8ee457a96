/// All rays from one point of a spherical space: where they reach the sky.
///
/// A ray stays in the plane that contains its first direction and the centre. Its end in that plane depends only on the
/// angle α between the direction and the radial direction, which points away from the centre. A list of ends over α is
/// therefore enough for all directions, and is so short that it is traced again when the camera moves.
///
/// The list is over τ = 1 − cos α / (|cos α| + sin α), which increases from 0 to 2 with α, so that no angle must be
/// computed for a pixel. It is divided into intervals, and these into cells with rays at their ends. Inside a
/// cell, the direction on the sky is interpolated linearly, with an error of at most h² |d²f/dτ²| / 8 for cells of size
/// h; the second differences of the rays estimate the derivative. Rays in cells with too large an error must be traced.
#pragma once

#include "view/sky/map_end.h"

#include <algorithm>

namespace kagero {

/// The end of a ray: its components along the radial direction, and along the other axis of its plane, on the side of
/// the first direction of the ray.
struct PlanarEnd {
    float radial = 0, transverse = 0;
    SkyEnd::Kind kind = SkyEnd::Kind::other;
};

/// The ends of the rays between two rays of the list, in floats for fast lookups.
struct OrbitCell {
    float radial = 0, transverse = 0;                ///< The end at the first ray of the cell,
    float radial_change = 0, transverse_change = 0;  ///< and its change within the cell.
    /// Estimated error of the direction in radians; infinity if the rays of the cell must be traced.
    float error = std::numeric_limits<float>::infinity();
    float magnification = 0.5f;  ///< Angle on the sky per angle of view.
    SkyEnd::Kind kind = SkyEnd::Kind::other;
};

/// Cells of equal width, and the ends at their borders: one more than cells.
struct OrbitInterval {
    std::vector<PlanarEnd> ends;
    std::vector<OrbitCell> cells;
};

class OrbitFamily {
public:
    /// The coordinates of a row of directions, in arrays that the compiler can vectorize.
    struct Row {
        std::vector<float> tau, across, upward;  ///< τ, and the unit vector perpendicular to the radial direction.
        std::vector<float> inverse_length;       ///< 1 / length of the direction.
    };

    /// Returns true if the rays from the camera of a plan are such a family.
    static bool contains_rays_of(const Plan& plan);
    /// The family of the rays from the camera of a plan.
    explicit OrbitFamily(const Plan& plan);

    /// Refines intervals until the error of their cells is at most `max_error` radians, or their cells are not wider
    /// than `least_width` radians. The first cells are not wider than `first_width`, so that they miss no details.
    void refine(const Plan& plan, double max_error, double first_width, double least_width);
    /// Sets the coordinates of `count` directions: first, first + step, ….
    void set_row(Row& row, const Double3& first, const Double3& step, std::uint32_t count) const;
    /// Returns the interpolated end of the ray in direction number i of a row.
    MapEnd end_at(const Row& row, std::uint32_t i) const {
        const float in_intervals = row.tau[i] * (0.5f * interval_count);
        const std::uint32_t index = std::min(std::uint32_t(in_intervals), interval_count - 1);
        const OrbitInterval& interval = intervals_[index];
        const auto cells = std::uint32_t(interval.cells.size());
        const float in_cells = (in_intervals - float(index)) * float(cells);
        const std::uint32_t number = std::min(std::uint32_t(in_cells), cells - 1);
        const OrbitCell& cell = interval.cells[number];
        const float share = in_cells - float(number), radial = cell.radial + share * cell.radial_change,
                    transverse = cell.transverse + share * cell.transverse_change, across = transverse * row.across[i],
                    upward = transverse * row.upward[i];
        MapEnd end;
        for (std::size_t k = 0; k < 3; ++k)
            end.direction[k] = radial * float_axes_[0][k] + across * float_axes_[1][k] + upward * float_axes_[2][k];
        end.kind = cell.kind;
        end.error = cell.error;
        end.magnification = cell.magnification * row.inverse_length[i];
        return end;
    }
    std::uint64_t rays() const { return rays_; }  ///< Returns the number of rays traced for the family.
    double seconds() const { return seconds_; }   ///< Returns the time of tracing for the family.

private:
    static constexpr std::uint32_t interval_count = 256;

    void trace(const Plan& plan, const std::vector<std::uint32_t>& intervals, std::uint32_t first_cells);

    std::array<Double3, 3> axes_;  ///< The radial direction, and two unit vectors perpendicular to it.
    std::array<std::array<float, 3>, 3> float_axes_;
    std::vector<OrbitInterval> intervals_;
    std::uint64_t rays_ = 0;
    double seconds_ = 0;
};

}  // namespace kagero
