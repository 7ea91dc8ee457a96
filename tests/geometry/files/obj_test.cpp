// Tests of OBJ files that occur in the field: every file must give the stated triangles, or a refusal with a reason.
#include "tests/support/mesh_file_fixture.h"

#include <numbers>
#include <random>

namespace kagero::test {

namespace {

using ObjFile = MeshFileTest;

/// Four vertices, of which the last one is used by no face. A reader that loses one gives a different triangle.
const std::string vertices = "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 5\n";
const std::string triangle = "0 0 1, 1 0 1, 1 1 1";
const std::string face = "f 1 2 3\n";

/// The four vertices as a square, and the two triangles of the square.
const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::string halves = "0 0 0, 1 0 0, 1 1 0 | 0 0 0, 1 1 0, 0 1 0";

std::string with_line_ends(std::string text, const std::string& line_end) {
    for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += line_end.size())
        text.replace(i, 1, line_end);
    return text;
}

std::string utf16(const std::string& text, bool big_endian) {
    std::string result = big_endian ? "\xfe\xff" : "\xff\xfe";
    for (const char c : text) result += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
    return result;
}

/// Returns an OBJ file with one polygon, and a quarter of a turn about the z axis, so that the plane is x = 0.
std::string polygon(const std::vector<std::array<double, 2>>& points) {
    std::ostringstream text, corners;
    for (std::size_t i = 0; i < points.size(); ++i) {
        text << "v 0 " << points[i][0] << ' ' << points[i][1] << '\n';
        corners << ' ' << i + 1;
    }
    return text.str() + "f" + corners.str() + "\n";
}

/// Returns the area of a polygon, which is positive if it is counterclockwise.
double area_of(const std::vector<std::array<double, 2>>& points) {
    double doubled = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto &a = points[i], &b = points[(i + 1) % points.size()];
        doubled += a[0] * b[1] - a[1] * b[0];
    }
    return doubled / 2;
}

}  // namespace

TEST_F(ObjFile, ReadsUnusualText) {
    const MeshFileCase cases[] = {
        {"plain.obj", vertices + face, triangle, ""},
        {"bom.obj", "\xef\xbb\xbf" + vertices + face, triangle, ""},
        {"utf16-little.obj", utf16(vertices + face, false), triangle, ""},
        {"utf16-big.obj", utf16(vertices + face, true), triangle, ""},
        {"UPPER.OBJ", vertices + face, triangle, ""},
        {"crlf.obj", with_line_ends(vertices + face, "\r\n"), triangle, ""},
        {"cr.obj", with_line_ends(vertices + face, "\r"), triangle, ""},
        {"mixed.obj", with_line_ends("# one\n" + vertices, "\r\n") + face, triangle, ""},
        {"no-end.obj", vertices + "f 1 2 3", triangle, ""},
        {"blank.obj", "\n\n  \n" + vertices + "\t\n" + face + "\n\n", triangle, ""},
        {"tabs.obj", "v\t0\t0\t1\nv\t1  0 \t1\n\tv 1 1 1\n  v 0 1 5  \nf \t1\t2  3\t\n", triangle, ""},
        {"comment-backslash.obj", "# c:\\models\\\n" + vertices + face, triangle, ""},
        {"late-comment-backslash.obj", "v 0 0 1 # c:\\models\\\nv 1 0 1\nv 1 1 1\nv 0 1 5\n" + face, triangle, ""},
        {"comment-backslash-crlf.obj", with_line_ends("# c:\\models\\\n" + vertices + face, "\r\n"), triangle, ""},
        {"face-comment.obj", vertices + "f 1 2 3 #", triangle, ""},
        {"face-comment-close.obj", vertices + "f 1 2 3#4\n", triangle, ""},
        {"comment-of-faces.obj", vertices + "#f 1 2 4\n" + face, triangle, ""},
        {"continued-face.obj", vertices + "f 1 2 \\\n3\n", triangle, ""},
        {"continued-close.obj", vertices + "f 1 2\\\n3\n", triangle, ""},
        {"continued-crlf.obj", with_line_ends(vertices + "f 1 2 \\\n 3\n", "\r\n"), triangle, ""},
        {"continued-blank.obj", vertices + "f 1 2 \\  \n3\n", triangle, ""},
        {"continued-twice.obj", vertices + "f 1 \\\n2 \\\n3\n", triangle, ""},
        {"continued-keyword.obj", vertices + "f \\\n1 2 3\n", triangle, ""},
        {"continued-vertex.obj", "v 0 0 \\\n1\n" + vertices.substr(8) + face, triangle, ""},
        {"continued-end.obj", vertices + "f 1 2 3 \\", triangle, ""},
        {"name-backslash.obj", "mtllib c:\\models\\\n" + vertices + "usemtl a\\\n" + face, triangle, ""},
        {"continued-name.obj", "g first \\\nsecond third\n" + vertices + face, triangle, ""},
        {"latin1.obj", "o W\xfcrfel\n" + vertices + "usemtl r\xf4t\n" + face, triangle, ""},
        {"names.obj", "mtllib a b.mtl\no my thing\n" + vertices + "g\ng a b c\nusemtl\ns off\n" + face, triangle, ""},
        {"zero.obj", "# a" + std::string(1, '\0') + "b\n" + vertices + face, triangle, ""},
        {"attributes.obj", "vp 0.5\nbevel on\nlod 2\nmg 1 0.5\n" + vertices + "s 1\n" + face, triangle, ""},
        {"old-face.obj", vertices + "fo 1 2 3\n", triangle, ""},
    };
    for (const MeshFileCase& file : cases) expect(file);
}

TEST_F(ObjFile, ReadsNumbersAndIndices) {
    const std::string vt = "vt 0 0\nvt 1 0 0\nvt 1\n", vn = "vn 0 0 1\n";
    const MeshFileCase cases[] = {
        {"exponents.obj", "v 0e0 0E5 10e-1\nv 1e+0 0 1\nv .1e1 1e5 1.\n" + face, "0 0 1, 1 0 1, 1 100000 1", ""},
        {"plus.obj", "v +0 0 +1\nv +1.0 0 1\nv +1 +.5 1\nf +1 +2 +3\n", "0 0 1, 1 0 1, 1 0.5 1", ""},
        {"minus.obj", "v -.5 0 1\nv 1 -0 1\nv 1 -1. 1\n" + face, "-0.5 0 1, 1 0 1, 1 -1 1", ""},
        {"tiny.obj", "v 1e-400 0 1\nv 1 0 1\nv 1 1 1\n" + face, triangle, ""},
        {"weight.obj", "v 0 0 2 2\nv 2 0 2 2\nv 1 1 1 1\n" + face, triangle, "2 vertices have a weight w other than 1"},
        {"weight-one.obj", "v 0 0 1 1\nv 1 0 1 1.0\nv 1 1 1 1\n" + face, triangle, ""},
        {"colour.obj", "v 0 0 1 .5 .5 .5\nv 1 0 1 9 9 9\nv 1 1 1 0 0 0\n" + face, triangle, ""},
        {"negative.obj", vertices + "f -4 -3 -2\n", triangle, ""},
        {"negative-middle.obj", vertices + "f -4 -3 -2\nv 7 7 7\nv 8 8 8\n", triangle, ""},
        {"negative-parts.obj", "v 0 0 1\nv 1 0 1\nv 1 1 1\nf -3 -2 -1\nv 0 0 2\nv 1 0 2\nv 1 1 2\nf -3 -2 -1\n",
         triangle + " | 0 0 2, 1 0 2, 1 1 2", ""},
        {"before.obj", face + vertices, triangle, ""},
        {"between.obj", "v 0 0 1\nv 1 0 1\n" + face + "v 1 1 1\n", triangle, ""},
        {"v-vt.obj", vertices + vt + "f 1/1 2/2 3/3\n", triangle, ""},
        {"v-vn.obj", vertices + vn + "f 1//1 2//1 3//1\n", triangle, ""},
        {"v-vt-vn.obj", vertices + vt + vn + "f 1/1/1 2/2/1 3/3/1\n", triangle, ""},
        {"empty-slashes.obj", vertices + "f 1// 2// 3//\n", triangle, ""},
        {"one-slash.obj", vertices + vt + vn + "f 1/1/ 2/ 3/3\n", triangle, ""},
        {"negative-all.obj", vertices + vt + vn + "f -4/-3/-1 -3/-2/-1 -2/-1/-1\n", triangle, ""},
        {"normal-nan.obj", vertices + "vn nan -nan(ind) nan\nf 1//1 2//1 3//1\n", triangle, ""},
        {"square.obj", square + "f 1 2 3 4\n", halves, ""},
        {"clockwise.obj", square + "f 4 3 2 1\n", "0 0 0, 0 1 0, 1 0 0 | 0 1 0, 1 1 0, 1 0 0", ""},
        {"dart.obj", "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 1 2 3 4\n", "0 0 0, 1 1 0, 0 4 0 | 0 0 0, 4 0 0, 1 1 0",
         ""},
        {"dart-turned.obj", "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\n",
         "0 0 0, 1 1 0, 0 4 0 | 0 0 0, 4 0 0, 1 1 0", ""},
        {"line.obj", vertices + "l 1 2 3\nl 1 2\n" + face, triangle, "3 points or lines were left out"},
        {"point.obj", vertices + "p 1 2 3 4\n" + face, triangle, "4 points or lines were left out"},
        {"two-corners.obj", vertices + "f 1 2\n" + face, triangle, "1 points or lines were left out"},
        {"repeated.obj", square + "f 1 2 2 3 4\n", "0 0 0, 1 0 0, 0 1 0 | 0 1 0, 1 0 0, 1 1 0",
         "1 triangles without area were left out"},
        {"line-face.obj", "v 0 0 0\nv .1 .1 0\nv .3 .3 0\nv .7 .7 0\n" + square + "f 1 2 3 4\nf 5 6 7 8\n", halves,
         "2 triangles without area were left out"},
        {"no-corners.obj", vertices + "f\n" + face, triangle, "1 faces without vertices were left out"},
        {"twice.obj", vertices + "f 1 2 2\n" + face, triangle, "1 triangles without area were left out"},
    };
    for (const MeshFileCase& file : cases) expect(file);
}

TEST_F(ObjFile, RefusesWrongFiles) {
    const MeshFileCase cases[] = {
        {"zero.obj", vertices + "f 0 1 2\n", "",
         "zero.obj:5: OBJ: index out of range: the vertex index 0 is not legal; "
         "legal are 1 to 4 and -4 to -1"},
        {"large.obj", vertices + "f 1 2 5\n" + face, "", "large.obj:5: OBJ: index out of range: the vertex index 5"},
        {"low.obj", vertices + "f -1 -2 -5\n" + face, "", "low.obj:5: OBJ: index out of range: the vertex index -5"},
        {"early.obj", "f -1 -2 -3\n" + vertices, "", "early.obj:1: OBJ: index out of range"},
        {"huge.obj", vertices + "f 1 2 4294967299\n", "", "the vertex index 4294967299"},
        {"no-vt.obj", vertices + "f 1/1 2/1 3/1\n", "", "the texture coordinate index 1 is not legal; there are none"},
        {"no-vn.obj", vertices + "vn 0 0 1\nf 1//1 2//2 3//1\n", "", "the normal index 2"},
        {"four-slashes.obj", vertices + "f 1/1/1/1 2 3\n", "", "the corner \"1/1/1/1\" is not legal"},
        {"no-vertex.obj", vertices + "f /1 2 3\n", "", "the corner \"/1\" is not legal"},
        {"real-index.obj", vertices + "f 1.0 2 3\n", "", "the corner \"1.0\" is not legal"},
        {"junk-index.obj", vertices + "f 1 2 3x\n", "", "junk-index.obj:5: OBJ: the corner \"3x\""},
        {"nan.obj", "# nan\nv 0 nan 1\n" + face, "",
         "nan.obj:2: OBJ: vertex 0 of part \"defaultobject\" is not finite: y"},
        {"inf.obj", "o ball\nv 0 0 -inf\n" + face, "",
         "inf.obj:2: OBJ: vertex 0 of part \"ball\" is not finite: z = -inf"},
        {"large-number.obj", "v 1e999 0 0\n" + face, "", "is not finite: x = inf"},
        {"msvc-nan.obj", "v 1.#QNAN 0 0\n" + face, "", "\"v\" has 1 numbers"},
        {"junk-number.obj", "v 0 abc 0\n" + face, "", "junk-number.obj:1: OBJ: \"abc\" is not a number"},
        {"comma.obj", "v 0,5 1 0\n" + face, "", "\"0,5\" is not a number"},
        {"hexadecimal.obj", "v 0x1p3 1 0\n" + face, "", "\"0x1p3\" is not a number"},
        {"signs.obj", "v +-1 1 0\n" + face, "", "\"+-1\" is not a number"},
        {"two-numbers.obj", "v 0 0\n" + face, "", "two-numbers.obj:1: OBJ: \"v\" has 2 numbers; it needs 3 numbers"},
        {"five-numbers.obj", "v 0 0 0 1 1\n" + face, "", "\"v\" has 5 numbers"},
        {"seven-numbers.obj", "v 0 0 0 1 1 1 1\n" + face, "", "\"v\" has 7 numbers"},
        {"weight-zero.obj", "v 0 0 0 0\n" + face, "", "the weight w of vertex 0 is 0"},
        {"short-normal.obj", vertices + "vn 0 0\n" + face, "", "short-normal.obj:5: OBJ: \"vn\" has 2 numbers"},
        {"vt-nan.obj", vertices + "vt 0 nan\n" + face, "", "the texture coordinates 0 are not finite"},
        {"surface.obj", vertices + "cstype bezier\ndeg 3 3\nsurf 0 1 0 1 1 2 3 4\nend\n", "",
         "surface.obj:7: OBJ: the statement \"surf\" is not supported"},
        {"curve.obj", vertices + face + "curv 0 1 1 2 3 4\n", "", "the statement \"curv\" is not supported"},
        {"curve2.obj", vertices + face + "curv2 1 2 3\n", "", "the statement \"curv2\" is not supported"},
        {"call.obj", "call other.obj\n" + vertices + face, "", "the statement \"call\" is not supported"},
        {"capital.obj", vertices + "F 1 2 3\n", "", "capital.obj:5: OBJ: \"F\" is not a statement of OBJ files"},
        {"misspelt.obj", vertices + "usemlt red\n" + face, "", "did you mean \"usemtl\"?"},
        {"prose.obj", "This is no mesh.\n", "", "\"This\" is not a statement of OBJ files"},
        {"continued-comment.obj", vertices + "f 1 2 # \\\n3\n" + face, "", "\"3\" is not a statement"},
        {"binary.obj",
         std::string("\x7f"
                     "ELF\2\1\1\0\0",
                     9),
         "", "is not a statement of OBJ files"},
        {"only-lines.obj", vertices + "l 1 2 3 4\n", "", "has no triangle with a nonzero area"},
    };
    for (const MeshFileCase& file : cases) expect(file);
}

TEST_F(ObjFile, ReadsNormalsAndTextureCoordinatesOfCorners) {
    object_.paint.kind = Paint::Kind::checker;
    const TriangleMesh read = mesh("corners.obj", square +
                                                      "vt .25 .5\nvt .75 0\nvt 0 1\nvn 0 0 2\nvn 3 0 0\n"
                                                      "f 1/1/1 2/2/1 3/3/1\nf 1/3/2 3/3/1 4//2\n");
    ASSERT_EQ(read.triangles.size(), 6u);
    EXPECT_EQ(read.triangles[1 + 1], read.triangles[3 + 1]) << "equal corners are one vertex";
    const double uv[6][2] = {{.25, .5}, {.75, 0}, {0, 1}, {0, 1}, {0, 1}, {0, 0}};
    const Double3 normals[6] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {1, 0, 0}};
    for (std::size_t i = 0; i < 6; ++i) {
        const std::size_t corner = read.triangles[i];
        for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(read.uv[2 * corner + k], uv[i][k]) << i;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(read.normals[3 * corner + k], normals[i][k]) << i;
    }
    ASSERT_EQ(remarks_.size(), 1u);
    EXPECT_NE(remarks_[0].find("1 vertices without texture coordinates"), std::string::npos);
}

// The triangles of a polygon with n corners are n − 2, and their areas sum up to that of the polygon. If triangles
// overlapped or left the polygon, the sum would be greater.
TEST_F(ObjFile, DividesConcavePolygons) {
    const std::vector<std::vector<std::array<double, 2>>> polygons{
        {{0, 0}, {4, 0}, {4, 3}, {3, 3}, {3, 1}, {1, 1}, {1, 3}, {0, 3}},  // the letter U
        {{0, 0}, {5, 0}, {5, 5}, {0, 5}, {0, 4}, {4, 4}, {4, 1}, {1, 1}, {1, 2}, {3, 2}, {3, 3}, {0, 3}},  // a spiral
        {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}},                  // corners on edges
        {{0, 0}, {6, 0}, {6, 6}, {0, 6}, {0, 0}, {2, 2}, {2, 4}, {4, 4}, {4, 2}, {2, 2}},  // a square hole
        {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 3}, {1, 3}, {1, 1}, {0, 1}},                  // the letter T
    };
    for (const auto& points : polygons) {
        const TriangleMesh read = mesh("concave.obj", polygon(points));
        const std::vector<double> areas = areas_of(read);
        double sum = 0;
        for (const double area : areas) sum += area;
        EXPECT_NEAR(sum, area_of(points), 1e-9) << points.size();
        EXPECT_EQ(areas.size(), points.size() - 2) << points.size();
        EXPECT_TRUE(remarks_.empty()) << remarks_[0];
        for (std::size_t i = 0; i < read.triangles.size(); i += 3) {
            const Double3 a = vertex(read, read.triangles[i]);
            const Double3 normal = cross(subtract(vertex(read, read.triangles[i + 1]), a),
                                         subtract(vertex(read, read.triangles[i + 2]), a));
            EXPECT_GT(normal[0], 0) << "the orientation is that of the polygon";
        }
    }
}

TEST_F(ObjFile, DividesRandomPolygons) {
    std::mt19937 random(1);
    for (int n = 5; n < 200; n += 7) {
        std::vector<std::array<double, 2>> points;
        for (int i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * i / n, radius = 1 + double(random() % 1000) / 100;
            points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
        }
        double sum = 0;
        for (const double area : areas_of(mesh("star.obj", polygon(points)))) sum += area;
        EXPECT_NEAR(sum / area_of(points), 1, 1e-4) << n;
        EXPECT_TRUE(remarks_.empty()) << n << ' ' << remarks_[0];
    }
}

TEST_F(ObjFile, KeepsAllTrianglesOfPolygonsWhoseEdgesCross) {
    const std::vector<std::vector<std::array<double, 2>>> polygons{
        {{0, 0}, {4, 0}, {0, 3}, {3, 3}, {1, -2}},     // crosses three times
        {{0, 0}, {2, 2}, {2, 0}, {0, 2}},              // a bow tie, whose two halves cancel
        {{0, 0}, {3, 2}, {2, 0}, {0, 3}, {-1, 1}},     // a bow tie with unequal halves
        {{0, 3}, {-2, -3}, {3, 1}, {-3, 1}, {2, -3}},  // a pentagram
    };
    for (const auto& points : polygons) {
        EXPECT_EQ(mesh("crossing.obj", polygon(points)).triangles.size(), 3 * (points.size() - 2));
        ASSERT_EQ(remarks_.size(), 1u);
        EXPECT_NE(remarks_[0].find("1 faces have edges that cross"), std::string::npos) << remarks_[0];
    }
}

TEST_F(ObjFile, DividesTheLargestPolygon) {
    std::vector<std::array<double, 2>> points;
    for (int i = 0; i < 30000; ++i) {
        const double angle = 2 * std::numbers::pi * i / 30000, radius = i % 2 ? 1 : 1.01;
        points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    const auto start = std::chrono::steady_clock::now();
    EXPECT_GT(mesh("large.obj", polygon(points)).triangles.size(), 3 * 29000u);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

}  // namespace kagero::test
