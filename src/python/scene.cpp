#include "python/scene.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "film/png.h"
#include "library/choices.h"
#include "library/ray_arrays.h"
#include "library/scene_plans.h"
#include "library/sweep.h"
#include "plan/names.h"
#include "python/arrays.h"
#include "python/columns.h"
#include "python/work.h"
#include "report/error/error_json.h"
#include "report/explanation.h"
#include "report/run_json.h"
#include "scene/print.h"

#include <pybind11/stl.h>

namespace py = pybind11;

namespace kagero {
namespace {

using SharedScene = std::shared_ptr<ScenePlans>;
using Texts = std::vector<std::string>;

std::shared_ptr<ScenePlans> load_scene_plans(const std::string& path, const std::optional<std::string>& text,
                                             const Texts& overrides) {
    const py::gil_scoped_release release;
    return std::make_shared<ScenePlans>(SceneSource{path, overrides, text});
}

RunOptions run_options(const std::string& isa, const std::string& strategy, const std::string& precision,
                       unsigned threads) {
    RunOptions options;
    options.isa = isa;
    options.strategy = strategy;
    options.precision = precision;
    options.threads = threads;
    return options;
}

void append_texts(Texts& texts, const std::vector<Warning>& warnings) {
    for (const Warning& warning : warnings) texts.push_back(warning.text);
}

/// Returns the results that all runs have, for the constructor of a result of kagero/_results.py.
py::dict run_facts(const Plan& plan, const RunReport& report, const std::vector<Warning>& warnings) {
    Texts texts = plan.remarks;
    append_texts(texts, warnings);
    py::dict facts;
    facts["interrupted"] = report.interrupted;
    facts["seconds"] = report.seconds;
    facts["warnings"] = texts;
    return facts;
}

/// Moves the layers of a film to arrays of the shape (height, width) or (height, width, channels).
py::dict arrays_of(Film& film) {
    py::dict arrays;
    for (const LayerInfo* layer : film.layers()) {
        std::vector<py::ssize_t> shape{film.height(), film.width()};
        if (layer->channels.size() > 1) shape.push_back(py::ssize_t(layer->channels.size()));
        arrays[py::str(layer->name)] = owning_array(film.take_plane(layer->name), shape);
    }
    return arrays;
}

/// A rendered picture with its warnings.
struct Rendering : RenderedPicture {
    std::vector<Warning> warnings;
};

Rendering rendering_of(const ScenePlans& scene, const RunOptions& options, const Texts& layers,
                       const RunControl& control) {
    Rendering rendering{scene.render(options, layers, control), {}};
    rendering.warnings = warnings_of(*rendering.plan, rendering.report, "and are black");
    return rendering;
}

/// Renders the scene. Returns the layers and the facts of the run, with the JSON of `kagero render --json`.
py::tuple render_scene_plans(const SharedScene& scene, const Texts& layers, const RunOptions& options,
                             const py::object& progress) {
    Rendering done;
    run_with_signals(progress,
                     [&](const RunControl& control) { done = rendering_of(*scene, options, layers, control); });
    std::vector<Warning> warnings = warnings_of_trial(*done.plan);
    warnings.insert(warnings.end(), done.warnings.begin(), done.warnings.end());
    py::dict facts = run_facts(*done.plan, done.report, warnings);
    facts["json"] = render_json(*done.plan, done.report, &*done.film, 0, done.warnings);
    return py::make_tuple(arrays_of(*done.film), facts);
}

/// The ends of rays with their plan.
struct Tracing {
    std::shared_ptr<const Plan> plan;
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
    std::vector<PathPoint> points;
    RunReport report;
};

std::optional<ObserverKind> observer_of(const RayRequest& request) {
    if (request.observer.empty()) return std::nullopt;
    return observer_named(request.observer);
}

RayRequest ray_request(const std::string& observer, const std::optional<std::uint32_t>& bounces,
                       const std::optional<double>& parameter, double every) {
    RayRequest request;
    request.observer = observer;
    request.bounces = bounces;
    request.parameter = parameter;
    request.every = every;
    return request;
}

/// Traces rays to their ends. Returns the columns and the facts of the run.
py::tuple trace_scene_plans(const SharedScene& scene, const py::array& positions, const py::array& directions,
                            RayRequest request, const Texts& chosen, const RunOptions& options,
                            const py::object& progress) {
    const Texts names = choose_columns_of_ends(chosen, request);
    const RayArrays rays = ray_arrays(positions, directions);
    const bool needs_paths = request.bounces.value_or(0) > 0;
    std::shared_ptr<const Plan> plan;
    RunReport report;
    EndArrays arrays(rays.count, names);
    run_with_signals(progress, [&](const RunControl& control) {
        check_finite(rays);
        plan = scene->rays(options, request);
        const auto write = [&](const auto& ends, const auto& paths, std::size_t first) {
            arrays.write(*plan, ends, paths, first);
        };
        report = trace_arrays(*plan, rays, observer_of(request), needs_paths, control, write);
    });
    py::dict facts = run_facts(*plan, report, warnings_of(*plan, report));
    return py::make_tuple(arrays.columns(*plan), facts);
}

/// Returns the warnings about the rays of a set, and about keys of the sweep that have no effect on them.
std::vector<Warning> warnings_of_sweep(const SweptSet& set) {
    std::vector<Warning> warnings = warnings_of(*set.plan, set.report);
    for (const std::string& remark : set.remarks) warnings.push_back({"sweep", remark});
    return warnings;
}

/// Traces rays for several sets of overrides. Returns a list with the columns and the facts of each set.
py::list sweep_scene_plans(const SharedScene& scene, const std::vector<Texts>& sets, const py::array& positions,
                           const py::array& directions, RayRequest request, const Texts& chosen,
                           const RunOptions& options, const py::object& progress) {
    const Texts names = choose_columns_of_ends(chosen, request);
    const RayArrays rays = ray_arrays(positions, directions);
    std::vector<SweptSet> swept;
    run_with_signals(progress, [&](const RunControl& control) {
        check_finite(rays);
        swept = trace_sweep(*scene, sets, rays, request, options, control);
    });
    py::list results;
    for (const SweptSet& set : swept)
        results.append(py::make_tuple(columns_of_ends(*set.plan, set.ends, set.paths, names),
                                      run_facts(*set.plan, set.report, warnings_of_sweep(set))));
    return results;
}

/// Traces rays for several values of keys: values[i] contains those of keys[i]. Returns the columns, in which the rays
/// of a set are consecutive, and the facts of the run.
py::tuple sweep_numbers_of_scene(const SharedScene& scene, const Texts& keys,
                                 const std::vector<std::vector<double>>& values, const py::array& positions,
                                 const py::array& directions, RayRequest request, const Texts& chosen,
                                 const RunOptions& options, const py::object& progress) {
    const Texts names = choose_columns_of_ends(chosen, request);
    const RayArrays rays = ray_arrays(positions, directions);
    std::vector<SweptKey> swept_keys;
    for (std::size_t i = 0; i < keys.size(); ++i) swept_keys.push_back({keys[i], values.at(i), {}});
    std::pair<SweepResult, RunReport> done;
    run_with_signals(progress, [&](const RunControl& control) {
        check_finite(rays);
        done = sweep_numbers(*scene, swept_keys, rays, request, options, control);
    });
    const auto& [result, report] = done;
    return py::make_tuple(columns_of_ends(result.plan, result.ends, {}, names),
                          run_facts(result.plan, report, warnings_of(result.plan, report)));
}

/// Traces the paths of rays. Returns the columns and the facts of the run.
py::tuple path_scene_plans(const SharedScene& scene, const py::array& positions, const py::array& directions,
                           RayRequest request, const Texts& chosen, const RunOptions& options,
                           const py::object& progress) {
    const Texts names = choose_columns_of_paths(chosen, request);
    const RayArrays rays = ray_arrays(positions, directions);
    Tracing done;
    run_with_signals(progress, [&](const RunControl& control) {
        check_finite(rays);
        done.plan = scene->rays(options, request);
        const auto starts = start_arrays(*done.plan, rays, observer_of(request));
        check_path_points(*done.plan, starts, starts.size(), control);
        done.points = trace_paths(*done.plan, starts, done.ends, control);
        done.report.interrupted = control.stop->load();
    });
    py::dict facts = run_facts(*done.plan, done.report, {});
    return py::make_tuple(columns_of_points(*done.plan, done.points, names), facts);
}

/// Returns text and JSON of `kagero explain`, and the remarks on the scene.
py::tuple explain_scene_plans(const SharedScene& scene, const RunOptions& options, const py::object& progress) {
    std::shared_ptr<const Plan> plan;
    run_with_signals(progress, [&](const RunControl& control) { plan = scene->picture(options, {}, control); });
    return py::make_tuple(explanation_text(*plan), explanation_json(*plan), plan->remarks);
}

/// Returns the JSON of `kagero error`, and true if it was interrupted.
py::tuple study_scene_plans(const SharedScene& scene, std::pair<unsigned, unsigned> sample, bool quick, bool full,
                            const RunOptions& requested, const py::object& progress) {
    const Options options = options_of(requested);
    StudyOptions study;
    study.width = sample.first;
    study.height = sample.second;
    study.quick = quick;
    study.full = full;
    if (options.threads) study.threads = options.threads;
    study.precision = options.precision;
    study.strategy = options.strategy;
    if (study.strategy == Strategy::per_ray)
        throw InputError("strategy: per-ray is not available in error(); choose auto, scalar or packet");
    std::string json;
    bool interrupted = false;
    run_with_signals(progress, [&](const RunControl& control) {
        Options plan_options;  // precision and strategy select curves of the study; they do not apply to this plan
        plan_options.isa = options.isa;
        plan_options.threads = options.threads;
        const Plan plan = make_plan(description_of(scene->source(), plan_options), plan_options);
        const ErrorStudy done = study_error(plan, study, control.progress, control.stop);
        json = error_json(plan, done);
        interrupted = done.interrupted;
    });
    return py::make_tuple(json, interrupted);
}

/// Returns the scene as a PNG file of at most `max_edge` pixels along its longer edge.
py::bytes png_of_scene_plans(const SharedScene& scene, unsigned max_edge) {
    const FilmDescription& film = scene->description().film;
    const double scale = std::min(1.0, double(max_edge) / std::max(film.width, film.height));
    const auto pixels = [&](std::uint32_t edge) { return std::to_string(std::max(1u, unsigned(edge * scale + 0.5))); };
    SceneSource source = scene->source();
    source.overrides.push_back("film.size=[" + pixels(film.width) + ", " + pixels(film.height) + "]");
    Rendering done;
    run_with_signals(py::none(), [&](const RunControl& control) {
        done = rendering_of(ScenePlans(source), {}, {"color"}, control);
    });
    const Tone tone = done.film->tone();
    const auto png =
        png_of_colors(done.film->take_plane("color"), int(done.film->width()), int(done.film->height()), tone);
    return {reinterpret_cast<const char*>(png.data()), png.size()};
}

/// Returns facts about a scene for its text representation.
py::dict summary_of(const SharedScene& scene) {
    const SceneDescription& description = scene->description();
    py::dict summary;
    summary["hamiltonian"] = description.space.hamiltonian;
    summary["objects"] = description.objects.size();
    summary["media"] = description.media.size();
    summary["size"] = py::make_tuple(description.film.width, description.film.height);
    summary["layers"] = description.film.layers;
    return summary;
}

}  // namespace

void add_scene(py::module_& module) {
    py::class_<RunOptions>(module, "RunOptions")
        .def(py::init(&run_options), py::arg("isa"), py::arg("strategy"), py::arg("precision"), py::arg("threads"));
    py::class_<RayRequest>(module, "RayRequest")
        .def(py::init(&ray_request), py::arg("observer"), py::arg("bounces"), py::arg("parameter"), py::arg("every"));
    py::class_<ScenePlans, SharedScene>(module, "Scene")
        .def(py::init(&load_scene_plans), py::arg("path"), py::arg("text"), py::arg("overrides"))
        .def_property_readonly("path", [](const SharedScene& scene) { return scene->source().file; })
        .def_property_readonly("text", [](const SharedScene& scene) { return *scene->source().text; })
        .def_property_readonly("overrides", [](const SharedScene& scene) { return scene->source().overrides; })
        .def("summary", &summary_of)
        .def("toml", [](const SharedScene& scene) { return print_scene(scene->description()); })
        .def("render", &render_scene_plans)
        .def("trace", &trace_scene_plans)
        .def("path_table", &path_scene_plans)
        .def("sweep", &sweep_scene_plans)
        .def("sweep_numbers", &sweep_numbers_of_scene)
        .def("explain", &explain_scene_plans)
        .def("error", &study_scene_plans)
        .def("png", &png_of_scene_plans);
}

}  // namespace kagero
