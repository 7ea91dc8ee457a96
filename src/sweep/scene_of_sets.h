/// The scene of one set of parameters at a time.
#pragma once

#include "rays/start_rays.h"
#include "sweep/parameter_sets.h"

namespace kagero {

/// A copy of a plan whose scene is changed from set to set, without loading it again. The space, the limits of rays and
/// the step depend on the parameters; everything else is shared with the plan of the constructor. Threads need one
/// object each.
class SceneOfSets {
public:
    /// `base` is the plan of a set whose rays bend, or of any set if all rays are straight. It must outlive this
    /// object.
    SceneOfSets(const Plan& base, const ParameterSets& sets, std::optional<ObserverKind> observer);

    /// Changes `plan` to that of a set.
    void select(std::size_t set);
    /// Returns the starts of the rays in the selected set.
    std::vector<RayStart> starts(const std::vector<RayInput>& rays) const { return start_rays(plan, rays, observer_); }

    Plan plan;  ///< The plan of the selected set. Its scene has no paints and no sky.

private:
    const Plan& base_;
    const ParameterSets& sets_;
    const std::optional<ObserverKind> observer_;
    const std::shared_ptr<Scene> scene_;
};

}  // namespace kagero
