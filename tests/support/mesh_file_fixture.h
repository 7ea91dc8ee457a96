/// Support for tests of mesh files: tables of files with the triangles or the refusal that each must give.
#pragma once

#include "geometry/mesh.h"
#include "scene/vector3.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero::test {

/// A mesh file and what it must give.
struct MeshFileCase {
    std::string name;  ///< Name of the file, with the extension that selects the reader.
    std::string bytes;
    std::string triangles;  ///< Expected triangles, see triangles_of; "" if the file must be refused.
    std::string message;    ///< Part of the refusal, or of the only remark. "" means that there must be no remark.
};

/// Returns the coordinates of all triangles as sorted text: "0 0 0, 1 0 0, 0 1 0 | …". The text of a triangle begins
/// with its least corner, and keeps the orientation.
inline std::string triangles_of(const TriangleMesh& mesh) {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        std::vector<std::string> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            std::ostringstream text;
            const Double3 point = vertex(mesh, mesh.triangles[i + k]);
            text << point[0] << ' ' << point[1] << ' ' << point[2];
            corners.push_back(text.str());
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        all.push_back(corners[0] + ", " + corners[1] + ", " + corners[2]);
    }
    std::sort(all.begin(), all.end());
    std::string text;
    for (const std::string& triangle : all) text += (text.empty() ? "" : " | ") + triangle;
    return text;
}

/// Returns the area of each triangle.
inline std::vector<double> areas_of(const TriangleMesh& mesh) {
    std::vector<double> areas;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const Double3 a = vertex(mesh, mesh.triangles[i]);
        areas.push_back(0.5 * length(cross(subtract(vertex(mesh, mesh.triangles[i + 1]), a),
                                           subtract(vertex(mesh, mesh.triangles[i + 2]), a))));
    }
    return areas;
}

/// Numbers of a binary file, in either order of bytes.
class Bytes {
public:
    explicit Bytes(bool big_endian = false) : big_endian_(big_endian) {}

    template <class Number>
    Bytes& add(std::initializer_list<Number> numbers) {
        for (const Number number : numbers) {
            std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
            if (big_endian_) std::reverse(bytes.begin(), bytes.end());
            text += bytes;
        }
        return *this;
    }

    std::string text;

private:
    bool big_endian_;
};

/// Fixture that loads mesh files without any transformation.
class MeshFileTest : public SceneTest {
protected:
    TriangleMesh mesh(const std::string& name, const std::string& bytes) {
        object_.name = "thing";
        object_.shape = Shape::mesh;
        object_.file = write(name, bytes);
        object_.file_location = {"scene.toml", 7, 8};
        remarks_.clear();
        return load_mesh(object_, {0, 0, 0}, remarks_);
    }

    void expect(const MeshFileCase& expected) {
        std::string found, message;
        try {
            found = triangles_of(mesh(expected.name, expected.bytes));
            for (const std::string& remark : remarks_) message += remark + '\n';
        } catch (const InputError& error) {
            message = error.what();
            EXPECT_NE(message.find("scene.toml:7:8"), std::string::npos) << expected.name << "\n" << message;
        }
        EXPECT_EQ(found, expected.triangles) << expected.name << "\n" << message;
        if (expected.message.empty()) EXPECT_EQ(message, "") << expected.name;
        else EXPECT_NE(message.find(expected.message), std::string::npos) << expected.name << "\n" << message;
    }

    ObjectDescription object_;
    std::vector<std::string> remarks_;
};

}  // namespace kagero::test
