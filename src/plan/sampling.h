/// The choice between tracing the rays of all pixels, and adaptive sampling.
#pragma once

#include "plan/run_config.h"

#include <string>

namespace kagero {

/// Returns the reason why the rays of all pixels of a picture are traced; empty if they are sampled adaptively.
std::string reason_for_full_sampling(const Scene& scene, const View& view, const RunConfig& run);

/// Returns the bound on the error of interpolated ray ends, in pixels. It is film.max_interpolation_error, but at most
/// half of a stated integrator.max_pixel_error. The other half of that bound is for the error of the method.
double interpolation_bound_of(const SceneDescription& scene);

/// Returns the bound on the error of the method, in pixels, that integrator.max_pixel_error states; 0: none is stated.
double method_bound_of(const SceneDescription& scene, const RunConfig& run);

}  // namespace kagero
