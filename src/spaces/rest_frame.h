/// The metric of a spacetime, and rest frames of observers with any velocity dq/dt.
///
/// The indices 0, 1, 2, 3 of tensors belong to x, y, z, t. The metric g_ab is the inverse of g^{ab} = ∂²H/∂p_a∂p_b, so
/// that a constant factor of H only changes the unit of lengths and times.
#pragma once

#include "modules/space.h"
#include "scene/description.h"

#include <optional>

namespace kagero {

using SpacetimeMatrix = std::array<std::array<double, 4>, 4>;

/// Computes g_ab at q, in the coordinates of the scene: ingoing coordinates inside the horizon of a black hole. Returns
/// Failure::none, or the reason why there is no metric: Failure::no_rest_frame if the space is not a spacetime. The
/// metric has the signature −+++, also if g^{ab} of H has the signature +−−−. `momentum_sign`, if not null, is then set
/// to −1, and to 1 otherwise: it is the sign of the time component of p = −k, where k is the momentum of the light.
Failure metric_at(const Space& space, const double (&q)[3], SpacetimeMatrix& g, double* momentum_sign = nullptr);

/// Computes g_ab at q for a formula, from values of H. This is several times as fast as metric_at, which also examines
/// whether the space is a spacetime. The formula must be one. Returns false if g^{ab} is singular.
bool metric_of_formula(const FormulaDescription& formula, const double (&q)[3], SpacetimeMatrix& g);

/// Returns g_ab v^a w^b.
double product(const SpacetimeMatrix& g, const std::array<double, 4>& v, const std::array<double, 4>& w);

/// The rest frame of an observer. With the coordinate axes e_i, projected orthogonally to the 4-velocity u, and
/// h_ik = e_i · e_k, its axes are E_i = Σ_k (h^(−1/2))_ik e_k.
struct RestFrame {
    std::array<double, 4> u, covariant_u;  ///< u^a and u_a.
    std::array<Double3, 3> inverse_root;   ///< h^(−1/2), which is symmetric.
    double momentum_sign = 1;              ///< See metric_at; −1 if the momenta of rays have the opposite sign.
};

/// Returns the rest frame of an observer with the velocity v = dq/dt; nothing if |v| is not below the speed of light.
std::optional<RestFrame> rest_frame(const SpacetimeMatrix& g, const Double3& v);

/// The light of a ray, as an observer at the ray's position measures it.
struct ObservedLight {
    double frequency;   ///< p · u, because rays are followed backward from the eye.
    Double3 direction;  ///< Unit vector, in the axes of the rest frame, of the backward motion of the light.
};
ObservedLight observed_light(const RestFrame& frame, const double (&p)[3], double pt);

/// Computes the map from directions in the rest frame of an observer at q with velocity v to momenta of light whose
/// frequency is 1 for the observer. If `ingoing` is true or q is inside the horizon of a black hole, the momenta are
/// those of the kernel's state in ingoing coordinates. Returns Failure::none, Failure::no_observer if |v| is not below
/// the speed of light, or the reason why there is no metric.
Failure make_moving_map(const Space& space, const double (&q)[3], const Double3& v, bool ingoing, StartMap& map);

/// Returns the displacements dq that belong to the unit axes of an observer's rest frame. The columns of `map` are the
/// covectors of the axes E_i, and the displacements are the spatial components of g^{ab} E_b. `momentum_sign` is that
/// of metric_at.
std::array<Double3, 3> axes_in_coordinates(const SpacetimeMatrix& g, double momentum_sign, const StartMap& map);

/// Returns the condition for |v| below the speed of light in the direction of v, as the end of a sentence: "in this
/// direction, the speed must be less than 0.9".
std::string speed_limit(const SpacetimeMatrix& g, const Double3& v);

}  // namespace kagero
