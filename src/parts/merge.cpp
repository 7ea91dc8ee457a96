#include "parts/merge.h"

#include "error.h"
#include "parts/identity.h"
#include "report/run_json.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>

namespace kagero {
namespace {

constexpr const char* render_again = "; render the part again, or use --incomplete for what is available";

std::ifstream open_part(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError("cannot read the part '" + path + "': " + std::strerror(errno));
    return in;
}

/// Throws InputError unless two parts belong to the same picture.
void check_same_picture(const TileFileHeader& a, const std::string& a_path, const TileFileHeader& b,
                        const std::string& b_path) {
    std::string difference = describe_difference(a.identity, a_path, b.identity, b_path);
    if (difference.empty()) difference = describe_difference(a.choices, a_path, b.choices, b_path);
    if (difference.empty()) difference = describe_difference(a.metadata, a_path, b.metadata, b_path);
    if (difference.empty() && a.part.count != b.part.count)
        difference = a_path + " is part " + a.part.text() + ", but " + b_path + " is part " + b.part.text();
    if (!difference.empty())
        throw InputError("these are not parts of the same picture: " + difference +
                         "; render all parts with the same scene, options and program");
}

std::vector<std::uint32_t> missing_numbers(const std::map<std::uint32_t, std::string>& paths, std::uint32_t count) {
    std::vector<std::uint32_t> missing;
    for (std::uint32_t number = 1; number <= count; ++number)
        if (!paths.contains(number)) missing.push_back(number);
    return missing;
}

/// Returns the numbers as a list in a sentence, at most the first twenty.
std::string list_of(const std::vector<std::uint32_t>& numbers) {
    constexpr std::size_t longest = 20;
    std::string list;
    for (std::size_t i = 0; i < numbers.size() && i < longest; ++i) append_to_list(list, std::to_string(numbers[i]));
    return numbers.size() > longest ? list + " and " + std::to_string(numbers.size() - longest) + " more" : list;
}

std::string describe_missing(const std::vector<std::uint32_t>& numbers, std::uint32_t count) {
    return (numbers.size() == 1 ? "part " : "parts ") + list_of(numbers) + " of " + std::to_string(count) +
           (numbers.size() == 1 ? " is missing" : " are missing");
}

/// The parts that were found, by number, and the header of the first one.
struct FoundParts {
    TileFileHeader header;
    std::map<std::uint32_t, std::string> paths;
    std::vector<std::string> remarks;  ///< Files without a complete header.
};

void add_part(FoundParts& found, const TileFileHeader& header, const std::string& path) {
    if (found.paths.empty()) found.header = header;
    else check_same_picture(found.header, found.paths.at(found.header.part.number), header, path);
    const auto [earlier, is_new] = found.paths.emplace(header.part.number, path);
    if (!is_new)
        throw InputError("part " + header.part.text() + " is given twice: " + earlier->second + " and " + path +
                         "; name each part once");
}

FoundParts find_parts(const std::vector<std::string>& files, Missing missing) {
    FoundParts found;
    for (const std::string& path : files) {
        std::ifstream in = open_part(path);
        if (const auto header = read_header(in, path)) {
            add_part(found, *header, path);
            continue;
        }
        const std::string remark = path + " is incomplete: it ends within its header";
        if (missing == Missing::refused) throw InputError(remark + render_again);
        found.remarks.push_back(remark);
    }
    if (found.paths.empty()) throw InputError(found.remarks.front() + ", and no other part was given");
    return found;
}

/// Reads the tiles of a part. Returns a remark about missing tiles, or throws it as an InputError.
std::string read_part(const std::string& path, Missing missing, Film& film, TileResults& results) {
    std::ifstream in = open_part(path);
    const TileFileHeader header = read_header(in, path).value();
    const std::uint64_t before = results.count(), expected = header.part.tiles_of(header.grid);
    const TilesRead read = read_tiles(in, header, film, results);
    if (read.end == TileFileEnd::complete) return "";
    const std::uint64_t count = results.count() - before;
    const bool is_damaged = read.end == TileFileEnd::damaged;
    std::string remark = path + " is " +
                         (is_damaged ? "damaged after byte " + std::to_string(read.valid_bytes) : "incomplete") +
                         ": it contains only " + std::to_string(count) + " of " + std::to_string(expected) + " tiles";
    if (missing == Missing::refused) throw InputError(remark + render_again);
    return remark;
}

}  // namespace

Metadata MergedPicture::metadata() const {
    Metadata all = header.metadata;
    const Metadata of_run = run_metadata(report);
    all.insert(all.end(), of_run.begin(), of_run.end());
    return all;
}

TileFileHeader check_parts(const std::vector<std::string>& files, Missing missing) {
    const FoundParts found = find_parts(files, missing);
    const std::uint32_t count = found.header.part.count;
    const std::vector<std::uint32_t> absent = missing_numbers(found.paths, count);
    if (missing == Missing::refused && !absent.empty())
        throw InputError(describe_missing(absent, count) +
                         "; name the files of all parts, or use --incomplete for what is available");
    return found.header;
}

MergedPicture merge_parts(const std::vector<std::string>& files, Missing missing) {
    const TileFileHeader first = check_parts(files, missing);
    const FoundParts found = find_parts(files, missing);
    MergedPicture picture{first, first.film(), {}, {}, 0, found.remarks};
    TileResults results;
    picture.missing_parts = missing_numbers(found.paths, first.part.count);
    if (!picture.missing_parts.empty())
        picture.remarks.push_back(describe_missing(picture.missing_parts, first.part.count));
    for (const auto& [number, path] : found.paths)
        if (std::string remark = read_part(path, missing, picture.film, results); !remark.empty())
            picture.remarks.push_back(std::move(remark));
    picture.missing_tiles = first.grid.count() - results.count();
    results.totals().write_to(picture.report);
    picture.report.interrupted = picture.missing_tiles > 0;
    return picture;
}

}  // namespace kagero
