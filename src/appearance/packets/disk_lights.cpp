#include "appearance/packets/disk_lights.h"

#include "appearance/blackbody.h"

namespace kagero {

void DiskLights::add(PixelSample& ray) {
    const RayEnd& end = *ray.end;
    rays_[count_] = &ray;
    kelvin_[count_] = observed_temperature(paints_.object(end.surface), {end.q[0], end.q[1], end.q[2]},
                                           redshift_of(sources_, spacetime_, ray));
    if (++count_ == capacity) finish();
}

void DiskLights::finish() {
    if (count_ == 0) return;
    std::array<std::array<double, 3>, capacity> rgb;
    blackbody_colors(module_, {kelvin_.data(), count_}, rgb.data());
    for (std::size_t i = 0; i < count_; ++i) {
        const double scale = paints_.object(rays_[i]->end->surface).inverse_luminance;
        for (std::size_t k = 0; k < 3; ++k) rays_[i]->source_color[k] = static_cast<float>(scale * rgb[i][k]);
    }
    count_ = 0;
}

}  // namespace kagero
