/// What distinguishes methods of one kind: data.
#pragma once

#include "kernels/integrators/butcher_tables.h"
#include "kernels/integrators/fractions.h"
#include "kernels/integrators/gauss_table.h"

namespace kagero {

struct Coefficients {
    Fractions fractions{};              ///< of the step: compositions, splittings, the printed recipe
    bool kick_first = false;            ///< Nyström
    const ButcherTable* table = nullptr;  ///< Runge–Kutta
    const GaussTableau* gauss = nullptr;  ///< collocation
};

}  // namespace kagero
