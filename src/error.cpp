#include "error.h"

#include <algorithm>

namespace kagero {

namespace {

/// Returns "file:line:column: message", without the parts that are unknown.
std::string located(const FileLocation& location, const std::string& message) {
    std::string text = location.file;
    if (location.line > 0) {
        text += ':' + std::to_string(location.line);
        if (location.column > 0) text += ':' + std::to_string(location.column);
    }
    return text.empty() ? message : text + ": " + message;
}

}  // namespace

InputError::InputError(const FileLocation& at, const std::string& message)
    : std::runtime_error(located(at, message)), location(at) {}

std::size_t edit_distance(const std::string& a, const std::string& b) {
    // Rows i−2, i−1 and i of the table of distances between the first i letters of a and the first j letters of b.
    std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before.swap(last);
        last.swap(row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
        }
    }
    return row[b.size()];
}

std::string near_match(const std::string& word, const std::vector<std::string>& known) {
    std::string nearest;
    // A single letter has distance 1 from every other letter, so it has no near match.
    std::size_t upper_bound = word.size() < 2 ? 1 : std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const std::string& name : known) {
        std::size_t distance = edit_distance(word, name);
        if (word.size() > 1 && distance > 0 && name.starts_with(word)) --distance;  // ends are most often left out
        if (distance < upper_bound) {
            upper_bound = distance;
            nearest = name;
        }
    }
    return nearest;
}

void append_to_list(std::string& list, const std::string& next) {
    list += (list.empty() ? "" : ", ") + next;
}

}  // namespace kagero
