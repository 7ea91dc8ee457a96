// Tests of docs/reference/scene.md, the reference of scene files. It must document exactly the keys that the loader
// accepts, with their ranges, names and defaults.
#include "plan/plan.h"
#include "scene/load/load.h"
#include "scene/print.h"
#include "scene/toml.h"
#include "scene/value.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace kagero::test {
namespace {

using Names = std::set<std::string>;

/// A scene with a medium and one object of each shape. The name of an object is its shape. Keys with a default are left
/// out.
constexpr const char* every_shape =
    R"([space]
hamiltonian = "wormhole"
[[medium]]
name = "glass"
hamiltonian = "uniform"
[camera]
position = [0, 0, 9]
look_at = [0, 0, 0]
[film]
size = [4, 4]
[[object]]
name = "rectangle"
shape = "rectangle"
origin = [2, 2, 2]
edge_u = [1, 0, 0]
edge_v = [0, 1, 0]
[[object]]
name = "box"
shape = "box"
min = [3, 3, 3]
max = [4, 4, 4]
)"
    R"([[object]]
name = "room"
shape = "room"
min = [-20, -20, -20]
max = [20, 20, 20]
[[object]]
name = "sphere"
shape = "sphere"
center = [5, 5, 5]
radius = 1
[[object]]
name = "mesh"
shape = "mesh"
file = "meshes/pavement.obj"
[[object]]
name = "disk"
shape = "disk"
center = [0, 0, 0]
inner = 4
outer = 5
)";

/// A table of scene files, for one kind of scene.
struct Table {
    std::string path;                   ///< Path of the table, as in -D.
    std::vector<Override> kind;         ///< Overrides that change `every_shape` to that kind of scene.
    std::vector<std::string> headings;  ///< Texts in headings of the reference above the keys of the table.
    Names absent;                       ///< Documented keys that this kind of scene does not have.
    Names declared;                     ///< Keys that the space declares; `kagero list` documents them.
};

std::vector<Table> tables() {
    const std::vector<Override> boundary{"object.sphere.material=boundary", "object.sphere.interior=glass"},
        diffuse{"object.sphere.material=diffuse"};
    std::vector<Table> all{
        {"space", {}, {"`[space]`"}, {}, {"throat"}},
        {"space", {"space.hamiltonian=formula", "space.H=px^2"}, {"`[space]`", "`hamiltonian = \"formula\"`"}, {}, {}},
        {"integrator", {}, {"`[integrator]`"}, {}, {}},
        {"medium.glass", {}, {"`[[medium]]`"}, {}, {"n0"}},
        {"medium.glass",
         {"medium.glass.hamiltonian=formula", "medium.glass.H=px^2"},
         {"`[[medium]]`", "`hamiltonian = \"formula\"`"},
         {"far_domain"},
         {}},
        {"medium.glass.integrator", {}, {"`[integrator]`"}, {}, {}},
        {"camera", {}, {"`[camera]`"}, {"height"}, {}},
        {"camera", boundary, {"`[camera]`"}, {"height"}, {}},
        {"film", boundary, {"`[film]`"}, {}, {}},
        {"object.disk", boundary, {"`[[object]]`", "`shape = \"disk\"`"}, {}, {}},
        {"object.sphere", boundary, {"`[[object]]`", "`shape = \"sphere\"`"}, {}, {}},
        {"object.sphere", diffuse, {"`[[object]]`", "`shape = \"sphere\"`"}, {}, {}},
        {"camera", {"camera.type=orthographic"}, {"`[camera]`"}, {}, {}},
        {"film", {}, {"`[film]`"}, {}, {}},
        {"sky", {}, {"`[sky]`"}, {}, {}},
        {"sky.far", {}, {"`[sky]`"}, {"far"}, {}},
        {"object.box.faces", {}, {"`[object.faces]`"}, {}, {}},
        {"animation", {"animation.frames=10"}, {"`[animation]`"}, {}, {}},
    };
    for (const std::string& shape : shape_names())
        all.push_back({"object." + shape, {}, {"`[[object]]`", "`shape = \"" + shape + "\"`"}, {}, {}});
    return all;
}

/// A row of the reference, which documents one key.
struct Row {
    std::string heading, key, legal, default_value;
};

std::vector<std::string> cells_of(std::string line) {
    line = std::regex_replace(line, std::regex(R"(\\\|)"), "/");
    std::vector<std::string> cells;
    std::istringstream text(line.substr(1));
    for (std::string cell; std::getline(text, cell, '|');)
        cells.push_back(std::regex_replace(cell, std::regex("^ +| +$"), ""));
    return cells;
}

/// The headings and rows of the reference.
struct Reference {
    std::vector<std::string> headings;
    std::vector<Row> rows;

    Reference() {
        std::ifstream file(KAGERO_SOURCE "/docs/reference/scene.md");
        bool in_code = false, in_key_table = false;
        for (std::string line; std::getline(file, line);) {
            if (line.starts_with("```")) in_code = !in_code;
            if (in_code) continue;
            if (line.starts_with('#')) headings.push_back(line);
            const auto cells = line.starts_with('|') ? cells_of(line) : std::vector<std::string>{};
            in_key_table = cells.size() == 5 && (in_key_table || cells[0] == "key");
            if (in_key_table && cells[0].starts_with('`'))
                rows.push_back({headings.back(), cells[0].substr(1, cells[0].size() - 2), cells[2], cells[3]});
        }
    }
};

/// Returns true if the row documents a key of the table.
bool has(const Table& table, const Row& row) {
    const auto above = [&](const std::string& heading) { return row.heading.find(heading) != std::string::npos; };
    return !table.absent.contains(row.key) && std::any_of(table.headings.begin(), table.headings.end(), above);
}

SceneDescription load(const std::vector<Override>& overrides) {
    static const Catalogue known = catalogue("auto");
    return load_scene_text(every_shape, KAGERO_SCENES "/every-shape.toml", overrides, known);
}

/// Returns the message of the loader for a value of a key, or "" if the value is accepted.
std::string refusal(const Table& table, const std::string& key, const std::string& value) {
    std::vector<Override> overrides = table.kind;
    overrides.emplace_back((table.path.empty() ? "" : table.path + '.') + key + '=' + value);
    try {
        load(overrides);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// Returns the text after the last `word` of a message, or "" if the message does not contain it.
std::string text_after(const std::string& word, const std::string& message) {
    const std::size_t at = message.rfind(word);
    return at == std::string::npos ? "" : message.substr(at + word.size());
}

/// Returns the legal names in the message that the loader prints for an illegal name.
Names actual_names(const std::string& message) {
    Names names;
    std::istringstream text(text_after("legal names: ", message));
    for (std::string name; std::getline(text >> std::ws, name, ',');) names.insert(name);
    return names;
}

/// Returns a range with its numbers in the format of the program.
std::string normalized(const std::string& range) {
    std::istringstream text(range);
    std::string result;
    for (std::string word; text >> word;) {
        char* end = nullptr;
        const double number = std::strtod(word.c_str(), &end);
        result += (result.empty() ? "" : " ") + (*end ? word : to_toml(number));
    }
    return result;
}

/// Returns the legal range of a number, or of the numbers of an array or table, from the message of the loader for a
/// number that is out of range. Returns "" if all finite numbers are legal.
std::string actual_range(const Table& table, const std::string& key) {
    for (const std::string number : {"9000000000000000000", "1e305"})
        for (const std::string& value :
             {number, '[' + number + ", 1]", '[' + number + ", 1, 1]", "{ a = " + number + " }"}) {
            const std::string range = text_after("legal range is ", refusal(table, key, value));
            if (!range.empty()) return normalized(range);
        }
    return "";
}

/// Returns the legal range in a row of the reference, or "" if the row has none.
std::string documented_range(const Row& row) {
    std::smatch found;
    const bool has_range = std::regex_search(row.legal, found, std::regex("`([^`]*\\bvalue\\b[^`]*)`"));
    return has_range ? normalized(found[1]) : "";
}

/// Returns the value of a key of a printed scene, or null if the scene does not contain it.
const Value* printed(const Value& scene, const std::string& path, const std::string& key) {
    const Value* table = &scene;
    std::istringstream names(path + '.' + key);
    for (std::string name; table && std::getline(names, name, '.');) {
        const Value* next = table->kind == Value::Kind::array ? nullptr : find(*table, name);
        for (const Value& item : table->items)
            if (table->kind == Value::Kind::array && find(item, "name")->string == name) next = &item;
        table = next;
    }
    return table;
}

TEST(SceneReference, DocumentsEveryTable) {
    const Reference reference;
    Names documented;
    for (const std::string& heading : reference.headings) {
        std::smatch found;
        if (std::regex_match(heading, found, std::regex(R"(## `\[+(\w+)\]+`)"))) documented.insert(found[1]);
    }
    EXPECT_EQ(documented, actual_names(refusal({}, "zzzzzz", "1")));
}

TEST(SceneReference, DocumentsEveryKeyAndNoOther) {
    const Reference reference;
    const std::vector<Table> all = tables();
    for (const Table& table : all) {
        Names documented = table.declared;
        for (const Row& row : reference.rows)
            if (has(table, row)) documented.insert(row.key);
        EXPECT_EQ(documented, actual_names(refusal(table, "zzzzzz", "1"))) << table.path;
    }
    for (const Row& row : reference.rows)
        EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Table& table) { return has(table, row); }))
            << row.heading << ": " << row.key;
}

TEST(SceneReference, DocumentsTheLegalRanges) {
    const Reference reference;
    for (const Table& table : tables())
        for (const Row& row : reference.rows) {
            if (!has(table, row)) continue;
            EXPECT_EQ(documented_range(row), actual_range(table, row.key)) << table.path << '.' << row.key;
        }
}

TEST(SceneReference, DocumentsTheLegalNames) {
    const Reference reference;
    const std::regex word("`\"([^`\"]+)\"`");
    for (const Table& table : tables())
        for (const Row& row : reference.rows) {
            if (!has(table, row) || !row.legal.starts_with("`\"")) continue;
            Names documented;
            for (std::sregex_iterator at(row.legal.begin(), row.legal.end(), word), end; at != end; ++at)
                documented.insert((*at)[1]);
            EXPECT_EQ(documented, actual_names(refusal(table, row.key, "zzzzzz"))) << table.path << '.' << row.key;
        }
}

TEST(SceneReference, DocumentsTheDefaults) {
    const Reference reference;
    Names documented, compared;
    for (const Table& table : tables()) {
        // Keys that the method does not use are printed as comments.
        const std::string text = std::regex_replace(print_scene(load(table.kind)), std::regex("\n# "), "\n");
        const Value scene = parse_toml(text, "printed");
        for (const Row& row : reference.rows) {
            std::smatch found;
            const std::string name = table.path + '.' + row.key;
            const auto sets = [&](const Override& one) { return one.text.starts_with(name + '='); };
            if (!has(table, row) || std::any_of(table.kind.begin(), table.kind.end(), sets)) continue;
            if (!std::regex_match(row.default_value, found, std::regex("`([^`]+)`"))) continue;
            documented.insert(row.heading + ": " + row.key);
            const Value* value = printed(scene, table.path, row.key);
            if (!value) continue;
            compared.insert(row.heading + ": " + row.key);
            EXPECT_EQ(to_toml(parse_toml_value(found[1], {})), to_toml(*value)) << name;
        }
    }
    EXPECT_GT(documented.size(), 20u);
    EXPECT_EQ(documented, compared);
}

}  // namespace
}  // namespace kagero::test
