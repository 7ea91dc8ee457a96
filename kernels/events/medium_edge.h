/// The edge of the medium: a ray escapes where the function `domain` of the Hamiltonian decreases to zero. H is
/// undefined beyond the edge.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

/// The ray leaves the medium.
struct MediumEdge : ValueEvent<MediumEdge> {
    static constexpr Status status = Status::escaped;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.kernel.bounded;
    }
    template <class V>
    KAGERO_INLINE static V value(const RayState<V>&, const RayState<V>& at) {
        return at.domain;
    }
};

}  // namespace kagero
