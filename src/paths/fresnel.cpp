#include "paths/fresnel.h"

#include <algorithm>

namespace kagero {

double reflectance(const OpticalSide& ray, const OpticalSide& other) {
    const auto share = [](double a, double b) {
        const double amplitude = (a - b) / (a + b);
        return amplitude * amplitude;
    };
    const double perpendicular = share(ray.index * ray.cosine, other.index * other.cosine),
                 parallel = share(other.index * ray.cosine, ray.index * other.cosine),
                 mean = 0.5 * (perpendicular + parallel);
    return mean >= 0 ? std::min(mean, 1.0) : 1;  // NaN if both sides have the cosine 0
}

}  // namespace kagero
