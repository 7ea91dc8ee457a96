/// Reads the C++ files of the repository, for tests that check the structure and the language of the sources.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace kagero::test {

/// A C++ file of the repository.
struct Source {
    std::string path;  ///< relative to the root of the repository
    std::vector<std::string> lines;
    std::vector<std::string> includes;  ///< as written, without quotes or brackets
    std::string code;                   ///< without comments and without the contents of string literals
};

inline bool starts_with(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

/// A part of C++ text: code, a comment, or a string or character literal.
struct Fragment {
    enum class Kind { code, comment, literal } kind;
    std::string text;
    std::size_t line;  ///< number of the line that contains the first character, from 1
};

/// Splits C++ text into fragments, in the order of the text.
inline std::vector<Fragment> fragments_of(const std::string& text) {
    std::vector<Fragment> all;
    std::size_t begin = 0, i = 0, line = 1;
    const auto add = [&](Fragment::Kind kind, std::size_t end) {
        if (end > begin) all.push_back({kind, text.substr(begin, end - begin), line});
        const auto first = text.begin() + std::ptrdiff_t(begin), last = text.begin() + std::ptrdiff_t(end);
        line += static_cast<std::size_t>(std::count(first, last, '\n'));
        begin = i = end;
    };
    const auto end_of = [&](const std::string& mark, std::size_t from) {
        const std::size_t found = text.find(mark, from);
        return found == std::string::npos ? text.size() : found + mark.size();
    };
    const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    while (i < text.size()) {
        if (text.compare(i, 2, "//") == 0) {
            add(Fragment::Kind::code, i);
            add(Fragment::Kind::comment, std::min(text.find('\n', i), text.size()));
        } else if (text.compare(i, 2, "/*") == 0) {
            add(Fragment::Kind::code, i);
            add(Fragment::Kind::comment, end_of("*/", i + 2));
        } else if (text.compare(i, 2, "R\"") == 0 && (i == 0 || !is_word(text[i - 1]))) {
            add(Fragment::Kind::code, i);
            const std::size_t open = std::min(text.find('(', i), text.size());
            add(Fragment::Kind::literal, end_of(")" + text.substr(i + 2, open - i - 2) + "\"", open));
        } else if (text[i] == '"' || (text[i] == '\'' && (i == 0 || !is_word(text[i - 1])))) {
            const char quote = text[i];
            add(Fragment::Kind::code, i);
            std::size_t end = i + 1;
            while (end < text.size() && text[end] != quote && text[end] != '\n') end += text[end] == '\\' ? 2 : 1;
            add(Fragment::Kind::literal, std::min(end + 1, text.size()));
        } else {
            ++i;
        }
    }
    add(Fragment::Kind::code, text.size());
    return all;
}

inline std::string read_text(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

inline std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

inline std::size_t count_line_ends(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Returns the text without comments and without the contents of string literals. Line ends are preserved.
inline std::string code_of(const std::string& text) {
    std::string code;
    for (const Fragment& fragment : fragments_of(text)) {
        if (fragment.kind == Fragment::Kind::code) code += fragment.text;
        else code += " " + std::string(count_line_ends(fragment.text), '\n');
    }
    return code;
}

/// Returns the C++ files below a folder of the repository, sorted by path.
inline std::vector<Source> sources_below(const std::string& folder) {
    namespace fs = std::filesystem;
    static const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
    std::vector<Source> all;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(KAGERO_SOURCE) / folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".h" && extension != ".cpp" && extension != ".in") continue;
        Source& source = all.emplace_back();
        source.path = fs::relative(entry.path(), KAGERO_SOURCE).generic_string();
        const std::string text = read_text(entry.path());
        source.lines = lines_of(text);
        source.code = code_of(text);
        for (const std::string& line : source.lines)
            if (std::smatch found; std::regex_search(line, found, include)) source.includes.push_back(found[1]);
    }
    std::sort(all.begin(), all.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
    EXPECT_FALSE(all.empty()) << folder;
    return all;
}

}  // namespace kagero::test
