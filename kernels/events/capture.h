/// Capture: a ray ends where the function `captured` of the Hamiltonian decreases to zero, for example near a horizon.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

/// The ray is captured.
struct Capture : ValueEvent<Capture> {
    static constexpr Status status = Status::captured;
    /// The ray is captured even if no partial step conserves H, because `captured` ≤ 0 at the end of the whole step.
    static constexpr bool ends_if_unrefined = true;

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
