/// Renders with --part and --resume.
#pragma once

#include "cli/terminal.h"
#include "parts/journals/render_tiles.h"
#include "ranks/communicator.h"

namespace kagero {

/// Adds --part and --resume.
void add_tile_options(CLI::App& verb, Arguments& arguments);

/// Returns the value of --part; nullopt if it is not given. Throws InputError.
std::optional<PartNumber> part_of(const Arguments& arguments);

/// Returns the path of the journal of an output; empty without --resume.
std::string journal_path(const Arguments& arguments, const std::string& output);

/// A render that keeps its tiles: a part of a picture, a picture with a journal, or one of several ranks.
struct TileJob {
    std::optional<PartNumber> part;  ///< The value of --part.
    std::optional<Journal> journal;  ///< Open with --resume.
    Communicator* ranks = nullptr;   ///< The ranks of --mpi; null without it.
    Properties identity;
    TileFileHeader header;
    TileResults results;  ///< The only place of the pixels of a part.

    explicit TileJob(std::optional<PartNumber> number)
        : part(number), results(number ? TileResults::Records::kept : TileResults::Records::dropped) {}
    /// Returns true if one of --part, --resume and --mpi is given.
    bool is_used() const { return part || journal || ranks; }
    /// Returns, for example, "3 of 12 tiles".
    std::string count_text() const;
};

/// Returns the plan of a picture. It has the choices of the journal if there is one, and otherwise those of
/// tune_with_progress. Throws InputError if the journal belongs to another render.
Plan plan_of(TileJob& job, SceneDescription scene, const Options& options, const Terminal& terminal);

/// Reads the finished tiles of the journal to the film, or begins a new journal.
void begin_tiles(TileJob& job, const Plan& plan, Film& film, const Terminal& terminal);

}  // namespace kagero
