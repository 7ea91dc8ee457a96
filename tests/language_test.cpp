// Tests of the English of comments, messages and pages, and of the layout of sources.
#include "tests/support/sources.h"

#include <gtest/gtest.h>

#include <cctype>
#include <map>
#include <set>

namespace kagero::test {
namespace {

namespace fs = std::filesystem;

/// A comment, a message or a paragraph of a page.
struct Prose {
    std::string path;
    std::size_t line;
    std::string text;
};

bool is_program_text(const fs::path& path) {
    return path.extension() == ".h" || path.extension() == ".cpp" || path.extension() == ".in";
}

/// Returns the text files of the repository, without the corpora of fuzz targets and the data of scenes.
std::vector<fs::path> files() {
    std::vector<fs::path> all;
    for (const char* folder : {"src", "kernels", "include", "tests", "bench", "cmake", "docs", "scenes", ".ci"})
        for (const auto& entry : fs::recursive_directory_iterator(fs::path(KAGERO_SOURCE) / folder))
            if (entry.is_regular_file()) all.push_back(entry.path());
    for (const char* name : {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CMakeLists.txt"})
        all.push_back(fs::path(KAGERO_SOURCE) / name);
    const std::set<std::string> text{".h", ".cpp", ".in", ".md", ".py", ".cmake", ".txt", ".toml", ""};
    std::erase_if(all, [&](const fs::path& path) {
        const std::string generic = path.generic_string();
        return !text.contains(path.extension().string()) || generic.find("/fuzz/") != std::string::npos ||
               generic.find("/scenes/data/") != std::string::npos || generic.find("__pycache__") != std::string::npos;
    });
    std::sort(all.begin(), all.end());
    return all;
}

std::string repository_path(const fs::path& path) { return fs::relative(path, KAGERO_SOURCE).generic_string(); }

std::string trimmed(const std::string& text) {
    constexpr const char* space = " \t\r\n";
    const std::size_t first = text.find_first_not_of(space);
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(space) - first + 1);
}

/// Returns the comments of C++ text, with consecutive lines joined, and its string literals that contain a space.
std::vector<Prose> prose_of_program(const std::string& path, const std::string& text) {
    std::vector<Prose> all;
    std::size_t last_line = 0;
    for (const Fragment& fragment : fragments_of(text)) {
        if (fragment.kind == Fragment::Kind::code) continue;
        if (fragment.kind == Fragment::Kind::literal) {
            if (fragment.text.find(' ') != std::string::npos)
                all.push_back({path, fragment.line, fragment.text.substr(1)});
            last_line = 0;
            continue;
        }
        static const std::regex mark("^/[/*]+<?");
        const std::string comment = trimmed(std::regex_replace(fragment.text, mark, ""));
        if (last_line != 0 && fragment.line == last_line + 1) all.back().text += " " + comment;
        else all.push_back({path, fragment.line, comment});
        last_line = comment.empty() ? 0 : fragment.line;
    }
    return all;
}

/// Returns the comments that begin with #, with consecutive lines joined.
std::vector<Prose> prose_of_script(const std::string& path, const std::string& text) {
    std::vector<Prose> all;
    std::size_t number = 0, last = 0;
    for (const std::string& line : lines_of(text)) {
        ++number;
        static const std::regex comment(R"(^\s*#+!?\s?(.*)$)");
        std::smatch found;
        if (!std::regex_match(line, found, comment)) continue;
        if (last != 0 && number == last + 1) all.back().text += " " + found[1].str();
        else all.push_back({path, number, found[1]});
        last = trimmed(found[1]).empty() ? 0 : number;
    }
    return all;
}

/// Returns the paragraphs, headings and table rows of a page, without the contents of fenced blocks.
std::vector<Prose> prose_of_page(const std::string& path, const std::string& text) {
    std::vector<Prose> all;
    bool fenced = false, in_paragraph = false;
    std::size_t number = 0;
    for (const std::string& line : lines_of(text)) {
        ++number;
        if (starts_with(line, "```")) fenced = !fenced;
        const std::string words = trimmed(line);
        const bool is_single_line = starts_with(words, "|") || starts_with(words, "#") || starts_with(words, "- ") ||
                                    starts_with(words, "<");
        if (fenced || words.empty() || starts_with(line, "```")) in_paragraph = false;
        else if (in_paragraph && !is_single_line) all.back().text += " " + words;
        else {
            all.push_back({path, number, words});
            in_paragraph = !starts_with(words, "|") && !starts_with(words, "#");
        }
    }
    return all;
}

/// Returns the prose of all files.
std::vector<Prose> prose() {
    std::vector<Prose> all;
    for (const fs::path& file : files()) {
        const std::string text = read_text(file), path = repository_path(file);
        const auto found = is_program_text(file)          ? prose_of_program(path, text)
                           : file.extension() == ".md" ? prose_of_page(path, text)
                                                       : prose_of_script(path, text);
        all.insert(all.end(), found.begin(), found.end());
    }
    EXPECT_GT(all.size(), 5000u);
    return all;
}

/// Expects that no prose contains a pattern, except in the exempt files. The failure message contains `why`.
void expect_absent(const std::string& pattern, const std::string& why, const std::set<std::string>& exempt = {}) {
    const std::regex expression(pattern);
    for (const Prose& p : prose())
        if (std::smatch found; !exempt.contains(p.path) && std::regex_search(p.text, found, expression))
            ADD_FAILURE() << p.path << ":" << p.line << ": \"" << trimmed(found.str()) << "\": " << why;
}

// This file contains the forbidden patterns themselves.
const std::set<std::string> this_file{"tests/language_test.cpp"};

TEST(Language, SentencesBeginWithTheirSubject) {
    expect_absent(R"((^|[.:;?!|] +)(Of|Who|Whom|Whose) [a-z]+)", "name the subject first", this_file);
}

TEST(Language, SentencesAreComplete) {
    expect_absent(R"(^…|[a-z,;] …($| *\|)|[a-z],? …\s*$)", "complete the sentence instead of continuing it elsewhere",
                  this_file);
}

TEST(Language, UsesNoVerbsOfSpeechOrThoughtForPrograms) {
    expect_absent(R"(\b([Tt]ell|[Tt]ells|[Tt]old|[Aa]sk|[Aa]sks|[Aa]sked|[Aa]sking)\b)"
                  R"(|\b(knows|knew|wants|wanted by|nobody|whoever)\b)",
                  "say what the program does: return, store, report, read, query", this_file);
}

// Sentences should have at most about 25 words. The limit is higher, because names and lists are counted too.
TEST(Language, SentencesAreShort) {
    static const std::regex word(R"([A-Za-z][A-Za-z'-]+)"), end(R"([.:;?!] |\|)");
    for (const Prose& p : prose()) {
        if (this_file.contains(p.path) || p.path == "tests/support/sources.h") continue;
        for (auto s = std::sregex_token_iterator(p.text.begin(), p.text.end(), end, -1);
             s != std::sregex_token_iterator(); ++s) {
            const std::string sentence = *s;
            const auto words =
                std::distance(std::sregex_iterator(sentence.begin(), sentence.end(), word), std::sregex_iterator());
            EXPECT_LE(words, 45) << p.path << ":" << p.line << ": " << sentence;
        }
    }
}

/// Returns the number of characters of UTF-8 text.
std::size_t columns(const std::string& line) {
    return static_cast<std::size_t>(std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

TEST(Language, LinesHaveAtMost120Columns) {
    for (const fs::path& file : files()) {
        std::size_t number = 0;
        bool fenced = false;
        for (const std::string& line : lines_of(read_text(file))) {
            ++number;
            const bool page = file.extension() == ".md";
            if (starts_with(line, "```")) fenced = !fenced;
            // Rows of tables, commands, their output, addresses, and lines with a SHA-256 sum cannot be broken.
            static const std::regex checksum("^[0-9a-f]{64} ");
            const bool exempt = (page && (fenced || starts_with(line, "|") || starts_with(line, "<"))) ||
                                line.find("://") != std::string::npos || (page && starts_with(line, "![")) ||
                                std::regex_search(line, checksum);
            if (exempt) continue;
            EXPECT_LE(columns(line), 120u) << repository_path(file) << ":" << number;
        }
    }
}

// `a = 1, b = 2;` are two statements in one.
TEST(Language, StatementsAreNotChainedByCommas) {
    static const std::regex chain(
        R"((?:^|[;{}]|\)|\belse\b)\s*)"
        R"([A-Za-z_][\w.]*(?:->\w+|\[[^\]]*\]|\.\w+)*\s*[-+*/|&]?=(?!=)[^;,(){}<>]*,\s*)"
        R"([A-Za-z_][\w.]*(?:->\w+|\[[^\]]*\]|\.\w+)*\s*[-+*/|&]?=(?!=)[^;(){}]*;)");
    for (const char* folder : {"src", "kernels", "tests", "bench", "include"})
        for (const Source& source : sources_below(folder))
            if (std::smatch found; std::regex_search(source.code, found, chain))
                ADD_FAILURE() << source.path << ": " << found.str();
}

// These identifiers are jargon: docs/glossary.md contains the terms that replace them.
TEST(Language, UsesTheTermsOfTheGlossary) {
    static const std::set<std::string> jargon{
        "Survey",    "Waypoint",      "Leg",          "Arrival",  "Passage",  "Encounter", "Landing",   "creased",
        "far_side",  "flow_of_rest",  "Master",       "Sighting", "PlanAs",   "torn",      "mul_add",   "make_harmless",
        "no_pace",   "not_landed",    "landing_ticks", "Halt",    "FewDouble", "ManyDouble", "pilot",   "pick",
        "written_again"};
    static const std::regex word(R"(\b[A-Za-z_]+\b)");
    for (const char* folder : {"src", "kernels", "tests", "bench", "include"})
        for (const Source& source : sources_below(folder)) {
            for (auto w = std::sregex_iterator(source.code.begin(), source.code.end(), word);
                 w != std::sregex_iterator(); ++w)
                if (jargon.contains(w->str())) ADD_FAILURE() << source.path << ": " << w->str();
        }
}

}  // namespace
}  // namespace kagero::test
