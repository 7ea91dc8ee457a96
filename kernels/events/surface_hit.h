/// Hit of a surface of the scene. The SceneIntersector finds the surface and the approximate position on the step.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

/// The ray hits a surface.
struct SurfaceHit {
    static constexpr Effect effect = Effect::end;
    static constexpr Status status = Status::hit;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.job.geometry != nullptr;
    }
};

}  // namespace kagero
