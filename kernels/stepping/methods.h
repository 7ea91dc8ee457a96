/// The table of integrators. A composition is one row with its fractions and citation; a new kind of step is one more `Kind`.
#pragma once

#include "kernels/abi.h"
#include "kernels/stepping/composition.h"
#include "kernels/stepping/gauss.h"
#include "kernels/stepping/runge_kutta.h"

#include <array>
#include <new>

namespace kagero {

/// Kinds of step: each is one struct, compiled once per Hamiltonian.
enum class Kind : std::uint8_t { composition, rk4, dp5, gauss2, gauss3, gauss4, gauss6, gauss8 };
inline constexpr int kind_count = 8;

/// From weights of the self-adjoint S2, which is χ_{w/2} then χ*_{w/2}, to fractions for χ and χ* in turn.
template <std::size_t n>
constexpr std::array<double, 2 * n> of_s2(const std::array<double, n>& weights) {
    std::array<double, 2 * n> fractions{};
    for (std::size_t i = 0; i < n; ++i) fractions[2 * i] = fractions[2 * i + 1] = weights[i] / 2;
    return fractions;
}

namespace fractions {

inline constexpr auto verlet = of_s2<1>({1.0});
inline constexpr auto yoshida4 = of_s2<3>({1.351207191959657634, -1.702414383919315268, 1.351207191959657634});
inline constexpr auto suzuki4_nine =
    of_s2<9>({1. / 6, 1. / 6, 1. / 6, 1. / 6, -1. / 3, 1. / 6, 1. / 6, 1. / 6, 1. / 6});

}  // namespace fractions

struct Method {
    IntegratorInfo info;
    Kind kind;
    Fractions fractions{};
};

inline constexpr std::array methods{
    Method{{"verlet", 2, true, true, true, false,
            "semi-implicit Euler, Satoh (2003) eq. (9), with its adjoint: generalised Stoermer-Verlet"},
           Kind::composition, fractions::verlet},
    Method{{"yoshida4", 4, true, true, true, false, "three verlet steps, Satoh (2003) eqs. (12), (13); Yoshida (1990)"},
           Kind::composition, fractions::yoshida4},
    Method{{"suzuki4-nine", 4, true, true, true, false, "nine verlet steps, Satoh (2003) eqs. (14), (15); Suzuki (1990)"},
           Kind::composition, fractions::suzuki4_nine},
    Method{{"rk4", 4, false, false, false, false, "classical Runge-Kutta, Kutta (1901)"}, Kind::rk4},
    Method{{"dp5", 5, false, false, false, false, "Dormand & Prince (1980), fifth order, fixed step"}, Kind::dp5},
    Method{{"gauss4", 4, true, true, true, false, "Gauss-Legendre collocation, 2 stages"}, Kind::gauss2},
    Method{{"gauss6", 6, true, true, true, false, "Gauss-Legendre collocation, 3 stages"}, Kind::gauss3},
    Method{{"gauss8", 8, true, true, true, false, "Gauss-Legendre collocation, 4 stages"}, Kind::gauss4},
    Method{{"gauss12", 12, true, true, true, false, "Gauss-Legendre collocation, 6 stages"}, Kind::gauss6},
    Method{{"gauss16", 16, true, true, true, false, "Gauss-Legendre collocation, 8 stages"}, Kind::gauss8},
};

/// Calls visit.operator()<Step>() with the struct of a kind.
template <class Visit>
constexpr auto visit_kind(Kind kind, const Visit& visit) {
    switch (kind) {
        case Kind::rk4: return visit.template operator()<RungeKutta<classical_rk4>>();
        case Kind::dp5: return visit.template operator()<RungeKutta<dormand_prince5>>();
        case Kind::gauss2: return visit.template operator()<Gauss<2>>();
        case Kind::gauss3: return visit.template operator()<Gauss<3>>();
        case Kind::gauss4: return visit.template operator()<Gauss<4>>();
        case Kind::gauss6: return visit.template operator()<Gauss<6>>();
        case Kind::gauss8: return visit.template operator()<Gauss<8>>();
        default: return visit.template operator()<Composition>();
    }
}

}  // namespace kagero
