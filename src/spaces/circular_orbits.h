/// Circular orbits of matter in a spacetime, found from its metric.
///
/// Matter on a circle around an axis of symmetry, in a plane of symmetry, has the 4-velocity u ∝ ∂_t + Ω ∂_φ. The
/// circle is a geodesic if ∂_R(g_tt + 2Ω g_tφ + Ω² g_φφ) = 0, where R is the distance from the axis. These components
/// are scalar products of ∂_t and ∂_φ, so that the condition is the same in all coordinates with this symmetry.
#pragma once

#include "modules/space.h"
#include "scene/description.h"

namespace kagero {

/// The circular orbits of matter in the plane of a disk.
class CircularOrbits {
public:
    /// There are no orbits: the disk is not part of a space in which they are searched for.
    CircularOrbits() = default;
    /// Finds the orbits in the plane of a disk. `center` is relative to the centre of the space.
    CircularOrbits(const Space& space, const Double3& center, const Double3& normal, double inner, double outer);

    /// Returns true if orbits were searched for.
    bool searched() const { return searched_; }
    /// Returns the reason why there are no orbits at any radius; "" if the space has the required symmetry.
    const std::string& refusal() const { return refusal_; }
    /// Returns the ranges of the distance from the centre in which there are no orbits, in ascending order.
    const std::vector<std::array<double, 2>>& gaps() const { return gaps_; }
    /// Returns the velocity dq/dt at q of matter that orbits the normal in the right-handed sense. Its components are
    /// NaN if there is no circular geodesic. The orbit may still be faster than light.
    Double3 velocity(const Double3& q) const;

private:
    /// ∂_R of g_tt, g_tφ and g_φφ.
    using Slopes = std::array<double, 3>;
    static constexpr std::size_t node_count = 513;

    Slopes slopes_at(const Space& space, double radius) const;
    Slopes interpolated_slopes(double radius) const;
    bool exists(const Space& space, double radius) const;
    void find_gaps(const Space& space);
    double radius_of(double node) const;

    bool searched_ = false;
    Double3 center_{}, axis_{}, outward_{};
    double inner_ = 0, outer_ = 0;
    std::vector<Slopes> nodes_;  ///< At radii whose logarithms are equidistant, from the inner to the outer edge.
    std::vector<std::array<double, 2>> gaps_;
    std::string refusal_;
};

}  // namespace kagero
