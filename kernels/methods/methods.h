/// The table of integrators. A composition is one row, with its fractions in `fractions.h`; a new kind of stepper is
/// one more struct and one more row of KAGERO_STEPPERS.
///
/// A stepper is a struct of static functions and constants,
///   family                                what it has in common with others
///   refusal<System>()                     null if it serves a system, else the reason why not
///   begin(system, state, coefficients)    fills state.stage at the start of rays
///   step(system, state, coefficients)     a step from state.start by state.h: sets end, carried quantities and solved,
///                                         counts gradients; adaptive methods also set accepted and suggested
///   operations(coefficients, program)     its cost with a Hamiltonian's programs, per gradient and per step
///   roundings(coefficients)               how often it rounds in a step
/// and, optionally,
///   curve<V>                              its own dense output; without it, that is the cubic Hermite one
///   resumes                               a step from another place or of another length needs no `begin` before it
///   carries                               RayState::carry goes from step to step
///   stages_inside                         no derivative is evaluated at the ends of a step, where the slope of H may jump
///   takes_sides                           it uses ∂K/∂q and ∂K/∂p separately
///   shareable<System>()                   it may be compiled once for all called systems instead of inlined
///   integrate_to_escape(system, state, coefficients, way)  integrates rays that meet nothing to the escape sphere
///   finish(state)                         changes the end of a step after its event functions have been evaluated
#pragma once

#include "kernels/abi.h"
#include "kernels/integrators/gauss.h"
#include "kernels/orbits/orbit.h"
#include "kernels/recipe/recipe.h"
#include "kernels/integrators/runge_kutta.h"
#include "kernels/integrators/splitting.h"

namespace kagero {

/// The kinds of stepper: each is compiled once per Hamiltonian that it serves, or once for all called systems.
#define KAGERO_STEPPERS(X)                                                                                                     \
    X(composition, Composition) X(recipe, Recipe) X(nystroem, Nystroem) X(exact_split, ExactSplit) X(orbit, Orbit)          \
    X(runge_kutta, RungeKutta) X(gauss, Gauss<0>) X(gauss_of_4, Gauss<4>)

enum class Kind : std::uint8_t {
#define KAGERO_KIND(NAME, ...) NAME,
    KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND
};
inline constexpr int kind_count = 0
#define KAGERO_KIND(...) +1
    KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND
    ;

/// The struct of a kind.
template <Kind kind>
struct StepperOf;
#define KAGERO_KIND(NAME, ...) template <> struct StepperOf<Kind::NAME> { using type = __VA_ARGS__; };
KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND

struct Method {
    IntegratorInfo info;
    Kind kind;
    Coefficients coefficients{};
};

inline constexpr std::array methods{
    Method{{.name = "euler", .order = 1, .symplectic = true, .implicit = true,
            .what = "semi-implicit Euler, Satoh (2003) eq. (9)"},
           Kind::composition, {.fractions = fractions::once}},
    Method{{.name = "satoh2", .order = 1, .symplectic = true, .implicit = true,
            .what = "S2 as printed, Satoh (2003) eq. (11): of order 1, because eq. (9) is not self-adjoint", .typical = true},
           Kind::recipe, {.fractions = fractions::once}},
    Method{{.name = "satoh4", .order = 1, .symplectic = true, .implicit = true,
            .what = "S4 as printed, Satoh (2003) eqs. (12), (13): of order 1", .typical = true},
           Kind::recipe, {.fractions = fractions::yoshida4_weights}},
    Method{{.name = "satoh4-nine", .order = 1, .symplectic = true, .implicit = true,
            .what = "S4 as printed, Satoh (2003) eqs. (14), (15): of order 1"},
           Kind::recipe, {.fractions = fractions::nine_weights}},
    Method{{.name = "verlet", .order = 2, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "eq. (9) with its adjoint: generalised Stoermer-Verlet, the self-adjoint S2", .typical = true},
           Kind::composition, {.fractions = fractions::verlet}},
    Method{{.name = "yoshida4", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "three S2, Satoh (2003) eqs. (12), (13); Yoshida (1990)"},
           Kind::composition, {.fractions = fractions::yoshida4}},
    Method{{.name = "suzuki4-nine", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "nine S2, Satoh (2003) eqs. (14), (15)", .typical = true},
           Kind::composition, {.fractions = fractions::suzuki4_nine}},
    Method{{.name = "suzuki4", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "five S2, Suzuki (1990)"},
           Kind::composition, {.fractions = fractions::suzuki4}},
    Method{{.name = "s6", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Blanes & Moan (2002) S6, as a composition of eq. (9) and its adjoint"},
           Kind::composition, {.fractions = fractions::s6}},
    Method{{.name = "s10", .order = 6, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Blanes & Moan (2002) S10, as a composition of eq. (9) and its adjoint"},
           Kind::composition, {.fractions = fractions::s10}},
    Method{{.name = "kahan-li6", .order = 6, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "nine S2, Kahan & Li (1997)"},
           Kind::composition, {.fractions = fractions::kahan_li6}},
    Method{{.name = "kahan-li8", .order = 8, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "seventeen S2, Kahan & Li (1997)"},
           Kind::composition, {.fractions = fractions::kahan_li8}},
    Method{{.name = "srkn6", .order = 4, .symplectic = true, .symmetric = true,
            .what = "Runge-Kutta-Nystroem, 6 kicks, Blanes & Moan (2002) SRKN6b; for |p|^2/2 + V(q)", .drifts = true},
           Kind::nystroem, {.fractions = fractions::srkn6, .kick_first = true}},
    Method{{.name = "srkn11", .order = 6, .symplectic = true, .symmetric = true,
            .what = "Runge-Kutta-Nystroem, 11 kicks, Blanes & Moan (2002) SRKN11b; for |p|^2/2 + V(q)", .drifts = true},
           Kind::nystroem, {.fractions = fractions::srkn11, .kick_first = true}},
    Method{{.name = "srkn14", .order = 6, .symplectic = true, .symmetric = true,
            .what = "Runge-Kutta-Nystroem, 14 kicks, Blanes & Moan (2002) SRKN14a; for |p|^2/2 + V(q)", .drifts = true},
           Kind::nystroem, {.fractions = fractions::srkn14, .kick_first = false}},
    Method{{.name = "ks-verlet", .order = 2, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Strang"},
           Kind::exact_split, {.fractions = fractions::split_verlet}},
    Method{{.name = "ks-yoshida4", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Yoshida (1990)"},
           Kind::exact_split, {.fractions = fractions::split_yoshida4}},
    Method{{.name = "ks-suzuki4-nine", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Satoh (2003) eqs. (14), (15)"},
           Kind::exact_split, {.fractions = fractions::split_suzuki4_nine}},
    Method{{.name = "ks-suzuki4", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Suzuki (1990)"},
           Kind::exact_split, {.fractions = fractions::split_suzuki4}},
    Method{{.name = "ks-s6", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Blanes & Moan (2002) S6"},
           Kind::exact_split, {.fractions = fractions::split_s6}},
    Method{{.name = "ks-s10", .order = 6, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Blanes & Moan (2002) S10", .typical = true},
           Kind::exact_split, {.fractions = fractions::split_s10}},
    Method{{.name = "ks-kahan-li6", .order = 6, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Kahan & Li (1997)"},
           Kind::exact_split, {.fractions = fractions::split_kahan_li6}},
    Method{{.name = "ks-kahan-li8", .order = 8, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Kahan & Li (1997)"},
           Kind::exact_split, {.fractions = fractions::split_kahan_li8}},
    Method{{.name = "orbit-srkn6", .order = 4,
            .what = "in the plane of the orbit, steps in radians; Blanes & Moan (2002) SRKN6b", .angular = true},
           Kind::orbit, {.fractions = fractions::srkn6, .kick_first = true}},
    Method{{.name = "orbit-srkn11", .order = 6,
            .what = "in the plane of the orbit, steps in radians; Blanes & Moan (2002) SRKN11b", .angular = true},
           Kind::orbit, {.fractions = fractions::srkn11, .kick_first = true}},
    Method{{.name = "orbit-srkn14", .order = 6,
            .what = "in the plane of the orbit, steps in radians; Blanes & Moan (2002) SRKN14a", .angular = true},
           Kind::orbit, {.fractions = fractions::srkn14, .kick_first = false}},
    Method{{.name = "rk4", .order = 4,
            .what = "classical Runge-Kutta, Kutta (1901)", .typical = true},
           Kind::runge_kutta, {.table = &kutta4}},
    Method{{.name = "dp5", .order = 5,
            .what = "Dormand & Prince (1980), fifth order, fixed step"},
           Kind::runge_kutta, {.table = &dormand_prince5}},
    Method{{.name = "dp54", .order = 5, .adaptive = true,
            .what = "Dormand & Prince (1980), step control by the embedded fourth order", .typical = true},
           Kind::runge_kutta, {.table = &dormand_prince54}},
    Method{{.name = "rkf78", .order = 8, .adaptive = true,
            .what = "Fehlberg (1968), step control by the embedded seventh order, which is blind between ends that are alike"},
           Kind::runge_kutta, {.table = &fehlberg78}},
    Method{{.name = "dp8", .order = 8,
            .what = "Dormand & Prince's eighth order of DOP853, Hairer, Noersett & Wanner (1993), fixed step"},
           Kind::runge_kutta, {.table = &dormand_prince8}},
    Method{{.name = "dp85", .order = 8, .adaptive = true,
            .what = "the same, step control by the embedded fifth order"},
           Kind::runge_kutta, {.table = &dormand_prince85}},
    Method{{.name = "verner9", .order = 9,
            .what = "Verner (2010), ninth order of his most efficient 9(8) pair, fixed step"},
           Kind::runge_kutta, {.table = &verner9}},
    Method{{.name = "midpoint", .order = 2, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "implicit midpoint rule: Gauss-Legendre collocation, 1 stage", .collocates = true},
           Kind::gauss, {.gauss = &gauss_tableau<1>}},
    Method{{.name = "gauss4", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 2 stages", .collocates = true},
           Kind::gauss, {.gauss = &gauss_tableau<2>}},
    Method{{.name = "gauss6", .order = 6, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 3 stages", .collocates = true},
           Kind::gauss, {.gauss = &gauss_tableau<3>}},
    Method{{.name = "gauss8", .order = 8, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 4 stages", .collocates = true, .typical = true},
           Kind::gauss_of_4, {.gauss = &gauss_tableau<4>}},
    Method{{.name = "gauss12", .order = 12, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 6 stages", .collocates = true},
           Kind::gauss, {.gauss = &gauss_tableau<6>}},
    Method{{.name = "gauss16", .order = 16, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 8 stages", .collocates = true},
           Kind::gauss, {.gauss = &gauss_tableau<8>}},
};

/// Calls visit.operator()<Stepper>() with the struct of a kind.
template <class Visit>
constexpr auto visit_kind(Kind kind, const Visit& visit) {
    switch (kind) {
#define KAGERO_KIND(NAME, ...) case Kind::NAME: return visit.template operator()<__VA_ARGS__>();
        KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND
    }
    __builtin_unreachable();
}

/// What the world is told of a method.
constexpr IntegratorInfo info_of(const Method& method) {
    IntegratorInfo info = method.info;
    info.family = visit_kind(method.kind, []<class Stepper>() { return Stepper::family; });
    return info;
}

/// A method's operations on the programs of a Hamiltonian.
inline Operations operations_of(const Method& method, const ProgramOperations& program) {
    return visit_kind(method.kind, [&]<class Stepper>() { return Stepper::operations(method.coefficients, program); });
}
constexpr RoundingCounts rounding_counts_of(const Method& method) {
    return visit_kind(method.kind, [&]<class Stepper>() { return Stepper::roundings(method.coefficients); });
}

}  // namespace kagero
