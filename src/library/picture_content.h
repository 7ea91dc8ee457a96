/// The content of Picture: the film of a run with its plan and report.
#pragma once

#include "film/film.h"
#include "plan/plan.h"
#include "render/run_report.h"

#include <kagero/picture.h>

namespace kagero {

struct Picture::Content {
    std::shared_ptr<const Plan> plan;
    Film film;
    RunReport report;
    RunChoices choices;
};

}  // namespace kagero
