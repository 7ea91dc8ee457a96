// kagero render: renders a scene to a picture.
#include "accuracy/end_errors.h"
#include "cli/frame_job.h"
#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/paths.h"
#include "cli/ranks/run_on_ranks.h"
#include "cli/ranks/work_for_root.h"
#include "cli/resolve.h"
#include "cli/tile_job.h"
#include "cli/verb.h"
#include "error.h"
#include "film/map.h"
#include "film/write_film.h"
#include "frames/sub_frames.h"
#include "plan/names.h"
#include "ranks/gather_tiles.h"
#include "ranks/shared_scene.h"
#include "ranks/shared_tiles.h"
#include "rays/camera.h"
#include "report/run_json.h"
#include "report/text/numbers.h"
#include "report/warnings.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <future>
#include <limits>
#include <ostream>

namespace kagero {

namespace {

void declare_render(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output,
               "File for the picture. .exr holds all layers; .npy and .pfm hold one layer as floats; .png, .jpg and "
               "other formats hold the layer color only. Default: SCENE.exr in the working directory",
               "FILE");
    add_crop(app, arguments);
    add_option(app, "--pixel", arguments.pixel,
               "Render nothing; write the path of the ray through the middle of this pixel as CSV to stdout, one row "
               "per step. Pixel (0, 0) is at the top left",
               "X,Y");
    add_columns(app, arguments, "Each adds a column to the CSV of --pixel; a picture has layers of the same names.");
    add_option(app, "--time-limit", arguments.time_limit,
               "Stop after this number of seconds of rendering, greater than 0, and write the picture so far. The "
               "limit changes no choice of the program. Default: no limit",
               "SECONDS");
    add_flag(app, "--maps", arguments.maps,
             "Also write a file PICTURE-LAYER.png for each layer of numbers, in false colours with a colour scale");
    add_tile_options(app, arguments);
    add_rank_options(app, arguments, "render");
    add_frame_options(app, arguments);
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
    write_paths_of(plan, {pixel_ray_start(plan, xy[0], xy[1])}, plan.run.max_bounces.has_value(), "-", control,
                   terminal);
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

/// Renders the picture or part. `sub_frames`, if not null, supplies the sub-frames of which the picture is the mean.
RunReport render_with_progress(const Plan& plan, Film& film, TileJob& job, FramePlans* sub_frames,
                               const std::string& output, double time_limit, const Terminal& terminal) {
    ProgressLine line(terminal);
    RunControl control;
    control.progress = [&](double done, double seconds) { line.show(done, seconds); };
    control.stop = InterruptGuard::requested();
    control.time_limit = time_limit;
    control.snapshot_requested = SnapshotGuard::requested();
    control.snapshot = [&](const Film* so_far) {
        if (job.part) return line.print_message([&] { terminal.warning("there is no snapshot of a part"); });
        if (so_far) return write_snapshot(plan, *so_far, output, terminal, line);
        line.print_message([&] { terminal.warning("not enough memory for a snapshot; rendering continues"); });
    };
    if (sub_frames) return render_sub_frames(*sub_frames, plan, 0, film, control);
    Journal* const journal = job.journal ? &*job.journal : nullptr;
    if (job.ranks) return render_on_ranks(*job.ranks, plan, job.header, film, job.results, journal, control);
    if (!job.is_used()) return render_with_errors(plan, film, control);
    return render_tiles(plan, job.header, film, job.results, journal, control);
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

/// Returns true if the finished tiles remain in the journal, and no output is written: after Ctrl-C or SIGTERM.
bool keeps_journal_only(const TileJob& job, const RunReport& report) {
    return job.journal && report.interrupted && !report.out_of_time;
}

void print_result(const RunReport& report, const TileJob& job, const std::string& path, const Terminal& terminal) {
    const double rays = static_cast<double>(report.rays - report.earlier_rays);
    const std::string output = !job.part ? "the picture" : "part " + job.part->text();
    std::string ending = output + " is in " + path;
    if (report.interrupted) ending = output + " so far is in " + path;
    if (job.is_used() && report.interrupted) ending += ", with " + job.count_text();
    if (keeps_journal_only(job, report))
        ending = job.count_text() + " are in " + job.journal->path() + "; the same command continues";
    if (report.interrupted)
        ending = (report.out_of_time ? "the time limit was reached; " : "interrupted; ") + ending;
    terminal.note(ending + " (" + rounded(rays) + " rays in " + rounded(report.seconds) + " s, " +
                  rounded(report.seconds > 0 ? rays / report.seconds : 0) + " rays/s)");
}

/// Throws InputError for options that cannot be combined with --pixel, or that need it.
void check_render_options(const Arguments& arguments) {
    check_rank_combination(arguments);
    if (arguments.pixel.empty() && !arguments.columns.empty())
        throw InputError("--columns has an effect only on the path of --pixel; add --pixel X,Y, or request the layers "
                         "action and time by --layers");
    if (!arguments.part.empty() && arguments.maps)
        throw InputError("--part writes no picture; leave --maps out");
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
    refuse(!arguments.part.empty(), "--part");
    refuse(arguments.resume, "--resume");
}

/// Writes the JSON report, in which `film` is summarized unless it is null, prints the result and warnings, and returns
/// the exit status.
int conclude(const Plan& plan, const RunReport& report, const TileJob& job, const Film* film, double write_seconds,
             const std::string& output, const std::string& json, const Terminal& terminal) {
    const std::vector<Warning> warnings = warnings_of_picture(plan, report);
    if (!json.empty())
        write_output(json, [&](std::ostream& out) { out << render_json(plan, report, film, write_seconds, warnings); });
    print_result(report, job, output, terminal);
    for (const Warning& warning : warnings) terminal.warning(warning.text);
    if (report.interrupted && !report.out_of_time) return exit_interrupted;
    return misses_stated_bound(plan) ? exit_bound : exit_done;
}

/// Returns the path of the picture or part.
std::string output_of(const Arguments& arguments, const std::optional<PartNumber>& part) {
    if (!arguments.output.empty()) return arguments.output;
    const std::string stem = std::filesystem::path(arguments.scene).stem().string();
    if (!part) return stem + ".exr";
    return stem + "-" + std::to_string(part->number) + "-of-" + std::to_string(part->count) + ".part";
}

/// Checks that all files of the render can be written. Throws InputError.
void check_files(const Arguments& arguments, const Options& options, const SceneDescription& scene,
                 const std::vector<const LayerInfo*>& mapped, const std::string& output) {
    std::vector<NamedFile> outputs{{"-o", output}, {"--json", arguments.json}};
    outputs.emplace_back("the journal", journal_path(arguments, output));
    for (const LayerInfo* layer : mapped) outputs.emplace_back("the map of " + layer->name, map_path(output, *layer));
    check_outputs(outputs, files_of(scene));
    const bool whole_film = arguments.crop.empty();
    const std::uint32_t width = whole_film ? scene.film.width : options.crop.x1 - options.crop.x0,
                        height = whole_film ? scene.film.height : options.crop.y1 - options.crop.y0;
    if (arguments.part.empty()) check_writable(output, scene.film.layers, width, height);
}

/// Writes the picture or part, and removes the journal if all tiles are finished. Returns the seconds for writing.
double write_result(TileJob& job, const Plan& plan, const Film& film, const RunReport& report,
                    const std::string& output) {
    if (keeps_journal_only(job, report)) return 0;
    const auto begin = std::chrono::steady_clock::now();
    if (job.part) write_part(output, job.header, job.results);
    else write_film(film, output, picture_metadata(plan, report));
    if (job.journal && !report.interrupted) job.journal->remove();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Returns the plans of the sub-frames if frame 0 consists of several; otherwise null. Throws InputError for --part,
/// --resume and --mpi, which need tiles that are finished one after another.
std::unique_ptr<FramePlans> sub_frames_of(const Arguments& arguments, const Options& options,
                                          const SceneDescription& scene, const Terminal& terminal) {
    if (!has_sub_frames(scene)) return nullptr;
    if (!arguments.part.empty() || arguments.resume || arguments.mpi)
        throw InputError(std::string(arguments.mpi      ? "--mpi"
                                     : arguments.resume ? "--resume"
                                                        : "--part") +
                         " cannot be combined with "
                         "camera.shutter > 0, because all tiles are finished at the same time; render whole frames, or "
                         "state -D camera.shutter=0");
    return frame_plans_with_progress(scene, options, terminal);
}

int render_picture(const Arguments& arguments, Options options, SceneDescription scene, const Terminal& terminal,
                   Communicator* ranks) {
    TileJob job(part_of(arguments));
    job.ranks = ranks;
    const std::string output = output_of(arguments, job.part);
    const std::vector<const LayerInfo*> mapped = mapped_layers(arguments, scene.film.layers);
    const double time_limit = time_limit_of(arguments);
    check_files(arguments, options, scene, mapped, output);
    // The JSON and the attributes of an .exr file contain the error of H. A part may become an .exr file.
    options.energy_error = job.part || ranks || !arguments.json.empty() || stores_all_layers(output);
    if (arguments.resume) job.journal.emplace(journal_path(arguments, output));
    auto writer_is_loaded = std::async(std::launch::async, [&] {
        if (!job.part) prepare_to_write(output);
    });
    const std::unique_ptr<FramePlans> sub_frames = sub_frames_of(arguments, options, scene, terminal);
    const Plan plan = sub_frames ? sub_frames->first() : plan_of(job, std::move(scene), options, terminal);
    // Until here, an interrupt terminates the program, because there are no results to keep.
    const InterruptGuard interrupts;
    print_plan(plan, terminal);
    Film film = film_of(plan, job.part ? Planes::none : Planes::allocated);
    begin_tiles(job, plan, film, terminal);
    if (ranks) share_tiles(*ranks, job.header, job.results);
    writer_is_loaded.get();  // Waits for the thread, so that no other work runs during rendering.
    const RunReport report = render_with_progress(plan, film, job, sub_frames.get(), output, time_limit, terminal);
    const double write_seconds = write_result(job, plan, film, report, output);
    if (!keeps_journal_only(job, report)) write_maps(film, mapped, output, terminal);
    return conclude(plan, report, job, job.part ? nullptr : &film, write_seconds, output, arguments.json, terminal);
}

/// Runs the verb. `ranks` is null without --mpi.
int render(const Arguments& arguments, const Terminal& terminal, Communicator* ranks) {
    check_render_options(arguments);
    const SnapshotGuard snapshots;  // Installed first, because the signal may arrive while the scene is loaded.
    Options options = options_of(arguments);
    request_columns(arguments, options);
    if (ranks) set_up_rank(*ranks, options, terminal);
    if (ranks && ranks->rank() > 0) return work_for_root(arguments, options, time_limit_of(arguments), *ranks);
    SceneDescription scene = scene_of(arguments, options);
    if (ranks) share_scene(*ranks, scene, arguments.send_files);
    check_crop(arguments, options, scene.film);
    if (!arguments.frames.empty())
        return render_frames_of(arguments, options, scene, time_limit_of(arguments), terminal, ranks);
    check_picture_output(arguments, scene);
    if (arguments.pixel.empty()) return render_picture(arguments, options, std::move(scene), terminal, ranks);
    // With --pixel, the precision is double without a trial: a path shows differences between float and double that are
    // invisible in a picture.
    if (!options.precision) options.precision = Precision::float64;
    const Plan plan = resolve_with_progress(std::move(scene), options, terminal);
    const InterruptGuard interrupts;
    print_plan(plan, terminal);
    return write_pixel_path(plan, arguments.pixel, terminal);
}

int run_render(const Arguments& arguments, const Terminal& terminal) {
    if (!arguments.mpi) return render(arguments, terminal, nullptr);
    return run_on_ranks(arguments, terminal,
                        [](const Arguments& of_rank, const Terminal& terminal_of_rank, Communicator& ranks) {
                            return render(of_rank, terminal_of_rank, &ranks);
                        });
}

}  // namespace

const Verb render_verb{"render", "Render a scene to a picture", declare_render, run_render};

}  // namespace kagero
