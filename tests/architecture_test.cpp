// Who may look into whom: the rooms of the house, checked on the sources themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
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

TEST(Kernels, IncludeDownwards) {
    const std::vector<std::string> order{"numeric", "hamiltonians", "stepping", "formula", "tracing"};
    const auto height = [&](const std::string& room) { return std::find(order.begin(), order.end(), room) - order.begin(); };
    for (const Source& source : sources_below("kernels")) {
        // Templates the build writes units from, and the module, join the rooms.
        if (source.path.ends_with(".cpp.in") || room_of(source.path).empty()) continue;
        for (const std::string& name : source.includes) {
            if (!starts_with(name, "kernels/") || name == "kernels/abi.h") continue;
            EXPECT_LE(height(room_of(name)), height(room_of(source.path))) << source.path << " includes " << name;
        }
    }
}

TEST(Kernels, KnowNothingOfTheProgram) {
    for (const Source& source : sources_below("kernels"))
        for (const std::string& name : source.includes) {
            const bool own = starts_with(name, "kernels/") || name.ends_with(".inc");
            const bool plain = name.find('/') == std::string::npos && !name.ends_with(".h");  // of the standard library
            EXPECT_TRUE(own || plain || name == "rtcore.h" || name == "xsimd/xsimd.hpp" || name == "immintrin.h") << source.path << " includes " << name;
            for (const char* heavy : {"iostream", "ostream", "istream", "sstream", "fstream", "stdexcept", "exception", "vector",
                                      "string", "map", "memory", "functional", "thread", "mutex"})
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
            EXPECT_TRUE(!starts_with(name, "rtcore") || source.path == "kernels/intersection/segment_query.h") << source.path;
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
    const std::map<std::string, std::vector<std::string>> may_see{
        {"film", {"film", "modules"}},
        {"modules", {"modules"}},
        {"formula", {"formula"}},
        {"scene", {"scene", "film", "formula"}},  // film: reading images
        {"render", {"render", "scene", "film", "modules", "formula"}},
        {"stability", {"stability", "render", "scene", "film", "modules", "formula"}},
        {"report", {"report", "stability", "render", "scene", "film", "modules", "formula"}},
        {"cli", {"cli", "report", "stability", "render", "scene", "film", "modules", "formula"}},
    };
    for (const Source& source : sources_below("src")) {
        const std::string room = room_of(source.path);
        for (const std::string& name : source.includes) {
            const std::size_t slash = name.find('/');
            const std::string other = name.substr(0, slash);
            if (slash == std::string::npos || !may_see.count(other)) continue;
            ASSERT_TRUE(may_see.count(room)) << source.path << " includes " << name;
            const auto& seen = may_see.at(room);
            EXPECT_NE(std::find(seen.begin(), seen.end(), other), seen.end()) << source.path << " includes " << name;
        }
    }
}

TEST(Program, SeesOfTheKernelsTheirAbiAlone) {
    for (const Source& source : sources_below("src"))
        for (const std::string& name : source.includes)
            EXPECT_TRUE(!starts_with(name, "kernels/") || name == "kernels/abi.h") << source.path << " includes " << name;
}

TEST(Program, KeepsEachLibraryInItsRoom) {
    const std::vector<std::pair<const char*, const char*>> homes{
        {"OpenImageIO/", "src/film/openimageio/"}, {"toml++/", "src/scene/toml.cpp"}, {"assimp/", "src/geometry/mesh.cpp"},
        {"CLI/", "src/cli/"}, {"rtcore.h", "src/scene/"}, {"nlohmann/", "src/report/"}, {"nlohmann/", "src/geometry/gltf_check.cpp"},
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

// Only the command line prints, and only it ends the process.
TEST(Program, PrintsAndExitsInTheCommandLineAlone) {
    static const std::regex words(R"(std::c(out|err|in|log)\b|\b[fv]*printf\s*\(|\bf?puts\s*\(|std::(quick_)?exit|\babort\s*\(|\b_exit\s*\()");
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
                EXPECT_FALSE(starts_with(name, "tests/") || starts_with(name, "bench/")) << source.path << " includes " << name;
}

}  // namespace
}  // namespace kagero::test
