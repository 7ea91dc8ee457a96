/// Support for tests of materials in mesh files: files with one square for each material, and a scene that shows each
/// square in 2 × 2 pixels.
#pragma once

#include "film/codec.h"
#include "render/render.h"
#include "tests/support/gltf_fixture.h"
#include "tests/support/plan_fixture.h"

namespace kagero::test {

/// Light of the sky.
inline constexpr double sky = 0.5;

/// The bytes of the texture, row by row from the top.
inline constexpr unsigned char texels[2][2][3] = {{{255, 0, 64}, {10, 200, 30}}, {{90, 120, 250}, {40, 60, 80}}};

inline double linear(unsigned char code) {
    const double s = code / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// Returns a texel; row and column may be beyond the edges of the image, which then repeats or is mirrored.
inline Double3 texel(int row, int column, bool is_mirrored = false) {
    const auto index = [&](int i) {
        const int within = (i % 2 + 2) % 2, repetition = (i - within) / 2;
        return is_mirrored && repetition % 2 != 0 ? 1 - within : within;
    };
    const unsigned char(&t)[3] = texels[index(row)][index(column)];
    return {linear(t[0]), linear(t[1]), linear(t[2])};
}

inline Double3 product(const Double3& a, const Double3& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

inline std::string png() {
    std::vector<unsigned char> bytes;
    EXPECT_EQ(encode_picture(".png", {2, 2, 3, PictureToEncode::Samples::bytes, texels}, bytes), "");
    return {bytes.begin(), bytes.end()};
}

/// A glTF file with a row of squares in the plane z = 0 of the file. Square i lies between x = 2i and 2i + 2.
struct Squares {
    Parts parts;

    Squares() {
        parts.file = {{"asset", {{"version", "2.0"}}},
                      {"scene", 0},
                      {"scenes", {{{"nodes", json::array()}}}},
                      {"nodes", json::array()},
                      {"meshes", json::array()},
                      {"materials", json::array()},
                      {"accessors", json::array()},
                      {"bufferViews", json::array()}};
        parts.add_accessor(Bytes().add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}).text, 5126, 4, "VEC3");
        parts.add_accessor(Bytes().add<float>({0, 1, 1, 1, 1, 0, 0, 0}).text, 5126, 4, "VEC2");
        parts.add_accessor(Bytes().add<std::uint16_t>({0, 1, 2, 0, 2, 3}).text, 5123, 6, "SCALAR");
        parts.add_accessor(Bytes().add<float>({2, 1, 3, 1, 3, 0, 2, 0}).text, 5126, 4, "VEC2");  // to the right of 0..1
    }
    /// Adds a square with a material. It is a mesh of its own, which a node scales by 2 and moves.
    Squares& add(const json& material) {
        const std::size_t i = parts.file["nodes"].size();
        json primitive = {{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}, {"TEXCOORD_1", 3}}}, {"indices", 2}};
        if (!material.is_null()) {
            primitive["material"] = parts.file["materials"].size();
            parts.file["materials"].push_back(material);
        }
        parts.file["meshes"].push_back({{"primitives", {primitive}}});
        parts.file["nodes"].push_back({{"mesh", i}, {"scale", {2, 2, 2}}, {"translation", {2.0 * double(i), 0, 0}}});
        parts.file["scenes"][0]["nodes"].push_back(i);
        return *this;
    }
    Squares& set(const char* key, const json& value) {
        parts.file[key] = value;
        return *this;
    }
};

class FileMaterials : public SceneTest {
protected:
    /// Returns a scene with a mesh whose squares cover 2 × 2 pixels each, with the pixels' centres at those of texels.
    std::string scene(const std::string& file, std::size_t squares,
                      const std::string& keys = "materials = \"file\"\n") {
        const std::string n = std::to_string(squares);
        return "[space]\nhamiltonian = \"flat\"\n[camera]\ntype = \"orthographic\"\nheight = 2\nposition = [" + n +
               ", 1, 5]\nlook_at = [" + n + ", 1, 0]\nup = [0, 1, 0]\n[film]\nsize = [" + std::to_string(2 * squares) +
               ", 2]\nspp = " + std::to_string(spp_) + "\nlayers = [\"color\", \"object\"" +
               (spp_ > 1 ? ", \"standard_error\"" : "") + "]\n[sky]\ncolor = [0.5, 0.5, 0.5]\n" +
               "[[object]]\nname = \"far\"\nshape = \"sphere\"\ncenter = [0, 0, -40]\nradius = 1\ncolor = [0, 0, 0]\n" +
               "[[object]]\nname = \"model\"\nshape = \"mesh\"\nfile = \"" + file + "\"\n" + keys;
    }
    /// Renders a scene. Afterwards, `remarks_` contains the remarks on its objects.
    void render_scene(const std::string& text) {
        const auto plan = plan_of_text(text, {});
        remarks_.clear();
        for (const std::string& remark : plan->scene->geometry->remarks()) remarks_ += remark + '\n';
        materials_.clear();
        for (const ObjectDescription& object : plan->description().objects) materials_.push_back(object.material);
        film_.emplace(film_of(*plan));
        render(*plan, *film_);
    }
    void render_squares(Squares& squares, std::size_t count) {
        write("texture.png", png());
        render_scene(scene(write("model.gltf", embedded(squares.parts)), count));
    }
    Double3 pixel(std::size_t x, std::size_t y) const {
        const float* color = film_->plane("color") + 3 * (y * film_->width() + x);
        return {double(color[0]), double(color[1]), double(color[2])};
    }
    void expect_pixel(std::size_t x, std::size_t y, const Double3& expected) const {
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(pixel(x, y)[k], expected[k], 2e-6) << "pixel " << x << ", " << y << ", channel " << k;
    }
    void expect_square(std::size_t square, const Double3& expected) const {
        for (std::size_t i = 0; i < 4; ++i) expect_pixel(2 * square + i % 2, i / 2, expected);
    }
    void expect_noisy_square(std::size_t square, const Double3& expected) const {
        for (std::size_t y : {0, 1})
            for (std::size_t x : {2 * square, 2 * square + 1})
                for (std::size_t k = 0; k < 3; ++k) {
                    const double error = double(film_->plane("standard_error")[3 * (y * film_->width() + x) + k]);
                    EXPECT_LT(error, 0.01 * expected[k]);
                    EXPECT_NEAR(pixel(x, y)[k], expected[k], 4 * error) << "pixel " << x << ", " << y;
                }
    }
    /// Returns the message with which a scene is refused.
    std::string refusal_of(const std::string& text) {
        try {
            plan_of_text(text, {});
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    std::size_t spp_ = 1;
    std::string remarks_;
    std::vector<Material> materials_;
    std::optional<Film> film_;
};

inline json diffuse(const json& color) {
    return {{"pbrMetallicRoughness", {{"baseColorFactor", color}, {"metallicFactor", 0}}}};
}
inline json textured(const json& texture) {
    return {{"pbrMetallicRoughness", {{"baseColorTexture", texture}, {"metallicFactor", 0}}}};
}

inline const json one_texture = {{{"source", 0}}}, texture_file = {{{"uri", "texture.png"}}};

inline const std::string obj =
    "mtllib my colours.mtl\n"
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 4 0 0\nv 4 2 0\nv 6 0 0\nv 6 2 0\nv 8 0 0\nv 8 2 0\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl red paint\nf 1/1 2/2 3/3 4/4\nusemtl picture\nf 2/1 5/2 6/3 3/4\n"
    "usemtl lamp\nf 5/1 7/2 8/3 6/4\nusemtl chrome\nf 7/1 9/2 10/3 8/4\n";

}  // namespace kagero::test
