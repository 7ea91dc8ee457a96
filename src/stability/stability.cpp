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

struct Case {
    const char *name, *what, *expected;
    void (*run)(Trial&);
};

// One row is one more case. `expected` is what must hold in every precision and strategy, unless it names one.
constexpr Case cases[] = {
    {"layer-refraction", "index layer tanh(z/d), d = 1e-1 … 1e-6: transmission and total reflection",
     "right class for every d; direction within 1e-6 for d >= 1e-3 (double)", stability::layer_refraction},
    {"layer-momentum", "the same layers: tangential momentum", "constant to 8 ulp", stability::layer_momentum},
    {"lens-surface", "the gradient jumps on the surface of a Luneburg lens",
     "steps end there, every method keeps its order to rounding or is refused (double); direction and parameter within 1e-5 (float)",
     stability::lens_surface},
    {"photon-sphere", "the critical ray, b = b_c, and one just above, from r = 10 rg",
     "4 windings in double, 2 in float (Gauss methods), then escaped or captured",
     stability::photon_sphere},
    {"near-critical", "b/b_c = 1 -+ 1e-6, 1e-4, 1e-2", "right class in double; in float from 1e-4", stability::near_critical},
    {"near-horizon", "static camera at r - rg = 1e-2, 1e-4, 1e-6 rg",
     "right class at 0.9 and 1.1 of the escape cone; float may refuse or fail with a reason instead", stability::near_horizon},
    {"inside", "observers at rg, inside, and at r = 0", "finite for a falling observer; no static one; r = 0 failed at its start",
     stability::inside},
    {"captured-stay", "rays with b up to 0.98 b_c, many methods and steps that resolve the orbit", "captured",
     stability::captured_stay},
    {"wrong-time-momentum", "p_t of the wrong sign, inward", "captured within 1000 steps", stability::wrong_time_momentum},
    {"unsolvable-step", "implicit steps of 1 … 1000 rg, too long to have a solution; b 6 % from b_c and more",
     "halved, or the ray fails with a reason, of a fan three quarters at most by midpoint and verlet, none by s10, gauss8 and gauss16; no wrong class, H within 4 %", stability::unsolvable_step},
    {"coarse-steps", "steps 200 times the default, 11 methods, and 1000 radians in the orbit plane; b 6 % from b_c and more", "right class; by verlet a ray of eight may fail with a reason; without rescaling up to three quarters, none by those of order 8 and more",
     stability::coarse_steps},
    {"vanishing-index", "n -> 0 and below", "escaped where the medium ends, turned back, or failed", stability::vanishing_index},
    {"long-path", "1e6 steps in a graded fibre and a fisheye",
     "H flat between first and last tenth: 1e-10 in double, 1e-3 in float; drift of rk4 told", stability::long_fiber},
    {"scaled-scene", "every space before a floor, 1e-30, 1e-7, 1e-3, 1e3, 1e7 and 1e10 times as large", "same classes, directions within 1e-6 (float 5e-3)",
     stability::scaled_scene},
    {"unusable-input", "directions of length zero, NaN, infinity; far starts; degenerate surfaces",
     "failed at the start with a reason, or refused; far outward starts escaped", stability::unusable_input},
    {"denormals", "coordinates and directions below 1e-308 (float: 1e-38)",
     "as with zeros there, to rounding; not 20 times slower", stability::denormals},
    {"grazing", "straight rays along a floor; rays that swing in a fibre to a wall, or almost", "every analytic hit found, no other", stability::grazing},
    {"trapped", "closed rays in a fisheye", "step_limit after exactly max_steps, twice the same", stability::trapped},
    {"throat", "Ellis wormhole, b/a = 1 -+ 1e-6 (float: 1e-4)", "through below, back above", stability::throat},
    {"float-floor", "a picture in float against double at r = 50, steps 0.4 … 0.0125",
     "floor below 1e-3; more steps make Gauss methods no worse (median; 99 %: by luck, a factor of 4)", stability::float_floor},
    {"straight-picture", "rg = 0 and constant indices", "the straight-ray picture, pixel by pixel", stability::straight_picture},
};

StabilityOutcome run_case(const Case& chosen, const StabilityRequest& request, const std::string& isa) {
    Findings findings;
    for (const Precision precision : request.precisions) {
        std::vector<Status> first;
        for (std::size_t i = 0; i < request.strategies.size(); ++i) {
            Options options;
            options.isa = isa, options.precision = precision, options.strategy = request.strategies[i];
            options.threads = request.threads, options.parameter = true;
            std::vector<Status> statuses;
            Trial trial(options, findings, statuses);
            try {
                chosen.run(trial);
            } catch (const std::exception& error) {
                trial.expect(false, error.what());
            }
            if (i == 0)
                first = statuses;
            else
                trial.expect(statuses == first,
                             std::string("rays end otherwise than with ") + name_of(request.strategies[0]));
        }
    }
    return {isa, findings.text(), findings.holds()};
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
    const auto known = stability_case_names();
    for (const std::string& name : names)
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw InputError("there is no case \"" + name + "\"" + suggestion(name, known));
}

std::vector<StabilityRow> run_stability(const std::vector<std::string>& names, const StabilityRequest& request,
                                        const std::function<void(const StabilityRow&)>& done,
                                        const std::atomic<bool>* stop) {
    require_cases(names);
    std::vector<StabilityRow> rows;
    for (const Case& each : cases) {
        if (!names.empty() && std::find(names.begin(), names.end(), each.name) == names.end()) continue;
        if (stop && *stop) break;
        StabilityRow& row = rows.emplace_back(StabilityRow{each.name, each.what, each.expected, {}});
        for (const std::string& isa : request.isas) row.outcomes.push_back(run_case(each, request, isa));
        if (done) done(row);
    }
    return rows;
}

}  // namespace kagero
