// kagero render: renders a scene to a picture.
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
#include "report/run_json.h"
#include "report/text/numbers.h"
#include "report/warnings.h"
#include "tuning/trial_run.h"

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
               "File for the picture. .exr holds all layers; .png, .jpg, .pfm and other formats hold the layer color "
               "only. Default: SCENE.exr in the working directory",
               "FILE");
    add_crop(app, arguments);
    add_option(app, "--pixel", arguments.pixel,
               "Render nothing; write the path of the ray through the middle of this pixel as CSV to stdout, one row "
               "per step. Pixel (0, 0) is at the top left",
               "X,Y");
    add_option(app, "--time-limit", arguments.time_limit,
               "Stop after this number of seconds of rendering, greater than 0, and write the picture so far. The "
               "limit changes no choice of the program. Default: no limit",
               "SECONDS");
    add_flag(app, "--maps", arguments.maps,
             "Also write a file PICTURE-LAYER.png for each layer of numbers, in false colours with a colour scale");
    add_schedule(app, arguments);
    add_json(app, arguments);
    add_execution(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

int write_pixel_path(const Plan& plan, const std::string& pixel, const Terminal& terminal) {
    const auto xy = whole_numbers("--pixel", pixel, ',', 2);
    check_inside("--pixel", pixel, plan.description().film, xy[0], xy[1]);
    RunControl control;
    control.stop = InterruptGuard::requested();
    write_paths_of(plan, {pixel_ray_start(plan, xy[0], xy[1])}, "-", control, terminal);
    if (!*control.stop) return exit_done;
    terminal.note("interrupted before the ray ended; its path is not written");
    return exit_interrupted;
}

double time_limit_of(const Arguments& arguments) {
    if (arguments.time_limit.empty()) return std::numeric_limits<double>::infinity();
    const double seconds = finite_number("--time-limit", arguments.time_limit);
    if (seconds <= 0) throw InputError("--time-limit: " + arguments.time_limit + " is not greater than 0 (in seconds)");
    return seconds;
}

/// Writes the unfinished picture, as SIGUSR1 requests. If this fails, prints a warning, and rendering continues.
void write_snapshot(const Plan& plan, const Film& film, const std::string& path, const Terminal& terminal,
                    ProgressLine& line) {
    RunReport so_far;
    so_far.interrupted = true;
    try {
        write_film(film, path, picture_metadata(plan, so_far));
        line.print_message([&] { terminal.note("a snapshot is in " + path); });
    } catch (const std::exception& error) {
        line.print_message([&] { terminal.warning(error.what()); });
    }
}

RunReport render_with_progress(const Plan& plan, Film& film, const std::string& output, double time_limit,
                               const Terminal& terminal) {
    ProgressLine line(terminal);
    RunControl control;
    control.progress = [&](double done, double seconds) { line.show(done, seconds); };
    control.stop = InterruptGuard::requested();
    control.time_limit = time_limit;
    control.snapshot_requested = SnapshotGuard::requested();
    control.snapshot = [&](const Film* so_far) {
        if (so_far) return write_snapshot(plan, *so_far, output, terminal, line);
        line.print_message([&] { terminal.warning("not enough memory for a snapshot; rendering continues"); });
    };
    return render_with_errors(plan, film, control);
}

/// Returns the layers among `names` that contain numbers, for which --maps writes files; none without --maps. Throws
/// InputError if --maps is given and no layer contains numbers.
std::vector<const LayerInfo*> mapped_layers(const Arguments& arguments, const std::vector<std::string>& names) {
    std::vector<const LayerInfo*> mapped;
    if (!arguments.maps) return mapped;
    for (const LayerInfo& layer : all_layers())
        if (layer.scale != LayerInfo::Scale::colors && std::find(names.begin(), names.end(), layer.name) != names.end())
            mapped.push_back(&layer);
    if (mapped.empty())
        throw InputError(
            "--maps: film.layers contains no layer of numbers; add one with --layers, or leave --maps out "
            "(see `kagero list layers`)");
    return mapped;
}

void write_maps(const Film& film, const std::vector<const LayerInfo*>& mapped, const std::string& output,
                const Terminal& terminal) {
    for (const LayerInfo* layer : mapped) {
        write_map(film, *layer, map_path(output, *layer));
        terminal.note("the map of layer " + layer->name + " is in " + map_path(output, *layer));
    }
}

void print_plan(const Plan& plan, const Terminal& terminal) {
    const std::string text = plan.description().space.hamiltonian + ", " + plan.method().name + ", " +
                             plan.module().isa + ", " + name_of(plan.run.kernel->strategy) + ", " +
                             name_of(plan.run.kernel->precision) + ", " + std::to_string(plan.run.kernel->lanes) +
                             " lanes";
    terminal.detail(text + ", " + std::to_string(plan.run.threads) + " threads; loaded in " +
                    rounded(plan.load_seconds) + " s");
}

void print_result(const RunReport& report, const std::string& path, const Terminal& terminal) {
    const double rate = report.seconds > 0 ? static_cast<double>(report.rays) / report.seconds : 0;
    const char* ending = report.out_of_time   ? "the time limit was reached; the picture so far is in "
                         : report.interrupted ? "interrupted; the picture so far is in "
                                              : "the picture is in ";
    terminal.note(ending + path + " (" + rounded(static_cast<double>(report.rays)) + " rays in " +
                  rounded(report.seconds) + " s, " + rounded(rate) + " rays/s)");
}

/// Returns the warnings about a picture. Without an error that trial rays have confirmed, a few rays test whether H is
/// conserved.
std::vector<Warning> warnings_of_picture(const Plan& plan, RunReport report) {
    const bool is_confirmed = plan.method_trial && plan.method_trial->bound_met;
    if (!is_confirmed && !(plan.run.outputs & output_energy)) report.energy_error = trace_trial(plan).energy_error;
    return warnings_of(plan, report, "and are black");
}

/// Throws InputError for options that cannot be combined with --pixel.
void check_combination(const Arguments& arguments) {
    if (arguments.pixel.empty()) return;
    const auto refuse = [](bool given, const char* option) {
        if (given)
            throw InputError(std::string("--pixel writes a path to stdout and renders nothing; leave ") + option +
                             " out");
    };
    refuse(!arguments.output.empty(), "-o");
    refuse(!arguments.json.empty(), "--json");
    refuse(!arguments.crop.empty(), "--crop");
    refuse(arguments.maps, "--maps");
    refuse(!arguments.time_limit.empty(), "--time-limit");
}

/// Writes the JSON report, prints the result and warnings, and returns the exit status.
int conclude(const Plan& plan, const RunReport& report, double write_seconds, const std::string& output,
             const std::string& json, const Terminal& terminal) {
    const std::vector<Warning> warnings = warnings_of_picture(plan, report);
    if (!json.empty())
        write_output(json, [&](std::ostream& out) { out << render_json(plan, report, write_seconds, warnings); });
    print_result(report, output, terminal);
    for (const Warning& warning : warnings) terminal.warning(warning.text);
    if (report.interrupted && !report.out_of_time) return exit_interrupted;
    return misses_stated_bound(plan) ? exit_bound : exit_done;
}

int run(const Arguments& arguments, const Terminal& terminal) {
    check_combination(arguments);
    const SnapshotGuard snapshots;  // Installed first, because the signal may arrive while the scene is loaded.
    const double time_limit = time_limit_of(arguments);
    Options options = options_of(arguments);
    // With --pixel, the precision is double without a trial: a path shows differences between float and double that are
    // invisible in a picture.
    if (!arguments.pixel.empty() && !options.precision) options.precision = Precision::float64;
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
    const bool whole_film = arguments.crop.empty();
    const std::uint32_t width = whole_film ? scene.film.width : options.crop.x1 - options.crop.x0,
                        height = whole_film ? scene.film.height : options.crop.y1 - options.crop.y0;
    if (arguments.pixel.empty()) {
        check_writable(output, scene.film.layers, width, height);
        // The JSON and the attributes of an .exr file contain the error of H.
        options.energy_error = !arguments.json.empty() || stores_all_layers(output);
    }
    auto writer_is_loaded = std::async(std::launch::async, [&] {
        if (arguments.pixel.empty()) prepare_to_write(output);
    });

    const Plan plan = resolve_with_progress(std::move(scene), options, terminal);
    // Until here, an interrupt terminates the program, because there are no results to keep.
    const InterruptGuard interrupts;
    print_plan(plan, terminal);
    if (!arguments.pixel.empty()) return write_pixel_path(plan, arguments.pixel, terminal);

    Film film = film_of(plan);
    writer_is_loaded.get();  // Waits for the thread, so that no other work runs during rendering.
    const RunReport report = render_with_progress(plan, film, output, time_limit, terminal);
    const double write_seconds = save_film(film, output, picture_metadata(plan, report));
    write_maps(film, mapped, output, terminal);
    return conclude(plan, report, write_seconds, output, arguments.json, terminal);
}

}  // namespace

const Verb render_verb{"render", "Render a scene to a picture", declare, run};

}  // namespace kagero
