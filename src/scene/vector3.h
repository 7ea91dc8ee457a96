/// Vector operations on Double3.
#pragma once

#include "scene/description.h"

#include <cmath>

namespace kagero {

inline Double3 add(const Double3& a, const Double3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Double3 subtract(const Double3& a, const Double3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Double3 scaled(const Double3& a, double s) {
    return {a[0] * s, a[1] * s, a[2] * s};
}
inline double dot(const Double3& a, const Double3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double length(const Double3& a) {
    return std::sqrt(dot(a, a));
}
inline Double3 unit(const Double3& a) {
    return scaled(a, 1 / length(a));
}
inline Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace kagero
