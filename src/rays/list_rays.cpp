#include "rays/list_rays.h"

#include "rays/camera.h"
#include "rays/pixel_rays.h"

namespace kagero {

void list_rays(const Plan& plan, const Tile& tile, RayList& list) {
    const FilmDescription& film = plan.description().film;
    const PixelRays pixel_rays(plan.description());
    const bool has_lens = plan.description().camera.aperture_radius > 0;
    list.starts.clear();
    list.frequencies.clear();
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
        for (std::uint32_t x = tile.x0; x < tile.x1; ++x)
            for (std::uint32_t i = 0; i < film.spp; ++i) {
                const auto [u, v] = pixel_rays.position(x, y, i);
                const CameraRay ray =
                    has_lens ? lens_ray(plan, x + u, y + v,
                                        concentric_disk(sample_square(pixel_rays.ray(x, y, i), RandomChoice::lens, 0)))
                             : camera_ray(plan, x + u, y + v);
                list.starts.push_back(ray.start);
                list.frequencies.push_back(ray.frequency);
            }
}

}  // namespace kagero
