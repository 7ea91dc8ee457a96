#include "parts/journals/render_tiles.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "parts/choices.h"
#include "parts/identity.h"
#include "parts/journals/journal_writer.h"
#include "report/run_json.h"

namespace kagero {
namespace {

/// Returns the identity of a render with its part, which the identity of a picture does not contain.
Properties with_part(Properties identity, const PartNumber& part) {
    identity.emplace_back("the part", part.text());
    return identity;
}

}  // namespace

void check_same_render(const Journal& journal, const Properties& identity, const PartNumber& part) {
    const TileFileHeader& begun = *journal.header();
    const std::string difference = describe_difference(with_part(begun.identity, begun.part), journal.path(),
                                                       with_part(identity, part), "this run");
    if (!difference.empty())
        throw InputError("the journal belongs to another render: " + difference + "; render as before, or remove " +
                         journal.path() + " to begin again");
}

TileFileHeader header_of(const Plan& plan, const Film& film, Properties identity, const PartNumber& part) {
    TileFileHeader header;
    header.identity = std::move(identity);
    header.choices = choices_of(plan);
    header.metadata = plan_metadata(plan);
    header.misses_bound = misses_stated_bound(plan);
    header.layers = plan.description().film.layers;
    header.width = film.width();
    header.height = film.height();
    header.window = film.window();
    header.tone = film.tone();
    header.grid = tile_grid_of(plan, film);
    header.part = part;
    return header;
}

RunReport render_tiles(const Plan& plan, const TileFileHeader& header, Film& film, TileResults& results,
                       Journal* journal, RunControl control) {
    const std::uint64_t earlier_rays = results.totals().sums.rays;
    control.selects_tile = [&](const Tile& tile) {
        const std::uint64_t index = header.grid.index_of(tile);
        return header.part.contains(index) && !results.has(index);
    };
    std::optional<JournalWriter> writer;
    if (journal) writer.emplace(*journal, header, film);
    if (results.keeps_records())
        control.tile_film_finished = [&](const Tile& tile, TileReport tile_report, const Film& pixels) {
            const std::uint64_t index = header.grid.index_of(tile);
            std::string record(encode_tile(header, index, tile_report, pixels));
            if (writer) writer->add(record);
            results.add(index, std::move(tile_report), std::move(record));
        };
    else
        control.tile_finished = [&](const Tile& tile, TileReport tile_report) {
            const std::uint64_t index = header.grid.index_of(tile);
            if (writer) writer->add(index, tile_report);
            results.add(index, std::move(tile_report));
        };
    RunReport report = render_with_errors(plan, film, control);
    if (writer && report.interrupted) writer->sync();
    results.totals().write_to(report);
    report.earlier_rays = earlier_rays;
    return report;
}

}  // namespace kagero
