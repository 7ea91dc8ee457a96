/// Capture: a ray ends where the Hamiltonian's `captured` falls to zero, for example close to a horizon.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

struct Capture : ValueEvent<Capture> {
    static constexpr Status status = Status::captured;
    /// A captured ray is captured even if H is lost on the way to where it is.
    static constexpr bool certain = true;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.kernel.capturing;
    }
    template <class V>
    KAGERO_INLINE static V value(const RayState<V>&, const RayState<V>& at) {
        return at.captured;
    }
};

}  // namespace kagero
