#include "cli/tile_job.h"

#include "cli/resolve.h"
#include "error.h"
#include "parts/choices.h"
#include "parts/identity.h"

namespace kagero {
namespace {

void warn_of_removed(std::uint64_t bytes, const std::string& path, const Terminal& terminal) {
    if (bytes > 0)
        terminal.warning("the last " + std::to_string(bytes) + " bytes of " + path +
                         " are not a complete tile; they are removed, and their tiles are rendered again");
}

}  // namespace

void add_tile_options(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--part", arguments.part,
               "Render only part I of N, with 1 <= I <= N <= 100000: every N-th tile. The output is a part file, from "
               "which `kagero merge` makes the picture. Default for -o: SCENE-I-of-N.part in the working directory",
               "I/N");
    add_flag(verb, "--resume", arguments.resume,
             "Keep finished tiles in the journal OUTPUT.journal, and continue from it if it exists. The journal is "
             "removed when the output is complete");
}

std::optional<PartNumber> part_of(const Arguments& arguments) {
    if (arguments.part.empty()) return {};
    const std::size_t slash = arguments.part.find('/');
    if (slash == std::string::npos)
        throw InputError("--part: '" + arguments.part + "' is not a number and a count separated by '/', such as 2/7");
    PartNumber part;
    part.count = count_of("--part, the count after '/'", arguments.part.substr(slash + 1), max_parts);
    part.number = count_of("--part, the number before '/'", arguments.part.substr(0, slash), part.count);
    return part;
}

std::string journal_path(const Arguments& arguments, const std::string& output) {
    return arguments.resume ? output + ".journal" : "";
}

std::string TileJob::count_text() const {
    return std::to_string(results.count()) + " of " + std::to_string(header.part.tiles_of(header.grid)) + " tiles";
}

Plan plan_of(TileJob& job, SceneDescription scene, const Options& options, const Terminal& terminal) {
    if (!job.is_used()) return resolve_with_progress(std::move(scene), options, terminal);
    Plan plan = make_plan(std::move(scene), options);
    job.identity = identity_of(plan, options);
    if (!job.journal || !job.journal->header()) return tune_with_progress(std::move(plan), options, terminal);
    check_same_render(*job.journal, job.identity, job.part.value_or(PartNumber{}));
    plan = with_choices(std::move(plan), job.journal->header()->choices, job.journal->path());
    print_remarks(plan, terminal);
    return plan;
}

void begin_tiles(TileJob& job, const Plan& plan, Film& film, const Terminal& terminal) {
    if (!job.is_used()) return;
    job.header = header_of(plan, film, job.identity, job.part.value_or(PartNumber{}));
    if (!job.journal) return;
    if (!job.journal->header()) return warn_of_removed(job.journal->begin(job.header), job.journal->path(), terminal);
    warn_of_removed(job.journal->read(film, job.results), job.journal->path(), terminal);
    terminal.note("continues from " + job.journal->path() + ": " + job.count_text() + " are finished");
}

}  // namespace kagero
