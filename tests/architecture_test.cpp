// Who may look into whom: the rooms of the house, checked on the sources themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace kagero::test {
namespace {

namespace fs = std::filesystem;

struct Source {
    std::string path;  ///< from the top of the repository
    std::vector<std::string> lines;
    std::vector<std::string> includes;  ///< as written, without quotes or brackets
    std::string code;                   ///< without comments and strings
};

/// Text without comments and the contents of string literals; line ends stay.
std::string code_of(const std::string& text) {
    static const std::regex unwanted(R"rx("(?:[^"\\\n]|\\.)*"|//[^\n]*|/\*[^*]*\*+(?:[^/*][^*]*\*+)*/)rx");
    return std::regex_replace(text, unwanted, " ");
}

std::vector<Source> sources_below(const std::string& room) {
    static const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
    std::vector<Source> all;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(KAGERO_SOURCE) / room)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".h" && extension != ".cpp" && extension != ".in") continue;
        Source& source = all.emplace_back();
        source.path = fs::relative(entry.path(), KAGERO_SOURCE).generic_string();
        std::ifstream file(entry.path());
        std::string text;
        for (std::string line; std::getline(file, line); text += line + '\n') {
            std::smatch found;
            if (std::regex_search(line, found, include)) source.includes.push_back(found[1]);
            source.lines.push_back(line);
        }
        source.code = code_of(text);
    }
    std::sort(all.begin(), all.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
    EXPECT_FALSE(all.empty()) << room;
    return all;
}

/// "kernels/integrators/gauss.h" → "stepping"; "" for files that lie in no room.
std::string room_of(const std::string& path) {
    const std::size_t first = path.find('/'), second = path.find('/', first + 1);
    return second == std::string::npos ? "" : path.substr(first + 1, second - first - 1);
}

bool starts_with(const std::string& text, const std::string& start) {
    return text.rfind(start, 0) == 0;
}

/// A header and the source file of the same name: "src/plan/view".
std::string unit_of(const std::string& path) {
    return path.substr(0, path.rfind('.'));
}

/// Which units each unit includes, of the files below a room; `prefix` comes before what is written between quotes.
std::map<std::string, std::set<std::string>> include_graph(const std::string& room, const std::string& prefix) {
    std::map<std::string, std::set<std::string>> graph;
    for (const Source& source : sources_below(room)) {
        if (source.path.ends_with(".in")) continue;
        const std::string own = unit_of(source.path);
        std::set<std::string>& included = graph[own];
        for (const std::string& name : source.includes)
            if (const std::string other = unit_of(prefix + name);
                other != own && fs::exists(fs::path(KAGERO_SOURCE) / (prefix + name)))
                included.insert(other);
    }
    return graph;
}

/// The first cycle of a graph, "a > b > a", or "".
std::string cycle_in(const std::map<std::string, std::set<std::string>>& graph) {
    std::vector<std::string> path;
    std::set<std::string> done;
    const std::function<std::string(const std::string&)> visit = [&](const std::string& unit) -> std::string {
        if (std::find(path.begin(), path.end(), unit) != path.end()) {
            std::string text;
            for (auto one = std::find(path.begin(), path.end(), unit); one != path.end(); ++one) text += *one + " > ";
            return text + unit;
        }
        if (done.count(unit) || !graph.count(unit)) return "";
        path.push_back(unit);
        for (const std::string& other : graph.at(unit))
            if (const std::string cycle = visit(other); !cycle.empty()) return cycle;
        path.pop_back();
        done.insert(unit);
        return "";
    };
    for (const auto& [unit, included] : graph)
        if (const std::string cycle = visit(unit); !cycle.empty()) return cycle;
    return "";
}

/// The folder of a unit, below src or kernels: "src/report/error/error_map" → "report/error".
std::string folder_of(const std::string& path) {
    const std::size_t first = path.find('/'), last = path.rfind('/');
    return first == last ? "" : path.substr(first + 1, last - first - 1);
}

std::map<std::string, std::set<std::string>> folder_graph(const std::map<std::string, std::set<std::string>>& units) {
    std::map<std::string, std::set<std::string>> folders;
    for (const auto& [unit, included] : units)
        for (const std::string& other : included)
            if (folder_of(unit) != folder_of(other)) folders[folder_of(unit)].insert(folder_of(other));
    return folders;
}

/// From the lowest layer to the highest; includes point to the same layer or down.
const std::vector<std::string> kernel_layers{"simd",      "numeric",      "autodiff",    "hamiltonians",
                                             "equations", "observers",    "integrators", "orbits",
                                             "recipe",    "intersection", "methods",     "formula",
                                             "events",    "trace",        "adjoint",     "comparison"};
const std::vector<std::vector<std::string>> program_layers{
    {"scene", "film", "modules", "formula"}, {"geometry"}, {"appearance"}, {"plan"}, {"rays"}, {"pixels"}, {"render"}, {"accuracy"}, {"tuning"},
    {"study"}, {"stability"}, {"report"}, {"library"}, {"cli"}};

TEST(Kernels, IncludeDownwards) {
    const auto height = [&](const std::string& room) {
        return std::find(kernel_layers.begin(), kernel_layers.end(), room) - kernel_layers.begin();
    };
    for (const Source& source : sources_below("kernels")) {
        // Templates the build writes units from, and the module, join the rooms.
        if (source.path.ends_with(".cpp.in") || room_of(source.path).empty()) continue;
        EXPECT_LT(height(room_of(source.path)), std::ptrdiff_t(kernel_layers.size()))
            << source.path << " lies in a folder that is no layer";
        for (const std::string& name : source.includes) {
            if (!starts_with(name, "kernels/") || room_of(name).empty()) continue;
            EXPECT_LE(height(room_of(name)), height(room_of(source.path))) << source.path << " includes " << name;
        }
    }
}

// A header and its implementation are one: a cycle through both would tie them together as well.
TEST(Kernels, HaveNoCycles) {
    EXPECT_EQ(cycle_in(include_graph("kernels", "")), "");
}

TEST(Program, HasNoCycles) {
    const auto units = include_graph("src", "src/");
    EXPECT_GT(units.size(), 80u);
    EXPECT_EQ(cycle_in(units), "");
    EXPECT_EQ(cycle_in(folder_graph(units)), "");
}

// Verbs, the program and the image module are reached through tables and function pointers.
TEST(Program, ImplementsHeadersInFilesOfTheirNames) {
    for (const Source& source : sources_below("src")) {
        if (!source.path.ends_with(".cpp") || starts_with(source.path, "src/cli/verbs/") ||
            source.path == "src/cli/main.cpp" || starts_with(source.path, "src/film/openimageio/"))
            continue;
        ASSERT_FALSE(source.includes.empty()) << source.path;
        const std::string own = unit_of(source.path).substr(4) + ".h", name = own.substr(own.rfind('/') + 1);
        const bool is_public = source.includes.front() == "kagero/" + name && starts_with(source.path, "src/library/");
        EXPECT_TRUE(source.includes.front() == own || is_public) << source.path << " must include its own header first";
    }
}

TEST(Kernels, KnowNothingOfTheProgram) {
    for (const Source& source : sources_below("kernels"))
        for (const std::string& name : source.includes) {
            const bool own = starts_with(name, "kernels/") || name.ends_with(".inc");
            const bool plain = name.find('/') == std::string::npos && !name.ends_with(".h");  // of the standard library
            EXPECT_TRUE(own || plain || name == "rtcore.h" || name == "xsimd/xsimd.hpp" || name == "immintrin.h")
                << source.path << " includes " << name;
            for (const char* heavy : {"iostream", "ostream", "istream", "sstream", "fstream", "stdexcept", "exception",
                                      "vector", "string", "map", "memory", "functional", "thread", "mutex"})
                EXPECT_NE(name, heavy) << source.path;
        }
}

// Inner loops neither throw nor allocate; placement new into given storage is neither.
TEST(Kernels, NeitherThrowNorAllocate) {
    static const std::regex words(
        R"(\b(throw|try|catch|malloc|calloc|realloc|std::vector|std::string)\b|\bdelete\s*(\[\s*\])?\s*[A-Za-z_]|\bnew\s+[A-Za-z_])");
    for (const Source& source : sources_below("kernels")) {
        std::smatch found;
        EXPECT_FALSE(std::regex_search(source.code, found, words)) << source.path << ": " << found.str();
    }
}

TEST(Kernels, NameEachLibraryInOnePlace) {
    for (const Source& source : sources_below("kernels"))
        for (const std::string& name : source.includes) {
            EXPECT_TRUE(!starts_with(name, "xsimd") || source.path == "kernels/simd/lanes.h") << source.path;
            EXPECT_TRUE(name != "immintrin.h" || source.path == "kernels/simd/registers.h") << source.path;
            EXPECT_TRUE(!starts_with(name, "rtcore") || source.path == "kernels/intersection/segment_query.h")
                << source.path;
        }
}

// A physicist's file: no word of SIMD.
TEST(Kernels, HamiltoniansAreFormulas) {
    static const std::regex words(R"(xsimd|__m\d|\blanes?\b|\bmask|\bbatch|\bpick\b|Embree|rtc[A-Z])");
    for (const Source& source : sources_below("kernels/hamiltonians")) {
        if (!source.path.ends_with(".h")) continue;
        std::smatch found;
        EXPECT_FALSE(std::regex_search(source.code, found, words)) << source.path << ": " << found.str();
    }
}

TEST(Program, IncludesDownwards) {
    const auto height = [](const std::string& path) {
        const std::string room = path.substr(0, path.find('/'));
        for (std::size_t i = 0; i < program_layers.size(); ++i)
            if (std::count(program_layers[i].begin(), program_layers[i].end(), room)) return int(i);
        return -1;
    };
    for (const Source& source : sources_below("src")) {
        const int own = height(source.path.substr(4));
        if (source.path.find('/', 4) == std::string::npos) continue;  // src/error.h
        EXPECT_GE(own, 0) << source.path << " lies in a folder that is no layer";
        for (const std::string& name : source.includes)
            EXPECT_LE(height(name), own) << source.path << " includes " << name;
    }
}

TEST(Program, SeesOfTheKernelsTheirAbiAlone) {
    const std::set<std::string> shared{"kernels/abi.h", "kernels/assertion.h", "kernels/operation.h"};
    for (const Source& source : sources_below("src"))
        for (const std::string& name : source.includes)
            EXPECT_TRUE(!starts_with(name, "kernels/") || shared.count(name)) << source.path << " includes " << name;
}

TEST(Program, KeepsEachLibraryInItsRoom) {
    const std::vector<std::pair<const char*, const char*>> homes{
        {"OpenImageIO/", "src/film/openimageio/"},
        {"toml++/", "src/scene/toml.cpp"},
        {"assimp/", "src/geometry/mesh.cpp"},
        {"CLI/", "src/cli/"},
        {"rtcore.h", "src/geometry/"},
        {"nlohmann/", "src/report/"},
        {"nlohmann/", "src/geometry/gltf_check.cpp"},
    };
    for (const Source& source : sources_below("src"))
        for (const std::string& name : source.includes) {
            bool known = false, at_home = false;
            for (const auto& [library, home] : homes) {
                if (!starts_with(name, library)) continue;
                known = true;
                at_home = at_home || starts_with(source.path, home);
            }
            EXPECT_EQ(known, at_home) << source.path << " includes " << name;
        }
}

// A plan is a value: whoever needs another one takes a copy.
TEST(Program, TakesNoPlanToChangeIt) {
    static const std::regex reference(R"((const\s+)?\b(Plan|Scene|View|RunConfig)\s*&)");
    // The two that fill a view while it is made, for its maker alone.
    const auto is_maker = [](const Source& source) { return source.path == "src/plan/view.cpp"; };
    for (const Source& source : sources_below("src")) {
        if (is_maker(source)) continue;
        for (auto found = std::sregex_iterator(source.code.begin(), source.code.end(), reference);
             found != std::sregex_iterator(); ++found)
            EXPECT_TRUE((*found)[1].matched) << source.path << ": " << found->str();
    }
}

// Only the command line prints, and only it ends the process.
TEST(Program, PrintsAndExitsInTheCommandLineAlone) {
    static const std::regex words(
        R"(std::c(out|err|in|log)\b|\b[fv]*printf\s*\(|\bf?puts\s*\(|std::(quick_)?exit|\babort\s*\(|\b_exit\s*\()");
    for (const Source& source : sources_below("src")) {
        if (starts_with(source.path, "src/cli/")) continue;
        std::smatch found;
        EXPECT_FALSE(std::regex_search(source.code, found, words)) << source.path << ": " << found.str();
    }
}

TEST(House, HasHeadersReadOnce) {
    for (const char* room : {"kernels", "src", "tests"})
        for (const Source& source : sources_below(room))
            EXPECT_EQ(std::count(source.lines.begin(), source.lines.end(), "#pragma once"), source.path.ends_with(".h"))
                << source.path;
}

// One idea each.
TEST(House, KeepsFoldersSmall) {
    std::map<std::string, int> files;
    for (const char* room : {"kernels", "src", "tests"})
        for (const Source& source : sources_below(room)) ++files[source.path.substr(0, source.path.rfind('/'))];
    for (const auto& [folder, count] : files) EXPECT_LE(count, 21) << folder;
}

// About 300 lines, and never more than 350.
TEST(House, KeepsFilesShort) {
    for (const char* room : {"kernels", "src", "tests"})
        for (const Source& source : sources_below(room)) EXPECT_LE(source.lines.size(), 350u) << source.path;
}

// The program is made of its sources, never of a test or a benchmark.
TEST(House, IsNotBuiltOnItsTests) {
    for (const char* room : {"kernels", "src"})
        for (const Source& source : sources_below(room))
            for (const std::string& name : source.includes)
                EXPECT_FALSE(starts_with(name, "tests/") || starts_with(name, "bench/"))
                    << source.path << " includes " << name;
}

}  // namespace
}  // namespace kagero::test
