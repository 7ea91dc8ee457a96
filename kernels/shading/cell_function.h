/// Biquadratic functions of the position in a cell of pixels.
#pragma once

#include "kernels/shading_cell.h"
#include "kernels/simd/lane_memory.h"

namespace kagero::shading {

/// The positions of consecutive pixels of a cell, one in each lane. Positions are from −1 at the first nodes to 1 at
/// the last ones.
template <class V>
struct CellPosition {
    V x, y;
};

/// The pixels of a cell in packets, row by row.
template <class V>
class CellPixels {
public:
    explicit CellPixels(std::uint32_t edge) : edge_(edge), scale_(2.0f / float(edge)) {
        double x[lane_count<V>], y[lane_count<V>];
        for (std::uint32_t lane = 0; lane < lane_count<V>; ++lane) {
            x[lane] = lane % edge * double(scale_) - 1;
            y[lane] = lane / edge * double(scale_) - 1;
        }
        first_ = {lanes_of<V>(x), lanes_of<V>(y)};
    }
    std::uint32_t count() const { return edge_ * edge_; }
    /// Returns the positions of the pixels i, i + 1 and so on. The number i is a multiple of the number of lanes.
    CellPosition<V> position(std::uint32_t i) const {
        return {first_.x + V(scale_ * float(i % edge_)), first_.y + V(scale_ * float(i / edge_))};
    }
    /// Difference of positions between neighbouring pixels.
    float scale() const { return scale_; }

private:
    std::uint32_t edge_;
    float scale_;
    CellPosition<V> first_;
};

/// A biquadratic function in powers of the position.
template <class V>
class CellFunction {
public:
    explicit CellFunction(const CellNodes& nodes) {
        double rows[3][3];  // coefficients of the powers of x, in the three rows of nodes
        for (int j = 0; j < 3; ++j) set_powers(nodes[3 * j], nodes[3 * j + 1], nodes[3 * j + 2], rows[j]);
        for (int p = 0; p < 3; ++p) {
            double column[3];
            set_powers(rows[0][p], rows[1][p], rows[2][p], column);
            for (int q = 0; q < 3; ++q) powers_[q][p] = static_cast<float>(column[q]);
        }
    }
    V value(const CellPosition<V>& at) const {
        return fma(at.y, fma(at.y, along_x(2, at.x), along_x(1, at.x)), along_x(0, at.x));
    }
    /// Returns the derivative along x, per unit of position.
    V by_x(const CellPosition<V>& at) const {
        return fma(at.y, fma(at.y, slope(2, at.x), slope(1, at.x)), slope(0, at.x));
    }
    V by_y(const CellPosition<V>& at) const {
        return fma(at.y + at.y, along_x(2, at.x), along_x(1, at.x));
    }

private:
    static void set_powers(double first, double middle, double last, double (&powers)[3]) {
        powers[0] = middle;
        powers[1] = 0.5 * (last - first);
        powers[2] = 0.5 * (first + last) - middle;
    }
    V along_x(int q, const V& x) const {
        return fma(x, fma(x, V(powers_[q][2]), V(powers_[q][1])), V(powers_[q][0]));
    }
    V slope(int q, const V& x) const { return fma(x + x, V(powers_[q][2]), V(powers_[q][1])); }

    float powers_[3][3];  ///< Element [q][p] is the factor of x^p y^q.
};

/// A parallelogram with the sides (right_x, right_y) and (below_x, below_y), and its principal axes: the sides of the
/// rectangle with the same covariance matrix.
template <class V>
struct PrincipalSides {
    V major_x, major_y, minor_x, minor_y, major_length, minor_length;

    PrincipalSides(const V& right_x, const V& right_y, const V& below_x, const V& below_y) {
        const V zero(0.0f), half(0.5f), one(1.0f);
        const V xx = fma(right_x, right_x, below_x * below_x), xy = fma(right_x, right_y, below_x * below_y),
                yy = fma(right_y, right_y, below_y * below_y);
        const V mean = half * (xx + yy), d = half * (xx - yy), difference = sqrt(fma(d, d, xy * xy));
        const V cos_2phi = select(difference > zero, d / difference, one);
        const V cosine = sqrt(max(half * (one + cos_2phi), zero)), size = sqrt(max(half * (one - cos_2phi), zero)),
                sine = select(xy < zero, -size, size);
        // The product of the lengths is the area; this form is accurate for slender parallelograms.
        const V area = abs(fms(right_x, below_y, right_y * below_x));
        major_length = sqrt(mean + difference);
        minor_length = select(major_length > zero, area / major_length, zero);
        major_x = major_length * cosine;
        major_y = major_length * sine;
        minor_x = -(minor_length * sine);
        minor_y = minor_length * cosine;
    }
};

/// Returns the greatest integer that is not greater than a, for |a| < 2^22.
template <class V>
KAGERO_INLINE V floor_of(const V& a) {
    const V nearest = nearest_integer(a);
    return select(nearest > a, nearest - V(1.0f), nearest);
}

}  // namespace kagero::shading
