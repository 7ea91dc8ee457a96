// Tests of mesh files from the field, those of the Debian package assimp-testmodels. The area and the bounds of each
// mesh are compared with those that assimp finds: cases/field.csv was computed from the STL files that `assimp export
// FILE o.stl -fstlb -tri -ptv` (assimp 5.2.5) writes. Every other file is refused with a reason.
#include "error.h"
#include "geometry/mesh.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace kagero::test {
namespace {

const std::filesystem::path models = "/usr/share/assimp/models";

TriangleMesh read_mesh(const std::filesystem::path& file) {
    ObjectDescription object;
    object.file = file.string();
    std::vector<std::string> remarks;
    return load_mesh(object, {0, 0, 0}, remarks);
}

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream text(line);
    for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
    return fields;
}

struct Measures {
    double area = 0;
    Double3 least{1e300, 1e300, 1e300}, greatest{-1e300, -1e300, -1e300};
};
Measures measures_of(const TriangleMesh& mesh) {
    Measures measures;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
        Double3 corner[3];
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                corner[i][k] = mesh.vertices[3 * mesh.triangles[t + i] + k];
                measures.least[k] = std::min(measures.least[k], corner[i][k]);
                measures.greatest[k] = std::max(measures.greatest[k], corner[i][k]);
            }
        measures.area += 0.5 * length(cross(subtract(corner[1], corner[0]), subtract(corner[2], corner[0])));
    }
    return measures;
}

TEST(FieldFiles, HaveTheAreaAndTheBoundsThatAssimpFinds) {
    std::ifstream table(KAGERO_SOURCE "/tests/geometry/files/cases/field.csv");
    std::string line;
    std::getline(table, line);
    int count = 0;
    while (std::getline(table, line)) {
        const auto columns = fields_of(line);
        ASSERT_EQ(columns.size(), 8u) << line;
        SCOPED_TRACE(columns[0]);
        if (!std::filesystem::exists(models / columns[0])) continue;  // the package of this Debian does not have it
        ++count;
        const Measures found = measures_of(read_mesh(models / columns[0]));
        const double area = std::stod(columns[1]), size = std::sqrt(area);
        EXPECT_NEAR(found.area, area, 1e-4 * area);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(found.least[k], std::stod(columns[2 + k]), 1e-5 * size);
            EXPECT_NEAR(found.greatest[k], std::stod(columns[5 + k]), 1e-5 * size);
        }
    }
    EXPECT_GE(count, 40);
}

TEST(FieldFiles, AreReadOrRefusedWithAReason) {
    int read = 0, refused = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(models)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".obj" && extension != ".ply" && extension != ".gltf" && extension != ".glb") continue;
        SCOPED_TRACE(entry.path());
        try {
            EXPECT_GT(measures_of(read_mesh(entry.path())).area, 0);
            ++read;
        } catch (const InputError& error) {
            EXPECT_GT(std::string(error.what()).size(), 20u);
            ++refused;
        }
    }
    EXPECT_GE(read, 45);
    EXPECT_GE(refused, 30);
}

}  // namespace
}  // namespace kagero::test
