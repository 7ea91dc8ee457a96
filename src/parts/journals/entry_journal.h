/// The journal of a run that consists of named entries, such as the cases of `stability`.
#pragma once

#include "parts/journals/append_file.h"
#include "parts/tile_file.h"
#include "report/json.h"

#include <map>

namespace kagero {

/// A text file that grows with every finished entry. Each line consists of the checksum of the rest of the line as 16
/// hexadecimal digits, a blank, and JSON. The first line states the identity of the run, and each other line an entry.
class EntryJournal {
public:
    /// Opens the journal, or creates it, and reads its entries. Removes bytes after the last complete line. Throws
    /// InputError if another process uses the journal, if the file is not such a journal, or if it belongs to a run
    /// with another identity.
    EntryJournal(std::string path, const Properties& identity);

    const std::string& path() const { return file_.path(); }
    /// Returns the entry with this name, or nullptr.
    const Json* find(const std::string& name) const;
    /// Returns all entries by their names.
    const std::map<std::string, Json>& entries() const { return entries_; }
    /// Appends an entry and transfers the file to the disk. Throws RunError if writing fails.
    void append(const std::string& name, const Json& entry);
    /// Removes the file.
    void remove();

private:
    void read(const Properties& identity);
    void write_line(const Json& json);

    AppendFile file_;
    std::map<std::string, Json> entries_;
};

}  // namespace kagero
