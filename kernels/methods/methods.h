/// The table of integrators. A new composition is one row of the table, with its fractions in `fractions.h`. A new
/// stepper is one more struct and one more entry of KAGERO_STEPPERS.
///
/// A stepper is a struct with these static functions and constants:
///   family                                family of methods that the stepper belongs to.
///   refusal<System>()                     nullptr if the stepper supports the system, else the reason why not.
///   begin(system, step, coefficients)     initialises step.stage and the stepper's memory at the start of rays.
///   step(system, step, coefficients)      performs a step of length step.h from step.start: sets end, solved and the
///                                         carried quantities, and counts gradients; adaptive methods also set
///                                         accepted and suggested_length.
///   operations(coefficients, program)     floating-point operations per gradient and per step; `program` contains
///                                         those of the programs of H.
///   rounding_counts(coefficients)         numbers of roundings per step.
/// These members are optional. A constant need only be declared; its value is not used:
///   curve<V>                              dense output of the method; the default is the cubic Hermite curve.
///   stage_state<V>                        writes the state and dq/dτ at a stage of the last step. The stages are those
///                                         of a quadrature formula with the order of the method.
///   steps_without_begin                   a step of a new length, or from a new state of a ray, needs no call of
///                                         `begin` first; only the start of a ray needs it.
///   keeps_memory                          RayState::stepper_memory is passed from step to step.
///   stages_inside                         the stepper evaluates no derivative at the ends of a step, where the
///                                         gradient of H may be discontinuous.
///   splits_gradient                       the stepper evaluates ∂K/∂q and ∂K/∂p separately.
///   shareable<System>()                   returns true if the stepper may be compiled once for all called systems.
///   regular_in_both_charts                `integrate_to_escape` is accurate in either chart of a spinning hole
///                                         (kernels/observers/charts.h), wherever rays turn.
///   integrate_to_escape(system, step, coefficients, integration)
///                                         integrates rays that cannot meet a surface to the escape sphere.
///   finish(step)                          changes the end of a step after its event functions have been evaluated.
#pragma once

#include "kernels/abi.h"
#include "kernels/integrators/gauss.h"
#include "kernels/orbits/orbit.h"
#include "kernels/orbits/separated.h"
#include "kernels/recipe/recipe.h"
#include "kernels/integrators/runge_kutta.h"
#include "kernels/integrators/splitting.h"

namespace kagero {

/// The list of steppers. Each is compiled once per Hamiltonian that it supports, or once for all called systems.
/// Gauss<0> supports every number of stages.
#define KAGERO_STEPPERS(X)                                                                                            \
    X(composition, Composition) X(recipe, Recipe) X(nystroem, Nystroem) X(exact_split, ExactSplit) X(orbit, Orbit)    \
    X(separated, Separated)                                                                                           \
    X(runge_kutta, RungeKutta) X(gauss, Gauss<0>) X(gauss_4_stages, Gauss<4>)

/// Identifies a stepper.
enum class StepperKind : std::uint8_t {
#define KAGERO_KIND(NAME, ...) NAME,
    KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND
};
/// Number of steppers.
inline constexpr int kind_count = 0
#define KAGERO_KIND(...) +1
    KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND
    ;

/// Maps a kind to the struct of its stepper.
template <StepperKind kind>
struct StepperOf;
#define KAGERO_KIND(NAME, ...) template <> struct StepperOf<StepperKind::NAME> { using type = __VA_ARGS__; };
KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND

/// One row of the table of integrators.
struct Method {
    IntegratorInfo info;
    StepperKind kind;
    Coefficients coefficients{};
};

inline constexpr std::array methods{
    Method{{.name = "euler", .order = 1, .symplectic = true, .implicit = true,
            .what = "semi-implicit Euler, Satoh (2003) eq. (9)"},
           StepperKind::composition, {.fractions = fractions::single_step}},
    Method{{.name = "satoh2", .order = 1, .symplectic = true, .implicit = true,
            .what = "S2 as printed, Satoh (2003) eq. (11): of order 1, because eq. (9) is not self-adjoint",
            .representative = true},
           StepperKind::recipe, {.fractions = fractions::single_step}},
    Method{{.name = "satoh4", .order = 1, .symplectic = true, .implicit = true,
            .what = "S4 as printed, Satoh (2003) eqs. (12), (13): of order 1", .representative = true},
           StepperKind::recipe, {.fractions = fractions::yoshida4_weights}},
    Method{{.name = "satoh4-nine", .order = 1, .symplectic = true, .implicit = true,
            .what = "S4 as printed, Satoh (2003) eqs. (14), (15): of order 1"},
           StepperKind::recipe, {.fractions = fractions::nine_weights}},
    Method{{.name = "verlet", .order = 2, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "eq. (9) composed with its adjoint: generalised Stoermer-Verlet, the self-adjoint S2",
            .representative = true},
           StepperKind::composition, {.fractions = fractions::verlet}},
    Method{{.name = "yoshida4", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "three S2, Satoh (2003) eqs. (12), (13); Yoshida (1990)"},
           StepperKind::composition, {.fractions = fractions::yoshida4}},
    Method{{.name = "suzuki4-nine", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "nine S2, Satoh (2003) eqs. (14), (15)", .representative = true},
           StepperKind::composition, {.fractions = fractions::suzuki4_nine}},
    Method{{.name = "suzuki4", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "five S2, Suzuki (1990)"},
           StepperKind::composition, {.fractions = fractions::suzuki4}},
    Method{{.name = "s6", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Blanes & Moan (2002) S6, as a composition of eq. (9) and its adjoint"},
           StepperKind::composition, {.fractions = fractions::s6}},
    Method{{.name = "s10", .order = 6, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Blanes & Moan (2002) S10, as a composition of eq. (9) and its adjoint"},
           StepperKind::composition, {.fractions = fractions::s10}},
    Method{{.name = "kahan-li6", .order = 6, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "nine S2, Kahan & Li (1997)"},
           StepperKind::composition, {.fractions = fractions::kahan_li6}},
    Method{{.name = "kahan-li8", .order = 8, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "seventeen S2, Kahan & Li (1997)"},
           StepperKind::composition, {.fractions = fractions::kahan_li8}},
    Method{{.name = "srkn6", .order = 4, .symplectic = true, .symmetric = true,
            .what = "Runge-Kutta-Nystroem, 6 kicks, Blanes & Moan (2002) SRKN6b; for |p|^2/2 + V(q)",
            .drift_kick = true},
           StepperKind::nystroem, {.fractions = fractions::srkn6, .kick_first = true}},
    Method{{.name = "srkn11", .order = 6, .symplectic = true, .symmetric = true,
            .what = "Runge-Kutta-Nystroem, 11 kicks, Blanes & Moan (2002) SRKN11b; for |p|^2/2 + V(q)",
            .drift_kick = true},
           StepperKind::nystroem, {.fractions = fractions::srkn11, .kick_first = true}},
    Method{{.name = "srkn14", .order = 6, .symplectic = true, .symmetric = true,
            .what = "Runge-Kutta-Nystroem, 14 kicks, Blanes & Moan (2002) SRKN14a; for |p|^2/2 + V(q)",
            .drift_kick = true},
           StepperKind::nystroem, {.fractions = fractions::srkn14, .kick_first = false}},
    Method{{.name = "ks-verlet", .order = 2, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Strang"},
           StepperKind::exact_split, {.fractions = fractions::split_verlet}},
    Method{{.name = "ks-yoshida4", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Yoshida (1990)"},
           StepperKind::exact_split, {.fractions = fractions::split_yoshida4}},
    Method{{.name = "ks-suzuki4-nine", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Satoh (2003) eqs. (14), (15)"},
           StepperKind::exact_split, {.fractions = fractions::split_suzuki4_nine}},
    Method{{.name = "ks-suzuki4", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Suzuki (1990)"},
           StepperKind::exact_split, {.fractions = fractions::split_suzuki4}},
    Method{{.name = "ks-s6", .order = 4, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Blanes & Moan (2002) S6"},
           StepperKind::exact_split, {.fractions = fractions::split_s6}},
    Method{{.name = "ks-s10", .order = 6, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Blanes & Moan (2002) S10", .representative = true},
           StepperKind::exact_split, {.fractions = fractions::split_s10}},
    Method{{.name = "ks-kahan-li6", .order = 6, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Kahan & Li (1997)"},
           StepperKind::exact_split, {.fractions = fractions::split_kahan_li6}},
    Method{{.name = "ks-kahan-li8", .order = 8, .symplectic = true, .symmetric = true,
            .what = "exact Kerr-Schild split, explicit; Kahan & Li (1997)"},
           StepperKind::exact_split, {.fractions = fractions::split_kahan_li8}},
    Method{{.name = "orbit-srkn6", .order = 4,
            .what = "in the plane of the orbit, steps in radians; Blanes & Moan (2002) SRKN6b", .angular = true},
           StepperKind::orbit, {.fractions = fractions::srkn6, .kick_first = true}},
    Method{{.name = "orbit-srkn11", .order = 6,
            .what = "in the plane of the orbit, steps in radians; Blanes & Moan (2002) SRKN11b", .angular = true},
           StepperKind::orbit, {.fractions = fractions::srkn11, .kick_first = true}},
    Method{{.name = "orbit-srkn14", .order = 6,
            .what = "in the plane of the orbit, steps in radians; Blanes & Moan (2002) SRKN14a", .angular = true},
           StepperKind::orbit, {.fractions = fractions::srkn14, .kick_first = false}},
    Method{{.name = "mino-srkn6", .order = 4,
            .what = "separated motion around a spinning hole, steps in radians; Blanes & Moan (2002) SRKN6b",
            .angular = true, .separated = true},
           StepperKind::separated, {.fractions = fractions::srkn6, .kick_first = true}},
    Method{{.name = "mino-srkn11", .order = 6,
            .what = "separated motion around a spinning hole, steps in radians; Blanes & Moan (2002) SRKN11b",
            .angular = true, .separated = true},
           StepperKind::separated, {.fractions = fractions::srkn11, .kick_first = true}},
    Method{{.name = "mino-srkn14", .order = 6,
            .what = "separated motion around a spinning hole, steps in radians; Blanes & Moan (2002) SRKN14a",
            .angular = true, .separated = true},
           StepperKind::separated, {.fractions = fractions::srkn14, .kick_first = false}},
    Method{{.name = "rk4", .order = 4,
            .what = "classical Runge-Kutta, Kutta (1901)", .representative = true},
           StepperKind::runge_kutta, {.table = &kutta4}},
    Method{{.name = "dp5", .order = 5,
            .what = "Dormand & Prince (1980), fifth order, fixed step"},
           StepperKind::runge_kutta, {.table = &dormand_prince5}},
    Method{{.name = "dp54", .order = 5, .adaptive = true,
            .what = "Dormand & Prince (1980), step control by the embedded fourth order", .representative = true},
           StepperKind::runge_kutta, {.table = &dormand_prince54}},
    Method{{.name = "rkf78", .order = 8, .adaptive = true,
            .what = "Fehlberg (1968), step control by the embedded seventh order; the error estimate uses only the two "
                    "ends of a step"},
           StepperKind::runge_kutta, {.table = &fehlberg78}},
    Method{{.name = "dp8", .order = 8,
            .what = "DOP853 of Dormand & Prince, eighth order, Hairer, Noersett & Wanner (1993), fixed step"},
           StepperKind::runge_kutta, {.table = &dormand_prince8}},
    Method{{.name = "dp85", .order = 8, .adaptive = true,
            .what = "DOP853 of Dormand & Prince, eighth order, step control by the embedded fifth order"},
           StepperKind::runge_kutta, {.table = &dormand_prince85}},
    Method{{.name = "verner9", .order = 9,
            .what = "Verner (2010), ninth order of the most efficient 9(8) pair, fixed step"},
           StepperKind::runge_kutta, {.table = &verner9}},
    Method{{.name = "midpoint", .order = 2, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "implicit midpoint rule: Gauss-Legendre collocation, 1 stage", .is_collocation = true},
           StepperKind::gauss, {.gauss = &gauss_tableau<1>}},
    Method{{.name = "gauss4", .order = 4, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 2 stages", .is_collocation = true},
           StepperKind::gauss, {.gauss = &gauss_tableau<2>}},
    Method{{.name = "gauss6", .order = 6, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 3 stages", .is_collocation = true},
           StepperKind::gauss, {.gauss = &gauss_tableau<3>}},
    Method{{.name = "gauss8", .order = 8, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 4 stages", .is_collocation = true, .representative = true},
           StepperKind::gauss_4_stages, {.gauss = &gauss_tableau<4>}},
    Method{{.name = "gauss12", .order = 12, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 6 stages", .is_collocation = true},
           StepperKind::gauss, {.gauss = &gauss_tableau<6>}},
    Method{{.name = "gauss16", .order = 16, .symplectic = true, .symmetric = true, .implicit = true,
            .what = "Gauss-Legendre collocation, 8 stages", .is_collocation = true},
           StepperKind::gauss, {.gauss = &gauss_tableau<8>}},
};

/// Calls visit.operator()<Stepper>(), where Stepper is the struct of the given kind, and returns the result.
template <class Visit>
constexpr auto visit_kind(StepperKind kind, const Visit& visit) {
    switch (kind) {
#define KAGERO_KIND(NAME, ...) case StepperKind::NAME: return visit.template operator()<__VA_ARGS__>();
        KAGERO_STEPPERS(KAGERO_KIND)
#undef KAGERO_KIND
    }
    __builtin_unreachable();
}

/// Returns the public description of a method.
constexpr IntegratorInfo info_of(const Method& method) {
    IntegratorInfo info = method.info;
    info.family = visit_kind(method.kind, []<class Stepper>() { return Stepper::family; });
    return info;
}

/// Returns the floating-point operations of a method for given programs of a Hamiltonian.
inline Operations operations_of(const Method& method, const ProgramOperations& program) {
    return visit_kind(method.kind, [&]<class Stepper>() { return Stepper::operations(method.coefficients, program); });
}
/// Returns the numbers of roundings of a method in one step.
constexpr RoundingCounts rounding_counts_of(const Method& method) {
    return visit_kind(method.kind, [&]<class Stepper>() { return Stepper::rounding_counts(method.coefficients); });
}

}  // namespace kagero
