#include "stability/stability.h"

#include "error.h"
#include "scene/reader.h"
#include "stability/critical.h"
#include "stability/holes.h"
#include "stability/media.h"
#include "stability/numbers.h"
#include "stability/scenes.h"

#include <algorithm>

namespace kagero {

namespace {

/// A row of the table of cases.
struct Case {
    const char *name, *description, *expected;
    void (*function)(CaseRun&);
};

// Each row defines a case. `expected` applies to every precision and strategy unless it names a precision or strategy.
constexpr Case cases[] = {
    {"layer-refraction", "refraction and total reflection at an index layer tanh(z/d), d = 1e-1 … 1e-6",
     "each ray is transmitted or reflected as Snell's law predicts; direction within 1e-6 for d >= 1e-3 (double)",
     stability::layer_refraction},
    {"layer-momentum", "tangential momentum at the same layers", "constant within 8 ulp", stability::layer_momentum},
    {"lens-surface", "Luneburg lens, on whose surface the gradient of the index jumps",
     "each method keeps its order until rounding limits the error (double), or is refused; "
     "direction and parameter within 1e-5 (float)",
     stability::lens_surface},
    {"photon-sphere", "rays at the critical impact parameter b = b_c and just above it, from r = 10 rg",
     "at least 4 revolutions in double, 2 in float (Gauss methods only), then escaped or captured",
     stability::photon_sphere},
    {"near-critical", "rays with b/b_c = 1 -+ 1e-6, 1e-4, 1e-2",
     "captured below b_c, escaped above b_c (float: from 1e-4)", stability::near_critical},
    {"near-horizon", "static observer at r - rg = 1e-2, 1e-4, 1e-6 rg",
     "escaped at up to 0.9 of the angle of the escape cone, captured from 1.1; "
     "in float the camera may be refused, or a ray may fail with a reason",
     stability::near_horizon},
    {"inside", "observers at rg, inside the horizon, and at r = 0",
     "escaped or captured for a falling observer; failed for a static observer and at r = 0", stability::inside},
    {"captured-stay", "rays with b up to 0.98 b_c, 7 methods, steps that resolve the orbit", "captured",
     stability::captured_stay},
    {"wrong-time-momentum", "inward rays whose p_t has the wrong sign", "captured within 1000 steps",
     stability::wrong_time_momentum},
    {"unsolvable-step", "implicit steps of 1 … 1000 rg, whose equations may have no solution; b at least 6 % from b_c",
     "right status, or failed with a reason: at most three quarters of the rays with midpoint and verlet, "
     "none with s10, gauss8 and gauss16; H within 4 %",
     stability::unsolvable_step},
    {"coarse-steps",
     "steps of 200 times the default with 11 methods, and of 1000 radians in the orbit plane; b at least 6 % from b_c",
     "right status, or failed with a reason: at most one ray in eight, and only with verlet; "
     "without rescaling at most three quarters of the rays, and none with methods of order 8 or more",
     stability::coarse_steps},
    {"vanishing-index", "media whose index falls to zero", "escaped at the edge of the medium, turned back, or failed",
     stability::vanishing_index},
    {"long-path", "1e6 steps in a graded-index fibre and a fisheye",
     "mean H of the first and the last tenth agree within 1e-10 (double) or 1e-3 (float); "
     "the drift of rk4 is reported without a bound",
     stability::long_fiber},
    {"scaled-scene", "every space with a floor, scaled by 1e-30, 1e-7, 1e-3, 1e3, 1e7 and 1e10",
     "same status, directions within 1e-6 (float: 5e-3)", stability::scaled_scene},
    {"unusable-input", "directions of length zero, NaN and infinity; distant starts; degenerate rectangles",
     "failed at the start with a reason, or refused; outward rays from distant starts escaped",
     stability::unusable_input},
    {"denormals", "coordinates and directions below 1e-308 (float: 1e-38)",
     "same result as with zeros, to rounding; less than 20 times slower", stability::denormals},
    {"grazing",
     "straight rays at grazing incidence on a floor; oscillating rays in a fibre that just reach or just miss a wall",
     "every analytic hit is found, and no other hit", stability::grazing},
    {"trapped", "closed rays in a fisheye", "step_limit after exactly max_steps, identical in two runs",
     stability::trapped},
    {"throat", "Ellis wormhole, b/a = 1 -+ 1e-6 (float: 1e-4)", "passes through the throat below 1, turns back above 1",
     stability::throat},
    {"float-floor", "a picture in float against double at r = 50, steps 0.4 … 0.0125",
     "Gauss methods: error below 1e-3 at the shortest step; "
     "shorter steps do not increase the median, and increase the 99th percentile at most by a factor of 4",
     stability::float_floor},
    {"straight-picture", "spaces with rg = 0 and constant indices",
     "same picture as with straight rays, pixel by pixel", stability::straight_picture},
};

/// Runs a case in every precision with every strategy on one instruction set. All strategies must have the same
/// statuses of rays.
StabilityOutcome run_case(const Case& chosen, const StabilityRequest& request, const std::string& isa) {
    Findings findings;
    for (const Precision precision : request.precisions) {
        std::vector<Status> first_statuses;
        for (std::size_t i = 0; i < request.strategies.size(); ++i) {
            Options options;
            options.isa = isa;
            options.precision = precision;
            options.strategy = request.strategies[i];
            options.threads = request.threads;
            options.parameter = true;
            std::vector<Status> statuses;
            CaseRun run(options, findings, statuses);
            try {
                chosen.function(run);
            } catch (const std::exception& error) {
                run.expect(false, error.what());
            }
            if (i == 0) first_statuses = statuses;
            else
                run.expect(statuses == first_statuses,
                           std::string("statuses differ from those of strategy ") + name_of(request.strategies[0]));
        }
    }
    return {isa, findings.text(), findings.passed()};
}

}  // namespace

bool StabilityRow::pass() const {
    return !outcomes.empty() &&
           std::all_of(outcomes.begin(), outcomes.end(), [](const StabilityOutcome& outcome) { return outcome.pass; });
}

std::vector<std::string> stability_case_names() {
    std::vector<std::string> names;
    for (const Case& each : cases) names.push_back(each.name);
    return names;
}

void require_cases(const std::vector<std::string>& names) {
    const auto names_of_cases = stability_case_names();
    for (const std::string& name : names)
        if (std::find(names_of_cases.begin(), names_of_cases.end(), name) == names_of_cases.end())
            throw InputError("there is no stability case \"" + name + "\"" + suggestion(name, names_of_cases));
}

std::vector<StabilityRow> run_stability(const std::vector<std::string>& names, const StabilityRequest& request,
                                        const std::function<void(const StabilityRow&)>& done,
                                        const std::atomic<bool>* stop) {
    require_cases(names);
    std::vector<StabilityRow> rows;
    for (const Case& each : cases) {
        if (!names.empty() && std::find(names.begin(), names.end(), each.name) == names.end()) continue;
        if (stop && *stop) break;
        StabilityRow& row = rows.emplace_back(StabilityRow{each.name, each.description, each.expected, {}});
        for (const std::string& isa : request.isas) row.outcomes.push_back(run_case(each, request, isa));
        if (done) done(row);
    }
    return rows;
}

}  // namespace kagero
