// kagero profile: measures where the run time of a render is spent.
#include "study/profile.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/resolve.h"
#include "cli/verb.h"
#include "error.h"
#include "film/partial_file.h"
#include "report/profile/profile_html.h"
#include "report/profile/profile_json.h"
#include "report/profile/profile_trace.h"
#include "report/run_json.h"

#include <filesystem>
#include <ostream>

namespace kagero {

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t max_rounds = 1000;

void declare_profile(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output,
               "Directory for the report: profile.json, trace.json, report.html and the picture. Default: "
               "SCENE-profile in the working directory",
               "DIR");
    add_option(app, "--repeat", arguments.repeat,
               "Number of rounds, 1 to 1000; each round renders the picture once in every configuration. Default: 3 to "
               "50 rounds in about 20 seconds",
               "N");
    add_crop(app, arguments);
    add_schedule(app, arguments);
    add_json(app, arguments);
    add_execution(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

/// Returns the number of rounds that --repeat states; 0 means that profile() chooses it.
unsigned rounds_of(const Arguments& arguments) {
    if (arguments.repeat.empty()) return 0;
    return count_of("--repeat", arguments.repeat, max_rounds);
}

Profile profile_with_progress(const Plan& plan, Film& film, unsigned rounds, const Terminal& terminal) {
    ProgressLine line(terminal);
    return profile(
        plan, film, rounds, [&](double done, double seconds) { line.show(done, seconds); },
        InterruptGuard::requested());
}

int run_profile(const Arguments& arguments, const Terminal& terminal) {
    const unsigned rounds = rounds_of(arguments);
    const Options options = options_of(arguments);
    SceneDescription scene = scene_of(arguments, options);
    check_crop(arguments, options, scene.film);
    const std::string picture = fs::path(arguments.scene).stem().string() + ".exr";
    const Plan plan = resolve_with_progress(std::move(scene), options, terminal);
    const InterruptGuard interrupts;
    const std::string directory = report_directory(arguments, "profile");
    const ReportDirectory report(directory, {"profile.json", "trace.json", "report.html", picture}, arguments.json,
                                 files_of(plan.description()));

    prepare_to_write(picture);  // The time for loading the picture writer must not count as time for writing.
    Film film = film_of(plan);
    const Profile profile = profile_with_progress(plan, film, rounds, terminal);
    if (profile.rounds == 0) throw Interrupted();
    const double write_seconds = save_film(film, path_in(directory, picture), picture_metadata(plan, profile.report));
    const std::string json = profile_json(plan, profile, write_seconds);
    write_text_file(path_in(directory, "profile.json"), json);
    write_text_file(path_in(directory, "trace.json"), profile_trace(plan, profile, write_seconds));
    write_text_file(path_in(directory, "report.html"), profile_page(plan, profile, write_seconds));
    if (!arguments.json.empty()) write_output(arguments.json, [&](std::ostream& out) { out << json; });
    if (arguments.json != "-")
        write_output("-", [&](std::ostream& out) { out << profile_text(profile, write_seconds); });
    terminal.note((profile.interrupted ? "interrupted; the results so far are in " : "the report is in ") +
                  path_in(directory, "report.html"));
    if (profile.interrupted) return exit_interrupted;
    return misses_stated_bound(plan) ? exit_bound : exit_done;
}

}  // namespace

const Verb profile_verb{"profile", "Measure where the run time of a render is spent", declare_profile, run_profile};

}  // namespace kagero
