#include "paths/medium_indices.h"

#include <algorithm>

namespace kagero {

void MediumIndices::reset(const Plan& plan, std::size_t rays) {
    varies_.assign(plan.media.size() + 1, false);
    for (std::uint32_t medium = 0; medium < varies_.size(); ++medium) {
        const Scene& scene = *plan.medium(medium).scene;
        varies_[medium] = !scene.straight && null_ray_sign(scene) == 0;
    }
    any_varies_ = std::find(varies_.begin(), varies_.end(), true) != varies_.end();
    first_.assign(any_varies_ ? rays * varies_.size() : 0, 0);
}

double MediumIndices::index_of(std::size_t ray, std::uint32_t medium, double index) {
    if (!varies_[medium]) return index;
    double& first = first_[ray * varies_.size() + medium];
    if (first == 0) first = index;
    return first;
}

double MediumIndices::radiance_ratio(std::size_t ray, std::uint32_t medium, const SurfaceInteraction& interaction) {
    const Branch& branch = *interaction.transmitted;
    if (!any_varies_ || medium == branch.medium) return branch.radiance;
    const double ratio =
        index_of(ray, medium, interaction.index) / index_of(ray, branch.medium, interaction.transmitted_index);
    return ratio * ratio;
}

}  // namespace kagero
