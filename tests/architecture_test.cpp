// Rules for the structure of the sources: layers, includes, and the folders that may use each library.
#include "tests/support/sources.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace kagero::test {
namespace {

namespace fs = std::filesystem;

/// Returns the folder directly below src or kernels: "integrators" for "kernels/integrators/gauss.h"; "" if the file is
/// not in such a folder.
std::string layer_of(const std::string& path) {
    const std::size_t first = path.find('/'), second = path.find('/', first + 1);
    return second == std::string::npos ? "" : path.substr(first + 1, second - first - 1);
}

/// Returns the path without its extension, which identifies a unit: a header and its implementation.
std::string unit_of(const std::string& path) {
    return path.substr(0, path.rfind('.'));
}

/// Returns the units that each unit below a folder includes. `prefix` is the path from the root of the repository to
/// the folder that the includes are relative to.
std::map<std::string, std::set<std::string>> include_graph(const std::string& folder, const std::string& prefix) {
    std::map<std::string, std::set<std::string>> graph;
    for (const Source& source : sources_below(folder)) {
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

/// Returns the first cycle that is found in a graph, as "a > b > a", or "" if the graph has no cycle.
std::string cycle_in(const std::map<std::string, std::set<std::string>>& graph) {
    std::vector<std::string> path;
    std::set<std::string> done;
    const std::function<std::string(const std::string&)> visit = [&](const std::string& unit) -> std::string {
        if (std::find(path.begin(), path.end(), unit) != path.end()) {
            std::string text;
            for (auto u = std::find(path.begin(), path.end(), unit); u != path.end(); ++u) text += *u + " > ";
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

/// Returns the path of a unit's folder relative to src or kernels: "report/error" for "src/report/error/error_map".
std::string folder_of(const std::string& path) {
    const std::size_t first = path.find('/'), last = path.rfind('/');
    return first == last ? "" : path.substr(first + 1, last - first - 1);
}

/// Returns the folders that each folder includes, from the graph of units.
std::map<std::string, std::set<std::string>> folder_graph(const std::map<std::string, std::set<std::string>>& units) {
    std::map<std::string, std::set<std::string>> folders;
    for (const auto& [unit, included] : units)
        for (const std::string& other : included)
            if (folder_of(unit) != folder_of(other)) folders[folder_of(unit)].insert(folder_of(other));
    return folders;
}

/// The layers from the lowest to the highest. A layer of kernels/ is one folder; a layer of src/ can consist of several
/// folders. A file may include files of its own layer and of lower layers.
const std::vector<std::string> kernel_layers{
    "simd",        "numeric",     "shading",         "autodiff",     "hamiltonians", "equations", "observers",
    "integrators", "orbits",      "recipe",          "intersection", "methods",      "formula",   "events",
    "trace",       "interaction", "lane_parameters", "adjoint",      "comparison"};
const std::vector<std::vector<std::string>> program_layers{{"scene", "animation", "film", "modules", "formula",
                                                            "compiler"},
                                                           {"geometry"},
                                                           {"media"},
                                                           {"spaces"},
                                                           {"appearance"},
                                                           {"plan"},
                                                           {"rays"},
                                                           {"paths"},
                                                           {"adaptive"},
                                                           {"pixels"},
                                                           {"render"},
                                                           {"sweep"},
                                                           {"accuracy"},
                                                           {"tuning"},
                                                           {"study"},
                                                           {"stability"},
                                                           {"report"},
                                                           {"parts"},
                                                           {"frames"},
                                                           {"ranks"},
                                                           {"library"},
                                                           {"python"},
                                                           {"view"},
                                                           {"cli"}};

TEST(Kernels, IncludeDownwards) {
    const auto height = [&](const std::string& folder) {
        return std::find(kernel_layers.begin(), kernel_layers.end(), folder) - kernel_layers.begin();
    };
    for (const Source& source : sources_below("kernels")) {
        // Files directly in kernels/, and the templates of generated sources, may include every folder.
        if (source.path.ends_with(".cpp.in") || layer_of(source.path).empty()) continue;
        EXPECT_LT(height(layer_of(source.path)), std::ptrdiff_t(kernel_layers.size()))
            << source.path << " is in a folder that is not listed as a layer";
        for (const std::string& name : source.includes) {
            if (!starts_with(name, "kernels/") || layer_of(name).empty()) continue;
            EXPECT_LE(height(layer_of(name)), height(layer_of(source.path))) << source.path << " includes " << name;
        }
    }
}

// A header and its implementation count as one unit, so that a cycle through both is found.
TEST(Kernels, HaveNoCycles) {
    EXPECT_EQ(cycle_in(include_graph("kernels", "")), "");
}

TEST(Program, HasNoCycles) {
    const auto units = include_graph("src", "src/");
    EXPECT_GT(units.size(), 80u);
    EXPECT_EQ(cycle_in(units), "");
    EXPECT_EQ(cycle_in(folder_graph(units)), "");
}

// Some files have no header of the same name: verbs and the modules for images, MPI and the web are called through
// tables. The files main.cpp and module.cpp only contain the entry points.
TEST(Program, ImplementsHeadersInFilesOfTheirNames) {
    for (const Source& source : sources_below("src")) {
        if (!source.path.ends_with(".cpp") || starts_with(source.path, "src/cli/verbs/") ||
            source.path == "src/cli/main.cpp" || source.path == "src/python/module.cpp" ||
            starts_with(source.path, "src/view/http/") || starts_with(source.path, "src/ranks/mpi/") ||
            (starts_with(source.path, "src/film/") && source.path.ends_with("/module.cpp")) ||
            source.path == "src/compiler/asmjit/module.cpp")
            continue;
        ASSERT_FALSE(source.includes.empty()) << source.path;
        const std::string own = unit_of(source.path).substr(4) + ".h", name = own.substr(own.rfind('/') + 1);
        const bool is_public =
            source.includes.front() == "kagero/" + name && starts_with(source.path, "src/library/");
        EXPECT_TRUE(source.includes.front() == own || is_public) << source.path << " must include its own header first";
    }
}

TEST(Kernels, IncludeNothingOfTheProgram) {
    for (const Source& source : sources_below("kernels"))
        for (const std::string& name : source.includes) {
            const bool own = starts_with(name, "kernels/") || name.ends_with(".inc");
            const bool standard = name.find('/') == std::string::npos && !name.ends_with(".h");
            EXPECT_TRUE(own || standard || name == "rtcore.h" || name == "xsimd/xsimd.hpp" || name == "immintrin.h")
                << source.path << " includes " << name;
            for (const char* costly : {"iostream", "ostream", "istream", "sstream", "fstream", "stdexcept", "exception",
                                       "vector", "string", "map", "memory", "functional", "thread", "mutex"})
                EXPECT_NE(name, costly) << source.path;
        }
}

// Inner loops neither throw nor allocate. Placement new into given storage is allowed.
TEST(Kernels, NeitherThrowNorAllocate) {
    static const std::regex words(
        R"(\b(throw|try|catch|malloc|calloc|realloc|std::vector|std::string)\b)"
        R"(|\bdelete\s*(\[\s*\])?\s*[A-Za-z_]|\bnew\s+[A-Za-z_])");
    for (const Source& source : sources_below("kernels")) {
        std::smatch found;
        EXPECT_FALSE(std::regex_search(source.code, found, words)) << source.path << ": " << found.str();
    }
}

TEST(Kernels, IncludeEachLibraryInOneFile) {
    for (const Source& source : sources_below("kernels"))
        for (const std::string& name : source.includes) {
            EXPECT_TRUE(!starts_with(name, "xsimd") || source.path == "kernels/simd/lanes.h") << source.path;
            EXPECT_TRUE(name != "immintrin.h" || source.path == "kernels/simd/registers.h") << source.path;
            EXPECT_TRUE(!starts_with(name, "rtcore") || source.path == "kernels/intersection/segment_query.h" ||
                        source.path == "kernels/intersection/query_context.h")
                << source.path;
        }
}

TEST(Kernels, WriteHamiltoniansWithoutSimdTerms) {
    static const std::regex words(R"(xsimd|__m\d|\blanes?\b|\bmask|\bbatch|\bselect\b|Embree|rtc[A-Z])");
    for (const Source& source : sources_below("kernels/hamiltonians")) {
        if (!source.path.ends_with(".h")) continue;
        std::smatch found;
        EXPECT_FALSE(std::regex_search(source.code, found, words)) << source.path << ": " << found.str();
    }
}

TEST(Program, IncludesDownwards) {
    const auto height = [](const std::string& path) {
        const std::string folder = path.substr(0, path.find('/'));
        for (std::size_t i = 0; i < program_layers.size(); ++i)
            if (std::count(program_layers[i].begin(), program_layers[i].end(), folder)) return int(i);
        return -1;
    };
    for (const Source& source : sources_below("src")) {
        const int own = height(source.path.substr(4));
        if (source.path.find('/', 4) == std::string::npos) continue;  // src/error.h
        EXPECT_GE(own, 0) << source.path << " is in a folder that is not listed as a layer";
        for (const std::string& name : source.includes)
            EXPECT_LE(height(name), own) << source.path << " includes " << name;
    }
}

// src/ and kernels/ share only the binary interfaces of the modules, assertions, the list of operations of formulas,
// and the data that a query passes to the callbacks of Embree.
TEST(Program, IncludesOnlySharedHeadersOfTheKernels) {
    const std::set<std::string> shared{"kernels/abi.h", "kernels/assertion.h", "kernels/operation.h",
                                       "kernels/code_generation.h", "kernels/shading_cell.h",
                                       "kernels/intersection/query_context.h"};
    for (const Source& source : sources_below("src"))
        for (const std::string& name : source.includes)
            EXPECT_TRUE(!starts_with(name, "kernels/") || shared.count(name)) << source.path << " includes " << name;
}

TEST(Program, UsesEachLibraryInOneFolder) {
    const std::vector<std::pair<const char*, const char*>> folders{
        {"OpenImageIO/", "src/film/openimageio/"},
        {"Imf", "src/film/openexr/"},
        {"png.h", "src/film/libpng/"},
        {"mpi.h", "src/ranks/mpi/"},
        {"asmjit/", "src/compiler/asmjit/"},
        {"toml++/", "src/scene/toml.cpp"},
        {"CLI/", "src/cli/"},
        {"rtcore.h", "src/geometry/"},
        {"nlohmann/", "src/report/"},
        {"nlohmann/", "src/geometry/files/gltf/"},
        {"pybind11/", "src/python/"},
        {"boost/beast/", "src/view/http/"},
        {"boost/asio/", "src/view/http/"},
    };
    for (const Source& source : sources_below("src"))
        for (const std::string& name : source.includes) {
            bool is_library = false, in_folder = false;
            for (const auto& [library, folder] : folders) {
                if (!starts_with(name, library)) continue;
                is_library = true;
                in_folder = in_folder || starts_with(source.path, folder);
            }
            EXPECT_EQ(is_library, in_folder) << source.path << " includes " << name;
        }
}

// Plans are values: a function that needs a different plan works on a copy.
TEST(Program, TakesPlansByConstReference) {
    static const std::regex reference(R"((const\s+)?\b(Plan|Scene|View|RunConfig)\s*&)");
    // view.cpp constructs a view with functions that fill parts of it.
    for (const Source& source : sources_below("src")) {
        if (source.path == "src/plan/view.cpp") continue;
        for (auto found = std::sregex_iterator(source.code.begin(), source.code.end(), reference);
             found != std::sregex_iterator(); ++found)
            EXPECT_TRUE((*found)[1].matched) << source.path << ": " << found->str();
    }
}

TEST(Program, PrintsAndExitsOnlyInTheCommandLine) {
    static const std::regex words(
        R"(std::c(out|err|in|log)\b|\b[fv]*printf\s*\(|\bf?puts\s*\(|std::(quick_)?exit|\babort\s*\(|\b_exit\s*\()");
    for (const Source& source : sources_below("src")) {
        if (starts_with(source.path, "src/cli/")) continue;
        std::smatch found;
        EXPECT_FALSE(std::regex_search(source.code, found, words)) << source.path << ": " << found.str();
    }
}

TEST(Sources, GuardTheirHeaders) {
    for (const char* folder : {"kernels", "src", "tests"})
        for (const Source& source : sources_below(folder))
            EXPECT_EQ(std::count(source.lines.begin(), source.lines.end(), "#pragma once"), source.path.ends_with(".h"))
                << source.path;
}

TEST(Sources, HaveAtMost21FilesPerFolder) {
    std::map<std::string, int> files;
    for (const char* folder : {"kernels", "src", "tests"})
        for (const Source& source : sources_below(folder)) ++files[source.path.substr(0, source.path.rfind('/'))];
    for (const auto& [folder, count] : files) EXPECT_LE(count, 21) << folder;
}

TEST(Sources, HaveAtMost350Lines) {
    for (const char* folder : {"kernels", "src", "tests"})
        for (const Source& source : sources_below(folder)) EXPECT_LE(source.lines.size(), 350u) << source.path;
}

TEST(Sources, IncludeNoTestsOrBenchmarks) {
    for (const char* folder : {"kernels", "src"})
        for (const Source& source : sources_below(folder))
            for (const std::string& name : source.includes)
                EXPECT_FALSE(starts_with(name, "tests/") || starts_with(name, "bench/"))
                    << source.path << " includes " << name;
}

}  // namespace
}  // namespace kagero::test
