/// The journal of a render: a tile file that grows with every finished tile, so that a later run can continue.
#pragma once

#include "parts/journals/append_file.h"
#include "parts/tile_file.h"

#include <chrono>

namespace kagero {

/// A journal, which no other process can open during the lifetime of the object.
class Journal {
public:
    /// Opens the journal, or creates it. Throws InputError if another process uses it, or if the file is not a journal
    /// that this program can read, or if the environment variable KAGERO_JOURNAL_INTERVAL is not a number of seconds.
    explicit Journal(std::string path);
    /// Closes the journal. Removes it if nothing was written to it.
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    const std::string& path() const { return file_.path(); }
    /// Returns the header of the run that began the journal; nullopt if the journal is new.
    const std::optional<TileFileHeader>& header() const { return header_; }
    /// Returns the greatest time between the end of a tile and its record in the file, if the disk is fast enough:
    /// KAGERO_JOURNAL_INTERVAL, by default 1 s.
    std::chrono::duration<double> interval() const { return interval_; }
    /// Removes all bytes, and writes the header of a new journal. Returns the number of removed bytes. Throws RunError.
    std::uint64_t begin(const TileFileHeader& header);
    /// Reads all complete tiles, and removes all bytes after them. Returns the number of removed bytes. Throws
    /// RunError.
    std::uint64_t read(Film& film, TileResults& results);
    /// Appends records. Throws RunError if this fails; the journal then ends with its last complete record.
    void append(std::string_view records);
    /// Transfers the file to the disk. Throws RunError.
    void transfer();
    /// Removes the file.
    void remove();

private:
    void refuse_after(int error) const;

    std::chrono::duration<double> interval_;  ///< Read first: with a wrong variable, no file is created.
    AppendFile file_;
    std::optional<TileFileHeader> header_;
    bool removed_ = false;
};

}  // namespace kagero
