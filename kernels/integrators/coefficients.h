/// Coefficients that distinguish the methods of one stepper.
#pragma once

#include "kernels/integrators/butcher_tables.h"
#include "kernels/integrators/fractions.h"
#include "kernels/integrators/gauss_table.h"

namespace kagero {

/// Coefficients of one method. Each stepper reads only the members that it needs.
struct Coefficients {
    Fractions fractions{};                ///< compositions, splittings, orbit methods, and the recipe as printed
    bool kick_first = false;              ///< Nyström and orbit methods: the first substep is a kick, not a drift
    const ButcherTable* table = nullptr;  ///< tableau of an explicit Runge–Kutta method
    const GaussTableau* gauss = nullptr;  ///< tableau of a Gauss–Legendre collocation method
};

}  // namespace kagero
