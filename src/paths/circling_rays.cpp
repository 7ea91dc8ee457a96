#include "paths/circling_rays.h"

#include <cmath>

namespace kagero {

void retrace_circling_rays(const Plan& plan, const Job& job, const RayStart* first, std::vector<RayEnd>& ends,
                           Counters& counters) {
    if (!plan.circling_run || std::isfinite(job.parameter_limit) || job.path_sink) return;
    RayList list;
    std::vector<std::size_t> retraced;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (ends[i].status != Status::step_limit) continue;
        retraced.push_back(i);
        list.starts.push_back(first[i]);
    }
    if (retraced.empty()) return;
    Job circling = job_of(*plan.scene, plan.view, *plan.circling_run);
    circling.outputs = job.outputs;
    circling.timed = job.timed;
    circling.cancelled = job.cancelled;
    circling.cancel_user = job.cancel_user;
    std::vector<RayEnd> again;
    trace_tile(*plan.circling_run->kernel, circling, {}, list, again, counters);
    for (std::size_t k = 0; k < retraced.size(); ++k) {
        RayEnd& end = ends[retraced[k]];
        const RayEnd& second = again[k];
        const bool is_followed = second.status != Status::step_limit && second.status != Status::failed;
        --counters.ended[static_cast<std::size_t>(is_followed ? end.status : second.status)];
        const RayEnd first_try = end;
        if (is_followed) end = second;
        end.steps = first_try.steps + second.steps;
        end.gradients = first_try.gradients + second.gradients;
        end.queries = first_try.queries + second.queries;
    }
}

}  // namespace kagero
