/// The sky to which a ray escapes, the direction of the ray on that sky, and the frequency of its light there.
#pragma once

#include "modules/space.h"
#include "scene/vector3.h"

#include <array>
#include <optional>

namespace kagero {

/// The sky to which a ray escapes, and the direction of the ray on that sky.
struct SkyView {
    bool on_second_sheet;  ///< True if the sky is that of a wormhole's second sheet ([sky.far]).
    Double3 direction;     ///< Unit vector.
    bool reflected = false;  ///< True if the direction is reflected at the plane perpendicular to q.
    double frequency = 0;    ///< Frequency of the light for the distant observers, if they are stated.
};

/// The skies of a scene: where rays reach them, and who sees them.
struct Skies {
    const Space* space = nullptr;
    double throat_radius = 0;                      ///< Radius of a wormhole's throat, or 0.
    const FormulaDescription* formula = nullptr;   ///< The Hamiltonian, if it is a formula.
    const VelocityDescription* frame = nullptr;    ///< Velocity of the distant observers, if stated.
    /// Frequency of light with |p_t| = 1 for an observer at rest at infinity.
    double frequency_at_rest = 1;

    /// True if every ray shows the first sky in the direction of its coordinate velocity.
    bool is_plain() const { return !frame && !has_far_domain() && !(throat_radius > 0); }
    bool has_far_domain() const { return formula && formula->far_domain_node >= 0; }
};

/// Returns the skies of a scene. Both arguments must outlive them.
Skies make_skies(const Space& space, const SceneDescription& scene);

/// Compares the velocity of the distant observers, if stated, with that of light at several points where rays end: on
/// the escape sphere, or at the edge of a formula's domain. Throws InputError if it is not slower at any of them.
/// Returns a remark if it is not slower at some of them, or "". Lengths in messages are multiplied by `length_unit`.
/// The space must be a spacetime.
std::string check_sky_frame(const Skies& skies, double escape_radius, double length_unit);

/// Returns the sky and the direction of an escaped ray. In isotropic coordinates, the second sheet of a wormhole is the
/// inside of the sphere |q| = R. The inversion q → q R²/|q|² maps this inside to its outside, where the metric has the
/// same form as that of the first sheet. The differential of the inversion reflects directions at the plane
/// perpendicular to n = q/|q|. A ray of direction d inside the sphere therefore has the direction d − 2 (d·n) n on the
/// second sheet. In a formula with far_domain, d is reflected in the same way if the ray moves inward there, so that
/// infinity of the other universe is at the centre; otherwise its direction is d.
///
/// d is the unit vector along dq/dλ, or the direction in the rest frame of the distant observers if they are stated. It
/// remains dq/dλ where these observers would not be slower than light.
SkyView sky_view(const Skies& skies, const RayEnd& end);

/// Derivatives of SkyView::direction with respect to the components of a ray's end: element k of each array belongs to
/// component k of the position, or of the unit direction of dq/dλ. The momentum of the light follows from both.
struct SkyDerivatives {
    std::array<Double3, 3> by_position, by_direction;
};

/// Returns the derivatives at the end of an escaped ray, by central differences. Returns nothing if no distant
/// observers are stated, or where they would not be slower than light.
std::optional<SkyDerivatives> sky_derivatives(const Skies& skies, const RayEnd& end);

/// Returns the frequency of the light of an escaped ray at its source: for the distant observers at the ray's end, or
/// for an observer at rest at infinity if they are not stated. Returns 0 where they would not be slower than light.
double frequency_at_sky(const Skies& skies, const RayEnd& end);

/// Returns the sky and the direction of an escaped ray that ends at q, relative to `space.center`, with the unit
/// direction d. `throat_radius` is R, or 0 if there is no second sheet.
SkyView sky_view(double throat_radius, const Double3& q, const Double3& d);

}  // namespace kagero
