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
    int column;  ///< of its first character, from 1
};

std::vector<Field> split(std::string_view line) {
    std::vector<Field> fields;
    std::size_t begin = 0;
    while (true) {
        const std::size_t comma = std::min(line.find(',', begin), line.size());
        std::size_t first = begin, last = comma;
        while (first < last && (line[first] == ' ' || line[first] == '\t')) ++first;
        while (last > first && (line[last - 1] == ' ' || line[last - 1] == '\t')) --last;
        fields.push_back({line.substr(first, last - first), static_cast<int>(first) + 1});
        if (comma == line.size()) return fields;
        begin = comma + 1;
    }
}

/// A value as shown in a message: of bounded length, without control characters.
std::string quoted(std::string_view text) {
    constexpr std::size_t longest = 40;
    std::string shown;
    for (const char c : text.substr(0, longest)) shown += (c >= ' ' && c != '\x7f') || c < 0 ? c : '?';
    return "'" + shown + (text.size() > longest ? "…" : "") + "'";
}

double parse_number(const Field& field, Place place) {
    place.column = field.column;
    std::string_view text = field.text;
    if (text.empty()) throw InputError(place, "expected a number, found nothing");
    const bool plus = text.front() == '+' && text.size() > 1 && text[1] != '-';  // which from_chars refuses
    if (plus) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range)
        throw InputError(place, quoted(field.text) + " is beyond what a double can hold (about 1e-308 to 1e308)");
    if (error != std::errc{} || end != text.data() + text.size())
        throw InputError(place, quoted(field.text) + " is not a number");
    return value;
}

/// For each of x, y, z, dx, dy, dz its place in a row.
std::array<std::size_t, 6> parse_header(const std::vector<Field>& fields, Place place) {
    constexpr std::size_t absent = ~std::size_t{0};
    std::array<std::size_t, 6> where;
    where.fill(absent);
    for (std::size_t i = 0; i < fields.size(); ++i) {
        place.column = fields[i].column;
        std::size_t k = 0;
        while (k < column_names.size() && fields[i].text != column_names[k]) ++k;
        if (k == column_names.size())
            throw InputError(place, quoted(fields[i].text) + " is not a column of rays; the header must be " +
                                        expected_header);
        if (where[k] != absent) throw InputError(place, "the column " + quoted(fields[i].text) + " stands there twice");
        where[k] = i;
    }
    place.column = 1;
    for (std::size_t k = 0; k < where.size(); ++k)
        if (where[k] == absent)
            throw InputError(place, std::string("the column '") + column_names[k] +
                                        "' is missing; the header must be " + expected_header);
    return where;
}

RayInput parse_row(const std::vector<Field>& fields, const std::array<std::size_t, 6>& where, Place place) {
    if (fields.size() != where.size()) {
        place.column = fields.size() > where.size() ? fields[where.size()].column : fields.back().column;
        throw InputError(place, "expected 6 values, found " + std::to_string(fields.size()));
    }
    std::array<double, 6> values;
    for (std::size_t i = 0; i < fields.size(); ++i) values[i] = parse_number(fields[i], place);
    RayInput ray;
    for (std::size_t k = 0; k < 3; ++k) {
        ray.position[k] = values[where[k]];
        ray.direction[k] = values[where[k + 3]];
    }
    return ray;
}

}  // namespace

std::vector<RayInput> read_rays(std::istream& in, const std::string& name) {
    std::vector<RayInput> rays;
    std::array<std::size_t, 6> where{};
    bool header_seen = false;
    Place place{name, 0, 0};
    std::vector<char> line(10'001);  // what has no lines at all would fill the memory
    while (in.getline(line.data(), static_cast<std::streamsize>(line.size()))) {
        ++place.line;
        std::string_view text(line.data(), static_cast<std::size_t>(in.gcount()) - (in.eof() ? 0 : 1));
        if (place.line == 1 && text.starts_with("\xef\xbb\xbf"))
            text.remove_prefix(3);  // a byte order mark, as spreadsheets write
        if (text.ends_with('\r')) text.remove_suffix(1);
        if (text.find_first_not_of(" \t") == std::string_view::npos) continue;
        const std::vector<Field> fields = split(text);
        if (header_seen) {
            rays.push_back(parse_row(fields, where, place));
        } else {
            where = parse_header(fields, place);
            header_seen = true;
        }
    }
    if (in.gcount() + 1 == static_cast<std::streamsize>(line.size()))
        throw InputError(Place{name, place.line + 1, 1}, "a line of more than 10,000 characters, which is no ray's");
    if (in.bad()) throw RunError("cannot read '" + name + "' to its end");
    if (!header_seen)
        throw InputError(Place{name, 1, 1},
                         std::string("there is nothing here; the first line must be ") + expected_header);
    return rays;
}

}  // namespace kagero
