#include "plan/sampling.h"

#include "film/film.h"

#include <algorithm>

namespace kagero {

std::string reason_for_full_sampling(const Scene& scene, const View& view, const RunConfig& run) {
    const FilmDescription& film = scene.description.film;
    if (film.sampling == Sampling::full) return "film.sampling = \"full\"";
    if (film.spp > 1) return "film.spp > 1: interpolation between the samples of a pixel is not supported";
    if (scene.description.camera.aperture_radius > 0) return "the rays of a pixel start at random points of the lens";
    for (const LayerInfo& layer : all_layers())
        if (!layer.interpolates && std::find(film.layers.begin(), film.layers.end(), layer.name) != film.layers.end())
            return "the layer " + layer.name + " cannot be interpolated";
    if (run.max_bounces) return "rays continue at surfaces, so their ends do not depend smoothly on the pixel";
    if (view.camera.start.ingoing && scene.geometry->kernel_view())
        return "rays that start near a horizon change their coordinates, so the space between them cannot be searched "
               "for surfaces";
    return "";
}

double interpolation_bound_of(const SceneDescription& scene) {
    const double whole = scene.integrator.max_pixel_error, bound = scene.film.max_interpolation_error;
    return whole > 0 ? std::min(bound, 0.5 * whole) : bound;
}

double method_bound_of(const SceneDescription& scene, const RunConfig& run) {
    return scene.integrator.max_pixel_error * (run.interpolation_bound > 0 ? 0.5 : 1);
}

}  // namespace kagero
