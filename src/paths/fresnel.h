/// Fresnel's formulas for light without polarization.
#pragma once

namespace kagero {

/// One side of a surface: the refractive index, and the cosine of the angle between the ray and the normal.
struct OpticalSide {
    double index, cosine;
};

/// Returns the share of the light that a surface between two transparent media reflects: the mean of the shares of both
/// polarizations (Born & Wolf, Principles of Optics, §1.5.2, eqs. 20, 21). `ray` is the side of the incident ray, and
/// `other` that of the transmitted ray; the share is the same in the opposite direction.
double reflectance(const OpticalSide& ray, const OpticalSide& other);

}  // namespace kagero
