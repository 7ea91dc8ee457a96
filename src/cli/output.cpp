#include "cli/output.h"

#include "error.h"
#include "film/partial_file.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>

namespace kagero {

namespace fs = std::filesystem;

namespace {

bool is_file(const NamedFile& file) { return !file.second.empty() && file.second != "-"; }

/// Returns true if both paths name the same regular file. If one of them does not exist yet, compares the paths.
bool is_same_file(const std::string& a, const std::string& b) {
    std::error_code ignored;
    if (fs::exists(a, ignored) && fs::exists(b, ignored))
        return fs::is_regular_file(a, ignored) && fs::equivalent(a, b, ignored);
    return fs::weakly_canonical(fs::absolute(a), ignored) == fs::weakly_canonical(fs::absolute(b), ignored);
}

}  // namespace

void check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
    for (auto output = outputs.begin(); output != outputs.end(); ++output) {
        if (!is_file(*output)) continue;
        check_file_writable(output->second);
        const auto refuse_same = [&](const NamedFile& other) {
            if (is_file(other) && is_same_file(output->second, other.second))
                throw InputError(output->first + " and " + other.first + " are the same file, '" + output->second +
                                 "'; choose another output file");
        };
        std::for_each(inputs.begin(), inputs.end(), refuse_same);
        std::for_each(output + 1, outputs.end(), refuse_same);
    }
}

void write_output(const std::string& path, const std::function<void(std::ostream&)>& write) {
    if (path == "-") {
        write(std::cout);
        if (!std::cout.flush()) throw RunError("writing the result to stdout failed");
        return;
    }
    write_file(path, write);
}

double save_film(const Film& film, const std::string& path, const Metadata& metadata) {
    const auto begin = std::chrono::steady_clock::now();
    write_film(film, path, metadata);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<const LayerInfo*> mapped_layers(const Arguments& arguments, const std::vector<std::string>& names) {
    std::vector<const LayerInfo*> mapped;
    if (!arguments.maps) return mapped;
    for (const LayerInfo& layer : all_layers())
        if (layer.channels.size() == 1 && std::find(names.begin(), names.end(), layer.name) != names.end())
            mapped.push_back(&layer);
    if (mapped.empty())
        throw InputError(
            "--maps: film.layers contains no layer of numbers; add one with --layers, or leave --maps out "
            "(see `kagero list layers`)");
    return mapped;
}

std::string path_in(const std::string& directory, const std::string& file) {
    return (fs::path(directory) / file).string();
}

std::string report_directory(const Arguments& arguments, const std::string& kind) {
    return arguments.output.empty() ? fs::path(arguments.scene).stem().string() + "-" + kind : arguments.output;
}

ReportDirectory::ReportDirectory(const std::string& directory, const std::vector<std::string>& files,
                                 const std::string& json, const std::vector<NamedFile>& inputs) {
    std::error_code failure, ignored;
    for (fs::path path = directory; !path.empty() && !fs::exists(path, ignored); path = path.parent_path())
        created_.push_back(path.string());
    fs::create_directories(directory, failure);
    if (failure || !fs::is_directory(directory))
        throw InputError("cannot create the directory '" + directory + "'" +
                         (failure ? ": " + failure.message() : ": a file has this name"));
    std::vector<NamedFile> outputs{{"--json", json}};
    for (const std::string& file : files) outputs.emplace_back(file + " of the report", path_in(directory, file));
    try {
        check_outputs(outputs, inputs);
    } catch (const InputError&) {
        remove_empty();
        throw;
    }
}

void ReportDirectory::remove_empty() const {
    std::error_code ignored;
    for (const std::string& path : created_) fs::remove(path, ignored);
}

}  // namespace kagero
