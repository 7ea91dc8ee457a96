#include "film/film.h"

#include "kernels/assertion.h"

#include "error.h"

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
    throw InputError("there is no layer '" + name + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?"));
}

}  // namespace

// One row is one more layer: it can then be asked for in `film.layers`, is allocated, written and listed. What its
// pixels hold is filled in where rays become pixels (src/render). A layer is `name.channel` in the file; only colours,
// which nobody counts with, are HALF.
const std::vector<LayerInfo>& all_layers() {
    using Scale = LayerInfo::Scale;
    static const std::vector<LayerInfo> layers{
        {"color", red_green_blue, Scale::colors, "what the rays meet, linear RGB; the mean of the pixel's rays"},
        {"status", number_channel, Scale::linear, "how the pixel's first ray ended: 0 hit, 1 escaped, 2 captured, 3 step_limit, 4 failed"},
        {"steps", number_channel, Scale::linear, "integration steps taken; mean"},
        {"gradients", number_channel, Scale::linear, "evaluations of the derivatives of H; mean"},
        {"energy_error", number_channel, Scale::logarithmic, "greatest |H - H0| / (|p . dH/dp| + |H0|) along any of the pixel's rays"},
        {"position_error", number_channel, Scale::logarithmic,
         "estimated error of the ends of the pixel's rays, pixels, the greatest: against half the step, or another method; nan where that ends otherwise"},
        {"rounding_error", number_channel, Scale::logarithmic,
         "the most that rounding can have done to these ends, pixels, the greatest: the sum of |adjoint * ulp| by a reverse sweep along the ray"},
        {"newton", number_channel, Scale::linear, "iterations of implicit solves; mean"},
        {"occupancy", number_channel, Scale::linear, "share of active lanes over the steps of the packet that traced the first ray; packets change with --schedule and --crop"},
        {"depth", number_channel, Scale::linear, "straight distance from the first ray's start to its hit, scene units; 0 without a hit"},
        {"redshift", number_channel, Scale::linear,
         "frequency seen over frequency sent where the first ray hits a disk, or from rest at infinity where it escapes; else 0"},
        {"footprint", number_channel, Scale::logarithmic, "longest axis of the ellipse of sky that the pixel stands for, radians (a pixel's side, where rays are straight); 0 where its first ray does not escape, or is the only one of its 2x2 block that does"},
        {"magnification", number_channel, Scale::logarithmic, "solid angle of the pixel over that of the sky it shows; 0 where its first ray does not escape, or is the only one of its 2x2 block that does, and for the parallel rays of an orthographic camera, whose pixels have none"},
        {"object", number_channel, Scale::linear, "place in the scene file of the object that the first ray hits, counted from 1; 0 without a hit"},
    };
    return layers;
}

Film::Film(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& layers, const FilmPlace& place)
    : width_(width), height_(height), place_(place) {
    for (const std::string& name : layers) {
        if (has(name)) continue;
        const LayerInfo& layer = find_layer(name);
        layers_.push_back(&layer);
        // What was never traced is black, and has no number.
        const float nothing = layer.scale == LayerInfo::Scale::colors ? 0.0f : std::numeric_limits<float>::quiet_NaN();
        planes_.emplace_back(std::size_t{width} * height * layer.channels.size(), nothing);
    }
}

bool Film::has(const std::string& layer) const {
    return plane(layer) != nullptr;
}

const float* Film::plane(const std::string& layer) const {
    for (std::size_t i = 0; i < layers_.size(); ++i)
        if (layers_[i]->name == layer) return planes_[i].data();
    return nullptr;
}

float* Film::plane(const std::string& layer) {
    return const_cast<float*>(std::as_const(*this).plane(layer));
}

float* Film::pixel(const std::string& layer, std::uint32_t x, std::uint32_t y) {
    KAGERO_ASSERT(x < width_ && y < height_ && has(layer));
    return plane(layer) + (std::size_t{y} * width_ + x) * find_layer(layer).channels.size();
}

}  // namespace kagero
