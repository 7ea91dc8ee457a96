/// Reports of a finished run: the JSON of `render` and `trace`, and the attributes of the picture file.
#pragma once

#include "film/write_film.h"
#include "render/render.h"
#include "report/warnings.h"

#include <string>
#include <vector>

namespace kagero {

/// Returns the JSON of `render`. `energy_error` is null unless the run measured the error of H. `standard_error` is
/// written if `film`, which may be null, has this layer.
std::string render_json(const Plan& plan, const RunReport& report, const Film* film, double write_seconds,
                        std::vector<Warning> warnings);

/// Returns the JSON of `trace` from one or more timed runs of the same rays. Counts are those of the last run. `ends`
/// contains the ends of the rays; their integrals are written if the plan requests them.
std::string trace_json(const Plan& plan, const std::vector<RunReport>& runs, const std::vector<RayEnd>& ends,
                       const std::vector<Warning>& warnings);

/// Returns the counts of a run that a merged picture has too: rays, work, ends of rays, interpolation and the
/// error of H.
Json counts_json(const RunReport& report);

/// Returns the attributes of picture_metadata that do not depend on the rays.
Metadata plan_metadata(const Plan& plan);
/// Returns the other attributes, which follow those of the plan.
Metadata run_metadata(const RunReport& report);

/// Returns the `kagero/*` attributes of the picture file. They are equal for all runs with the same scene, options and
/// instruction set.
Metadata picture_metadata(const Plan& plan, const RunReport& report);

}  // namespace kagero
