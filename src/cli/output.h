/// Where results go: stdout, files, and directories of reports.
#pragma once

#include "cli/arguments.h"
#include "film/write_film.h"

#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// Calls `write` with stdout for "-", else with a file that appears when it is complete. Throws RunError when not all
/// could be written.
void write_output(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Writes a film, and says how many seconds that took.
double save_film(const Film& film, const std::string& path, const Metadata& metadata);

/// A file, and what messages call it: "--json", "the texture of object.floor".
using NamedFile = std::pair<std::string, std::string>;
/// The files that a scene comes from: its own, images and meshes.
std::vector<NamedFile> files_of(const SceneDescription& scene);
/// Throws InputError when one of the outputs cannot be written, or is the same file as another of them, or as an input.
/// Empty and "-" are none.
void check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs = {});
/// Makes the directory of a report of these files, which stays empty until they are written, and checks them as
/// check_outputs does, and `--json` with them. At its end what it made is taken away again, if nothing was written.
class ReportDirectory {
public:
    ReportDirectory(const std::string& directory, const std::vector<std::string>& files, const std::string& json,
                    const std::vector<NamedFile>& inputs = {});
    ReportDirectory(const ReportDirectory&) = delete;
    ReportDirectory& operator=(const ReportDirectory&) = delete;
    ~ReportDirectory() { remove_empty(); }

private:
    void remove_empty() const;
    std::vector<std::string> made_;  ///< the innermost first
};
/// The directory that -o names, or SCENE-kind here.
std::string report_directory(const Arguments& arguments, const std::string& kind);
std::string path_in(const std::string& directory, const std::string& file);

}  // namespace kagero
