/// The pictures that the example scenes use, each made from formulas and fixed seeds.
#pragma once

#include "picture.h"

namespace textures {

Picture galaxy_sky();
Picture milky_way();
Picture paving();
Picture clouds();

}  // namespace textures
