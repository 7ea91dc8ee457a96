/// Output of results to stdout, files and report directories.
#pragma once

#include "cli/arguments.h"
#include "film/write_film.h"
#include "scene/files.h"

#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// Calls `write` with stdout if `path` is "-", otherwise with a file. The file appears at `path` when it is complete.
/// Throws RunError if writing fails.
void write_output(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Writes a film and returns the seconds that this took.
double save_film(const Film& film, const std::string& path, const Metadata& metadata);

/// Returns the layers among `names` that contain numbers, for which --maps writes files; none without --maps. Throws
/// InputError if --maps is given and no layer contains numbers.
std::vector<const LayerInfo*> mapped_layers(const Arguments& arguments, const std::vector<std::string>& names);

/// Throws InputError if an output cannot be written, or if it is the same file as an input or another output. Ignores
/// paths that are empty or "-".
void check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs = {});
/// The directory of a report. The constructor creates the directory and checks its files and `--json` as check_outputs
/// does. The destructor removes the directories that the constructor created, unless they contain files.
class ReportDirectory {
public:
    ReportDirectory(const std::string& directory, const std::vector<std::string>& files, const std::string& json,
                    const std::vector<NamedFile>& inputs = {});
    ReportDirectory(const ReportDirectory&) = delete;
    ReportDirectory& operator=(const ReportDirectory&) = delete;
    ~ReportDirectory() { remove_empty(); }

private:
    void remove_empty() const;
    std::vector<std::string> created_;  ///< Directories that the constructor created, the innermost first.
};
/// Returns the directory of option -o, or by default SCENE-kind in the working directory.
std::string report_directory(const Arguments& arguments, const std::string& kind);
/// Returns the path of a file in a directory.
std::string path_in(const std::string& directory, const std::string& file);

}  // namespace kagero
