#include "film/film.h"

#include "error.h"
#include "kernels/assertion.h"
#include "large_vector.h"

#include <algorithm>
#include <limits>

namespace kagero {

namespace {

const std::vector<std::string> red_green_blue{"R", "G", "B"};
const std::vector<std::string> number_channel{"V"};

std::vector<std::string> layer_names() {
    std::vector<std::string> names;
    for (const LayerInfo& layer : all_layers()) names.push_back(layer.name);
    return names;
}

const LayerInfo& find_layer(const std::string& name) {
    for (const LayerInfo& layer : all_layers())
        if (layer.name == name) return layer;
    const std::string near = near_match(name, layer_names());
    throw InputError("there is no layer named '" + name + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?"));
}

}  // namespace

// Each row defines a layer. A layer is allocated and written if `film.layers` selects it. pixels/shade.cpp computes the
// values. In EXR files, the channels are named `layer.channel`. Only colours are stored as HALF, because other layers
// are used for computations.
const std::vector<LayerInfo>& all_layers() {
    using Scale = LayerInfo::Scale;
    using OfRays = LayerInfo::OfRays;
    static const std::vector<LayerInfo> layers{
        {"color", red_green_blue, Scale::colors, "linear RGB colour of the objects that the pixel's rays meet; mean"},
        {"standard_error", red_green_blue, Scale::logarithmic,
         "standard error of color: the standard deviation of the mean of the pixel's rays over random seeds, estimated "
         "from independent groups of rays; nan with spp = 1 and with an open shutter"},
        {"status", number_channel, Scale::linear,
         "status of the pixel's first ray: 0 hit, 1 escaped, 2 captured, 3 step_limit, 4 failed", OfRays::first},
        {"steps", number_channel, Scale::linear, "number of integration steps; mean", OfRays::mean, false},
        {"gradients", number_channel, Scale::linear, "number of evaluations of the derivatives of H; mean",
         OfRays::mean, false},
        {"energy_error", number_channel, Scale::logarithmic,
         "greatest |H - H0| / (|p . dH/dp| + |H0|) on the pixel's rays", OfRays::greatest, false},
        {"position_error", number_channel, Scale::logarithmic,
         "greatest estimated error of the ends of the pixel's rays, in pixels, from a comparison with half the step or "
         "with another method; nan if the compared ray ends otherwise",
         OfRays::greatest, false},
        {"rounding_error", number_channel, Scale::logarithmic,
         "greatest bound on the effect of rounding on the ends of the pixel's rays, in pixels: the sum of "
         "|adjoint * ulp| by a reverse sweep along the ray",
         OfRays::greatest, false},
        {"newton", number_channel, Scale::linear, "number of iterations of implicit solves; mean", OfRays::mean, false},
        {"occupancy", number_channel, Scale::linear,
         "fraction of active lanes over the steps of the packet that traced the first ray; packets depend on "
         "--schedule and --crop",
         OfRays::first, false},
        {"depth", number_channel, Scale::linear,
         "straight distance from the start of the first ray to its hit, in scene units; 0 without a hit",
         OfRays::first},
        {"redshift", number_channel, Scale::linear,
         "observed frequency over emitted frequency, if the first ray hits a disk, or if it escapes, with emission at "
         "rest at infinity or in space.sky_frame; else 0",
         OfRays::first},
        {"footprint", number_channel, Scale::logarithmic,
         "longest axis of the ellipse of sky that the pixel covers, in radians (the edge of the pixel for straight "
         "rays); 0 if its first ray does not escape, or is the only one in its 2x2 block that escapes",
         OfRays::first},
        {"magnification", number_channel, Scale::logarithmic,
         "solid angle of the pixel over the solid angle of the sky that it covers; 0 if its first ray does not escape "
         "or is the only one in its 2x2 block that escapes; 0 for an orthographic camera, whose pixels have no solid "
         "angle",
         OfRays::first},
        {"object", number_channel, Scale::linear,
         "number of the object that the first ray hits, in the order of the scene file, from 1; 0 without a hit",
         OfRays::first},
        {"action", number_channel, Scale::linear,
         "integral of p . dq from the camera to the end of the ray, in scene units: the optical path length in a "
         "medium; mean"},
        {"time", number_channel, Scale::linear,
         "integral of dH/dpt over lambda from the camera to the end of the ray, in scene units: the coordinate time in "
         "a spacetime, with the sign of the followed ray; mean"},
        {"traced", number_channel, Scale::linear,
         "1 if a ray of the pixel was traced, 0 if the end of its ray is interpolated (film.sampling)"},
    };
    return layers;
}

Film::Film(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& layers, const CropWindow& window,
           const Tone& tone, Planes planes)
    : width_(width), height_(height), window_(window), tone_(tone) {
    for (const std::string& name : layers) {
        if (has(name)) continue;
        const LayerInfo& layer = find_layer(name);
        layers_.push_back(&layer);
        std::vector<float>& plane = planes_.emplace_back();
        if (planes == Planes::none) continue;
        // Pixels whose rays are never traced are black in layers of colours, and NaN in other layers.
        constexpr float nan = std::numeric_limits<float>::quiet_NaN();
        const float initial_value = layer.scale == LayerInfo::Scale::colors ? 0.0f : nan;
        plane = large_vector<float>(std::size_t{width} * height * layer.channels.size(), 0, initial_value);
    }
}

bool Film::has(const std::string& layer) const {
    return std::any_of(layers_.begin(), layers_.end(), [&](const LayerInfo* info) { return info->name == layer; });
}

const float* Film::plane(const std::string& layer) const {
    for (std::size_t i = 0; i < layers_.size(); ++i)
        if (layers_[i]->name == layer) return planes_[i].data();
    return nullptr;
}

float* Film::plane(const std::string& layer) {
    return const_cast<float*>(std::as_const(*this).plane(layer));
}

std::vector<float> Film::take_plane(const std::string& layer) {
    std::size_t i = 0;
    while (layers_.at(i)->name != layer) ++i;
    return std::move(planes_[i]);
}

float* Film::pixel(const std::string& layer, std::uint32_t x, std::uint32_t y) {
    KAGERO_ASSERT(x < width_ && y < height_ && has(layer));
    return plane(layer) + (std::size_t{y} * width_ + x) * find_layer(layer).channels.size();
}

}  // namespace kagero
