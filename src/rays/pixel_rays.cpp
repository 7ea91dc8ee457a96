#include "rays/pixel_rays.h"

#include <algorithm>

namespace kagero {

PixelRays::PixelRays(const SceneDescription& scene) : spp_(scene.film.spp), seed_(scene.film.seed) {
    const std::vector<std::string>& layers = scene.film.layers;
    const bool is_random = has_material(scene, Material::diffuse) || scene.camera.aperture_radius > 0,
               has_error = std::find(layers.begin(), layers.end(), "standard_error") != layers.end();
    if (is_random || has_error) groups_ = std::min(spp_, max_groups);
}

PixelRay PixelRays::ray(std::uint32_t x, std::uint32_t y, std::uint32_t index) const {
    if (groups_ == 1) return {x, y, index, seed_};
    // Seeds of different groups and of neighbouring seeds differ in all bits, because the multiplier is odd and large.
    return {x, y, index / groups_, (seed_ + 1) * 0x9e3779b9u ^ group_of(index) * 0x85ebca6bu};
}

std::array<double, 2> PixelRays::position(std::uint32_t x, std::uint32_t y, std::uint32_t index) const {
    const PixelRay member = ray(x, y, index);
    return sample_position(x, y, member.index, spp_, member.seed);
}

}  // namespace kagero
