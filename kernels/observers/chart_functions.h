/// The functions of the module that convert between the charts near a black hole.
#pragma once

#include "kernels/abi.h"
#include "kernels/observers/charts.h"

#include <algorithm>

namespace kagero::chart_functions {

inline charts::State chart_state(const double q[3], const double p[3], double pt) {
    charts::State state{};
    std::copy(q, q + 3, state.q);
    std::copy(p, p + 3, state.p);
    state.pt = pt;
    return state;
}

inline void to_ingoing(const Hole* hole, RayStart* start) {
    charts::State state = chart_state(start->q, start->p, start->pt);
    charts::to_ingoing(*hole, state);
    std::copy(state.q, state.q + 3, start->q);
    std::copy(state.p, state.p + 3, start->p);
    start->pt = state.pt;
    start->ingoing = true;
}

inline void to_scene(const Hole* hole, double q[3], double p[3], double* pt) {
    charts::State state = chart_state(q, p, *pt);
    charts::to_scene(*hole, state);
    std::copy(state.q, state.q + 3, q);
    std::copy(state.p, state.p + 3, p);
    *pt = state.pt;
}

inline void momentum_in_ingoing_form(const Hole* hole, const double q[3], double p[3], double* pt) {
    charts::State state = chart_state(q, p, *pt);
    charts::convert(*hole, state, -1);
    charts::rotate(state.p, charts::azimuth_shift(*hole, charts::radius(*hole, state.q)));
    std::copy(state.p, state.p + 3, p);
    *pt = -state.pt;
}

inline double hole_radius(const Hole* hole, const double q[3]) {
    const double position[3] = {q[0], q[1], q[2]};
    return charts::radius(*hole, position);
}

}  // namespace kagero::chart_functions
