// kagero render: a scene to a picture.
#include "accuracy/end_errors.h"
#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/paths.h"
#include "cli/resolve.h"
#include "cli/verb.h"
#include "error.h"
#include "film/map.h"
#include "film/write_film.h"
#include "plan/names.h"
#include "rays/camera.h"
#include "render/deadline.h"
#include "report/text/numbers.h"
#include "report/run_json.h"

#include <algorithm>
#include <filesystem>
#include <future>
#include <limits>
#include <ostream>

namespace kagero {

namespace {

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output,
                   "The picture: .exr with all layers, .png, .jpg, .pfm …; default: SCENE.exr here", "FILE");
    add_crop(app, arguments);
    add_option(app, "--pixel", arguments.pixel,
                   "Write the path of one pixel's ray, step by step, as CSV on stdout; render nothing", "X,Y");
    add_option(app, "--time-limit", arguments.time_limit,
               "Stop after so many seconds; the picture so far is written. In double, unless --precision says else",
               "SECONDS");
    add_flag(app, "--maps", arguments.maps,
             "Beside the picture, PICTURE-LAYER.png of every layer of numbers, in false colours with a scale");
    add_schedule(app, arguments);
    add_json(app, arguments);
    add_machine(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

int write_pixel_path(const Plan& plan, const std::string& pixel, const Terminal& terminal) {
    const auto xy = whole_numbers("--pixel", pixel, ',', 2);
    check_inside("--pixel", pixel, plan.description().film, xy[0], xy[1]);
    Watch watch;
    watch.stop = InterruptGuard::requested();
    write_paths_of(plan, {pixel_ray(plan, xy[0], xy[1])}, "-", watch, terminal);
    if (!*watch.stop) return exit_done;
    terminal.note("interrupted before the ray's end: it has no path");
    return exit_interrupted;
}

double time_limit_of(const Arguments& arguments) {
    if (arguments.time_limit.empty()) return std::numeric_limits<double>::infinity();
    const double seconds = finite_number("--time-limit", arguments.time_limit);
    if (seconds <= 0)
        throw InputError("--time-limit: " + arguments.time_limit + " is not a positive number of seconds");
    return seconds;
}

/// Answers SIGUSR1. A snapshot that cannot be written is no reason to end the work.
void write_snapshot(const Plan& plan, const Film& film, const std::string& path, const Terminal& terminal,
                    ProgressLine& line) {
    RunReport so_far;
    so_far.interrupted = true;
    try {
        write_film(film, path, picture_metadata(plan, so_far));
        line.aside([&] { terminal.note("a snapshot is in " + path); });
    } catch (const std::exception& error) {
        line.aside([&] { terminal.warning(error.what()); });
    }
}

RunReport render_watched(const Plan& plan, Film& film, const std::string& output, double time_limit,
                         const Terminal& terminal) {
    ProgressLine line(terminal);
    Watch watch;
    watch.progress = [&](double done, double seconds) { line.show(done, seconds); };
    watch.stop = InterruptGuard::requested();
    watch.time_limit = time_limit;
    watch.snapshot_wanted = SnapshotGuard::wanted();
    watch.snapshot = [&](const Film* so_far) {
        if (so_far) return write_snapshot(plan, *so_far, output, terminal, line);
        line.aside([&] { terminal.warning("there is not enough memory for a snapshot"); });
    };
    return render_with_errors(plan, film, watch);
}

/// The layers of these names that --maps shows; none without it. Throws InputError where there are none to show.
std::vector<const LayerInfo*> mapped_layers(const Arguments& arguments, const std::vector<std::string>& names) {
    std::vector<const LayerInfo*> mapped;
    if (!arguments.maps) return mapped;
    for (const LayerInfo& layer : all_layers())
        if (layer.scale != LayerInfo::Scale::colors && std::find(names.begin(), names.end(), layer.name) != names.end())
            mapped.push_back(&layer);
    if (mapped.empty()) throw InputError("--maps: film.layers has no layer of numbers; see `kagero list layers`");
    return mapped;
}

void write_maps(const Film& film, const std::vector<const LayerInfo*>& mapped, const std::string& output,
                const Terminal& terminal) {
    for (const LayerInfo* layer : mapped) {
        write_map(film, *layer, map_path(output, *layer));
        terminal.note("a map of " + layer->name + " is in " + map_path(output, *layer));
    }
}

void tell_plan(const Plan& plan, const Terminal& terminal) {
    const std::string text = plan.description().space.hamiltonian + ", " + plan.method().name + ", " +
                             plan.module().isa + ", " + name_of(plan.run.kernel->strategy) + ", " +
                             name_of(plan.run.kernel->precision) + ", " + std::to_string(plan.run.kernel->lanes) +
                             " lanes";
    terminal.detail(text + ", " + std::to_string(plan.run.threads) + " threads; loaded in " +
                    rounded(plan.load_seconds) + " s");
}

void tell_result(const RunReport& report, const std::string& path, const Terminal& terminal) {
    const double rate = report.seconds > 0 ? static_cast<double>(report.rays) / report.seconds : 0;
    const char* ending = report.out_of_time   ? "the time is up; what was done is in "
                         : report.interrupted ? "interrupted; what was done is in "
                                              : "the picture is in ";
    terminal.note(ending + path + " (" + rounded(static_cast<double>(report.rays)) + " rays in " +
                  rounded(report.seconds) + " s, " + rounded(rate) + " rays/s)");
}

/// Pixels that show nothing of the scene, and why.
void warn_of_ends(const Plan& plan, const RunReport& report, const Terminal& terminal) {
    constexpr double many = 0.01, large = 0.01;
    const auto count = [&](Status status) { return double(report.counters.ended[static_cast<int>(status)]); };
    const double rays = double(report.rays);
    if (const double endless = count(Status::step_limit); endless > many * rays)
        terminal.warning(
            (endless == rays ? "no ray ended" : rounded(endless) + " of " + rounded(rays) + " rays did not end") +
            " within integrator.max_steps = " + std::to_string(plan.description().integrator.max_steps) +
            " steps: such rays show black");
    if (count(Status::failed) > many * rays)
        terminal.warning(rounded(count(Status::failed)) + " of " + rounded(rays) +
                         " rays failed, and are black; `kagero trace` tells the reason of each. Where it is a step, " +
                         (plan.method().adaptive ? "another integrator.tolerance" : "a smaller integrator.step") +
                         " may do");
    if (report.energy_error.p99 > large && !(plan.method_trial && plan.method_trial->met))
        terminal.warning("99 % of the rays keep H to " + rounded(report.energy_error.p99) +
                         " alone: a smaller integrator.step will show another picture");
}

/// A path goes to stdout, and is of one pixel of the whole film.
void check_combination(const Arguments& arguments) {
    if (arguments.pixel.empty()) return;
    const auto refuse = [](bool given, const char* option) {
        if (given)
            throw InputError(std::string("--pixel writes a path on stdout and renders nothing; leave ") + option +
                             " out");
    };
    refuse(!arguments.output.empty(), "-o"), refuse(!arguments.json.empty(), "--json"),
        refuse(!arguments.crop.empty(), "--crop");
    refuse(arguments.maps, "--maps"), refuse(!arguments.time_limit.empty(), "--time-limit");
}

/// What is told when the picture is written, and the exit status.
int conclude(const Plan& plan, const RunReport& report, double write_seconds, const std::string& output,
             const std::string& json, const Terminal& terminal) {
    if (!json.empty()) write_output(json, [&](std::ostream& out) { out << render_json(plan, report, write_seconds); });
    tell_result(report, output, terminal);
    warn_of_ends(plan, report, terminal);
    if (report.interrupted && !report.out_of_time) return exit_interrupted;
    return plan.method_trial && !plan.method_trial->met ? exit_bound : exit_done;
}

int run(const Arguments& arguments, const Terminal& terminal) {
    check_combination(arguments);
    const SnapshotGuard snapshots;  // from here on: the signal may come while the scene is being loaded
    const double time_limit = time_limit_of(arguments);
    Options options = options_of(arguments);
    // A path is read, not looked at; and where time is short a trial of float would use it up.
    const bool no_trial = !arguments.pixel.empty() || !arguments.time_limit.empty();
    if (no_trial && !options.precision) options.precision = Precision::float64;
    SceneDescription scene = scene_of(arguments, options);
    const std::string output =
        arguments.output.empty() ? std::filesystem::path(arguments.scene).stem().string() + ".exr" : arguments.output;
    const std::vector<const LayerInfo*> mapped = mapped_layers(arguments, scene.film.layers);
    if (arguments.pixel.empty()) {
        std::vector<NamedFile> outputs{{"-o", output}, {"--json", arguments.json}};
        for (const LayerInfo* layer : mapped)
            outputs.emplace_back("the map of " + layer->name, map_path(output, *layer));
        check_outputs(outputs, files_of(scene));
    }
    check_crop(arguments, options, scene.film);
    const bool whole = arguments.crop.empty();
    const std::uint32_t width = whole ? scene.film.width : options.crop.x1 - options.crop.x0,
                        height = whole ? scene.film.height : options.crop.y1 - options.crop.y0;
    if (arguments.pixel.empty()) {
        check_writable(output, scene.film.layers, width, height);
        options.energy_error = !arguments.json.empty() || holds_layers(output);  // both tell it
    }
    auto prepared = std::async(std::launch::async, [&] { if (arguments.pixel.empty()) prepare_to_write(output); });

    constexpr double pilots_share = 0.5;  // the rest of the time is the picture's
    const Deadline deadline(time_limit);
    const Plan plan = resolve_watched(std::move(scene), options, terminal, pilots_share * time_limit);
    const InterruptGuard interrupts;  // from here on there is something to keep; before, the signal ends the program
    tell_plan(plan, terminal);
    if (!arguments.pixel.empty()) return write_pixel_path(plan, arguments.pixel, terminal);

    Film film = film_of(plan);
    prepared.get();  // nothing else runs beside the rays
    const RunReport report = render_watched(plan, film, output, deadline.left() + plan.load_seconds, terminal);
    const double write_seconds = save_film(film, output, picture_metadata(plan, report));
    write_maps(film, mapped, output, terminal);
    return conclude(plan, report, write_seconds, output, arguments.json, terminal);
}

}  // namespace

const Verb render_verb{"render", "Render a scene to a picture", declare, run};

}  // namespace kagero
