#include "sweep/scene_of_sets.h"

#include "spaces/formula_space.h"

#include <algorithm>

namespace kagero {

SceneOfSets::SceneOfSets(const Plan& base, const ParameterSets& sets, std::optional<ObserverKind> observer)
    : base_(base), sets_(sets), observer_(observer), scene_(std::make_shared<Scene>()) {
    const Scene& scene = *base.scene;
    scene_->description = scene.description;
    scene_->space = scene.space;
    scene_->unit = scene.unit;
    scene_->geometry = scene.geometry;
    plan.view = base.view;
    plan.run = base.run;
    plan.scene = scene_;
}

void SceneOfSets::select(std::size_t set) {
    Space& space = scene_->space;
    if (scene_->description.space.formula) {
        set_parameters(*scene_->description.space.formula, sets_.parameters(set), space);
    } else {
        std::copy_n(sets_.parameters(set), space.parameters.size(), space.parameters.begin());
    }
    scene_->straight = space.is_straight();
    scene_->limits = ray_limits(space, *scene_->geometry, scene_->description.integrator.escape_radius,
                                observer_ != ObserverKind::falling);
    plan.run.method.rescaled = base_.run.method.rescaled && !scene_->straight;
}

}  // namespace kagero
