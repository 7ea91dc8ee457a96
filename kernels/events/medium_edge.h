/// The edge of the medium: a ray leaves the medium where the Hamiltonian's `domain` falls to zero. Beyond it H has no
/// meaning.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

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
