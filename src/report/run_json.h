/// What a run says of itself: JSON for programs, attributes for the picture.
#pragma once

#include "film/write_film.h"
#include "render/render.h"

#include <string>
#include <vector>

namespace kagero {

/// The JSON of `render`; `energy_error` is null unless the plan watched it.
std::string render_json(const Plan& plan, const RunReport& report, double write_seconds);

/// The JSON of `trace`, from one or more timed runs of the same rays.
std::string trace_json(const Plan& plan, const std::vector<RunReport>& runs);

/// Attributes of the picture. They hold nothing that differs between two runs of the same scene, options and
/// instruction set.
Metadata picture_metadata(const Plan& plan, const RunReport& report);

}  // namespace kagero
