/// A ray meets a surface of the scene. Which one, and roughly where on the step, is found by the SceneIntersector.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

struct SurfaceHit {
    static constexpr Effect effect = Effect::end;
    static constexpr Status status = Status::hit;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.job.geometry != nullptr;
    }
};

}  // namespace kagero
