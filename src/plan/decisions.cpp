#include "plan/decisions.h"

#include "error.h"
#include "film/film.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero {
namespace {

/// Collects decisions; `why_not` is read where one is not taken.
struct Parts {
    std::vector<Decision> all{};

    void add(bool taken, const std::string& what, const std::string& why_not) { all.push_back({what, taken, why_not}); }
    void always(const std::string& what) { all.push_back({what, true, {}}); }
};

/// The properties of the space, built in or as a formula.
HamiltonianInfo space_of(const Scene& scene) {
    HamiltonianInfo info = scene.space.info();
    if (const auto& formula = scene.description.space.formula) {
        info.bounded = !formula->domain.empty(), info.captures = !formula->capture.empty();
        info.bounds_steps = !formula->length_scale.empty(), info.rescales = formula->parsed.rescale >= 0;
    }
    if (!scene.programs.empty()) info.rescales = true, std::fill_n(info.cyclic, 3, false);
    return info;
}

/// The first method in the plane of an orbit that serves the space; null where none does.
const char* orbit_method_served(const Scene& scene) {
    for (std::uint32_t i = 0; i < scene.module().integrator_count; ++i)
        if (scene.module().integrators[i].angular && !refusal_of(scene, i, false))
            return scene.module().integrators[i].name;
    return nullptr;
}

/// Whether what is integrated is |p|²/2 + V(q): Nyström methods take nothing else.
bool is_separable(const Scene& scene, const RunConfig& run) {
    for (std::uint32_t i = 0; i < scene.module().integrator_count; ++i)
        if (scene.module().integrators[i].drifts) return !refusal_of(scene, i, run.method.rescaled);
    return false;
}

std::string why_no_orbit(const Scene& scene, const HamiltonianInfo& space, bool tuned) {
    if (scene.straight) return "these parameters leave every ray straight";
    if (const char* method = orbit_method_served(scene); method && !space.orbit_method)
        return std::string("the space does not take it unasked: integrator.method = \"") + method + "\" does";
    if (!space.orbit_method) return "the space declares no potential of it";
    if (!scene.description.integrator.use_symmetry) return "integrator.symmetry = \"none\"";
    if (tuned) return "the pilot found the general path to be cheaper";
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
std::string why_not_cyclic(const Scene& scene, const RunConfig& run, const HamiltonianInfo& space) {
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    if (scene.straight) return "these parameters leave every ray straight";
    if (!scene.programs.empty()) return "integrator.rescale is an expression";
    if (cyclic_coordinates(space).empty()) return "every coordinate occurs in H";
    if (!run.use_symmetry) return "integrator.symmetry = \"none\"";
    if (!method.drifts) return std::string(method.name) + " takes all coordinates together";
    return "";
}

std::string why_not_rescaled(const Scene& scene, const RunConfig& run, const HamiltonianInfo& space) {
    if (scene.straight) return "rays are straight";
    if (!space.rescales) return "the space declares none";
    if (scene.description.integrator.rescale == "none") return "integrator.rescale = \"none\"";
    return std::string(scene.module().integrators[run.method.integrator].name) +
           " does not serve the rescaled Hamiltonian";
}

/// The variables of the formula, and the momenta that are therefore conserved.
void formula_decisions(const Scene& scene, const RunConfig& run, Parts& parts) {
    const FormulaDescription& formula = *scene.description.space.formula;
    const auto variables_of = [&](std::int32_t node) {
        return node < 0 ? 0 : formula.scope.variables[static_cast<std::size_t>(node)];
    };
    const int occurring = variables_of(formula.parsed.energy), rescaling = variables_of(formula.parsed.rescale);
    const auto occurs = [&](std::size_t i) { return (occurring >> i & 1) != 0; };
    std::string variables;
    for (std::size_t i = 0; i < formula_variables.size(); ++i)
        if (occurs(i)) enumerate(variables, formula_variables[i]);
    parts.always("H of " + variables + (is_separable(scene, run) ? "; what is integrated is |p|\u00b2/2 + V(q)" : ""));
    for (std::size_t i = 0; i < 3; ++i)
        if (!occurs(i) && !(rescaling >> i & 1))
            parts.add(false, std::string("the equation of motion of ") + formula_variables[i + 3],
                      std::string(formula_variables[i]) + " does not occur in H: " + formula_variables[i + 3] +
                          " is a constant of the motion");
}

std::vector<Decision> end_decisions(const Scene& scene, const RunConfig& run) {
    const HamiltonianInfo space = space_of(scene);
    const Geometry* geometry = scene.geometry->kernel_view();
    Parts parts;
    const std::string nothing = "the scene has no objects";
    parts.add(space.bounded, "test for the edge of the medium", "the medium has no edge");
    parts.add(space.captures && !scene.straight, "test for capture",
              space.captures ? "rays are straight" : "nothing captures rays");
    parts.add(geometry,
              "Embree scene of " + std::to_string(geometry ? geometry->surface_count : 0) +
                  (geometry && geometry->surface_count == 1 ? " surface" : " surfaces"),
              nothing + ": no Embree device");
    parts.add(geometry && geometry->clearance, "clearance grid: steps far from every surface ask Embree nothing",
              !geometry        ? nothing
              : scene.straight ? "rays are straight: each asks once"
                               : "integrator.cull = \"none\"");
    parts.add(run.hit == HitModel::hermite && !scene.straight,
              "ends delivered by partial steps, in the order of the method",
              scene.straight ? "rays are straight: they end in closed form" : "integrator.hit = \"chord\"");
    parts.add(run.refill == Refill::on, "new rays into lanes whose own have ended",
              run.refill == Refill::off ? "integrator.refill = \"off\""
                                        : "rays of neighbouring pixels end together; `trace` does it where a few "
                                          "packets of its rays say that it pays");
    parts.add(scene.straight && geometry, "one query for the whole way of a ray",
              geometry ? "rays are bent: each step is a segment" : nothing);
    return std::move(parts.all);
}

std::vector<Decision> picture_decisions(const Scene& scene, const View& view) {
    Parts parts;
    const FilmDescription& film = scene.description.film;
    const bool kernel_rays = kernel_makes_rays(scene, view);
    parts.add(kernel_rays, "camera rays made in the kernel, a packet at a time",
              film.spp > 1          ? "film.spp > 1"
              : view.each_direction ? "every direction's momentum is solved for"
                                    : "the camera is " + name_of(scene.description.camera.type));
    parts.add(film.spp > 1, "scrambled Sobol places in the pixel", "film.spp = 1: the pixel's middle");
    parts.add(scene.paints->sky_has_pattern(), "footprints of pixels on the sky",
              "the sky is neither an image nor checkered");
    parts.add(scene.paints->surfaces_have_patterns(), "patches of surfaces that pixels show",
              "no object has an image or a checker");
    for (const LayerInfo& layer : all_layers()) {
        const bool wanted = std::find(film.layers.begin(), film.layers.end(), layer.name) != film.layers.end();
        parts.add(wanted, std::string("layer ") + layer.name, "not in film.layers");
    }
    parts.add(false, "the parameter along rays", "no layer asks for it");
    parts.add(scene.unit != 1, "lengths in units of " + plain_number(scene.unit),
              scene.description.space.formula || !scene.programs.empty() ? "a formula has the unit it was written in"
                                                                         : "the scene is of ordinary size");
    return std::move(parts.all);
}

}  // namespace

std::string plain_number(double x) {
    std::ostringstream out;
    out << x;
    return out.str();
}

std::vector<Decision> motion_decisions(const Scene& scene, const RunConfig& run, bool tuned) {
    const HamiltonianInfo space = space_of(scene);
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    const bool bent = !scene.straight;
    const std::string straight = "these parameters leave every ray straight";
    Parts parts;
    parts.add(bent,
              std::string("integration by ") + method.name +
                  (method.adaptive ? ", tolerance " + plain_number(run.tolerance)
                                   : ", step " + plain_number(stated_step(scene, run))),
              straight);
    parts.add(bent, "derivatives of H by reverse automatic differentiation, one-sided where the method needs one side",
              straight);
    parts.add(false, "the equation of motion of p_t", "p_t is a constant of the motion: H does not depend on time");
    parts.add(bent && method.angular, "the plane of the orbit: of six variables two are left, and the angle",
              why_no_orbit(scene, space, tuned));
    const std::string why_all = why_not_cyclic(scene, run, space);
    if (!scene.description.space.formula)
        parts.add(why_all.empty(),
                  why_all.empty()
                      ? "stratified space: along " + cyclic_coordinates(space) + " straight to every step's end"
                      : "stratified space: coordinates that do not occur in H",
                  why_all);
    parts.add(run.method.rescaled, "time transformation K = \u03a9 (H \u2212 H0)", why_not_rescaled(scene, run, space));
    if (scene.description.space.formula) formula_decisions(scene, run, parts);
    else if (scene.programs.empty()) parts.add(false, "an interpreter of H", "H and its rescaling are compiled");
    else parts.always("an interpreter: H times " + scene.description.integrator.rescale + " is compiled for no space");
    const bool implicit = bent && method.implicit && (method.collocates || !is_separable(scene, run));
    parts.add(implicit,
              std::string("implicit equations: ") +
                  (method.family == Family::recipe ? "Newton's method" : "fixed-point iteration") + ", lane by lane",
              !bent             ? straight
              : method.implicit ? "what is integrated is |p|\u00b2/2 + V(q): its steps are explicit"
                                : "the method is explicit");
    parts.add(bent && method.adaptive, "step control, lane by lane", bent ? "steps have a fixed length" : straight);
    const bool leaps = bent && method.adaptive && std::isfinite(run.longest_share);
    if (leaps)
        parts.always(
            "bound on the step: a quarter of |q|, for the space states no length_scale, and long steps miss what is "
            "small");
    else
        parts.add(bent && space.bounds_steps && !method.angular, "bound on the step from the space's length scale",
                  !bent            ? straight
                  : method.angular ? "in the plane of the orbit steps have no length"
                                   : "the space declares none");
    parts.add(bent && space.discontinuous, "steps split where H is not smooth",
              !bent                             ? straight
              : scene.description.space.formula ? "a formula states no surface where its slope jumps"
                                                : "H is smooth");
    parts.add(bent && std::isfinite(job_of(scene, {}, run).bends_within),
              "where rays are straight, one step goes all the way",
              bent ? "the space knows of no such part" : straight);
    parts.add(bent, "energy test: a step that loses H is halved", straight);
    return std::move(parts.all);
}

Decisions decisions_of(const Scene& scene, const View& view, const RunConfig& run) {
    return {{}, motion_decisions(scene, run, false), end_decisions(scene, run), picture_decisions(scene, view)};
}

}  // namespace kagero
