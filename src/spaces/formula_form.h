/// Examination of a formula: whether it describes a spacetime, and in which of the usual forms.
#pragma once

#include "scene/description.h"

#include <string>

namespace kagero {

/// The form of H at one position.
struct FormulaForm {
    /// H = ½ c g^{ab} p_a p_b with H0 = 0, where g is the metric of a spacetime with time as the coordinate of p_t.
    bool is_spacetime = false;
    /// The sign of p_t for light that is followed backward in time: 1 for the signature −+++, and −1 for +−−−. With
    /// g^{tt} as in H, dt/dλ = ∂H/∂p_t is then negative for an observer at rest.
    double backward_pt_sign = 1;
    /// One of x, y, z is a time: H does not contain p_t, and it is an indefinite quadratic form in p_x, p_y, p_z.
    bool has_time_coordinate = false;
};

/// Returns the form of H at the position q, relative to the centre of the space.
FormulaForm form_of(const FormulaDescription& formula, const Double3& q);

/// The momentum p_t of rays, and a remark for the user; the remark is empty if the scene states a usual p_t.
struct RayFrequency {
    double pt;
    std::string remark;
};

/// Returns p_t of the rays of a formula. For pictures of a spacetime, it has the sign of light that is followed
/// backward in time; otherwise, it is that of the scene. `q` is the position of the camera relative to the centre of
/// the space. Throws InputError if the formula describes a spacetime, but p_t is 0.
RayFrequency ray_frequency(const FormulaDescription& formula, const Double3& q, bool is_picture);

/// Returns the cause, if the form of H explains why no momentum has a certain direction; else an empty string.
std::string cause_of_missing_momentum(const FormulaDescription& formula, const Double3& q);

}  // namespace kagero
