#include "adaptive/end_interpolant.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {

EndInterpolant::Values EndInterpolant::values_of(const RayEnd& end) {
    return {end.v[0], end.v[1], end.v[2], end.q[0],      end.q[1],   end.q[2],
            end.p[0], end.p[1], end.p[2], end.parameter, end.action, end.time};
}

EndInterpolant::EndInterpolant(const EndLattice& ends) : middle_(*ends[4]) {
    for (std::size_t i = 0; i < 9; ++i) nodes_[i] = values_of(*ends[i]);
}

void EndInterpolant::set_row(double v) {
    const double weights[3] = {0.5 * (v - 1) * (v - 2), v * (2 - v), 0.5 * v * (v - 1)};
    for (std::size_t c = 0; c < components; ++c) {
        double column[3];
        for (std::size_t j = 0; j < 3; ++j)
            column[j] = weights[0] * nodes_[j][c] + weights[1] * nodes_[3 + j][c] + weights[2] * nodes_[6 + j][c];
        constant_[c] = column[0];
        linear_[c] = -1.5 * column[0] + 2 * column[1] - 0.5 * column[2];
        quadratic_[c] = 0.5 * (column[0] + column[2]) - column[1];
    }
}

void EndInterpolant::write(double u, RayEnd& end) const {
    Values x;
    for (std::size_t c = 0; c < components; ++c) x[c] = constant_[c] + u * (linear_[c] + u * quadratic_[c]);
    const double norm = 1 / std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    end = middle_;
    for (std::size_t k = 0; k < 3; ++k) {
        end.v[k] = x[k] * norm;
        end.q[k] = x[3 + k];
        end.p[k] = x[6 + k];
    }
    end.parameter = x[9];
    end.action = x[10];
    end.time = x[11];
    end.energy_error = std::numeric_limits<double>::quiet_NaN();
}

}  // namespace kagero
