#include "cli/verb.h"
#include "error.h"
#include "film/partial_file.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace kagero {

namespace fs = std::filesystem;

void check_output(const std::string& path) {
    if (!path.empty() && path != "-") check_file_writable(path);
}

void check_distinct(const std::vector<std::pair<std::string, std::string>>& files) {
    const auto same = [](const std::string& a, const std::string& b) {
        std::error_code ignored;
        return fs::weakly_canonical(fs::absolute(a), ignored) == fs::weakly_canonical(fs::absolute(b), ignored) && (!fs::exists(a, ignored) || fs::is_regular_file(a, ignored));
    };
    for (auto a = files.begin(); a != files.end(); ++a)
        for (auto b = a + 1; b != files.end(); ++b) {
            if (a->second.empty() || b->second.empty() || a->second == "-" || b->second == "-" || !same(a->second, b->second)) continue;
            throw InputError(a->first + " and " + b->first + " name the same file, '" + b->second + "'");
        }
}

void write_output(const std::string& path, const std::function<void(std::ostream&)>& write) {
    if (path == "-") {
        write(std::cout);
        if (!std::cout.flush()) throw RunError("cannot write all of the result to stdout");
        return;
    }
    PartialFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    write(out);
    out.close();
    if (!out) throw RunError("cannot write '" + path + "': is the disk full?");
    file.complete();
}

double write_picture(const Film& film, const std::string& path, const Metadata& metadata) {
    const auto begin = std::chrono::steady_clock::now();
    write_film(film, path, metadata);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::string path_in(const std::string& directory, const std::string& file) {
    return (fs::path(directory) / file).string();
}

std::string report_directory(const Arguments& arguments, const std::string& kind) {
    return arguments.output.empty() ? fs::path(arguments.scene).stem().string() + "-" + kind : arguments.output;
}

void make_report_directory(const std::string& directory, const std::vector<std::string>& files) {
    std::error_code failure;
    fs::create_directories(directory, failure);
    if (failure || !fs::is_directory(directory))
        throw InputError("cannot make the directory '" + directory + "'" +
                         (failure ? ": " + failure.message() : "; a file bears its name"));
    for (const std::string& file : files) check_output(path_in(directory, file));
}

}  // namespace kagero
