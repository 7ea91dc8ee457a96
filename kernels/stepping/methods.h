/// The table of integrators. A composition is one row, with its fractions in `fractions.h`; a new kind of step is one more struct and
/// one more `Kind`.
#pragma once

#include "kernels/abi.h"
#include "kernels/stepping/gauss.h"
#include "kernels/stepping/recipe.h"
#include "kernels/stepping/runge_kutta.h"
#include "kernels/stepping/splitting.h"

namespace kagero {

/// Kinds of step: each is one struct, compiled once per Hamiltonian that it serves.
enum class Kind : std::uint8_t {
    composition, recipe, nystroem_kick, nystroem_drift, exact_split, rk4, dp5, dp54, rkf78, gauss1, gauss2, gauss3, gauss4, gauss6, gauss8,
};
inline constexpr int kind_count = 15;

struct Method {
    IntegratorInfo info;  ///< name, order, symplectic, symmetric, implicit, adaptive, what
    Kind kind;
    Fractions fractions{};
};

inline constexpr std::array methods{
    Method{{"euler", 1, true, false, true, false,
            "semi-implicit Euler, Satoh (2003) eq. (9)"},
           Kind::composition, fractions::once},
    Method{{"satoh2", 1, true, false, true, false,
            "S2 as printed, Satoh (2003) eq. (11): of order 1, because eq. (9) is not self-adjoint"},
           Kind::recipe, fractions::once},
    Method{{"satoh4", 1, true, false, true, false,
            "S4 as printed, Satoh (2003) eqs. (12), (13): of order 1"},
           Kind::recipe, fractions::yoshida4_weights},
    Method{{"satoh4-nine", 1, true, false, true, false,
            "S4 as printed, Satoh (2003) eqs. (14), (15): of order 1"},
           Kind::recipe, fractions::nine_weights},
    Method{{"verlet", 2, true, true, true, false,
            "eq. (9) with its adjoint: generalised Stoermer-Verlet, the self-adjoint S2"},
           Kind::composition, fractions::verlet},
    Method{{"yoshida4", 4, true, true, true, false,
            "three S2, Satoh (2003) eqs. (12), (13); Yoshida (1990)"},
           Kind::composition, fractions::yoshida4},
    Method{{"suzuki4-nine", 4, true, true, true, false,
            "nine S2, Satoh (2003) eqs. (14), (15)"},
           Kind::composition, fractions::suzuki4_nine},
    Method{{"suzuki4", 4, true, true, true, false,
            "five S2, Suzuki (1990)"},
           Kind::composition, fractions::suzuki4},
    Method{{"s6", 4, true, true, true, false,
            "Blanes & Moan (2002) S6, as a composition of eq. (9) and its adjoint"},
           Kind::composition, fractions::s6},
    Method{{"s10", 6, true, true, true, false,
            "Blanes & Moan (2002) S10, as a composition of eq. (9) and its adjoint"},
           Kind::composition, fractions::s10},
    Method{{"kahan-li6", 6, true, true, true, false,
            "nine S2, Kahan & Li (1997)"},
           Kind::composition, fractions::kahan_li6},
    Method{{"kahan-li8", 8, true, true, true, false,
            "seventeen S2, Kahan & Li (1997)"},
           Kind::composition, fractions::kahan_li8},
    Method{{"srkn6", 4, true, true, false, false,
            "Runge-Kutta-Nystroem, 6 kicks, Blanes & Moan (2002) SRKN6b; for |p|^2/2 + V(q)"},
           Kind::nystroem_kick, fractions::srkn6},
    Method{{"srkn11", 6, true, true, false, false,
            "Runge-Kutta-Nystroem, 11 kicks, Blanes & Moan (2002) SRKN11b; for |p|^2/2 + V(q)"},
           Kind::nystroem_kick, fractions::srkn11},
    Method{{"srkn14", 6, true, true, false, false,
            "Runge-Kutta-Nystroem, 14 kicks, Blanes & Moan (2002) SRKN14a; for |p|^2/2 + V(q)"},
           Kind::nystroem_drift, fractions::srkn14},
    Method{{"ks-verlet", 2, true, true, false, false,
            "exact Kerr-Schild split, explicit; Strang"},
           Kind::exact_split, fractions::split_verlet},
    Method{{"ks-yoshida4", 4, true, true, false, false,
            "exact Kerr-Schild split, explicit; Yoshida (1990)"},
           Kind::exact_split, fractions::split_yoshida4},
    Method{{"ks-suzuki4-nine", 4, true, true, false, false,
            "exact Kerr-Schild split, explicit; Satoh (2003) eqs. (14), (15)"},
           Kind::exact_split, fractions::split_suzuki4_nine},
    Method{{"ks-suzuki4", 4, true, true, false, false,
            "exact Kerr-Schild split, explicit; Suzuki (1990)"},
           Kind::exact_split, fractions::split_suzuki4},
    Method{{"ks-s6", 4, true, true, false, false,
            "exact Kerr-Schild split, explicit; Blanes & Moan (2002) S6"},
           Kind::exact_split, fractions::split_s6},
    Method{{"ks-s10", 6, true, true, false, false,
            "exact Kerr-Schild split, explicit; Blanes & Moan (2002) S10"},
           Kind::exact_split, fractions::split_s10},
    Method{{"ks-kahan-li6", 6, true, true, false, false,
            "exact Kerr-Schild split, explicit; Kahan & Li (1997)"},
           Kind::exact_split, fractions::split_kahan_li6},
    Method{{"ks-kahan-li8", 8, true, true, false, false,
            "exact Kerr-Schild split, explicit; Kahan & Li (1997)"},
           Kind::exact_split, fractions::split_kahan_li8},
    Method{{"rk4", 4, false, false, false, false,
            "classical Runge-Kutta, Kutta (1901)"},
           Kind::rk4},
    Method{{"dp5", 5, false, false, false, false,
            "Dormand & Prince (1980), fifth order, fixed step"},
           Kind::dp5},
    Method{{"dp54", 5, false, false, false, true,
            "Dormand & Prince (1980), step control by the embedded fourth order"},
           Kind::dp54},
    Method{{"rkf78", 8, false, false, false, true,
            "Fehlberg (1968), step control by the embedded seventh order"},
           Kind::rkf78},
    Method{{"midpoint", 2, true, true, true, false,
            "implicit midpoint rule: Gauss-Legendre collocation, 1 stage"},
           Kind::gauss1},
    Method{{"gauss4", 4, true, true, true, false,
            "Gauss-Legendre collocation, 2 stages"},
           Kind::gauss2},
    Method{{"gauss6", 6, true, true, true, false,
            "Gauss-Legendre collocation, 3 stages"},
           Kind::gauss3},
    Method{{"gauss8", 8, true, true, true, false,
            "Gauss-Legendre collocation, 4 stages"},
           Kind::gauss4},
    Method{{"gauss12", 12, true, true, true, false,
            "Gauss-Legendre collocation, 6 stages"},
           Kind::gauss6},
    Method{{"gauss16", 16, true, true, true, false,
            "Gauss-Legendre collocation, 8 stages"},
           Kind::gauss8},
};

/// Calls visit.operator()<Step>() with the struct of a kind.
template <class Visit>
constexpr auto visit_kind(Kind kind, const Visit& visit) {
    switch (kind) {
        case Kind::recipe: return visit.template operator()<Recipe>();
        case Kind::nystroem_kick: return visit.template operator()<Nystroem<true>>();
        case Kind::nystroem_drift: return visit.template operator()<Nystroem<false>>();
        case Kind::exact_split: return visit.template operator()<ExactSplit>();
        case Kind::rk4: return visit.template operator()<RungeKutta<classical_rk4>>();
        case Kind::dp5: return visit.template operator()<RungeKutta<dormand_prince5>>();
        case Kind::dp54: return visit.template operator()<RungeKutta<dormand_prince54>>();
        case Kind::rkf78: return visit.template operator()<RungeKutta<fehlberg78>>();
        case Kind::gauss1: return visit.template operator()<Gauss<1>>();
        case Kind::gauss2: return visit.template operator()<Gauss<2>>();
        case Kind::gauss3: return visit.template operator()<Gauss<3>>();
        case Kind::gauss4: return visit.template operator()<Gauss<4>>();
        case Kind::gauss6: return visit.template operator()<Gauss<6>>();
        case Kind::gauss8: return visit.template operator()<Gauss<8>>();
        default: return visit.template operator()<Composition>();
    }
}

}  // namespace kagero
