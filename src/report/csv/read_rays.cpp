#include "report/csv/read_rays.h"

#include <algorithm>
#include <charconv>
#include <istream>
#include <string_view>

namespace kagero {

namespace {

constexpr std::array<const char*, 6> column_names{"x", "y", "z", "dx", "dy", "dz"};
constexpr const char* expected_header = "x,y,z,dx,dy,dz";

struct Field {
    std::string_view text;
    int column;  ///< Column of the first character, counted from 1.
};

/// Splits a line at commas and removes spaces and tabs around each field, and quotes, which some programs write around
/// the names of columns.
std::vector<Field> split(std::string_view line) {
    std::vector<Field> fields;
    std::size_t begin = 0;
    while (true) {
        const std::size_t comma = std::min(line.find(',', begin), line.size());
        std::size_t first = begin, last = comma;
        while (first < last && (line[first] == ' ' || line[first] == '\t')) ++first;
        while (last > first && (line[last - 1] == ' ' || line[last - 1] == '\t')) --last;
        if (last - first > 1 && line[first] == '"' && line[last - 1] == '"') {
            ++first;
            --last;
        }
        fields.push_back({line.substr(first, last - first), static_cast<int>(first) + 1});
        if (comma == line.size()) return fields;
        begin = comma + 1;
    }
}

/// Returns a field in quotes for messages, with at most 40 characters and with control characters replaced by '?'.
std::string quoted(std::string_view text) {
    constexpr std::size_t max_length = 40;
    std::string shown;
    for (const char c : text.substr(0, max_length)) shown += (c >= ' ' && c != '\x7f') || c < 0 ? c : '?';
    return "'" + shown + (text.size() > max_length ? "…" : "") + "'";
}

double parse_number(const Field& field, FileLocation location) {
    location.column = field.column;
    std::string_view text = field.text;
    if (text.empty()) throw InputError(location, "the field is empty; expected a number");
    const bool plus = text.front() == '+' && text.size() > 1 && text[1] != '-';  // from_chars does not accept '+'.
    if (plus) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range)
        throw InputError(location, quoted(field.text) + " is out of the range of a double (about 1e-308 to 1e308)");
    if (error != std::errc{} || end != text.data() + text.size())
        throw InputError(location, quoted(field.text) + " is not a number");
    return value;
}

/// Returns the index, in each row, of the columns x, y, z, dx, dy and dz, in this order.
std::array<std::size_t, 6> parse_header(const std::vector<Field>& fields, FileLocation location) {
    constexpr std::size_t absent = ~std::size_t{0};
    std::array<std::size_t, 6> indices;
    indices.fill(absent);
    for (std::size_t i = 0; i < fields.size(); ++i) {
        location.column = fields[i].column;
        std::size_t k = 0;
        while (k < column_names.size() && fields[i].text != column_names[k]) ++k;
        if (k == column_names.size())
            throw InputError(location, quoted(fields[i].text) + " is not a known column; the header must be " +
                                           expected_header + " (in any order)");
        if (indices[k] != absent) throw InputError(location, "the column " + quoted(fields[i].text) + " occurs twice");
        indices[k] = i;
    }
    location.column = 1;
    for (std::size_t k = 0; k < indices.size(); ++k)
        if (indices[k] == absent)
            throw InputError(location, std::string("the column '") + column_names[k] +
                                           "' is missing; the header must be " + expected_header + " (in any order)");
    return indices;
}

RayInput parse_row(const std::vector<Field>& fields, const std::array<std::size_t, 6>& indices, FileLocation location) {
    if (fields.size() != indices.size()) {
        location.column = fields.size() > indices.size() ? fields[indices.size()].column : fields.back().column;
        throw InputError(location, "expected 6 values, found " + std::to_string(fields.size()));
    }
    std::array<double, 6> values;
    for (std::size_t i = 0; i < fields.size(); ++i) values[i] = parse_number(fields[i], location);
    RayInput ray;
    for (std::size_t k = 0; k < 3; ++k) {
        ray.position[k] = values[indices[k]];
        ray.direction[k] = values[indices[k + 3]];
    }
    return ray;
}

}  // namespace

std::vector<RayInput> read_rays(std::istream& in, const std::string& name) {
    std::vector<RayInput> rays;
    std::array<std::size_t, 6> indices{};
    bool header_seen = false;
    FileLocation location{name, 0, 0};
    std::vector<char> line(10'001);  // Bounds the memory for input without line breaks.
    while (in.getline(line.data(), static_cast<std::streamsize>(line.size()))) {
        ++location.line;
        std::string_view text(line.data(), static_cast<std::size_t>(in.gcount()) - (in.eof() ? 0 : 1));
        if (location.line == 1 && text.starts_with("\xef\xbb\xbf"))
            text.remove_prefix(3);  // Removes the UTF-8 byte order mark that spreadsheets write.
        if (text.ends_with('\r')) text.remove_suffix(1);
        if (text.find_first_not_of(" \t") == std::string_view::npos) continue;
        const std::vector<Field> fields = split(text);
        if (header_seen) {
            rays.push_back(parse_row(fields, indices, location));
        } else {
            indices = parse_header(fields, location);
            header_seen = true;
        }
    }
    if (in.gcount() + 1 == static_cast<std::streamsize>(line.size()))
        throw InputError(FileLocation{name, location.line + 1, 1},
                         "a line of more than 10,000 characters; expected six comma-separated numbers per line");
    if (in.bad()) throw RunError("reading '" + name + "' failed before its end");
    if (!header_seen)
        throw InputError(FileLocation{name, 1, 1},
                         std::string("the input is empty; the first line must be the header ") + expected_header);
    return rays;
}

}  // namespace kagero
