/// Means of checkers over parallelograms, for a packet of pixels. The formulas are those of checker_color in
/// src/appearance/texture.cpp.
#pragma once

#include "kernels/shading/cell_function.h"

namespace kagero::shading {

/// Returns the distance to the nearest even number: the integral of the square wave that is 1 between an even number
/// and the next integer, and −1 elsewhere.
template <class V>
KAGERO_INLINE V wave_integral(const V& t) {
    const V half(0.5f);
    return abs(fnma(V(2.0f), floor_of(fma(half, t, half)), t));
}

/// Returns the value of the square wave.
template <class V>
KAGERO_INLINE V wave(const V& t) {
    const V below = floor_of(t), half(0.5f);
    return fnma(V(2.0f), fnma(V(2.0f), floor_of(half * below), below), V(1.0f));
}

/// Returns the mean of the square wave over the part of an interval between two limits.
template <class V>
KAGERO_INLINE V mean_wave(const V& middle, const V& width, const V& least, const V& greatest) {
    const V half_width = V(0.5f) * width, lower = max(middle - half_width, least),
            upper = min(middle + half_width, greatest), length = upper - lower;
    // For a short interval, the difference of integrals is inaccurate.
    const auto is_short = !(length >= V(1e-3f));
    return select(is_short, wave(middle), (wave_integral(upper) - wave_integral(lower)) / length);
}

/// Returns the brightness of a checker, which is 1 in even squares and 1/4 in odd ones, over the parallelograms around
/// the positions (x, y).
template <class V>
V checker_brightness(const CheckerPattern& checker, const double (&base)[2], const V& x, const V& y,
                     const PrincipalSides<V>& sides, const V& reach_x, const V& reach_y) {
    constexpr float max_rectangles = 64;
    const V zero(0.0f), half(0.5f), one(1.0f);
    const V from_edge_x = x - floor_of(x), from_edge_y = y - floor_of(y);
    V sign = wave(x) * wave(y);
    const auto is_inside = (from_edge_x >= reach_x) & (from_edge_x < one - reach_x) & (from_edge_y >= reach_y) &
                           (from_edge_y < one - reach_y);
    if (any(!is_inside)) {
        const auto limit = [&](const double (&limits)[2], int axis) { return V(float(limits[axis] - base[axis])); };
        const V least_x = limit(checker.lower, 0), greatest_x = limit(checker.upper, 0),
                least_y = limit(checker.lower, 1), greatest_y = limit(checker.upper, 1);
        // The parallelogram is a row of rectangles along its longer axis.
        const V smaller = min(abs(sides.major_x), abs(sides.major_y)),
                part = max(sides.minor_length, smaller * V(1 / max_rectangles));
        const V ratio = select(part > zero, smaller / part, one) - V(1e-5f);
        V count = min(max(-floor_of(-ratio), one), V(max_rectangles));
        count = select(is_inside, one, count);
        const V share = one / count;
        const auto extent = [&](const V& major, const V& minor) {
            const V major_part = major * share;
            return sqrt(fma(major_part, major_part, minor * minor));
        };
        const V width = extent(sides.major_x, sides.minor_x), height = extent(sides.major_y, sides.minor_y);
        V sum = zero;
        for (V i = half; any(i < count); i += one) {
            const V t = fms(i, share, half);
            const V mean = mean_wave(fma(t, sides.major_x, x), width, least_x, greatest_x) *
                           mean_wave(fma(t, sides.major_y, y), height, least_y, greatest_y);
            sum = select(i < count, sum + mean, sum);
        }
        sign = select(is_inside, sign, sum * share);
    }
    return fma(V(0.375f), sign, V(0.625f));
}

}  // namespace kagero::shading
