// Tests of PLY files that occur in the field: every file must give the stated triangles, or a refusal with a reason.
#include "tests/support/mesh_file_fixture.h"

#include <sys/resource.h>

namespace kagero::test {

namespace {

using PlyFile = MeshFileTest;

const std::string start = "ply\nformat ascii 1.0\n", xyz = "property float x\nproperty float y\nproperty float z\n",
                  four = "element vertex 4\n" + xyz, list = "property list uchar int vertex_indices\n",
                  one = "element face 1\n" + list, end = "end_header\n";

/// Four vertices, of which the last one is used by no face.
const std::string points = "0 0 1\n1 0 1\n1 1 1\n0 1 5\n";
const std::string triangle = "0 0 1, 1 0 1, 1 1 1";
const std::string header = start + four + one + end;

std::string replaced(std::string text, const std::string& old, const std::string& by) {
    for (std::size_t i = 0; (i = text.find(old, i)) != std::string::npos; i += by.size())
        text.replace(i, old.size(), by);
    return text;
}

std::string strips(const std::string& lists, int count = 1, const std::string& type = "int") {
    return start + "element vertex 6\n" + xyz + "element tristrips " + std::to_string(count) + "\nproperty list int " +
           type + " vertex_indices\n" + end + "0 0 1\n0 1 1\n1 0 1\n1 1 1\n2 0 1\n2 1 1\n" + lists;
}

/// The triangles of the strip 0 1 2 3.
const std::string two_of_strip = "0 0 1, 0 1 1, 1 0 1 | 0 1 1, 1 1 1, 1 0 1";

/// Returns a binary file. All types of numbers occur, in elements and lists before, between and after those that count.
std::string binary(bool big_endian, const std::string& line_end = "\n") {
    const std::string text =
        std::string("ply\nformat binary_") + (big_endian ? "big" : "little") + "_endian 1.0\n" +
        "comment made by hand\nobj_info source: none\n"
        "element first 2\nproperty list ushort double stuff\nproperty char c\nproperty list int8 int16 more\n"
        "element vertex 4\nproperty uchar red\nproperty double z\nproperty list uint8 float32 weights\n"
        "property short x\nproperty uint y\n"
        "element face 2\nproperty float64 quality\nproperty list uint uint16 vertex_index\nproperty int32 flags\n"
        "element last 1\nproperty list uint32 uint32 many\nend_header\n";
    Bytes data(big_endian);
    for (int i = 0; i < 2; ++i) {
        data.add<std::uint16_t>({2}).add<double>({1.5, -2}).add<std::int8_t>({-1, 3});
        data.add<std::int16_t>({-1, 2, 300});
    }
    const double z[] = {1, 1, 1, 5};
    const std::int16_t x[] = {0, 1, 1, 0};
    const std::uint32_t y[] = {0, 0, 1, 1};
    for (std::size_t i = 0; i < 4; ++i) {
        data.add<std::uint8_t>({255}).add<double>({z[i]}).add<std::uint8_t>({static_cast<std::uint8_t>(i % 2)});
        if (i % 2) data.add<float>({0.5f});
        data.add<std::int16_t>({x[i]}).add<std::uint32_t>({y[i]});
    }
    for (const std::uint16_t last : {std::uint16_t{2}, std::uint16_t{3}})
        data.add<double>({1e300}).add<std::uint32_t>({3}).add<std::uint16_t>({0, 1, last}).add<std::int32_t>({-7});
    data.add<std::uint32_t>({2, 9, 0xffffffff});
    return replaced(text, "\n", line_end) + data.text;
}

const std::string two_of_binary = "0 0 1, 1 0 1, 0 1 5 | 0 0 1, 1 0 1, 1 1 1";

}  // namespace

TEST_F(PlyFile, ReadsUnusualText) {
    const std::string good = header + points + "3 0 1 2\n";
    const std::string junk = "element junk 2\nproperty list uchar double stuff\nproperty uchar c\n";
    const std::string junk_data = "2 1 2 9\n0 7\n";
    const std::string left_out = "2 elements \"junk\" were left out";
    const MeshFileCase cases[] = {
        {"plain.ply", good, triangle, ""},
        {"crlf.ply", replaced(good, "\n", "\r\n"), triangle, ""},
        {"cr.ply", replaced(good, "\n", "\r"), triangle, ""},
        {"crlf-body.ply", header + replaced(points + "3 0 1 2\n", "\n", "\r\n"), triangle, ""},
        {"crlf-header.ply", replaced(header, "\n", "\r\n") + points + "3 0 1 2\n", triangle, ""},
        {"no-end.ply", header + points + "3 0 1 2", triangle, ""},
        {"bom.ply", "\xef\xbb\xbf" + good, triangle, ""},
        {"same-names.ply",
         replaced(header, "float z\n", "float z\nproperty int a\nproperty int a\n") +
             "0 0 1 7 8\n1 0 1 7 8\n1 1 1 7 8\n0 1 5 7 8\n3 0 1 2\n",
         triangle, ""},
        {"capital.ply", replaced(good, "ply\n", "PLY\n"), triangle, ""},
        {"blank.ply", header + "\n" + replaced(points, "\n", "\n\n  \n") + "\n\t3  0\t1 2 \n\n", triangle, ""},
        {"comments.ply", replaced(good, end, "comment end_header\nobj_info element x\ncomment\n" + end), triangle, ""},
        {"no-comment.ply", replaced(good, four, "Created by hand\n\n" + four + "source: a.blend\n"), triangle,
         "2 lines of the header are neither declarations nor comments and were left out; the first one is line 3"},
        {"comment-first.ply", replaced(good, "ply\n", "ply\ncomment element face 9\n"), triangle, ""},
        {"spaces.ply",
         replaced(replaced(good, "element vertex 4", "element  vertex  4 "), "property float x", " property\tfloat x "),
         triangle, ""},
        {"other-names.ply", replaced(replaced(good, "float", "float64"), "uchar int", "uint8 int32"), triangle, ""},
        {"vertex-index.ply", replaced(good, "vertex_indices", "vertex_index"), triangle, ""},
        {"unsigned.ply", replaced(good, "uchar int", "uint uint"), triangle, ""},
        {"real-index.ply", replaced(replaced(good, "uchar int", "uchar float"), "3 0 1 2", "3 0.0 1.0 2e0"), triangle,
         ""},
        {"junk-first.ply", start + junk + four + one + end + junk_data + points + "3 0 1 2\n", triangle, left_out},
        {"junk-between.ply", start + four + junk + one + end + points + junk_data + "3 0 1 2\n", triangle, left_out},
        {"junk-last.ply", start + four + one + junk + end + points + "3 0 1 2\n" + junk_data, triangle, left_out},
        {"junk-none.ply", start + replaced(junk, "junk 2", "junk 0") + four + one + end + points + "3 0 1 2\n",
         triangle, ""},
        {"empty-element.ply", start + "element empty 4000000000\n" + four + one + end + points + "3 0 1 2\n", triangle,
         ""},
        {"faces-first.ply", start + one + four + end + "3 0 1 2\n" + points, triangle, ""},
        {"edges.ply",
         start + four + one + "element edge 1\nproperty int vertex1\nproperty int vertex2\n" + end + points +
             "3 0 1 2\n0 3\n",
         triangle, "1 elements \"edge\" were left out"},
        {"face-lists.ply",
         start + four + "element face 1\nproperty uchar n\nproperty list uchar uchar before\n" + list +
             "property list int float after\n" + end + points + "7 2 8 9 3 0 1 2 1 0.5\n",
         triangle, ""},
        {"vertex-lists.ply",
         start + "element vertex 3\nproperty list uchar int a\n" + xyz + "property uchar red\n" + one + end +
             "1 5 0 0 1 9\n0 1 0 1 9\n2 6 7 1 1 1 9\n3 0 1 2\n",
         triangle, ""},
        {"order.ply",
         start + "element vertex 3\nproperty int z\nproperty char y\nproperty double x\n" + one + end +
             "1 0 0\n1 0 1\n1 1 1\n3 0 1 2\n",
         triangle, ""},
        {"quad.ply", header + "0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 1 2 3\n", "0 0 1, 1 0 1, 1 1 1 | 0 0 1, 1 1 1, 0 1 1",
         ""},
        {"dart.ply", header + "0 0 0\n4 0 0\n1 1 0\n0 4 0\n4 0 1 2 3\n", "0 0 0, 1 1 0, 0 4 0 | 0 0 0, 4 0 0, 1 1 0",
         ""},
        {"two-corners.ply", start + four + "element face 2\n" + list + end + points + "2 0 1\n3 0 1 2\n", triangle,
         "1 points or lines were left out"},
        {"numbers.ply", header + "0e5 -0 1.\n+1 .0 1e0\n1.0 1E+0 10e-1\n0 1 5\n3 0 1 2\n", triangle, ""},
    };
    for (const MeshFileCase& file : cases) expect(file);
}

TEST_F(PlyFile, ReadsTriangleStrips) {
    const MeshFileCase cases[] = {
        {"strip.ply", strips("4 0 1 2 3\n"), two_of_strip, ""},
        {"whole.ply", strips("6 0 1 2 3 4 5\n"), two_of_strip + " | 1 0 1, 1 1 1, 2 0 1 | 1 1 1, 2 1 1, 2 0 1", ""},
        {"restart.ply", strips("8 0 1 2 3 -1 2 3 4\n"), two_of_strip + " | 1 0 1, 1 1 1, 2 0 1", ""},
        {"odd-restart.ply", strips("7 0 1 2 -1 2 3 4\n"), "0 0 1, 0 1 1, 1 0 1 | 1 0 1, 1 1 1, 2 0 1", ""},
        {"last-restart.ply", strips("6 -1 0 1 2 3 -1\n"), two_of_strip, ""},
        {"two-lists.ply", strips("3 0 1 2\n3 2 3 4\n", 2), "0 0 1, 0 1 1, 1 0 1 | 1 0 1, 1 1 1, 2 0 1", ""},
        {"joined.ply", strips("7 0 1 2 2 2 3 4\n"), "0 0 1, 0 1 1, 1 0 1 | 1 0 1, 1 1 1, 2 0 1", ""},
        {"parity.ply", strips("5 0 1 2 2 3\n"), "0 0 1, 0 1 1, 1 0 1", ""},
        {"short.ply", strips("2 0 1\n4 0 1 2 3\n", 2), two_of_strip, ""},
        {"other-name.ply", replaced(strips("4 0 1 2 3\n"), "vertex_indices", "vertex_index"), two_of_strip, ""},
        {"faces-too.ply", replaced(strips("3 0 1 2\n3 2 3 4\n"), "element tristrips", one + "element tristrips"),
         "0 0 1, 0 1 1, 1 0 1 | 1 0 1, 1 1 1, 2 0 1", ""},
        {"outside.ply", strips("4 0 1 2 6\n"), "", "outside.ply:16: PLY: strip 0 has the vertex index 6"},
        {"minus-two.ply", strips("4 0 1 2 -2\n"), "", "strip 0 has the vertex index -2"},
        {"no-list.ply", replaced(strips("4 0 1 2 3\n"), "vertex_indices", "indices"), "",
         "the element \"tristrips\" has no list vertex_indices or vertex_index; its properties are \"indices\""},
    };
    for (const MeshFileCase& file : cases) expect(file);
}

TEST_F(PlyFile, ReadsBinaryFilesOfBothByteOrders) {
    const std::string left_out = "2 elements \"first\", 1 elements \"last\" were left out";
    for (const bool big_endian : {false, true}) {
        expect({"binary.ply", binary(big_endian), two_of_binary, left_out});
        expect({"crlf.ply", binary(big_endian, "\r\n"), two_of_binary, left_out});
        expect({"cr.ply", binary(big_endian, "\r"), two_of_binary, left_out});
        expect({"padded.ply", binary(big_endian) + "\n\r\n", two_of_binary, left_out});
        expect({"more.ply", binary(big_endian) + '\0', "", "PLY: the file contains more data"});
        const std::string whole = binary(big_endian);
        for (std::size_t size = whole.find("end_header") + 11; size < whole.size(); ++size)
            expect({"cut.ply", whole.substr(0, size), "", "but the file ends after"});
    }
}

// The first byte of the data is a line feed.
TEST_F(PlyFile, ReadsDataThatBeginsLikeALineEnd) {
    const std::string head =
        "ply\rformat binary_little_endian 1.0\relement vertex 3\rproperty uchar x\rproperty uchar y\r"
        "property uchar z\relement face 1\rproperty list uchar uchar vertex_indices\rend_header\r";
    const std::string data("\n\n\1\13\n\1\n\13\1\3\0\1\2", 13);
    expect({"cr.ply", head + data, "10 10 1, 11 10 1, 10 11 1", ""});
    expect({"lf.ply", replaced(head, "\r", "\n") + data, "10 10 1, 11 10 1, 10 11 1", ""});
    expect({"crlf.ply", replaced(head, "\r", "\r\n") + data, "10 10 1, 11 10 1, 10 11 1", ""});
}

// Neither the memory nor the time may depend on counts that exceed the file.
TEST_F(PlyFile, RefusesCountsThatExceedTheFile) {
    const std::string head = replaced(header, "ascii", "binary_little_endian");
    Bytes data;
    data.add<float>({0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 5});
    const std::string list_of_uint = replaced(head, "uchar int", "uint uint");
    const MeshFileCase cases[] = {
        {"list.ply", list_of_uint + Bytes(data).add<std::uint32_t>({0xffffffff, 0, 1, 2}).text, "",
         "but the file ends"},
        {"signed.ply", replaced(head, "uchar int", "int int") + Bytes(data).add<std::int32_t>({-1, 0, 1, 2}).text, "",
         "a list of an element \"face\" declares more entries"},
        {"vertices.ply", replaced(head, "vertex 4", "vertex 2000000000") + data.text, "",
         "declares 2000000000 elements \"vertex\", but the file ends after 4"},
        {"faces.ply",
         replaced(head, "face 1", "face 4000000000") +
             Bytes(data).add<std::uint8_t>({3}).add<std::int32_t>({0, 1, 2}).text,
         "", "declares 4000000000 elements \"face\", but the file ends after 1"},
        {"too-many.ply", replaced(head, "vertex 4", "vertex 3000000000") + data.text, "", "the limit is 2^31"},
        {"overflow.ply", replaced(head, "vertex 4", "vertex 99999999999999999999") + data.text, "",
         "an element line must have the form"},
        {"text.ply", replaced(header, "vertex 4", "vertex 2000000000") + points, "", "but the file ends after 4"},
        {"text-list.ply", header + points + "4000000000 0 1 2\n", "", "declares more entries than its line"},
    };
    for (const MeshFileCase& file : cases) expect(file);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    EXPECT_LT(usage.ru_maxrss, 1 << 20) << "in units of 1024 bytes";
}

TEST_F(PlyFile, RefusesWrongFiles) {
    const std::string good = header + points + "3 0 1 2\n", edge = "element edge 1\nproperty int a\nproperty int b\n";
    const MeshFileCase cases[] = {
        {"other.ply", "solid cube\n", "", "must begin with the word ply"},
        {"no-format.ply", replaced(good, "format ascii 1.0\n", ""), "", "the header has no format line"},
        {"format.ply", replaced(good, "ascii", "text"), "", "format.ply:2: PLY: format text is not known"},
        {"type.ply", replaced(good, "float y", "real y"), "", "type.ply:5: PLY: type \"real\" is not known"},
        {"list-type.ply", replaced(good, "uchar int", "float int"), "",
         "type \"float\" of a list's length is not legal"},
        {"negative-count.ply", replaced(good, "vertex 4", "vertex -4"), "",
         "negative-count.ply:3: PLY: an element line"},
        {"real-count.ply", replaced(good, "vertex 4", "vertex 4.0"), "", "an element line must have the form"},
        {"no-count.ply", replaced(good, "vertex 4", "vertex"), "", "an element line must have the form"},
        {"no-name.ply", replaced(good, "float y", "float"), "", "a property line must have the form"},
        {"early-property.ply", replaced(good, start, start + "property int a\n"), "", "precedes the first element"},
        {"twice.ply", replaced(good, one, four + one), "", "the element \"vertex\" is declared twice"},
        {"property-twice.ply", replaced(good, "float y", "float x"), "",
         "the property \"x\" of the element \"vertex\" is declared twice"},
        {"misspelt.ply", replaced(good, one, "elements face 1\n"), "",
         "misspelt.ply:7: PLY: \"elements\" is not legal in the header; did you mean \"element\"?"},
        {"no-end.ply", start + four + one, "", "the line end_header is missing"},
        {"no-z.ply", replaced(good, "float z", "float w"), "", "the element \"vertex\" has no property \"z\""},
        {"list-x.ply", replaced(good, "float x", "list uchar int x"), "",
         "the property \"x\" of the element \"vertex\" is a"},
        {"no-indices.ply", replaced(good, "vertex_indices", "corners"), "", "its properties are \"corners\""},
        {"number-index.ply", replaced(good, list, "property int vertex_indices\n"), "", "has no list vertex_indices"},
        {"no-vertices.ply", start + one + end + "3 0 1 2\n", "", "its part has only 0 vertices"},
        {"edges.ply", start + four + edge + end + points + "0 1\n", "", "1 elements \"edge\" are not supported"},
        {"patches.ply", start + four + "element patch 1\n" + list + end + points + "4 0 1 2 3\n", "",
         "the file has no face; 1 elements \"patch\" are not supported"},
        {"edges-no-faces.ply", start + four + edge + replaced(one, "face 1", "face 0") + end + points + "0 1\n", "",
         "1 elements \"edge\" are not supported"},
        {"cloud.ply", start + four + end + points, "", "has no triangle with a nonzero area"},
        {"index.ply", header + points + "3 0 1 4\n", "", "index.ply:14: PLY: face 0 has the vertex index 4"},
        {"minus.ply", header + points + "3 0 1 -1\n", "", "face 0 has the vertex index -1"},
        {"half.ply", replaced(header, "uchar int", "uchar float") + points + "3 0 1 1.5\n", "", "the vertex index 1.5"},
        {"nan-index.ply", replaced(header, "uchar int", "uchar float") + points + "3 0 1 nan\n", "", "index nan"},
        {"no-corners.ply", header + points + "0\n", "", "no-corners.ply:14: PLY: face 0 has no vertices"},
        {"word.ply", header + replaced(points, "5", "five") + "3 0 1 2\n", "",
         "word.ply:13: PLY: \"five\" is not a number"},
        {"inf.ply", header + replaced(points, "5", "inf") + "3 0 1 2\n", "",
         "inf.ply:13: PLY: vertex 3 of part \"\" is not"},
        {"wrapped.ply", header + points + "3 0 1\n2\n", "", "expected 4 numbers for an element \"face\", got 3"},
        {"joined.ply", header + replaced(points, "1\n1 1", "1 1 1") + "3 0 1 2\n", "",
         "joined.ply:11: PLY: expected 3"},
        {"control.ply", header + points + "3 0 1 2\f\n", "", "contains a control character"},
        {"half-list.ply", header + points + "3.5 0 1 2\n", "", "its length is not a whole number >= 0: 3.5"},
        {"cr-body.ply", header + replaced(points, "\n", "\r") + "3 0 1 2\n", "", "contains a control character"},
    };
    for (const MeshFileCase& file : cases) expect(file);
}

TEST_F(PlyFile, ReadsNormalsAndTextureCoordinates) {
    for (const auto& [u, v] :
         {std::pair("s", "t"), {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}) {
        const std::string more =
            std::string("property float nz\nproperty float nx\nproperty float ny\nproperty float ") + v +
            "\nproperty float " + u + "\n";
        const TriangleMesh read = mesh("all.ply", replaced(header, "float z\n", "float z\n" + more) +
                                                      "0 0 1 2 0 0 .25 1\n1 0 1 0 3 0 .5 2\n1 1 1 0 0 0 .75 3\n"
                                                      "0 1 5 nan 0 1 0 0\n3 0 1 2\n");
        EXPECT_EQ(read.uv, (std::vector<double>{1, .25, 2, .5, 3, .75, 0, 0})) << u;
        EXPECT_EQ(read.normals, (std::vector<double>{0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0})) << u;
        EXPECT_TRUE(remarks_.empty()) << u;
    }
    expect({"nan.ply",
            replaced(header, "float z\n", "float z\nproperty float s\nproperty float t\n") +
                "0 0 1 0 0\n1 0 1 0 nan\n1 1 1 0 0\n0 1 5 0 0\n3 0 1 2\n",
            "", "nan.ply:13: PLY: the texture coordinates of vertex 1 are not finite"});
}

// Some programs write texture coordinates of each corner of a face, because vertices on seams have several.
TEST_F(PlyFile, ReadsTextureCoordinatesOfCorners) {
    const std::string head =
        start + four + "element face 2\n" + list + "property list uchar float texcoord\n" + end + points;
    object_.paint.kind = Paint::Kind::checker;
    const TriangleMesh read = mesh("corners.ply", head + "3 0 1 2 6 .1 .2 .3 .4 .5 .6\n3 0 2 3 6 .7 .8 1 0 0 1\n");
    ASSERT_EQ(read.triangles.size(), 6u);
    const double expected[6][2] = {{.1, .2}, {.3, .4}, {.5, .6}, {.7, .8}, {1, 0}, {0, 1}};
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(read.uv[2 * read.triangles[i] + k], expected[i][k]) << i;
    EXPECT_TRUE(remarks_.empty());
    mesh("one.ply", head + "3 0 1 2 6 .1 .2 .3 .4 .5 .6\n3 0 2 3 0\n");
    ASSERT_EQ(remarks_.size(), 1u);
    EXPECT_NE(remarks_[0].find("3 vertices without texture coordinates"), std::string::npos) << remarks_[0];
    expect(
        {"five.ply", head + "3 0 1 2 5 .1 .2 .3 .4 .5\n3 0 2 3 0\n", "", "face 0 has 5 numbers in its list texcoord"});
}

}  // namespace kagero::test
