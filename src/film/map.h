/// Layers in false colours, for people to look at.
#pragma once

#include "film/film.h"

namespace kagero {

/// The file that the map of a layer goes to: PICTURE-LAYER.png beside the picture.
std::string map_path(const std::string& picture, const LayerInfo& layer);

/// Writes a layer of one channel, dark to bright, with the scale beside it: from zero, or from the least positive value
/// where the layer's scale is logarithmic, to the greatest. Pixels without a value are grey. Throws RunError.
void write_map(const Film& film, const LayerInfo& layer, const std::string& path);

}  // namespace kagero
