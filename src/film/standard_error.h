/// Summary of the standard errors of a picture.
#pragma once

#include "film/film.h"

#include <kagero/picture.h>

namespace kagero {

/// Returns the summary of the layer `standard_error` of a film; all members are NaN if the film does not have the
/// layer, or if no error is known, as with one ray per pixel.
StandardError summarize_standard_error(const Film& film);

}  // namespace kagero
