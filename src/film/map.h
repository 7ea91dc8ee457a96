/// Maps: pictures of single layers in false colours.
#pragma once

#include "film/film.h"

namespace kagero {

/// Returns the path of the map of a layer: PICTURE-LAYER.png beside the picture.
std::string map_path(const std::string& picture, const LayerInfo& layer);

/// A layer of numbers in false colours: three bytes per pixel, and the values at the ends of the scale.
struct FalseColors {
    std::vector<unsigned char> rgb;
    double least, greatest;
};
/// Returns the false colours of `count` numbers of a layer, with the scale of write_map.
FalseColors false_colors_of(const float* numbers, std::size_t count, const LayerInfo& layer);

/// Writes the map of a layer with one channel, with false colours from dark to bright and a colour bar at the right. A
/// linear scale extends from zero to the greatest value. A logarithmic scale extends from the least positive value to
/// the greatest value. Pixels whose value is not on the scale, such as NaN, are grey. Throws RunError if the file
/// cannot be written.
void write_map(const Film& film, const LayerInfo& layer, const std::string& path);

}  // namespace kagero
