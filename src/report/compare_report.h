/// Reports of a comparison of vectorization strategies, as JSON and as a text table.
#pragma once

#include "study/compare/compare.h"

#include <string>

namespace kagero {

/// Returns the JSON of `compare`, with one object per row of the comparison.
std::string compare_json(const SceneDescription& scene, const CompareOptions& options, const Comparison& comparison);

/// Returns a table with aligned columns, a summary of the measurement, and the kernels that were left out with the
/// reasons.
std::string compare_text(const SceneDescription& scene, const CompareOptions& options, const Comparison& comparison);

}  // namespace kagero
