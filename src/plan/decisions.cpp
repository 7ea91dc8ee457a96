#include "plan/decisions.h"

#include "error.h"
#include "film/film.h"
#include "formula/formula.h"
#include "rays/camera.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero {
namespace {

/// Sorts the parts of a run into those that take place and those that do not.
class Parts {
public:
    explicit Parts(Explanation& text) : text_(text) {}

    /// `why_not` is read where the part is left out.
    void add(bool used, const std::string& what, const std::string& why_not) {
        if (used) text_.used.push_back(what);
        else text_.left_out.push_back({what, why_not});
    }
    void always(const std::string& what) { text_.used.push_back(what); }

private:
    Explanation& text_;
};

std::string plain_number(double x) {
    std::ostringstream out;
    out << x;
    return out.str();
}

/// What the space states, built in or as a formula.
HamiltonianInfo space_of(const Plan& plan) {
    HamiltonianInfo info = plan.module->hamiltonians[plan.hamiltonian];
    if (const auto& formula = plan.scene.space.formula) {
        info.bounded = !formula->domain.empty(), info.captures = !formula->capture.empty();
        info.scaled = !formula->length_scale.empty(), info.rescales = formula->parsed.rescale >= 0;
    }
    if (!plan.programs.empty()) info.rescales = true, std::fill_n(info.cyclic, 3, false);
    return info;
}

/// The first method in the plane of an orbit that serves the space; null where none does.
const char* orbit_method_served(const Plan& plan) {
    for (std::uint32_t i = 0; i < plan.module->integrator_count; ++i)
        if (plan.module->integrators[i].angular && !refusal_of(plan, i, false)) return plan.module->integrators[i].name;
    return nullptr;
}

/// Whether what is integrated is |p|²/2 + V(q): Nyström methods take nothing else.
bool is_separable(const Plan& plan) {
    for (std::uint32_t i = 0; i < plan.module->integrator_count; ++i)
        if (plan.module->integrators[i].drifts) return !refusal_of(plan, i, plan.job.rescaled);
    return false;
}

std::string why_no_orbit(const Plan& plan, const HamiltonianInfo& space) {
    if (plan.straight) return "these parameters leave every ray straight";
    if (const char* method = orbit_method_served(plan); method && !space.orbit_method)
        return std::string("the space does not take it unasked: integrator.method = \"") + method + "\" does";
    if (!space.orbit_method) return "the space declares no potential of it";
    if (plan.scene.integrator.symmetry == "none") return "integrator.symmetry = \"none\"";
    if (plan.pilot && plan.pilot->met) return "the pilot found the general path to be cheaper";
    return "the scene states a method for the general path, or a step, a tolerance or a rescaling";
}

/// "x, y", of the coordinates that do not occur in what is integrated.
std::string cyclic_coordinates(const HamiltonianInfo& space) {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i)
        if (space.cyclic[i]) enumerate(text, formula_variables[i]);
    return text;
}

/// Whether they are left out of every step until its end.
std::string why_not_cyclic(const Plan& plan, const HamiltonianInfo& space) {
    if (plan.straight) return "these parameters leave every ray straight";
    if (!plan.programs.empty()) return "integrator.rescale is an expression";
    if (cyclic_coordinates(space).empty()) return "every coordinate occurs in H";
    if (!plan.job.use_symmetry) return "integrator.symmetry = \"none\"";
    if (!plan.module->integrators[plan.job.integrator].drifts) return plan.scene.integrator.method + " takes all coordinates together";
    return "";
}

std::string why_not_rescaled(const Plan& plan, const HamiltonianInfo& space) {
    if (plan.straight) return "rays are straight";
    if (!space.rescales) return "the space declares none";
    if (plan.scene.integrator.rescale == "none") return "integrator.rescale = \"none\"";
    return plan.scene.integrator.method + " does not serve the rescaled Hamiltonian";
}

/// What the expression says of itself: which variables it has, and so what is conserved.
void explain_formula(const Plan& plan, Parts& parts) {
    const FormulaDescription& formula = *plan.scene.space.formula;
    const auto variables_of = [&](std::int32_t node) { return node < 0 ? 0 : formula.scope.variables[static_cast<std::size_t>(node)]; };
    const int occurring = variables_of(formula.parsed.energy), rescaling = variables_of(formula.parsed.rescale);
    const auto occurs = [&](std::size_t i) { return (occurring >> i & 1) != 0; };
    std::string variables;
    for (std::size_t i = 0; i < formula_variables.size(); ++i)
        if (occurs(i)) enumerate(variables, formula_variables[i]);
    parts.always("H of " + variables + (is_separable(plan) ? "; what is integrated is |p|\u00b2/2 + V(q)" : ""));
    for (std::size_t i = 0; i < 3; ++i)
        if (!occurs(i) && !(rescaling >> i & 1))
            parts.add(false, std::string("the equation of motion of ") + formula_variables[i + 3],
                      std::string(formula_variables[i]) + " does not occur in H: " + formula_variables[i + 3] + " is a constant of the motion");
}

void explain_motion(const Plan& plan, const HamiltonianInfo& space, Parts& parts) {
    const IntegratorDescription& chosen = plan.scene.integrator;
    const IntegratorInfo& method = plan.module->integrators[plan.job.integrator];
    const bool bent = !plan.straight;
    const std::string straight = "these parameters leave every ray straight";
    if (const auto& pilot = plan.pilot)
        parts.add(pilot->met, pilot->met ? "a pilot of " + std::to_string(pilot->rays) + " rays: 99 % of them within " + plain_number(pilot->estimate) +
                                               " pixels, of " + plain_number(pilot->bound) + " allowed"
                                         : std::string("what a pilot chose"), "no way to keep within " + plain_number(pilot->bound) + " pixels was seen: " + pilot->why_not);
    else
        parts.add(false, "a pilot that chooses method, step and precision", "the scene states them, or takes the space's (integrator.max_pixel_error)");
    if (const auto& trial = plan.float_trial) {
        const bool taken = trial->why_not.empty();
        parts.add(taken, taken ? "float: 99 % of " + std::to_string(trial->rays) + " rays ended within " + plain_number(trial->apart) +
                                     " pixels of where double ends them" : "float", trial->why_not);
    }
    parts.add(bent, "integration by " + chosen.method + (method.adaptive ? ", tolerance " + plain_number(chosen.tolerance)
                                                                         : ", step " + plain_number(chosen.step)), straight);
    parts.add(bent, "derivatives of H by reverse automatic differentiation, one-sided where the method needs one side", straight);
    parts.add(false, "the equation of motion of p_t", "p_t is a constant of the motion: H does not depend on time");
    parts.add(bent && method.angular, "the plane of the orbit: of six variables two are left, and the angle", why_no_orbit(plan, space));
    const std::string why_all = why_not_cyclic(plan, space);
    if (!plan.scene.space.formula)
        parts.add(why_all.empty(), why_all.empty() ? "stratified space: along " + cyclic_coordinates(space) + " straight to every step's end"
                                                   : "stratified space: coordinates that do not occur in H", why_all);
    parts.add(plan.job.rescaled, "time transformation K = \u03a9 (H \u2212 H0)", why_not_rescaled(plan, space));
    if (plan.scene.space.formula) explain_formula(plan, parts);
    else if (plan.programs.empty()) parts.add(false, "an interpreter of H", "H and its rescaling are compiled");
    else parts.always("an interpreter: H times " + plan.scene.integrator.rescale + " is compiled for no space");
    const bool implicit = bent && method.implicit && (method.collocates || !is_separable(plan));
    parts.add(implicit, std::string("implicit equations: ") + (method.family == Family::recipe ? "Newton's method" : "fixed-point iteration") + ", lane by lane", !bent ? straight
              : method.implicit ? "what is integrated is |p|\u00b2/2 + V(q): its steps are explicit" : "the method is explicit");
    parts.add(bent && method.adaptive, "step control, lane by lane", bent ? "steps have a fixed length" : straight);
    const bool leaps = bent && method.adaptive && std::isfinite(plan.job.longest_share);
    if (leaps) parts.always("bound on the step: a quarter of |q|, for the space states no length_scale, and long steps miss what is small");
    else parts.add(bent && space.scaled && !method.angular, "bound on the step from the space's length scale",
                   !bent ? straight : method.angular ? "in the plane of the orbit steps have no length" : "the space declares none");
    parts.add(bent && space.creased, "steps split where H is not smooth", !bent ? straight : plan.scene.space.formula ? "a formula states no surface where its slope jumps" : "H is smooth");
    parts.add(bent && std::isfinite(plan.job.bends_within), "where rays are straight, one step goes all the way",
              bent ? "the space knows of no such part" : straight);
    parts.add(bent, "energy test: a step that loses H is halved", straight);
}

void explain_ends(const Plan& plan, const HamiltonianInfo& space, Parts& parts) {
    const Geometry* geometry = plan.job.geometry;
    const std::string nothing = "the scene has no objects";
    parts.add(space.bounded, "test for the edge of the medium", "the medium has no edge");
    parts.add(space.captures && !plan.straight, "test for capture", space.captures ? "rays are straight" : "nothing captures rays");
    parts.add(geometry, "Embree scene of " + std::to_string(geometry ? geometry->surface_count : 0) + (geometry && geometry->surface_count == 1 ? " surface" : " surfaces"), nothing + ": no Embree device");
    parts.add(geometry && geometry->clearance, "clearance grid: steps far from every surface ask Embree nothing",
              !geometry ? nothing : plan.straight ? "rays are straight: each asks once" : "integrator.cull = \"none\"");
    parts.add(plan.job.hit == HitModel::hermite && !plan.straight, "ends delivered by partial steps, in the order of the method",
              plan.straight ? "rays are straight: they end in closed form" : "integrator.hit = \"chord\"");
    parts.add(plan.job.refill, "new rays into lanes whose own have ended",
              plan.scene.integrator.refill == "off" ? "integrator.refill = \"off\""
                                                    : "rays of neighbouring pixels end together; `trace` does it where a few packets of its rays say that it pays");
    parts.add(plan.straight && geometry, "one query for the whole way of a ray", geometry ? "rays are bent: each step is a segment" : nothing);
}

void explain_picture(const Plan& plan, Parts& parts) {
    const FilmDescription& film = plan.scene.film;
    const bool kernel_rays = kernel_makes_rays(plan);
    parts.add(kernel_rays, "camera rays made in the kernel, a packet at a time",
              film.spp > 1 ? "film.spp > 1" : plan.each_direction ? "every direction's momentum is solved for" : "the camera is " + plan.scene.camera.type);
    parts.add(film.spp > 1, "scrambled Sobol places in the pixel", "film.spp = 1: the pixel's middle");
    parts.add(plan.geometry->sky_has_pattern(), "footprints of pixels on the sky", "the sky is neither an image nor checkered");
    parts.add(plan.geometry->surfaces_have_patterns(), "patches of surfaces that pixels show", "no object has an image or a checker");
    for (const LayerInfo& layer : all_layers()) {
        const bool wanted = std::find(film.layers.begin(), film.layers.end(), layer.name) != film.layers.end();
        parts.add(wanted, std::string("layer ") + layer.name, "not in film.layers");
    }
    parts.add(false, "the parameter along rays", "no layer asks for it");
    parts.add(plan.unit != 1, "lengths in units of " + plain_number(plan.unit),
              plan.scene.space.formula || !plan.programs.empty() ? "a formula has the unit it was written in" : "the scene is of ordinary size");
}

}  // namespace

Explanation explain(const Plan& plan) {
    Explanation text;
    const HamiltonianInfo space = space_of(plan);
    text.kernel = std::string(space.name) + (plan.job.rescaled ? " (rescaled)" : "") + ", " +
                  (plan.straight ? "straight" : plan.scene.integrator.method) + ", compiler " + plan.module->compiler;
    Parts parts(text);
    explain_motion(plan, space, parts);
    explain_ends(plan, space, parts);
    explain_picture(plan, parts);
    return text;
}

}  // namespace kagero
