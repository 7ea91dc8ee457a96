/// Textures of the example scenes. Each is computed from formulas and fixed seeds.
#pragma once

#include "picture.h"

namespace textures {

/// Returns a dark sky with a spiral galaxy at +x, 2048 x 1024 pixels, equirectangular.
Picture galaxy_sky();
/// Returns a sky with the Milky Way along the equator, 2048 x 1024 pixels, equirectangular.
Picture milky_way();
/// Returns stone paving seen from above, 1024 x 1024 pixels, periodic in both directions.
Picture paving();
/// Returns a cloudy sky for a horizontal plane, 1024 x 512 pixels, periodic from top to bottom.
Picture clouds();

}  // namespace textures
