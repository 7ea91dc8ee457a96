// Tests the shading of cells as units: their colours are compared with those of the same pixels that are shaded one by
// one, from interpolated ray ends.
#include "pixels/cell_shader.h"
#include "adaptive/sample_tile.h"
#include "adaptive/write_ends.h"
#include "pixels/shade_tile.h"
#include "render/render.h"
#include "tests/support/file_materials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kagero::test {
namespace {

/// The same picture, shaded in cells and pixel by pixel.
struct TwoPictures {
    Film in_cells, by_pixel;
    std::vector<bool> is_in_cell;                 ///< For each pixel: true if its cell was shaded as a unit.
    std::size_t squares = 0, shaded_squares = 0;  ///< Numbers of squares of 8 × 8 pixels in cells.

    explicit TwoPictures(const Plan& plan)
        : in_cells(film_of(plan)), by_pixel(film_of(plan)),
          is_in_cell(std::size_t{in_cells.width()} * in_cells.height()) {
        const Tile window = plan.view.window;
        for (std::uint32_t y = 0; y < window.y1; y += adaptive_tile_edge)
            for (std::uint32_t x = 0; x < window.x1; x += adaptive_tile_edge)
                add(plan,
                    {x, y, std::min(x + adaptive_tile_edge, window.x1), std::min(y + adaptive_tile_edge, window.y1)});
    }

private:
    void add(const Plan& plan, const Tile& tile) {
        TracedRays rays;
        AdaptiveSamples samples;
        Counters counters{};
        sample_tile(plan, plan.job(), tile, plan.run.interpolation_bound, rays, samples, counters, {});
        TracedRays single = rays;
        write_ends(tile, single);
        single.cells.clear();
        const Tile window = plan.view.window;
        shade_tile(plan, tile, window, single, {}, by_pixel);
        shade_tile(plan, tile, window, rays, {}, in_cells);
        Film ignored = film_of(plan);
        const CellShader shader(plan, window, ignored);
        for (const RayCell& cell : rays.cells) find_parts(shader, cell, tile);
    }
    /// Finds the parts of a cell that are shaded as units.
    void find_parts(const CellShader& shader, const RayCell& cell, const Tile& tile) {
        if (!shader.shade(cell) && cell.edge > 8) {
            for (const RayCell& quarter : quarters_of(cell)) find_parts(shader, quarter, tile);
            return;
        }
        const std::size_t count = cell.edge / 8 * (cell.edge / 8);
        squares += count;
        if (shader.shade(cell)) {
            shaded_squares += count;
            for (std::uint32_t y = cell.y; y < std::min(cell.y + cell.edge, tile.y1); ++y)
                for (std::uint32_t x = cell.x; x < std::min(cell.x + cell.edge, tile.x1); ++x)
                    is_in_cell[std::size_t{y} * in_cells.width() + x] = true;
        }
    }
};

/// Compares the pictures. A pixel of one may differ from that of the other by `tolerance` beyond the range of the
/// pixels within a distance of 1, because positions may differ by the bound on errors. `greatest_mean` is the greatest
/// mean difference of all pixels in cells.
void expect_agreement(const Plan& plan, double least_share, double tolerance, double greatest_mean) {
    const TwoPictures pictures(plan);
    EXPECT_GE(double(pictures.shaded_squares), least_share * double(pictures.squares));
    const float *a = pictures.in_cells.plane("color"), *b = pictures.by_pixel.plane("color");
    const std::uint32_t width = pictures.in_cells.width(), height = pictures.in_cells.height();
    const auto index = [&](std::uint32_t x, std::uint32_t y) { return std::size_t{y} * width + x; };
    double sum = 0, outside = 0, greatest = 0;
    std::size_t count = 0;
    for (std::uint32_t y = 1; y + 1 < height; ++y)
        for (std::uint32_t x = 1; x + 1 < width; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t i = 3 * index(x, y) + c;
                if (!pictures.is_in_cell[index(x, y)]) {
                    ASSERT_EQ(a[i], b[i]) << x << "," << y;
                    continue;
                }
                float least = b[i], most = b[i];
                for (const std::uint32_t ny : {y - 1, y, y + 1})
                    for (const std::uint32_t nx : {x - 1, x, x + 1}) {
                        least = std::min(least, b[3 * index(nx, ny) + c]);
                        most = std::max(most, b[3 * index(nx, ny) + c]);
                    }
                sum += std::abs(a[i] - b[i]);
                ++count;
                const double beyond = std::max<double>({0, least - a[i], a[i] - most});
                outside += beyond > tolerance;
                greatest = std::max(greatest, beyond);
            }
    ASSERT_GT(count, 0u);
    EXPECT_LE(sum / double(count), greatest_mean);
    EXPECT_LE(outside / double(count), 1e-4) << "greatest: " << greatest;
}

/// A scene of the gallery, and the least share of its cells that are shaded as units.
struct GalleryCase {
    const char* scene;
    double least_share;
};

TEST(CellShader, AgreesWithPixelsOfTheGallery) {
    for (const auto& [scene, least_share] : {GalleryCase{"galaxy.toml", 0.85},
                                             {"hole.toml", 0.85},
                                             {"wormhole.toml", 0.8},
                                             {"room.toml", 0.9},
                                             {"kerr.toml", 0.7},
                                             {"mirage.toml", 0.9},
                                             {"luneburg.toml", 0.5}}) {
        SCOPED_TRACE(scene);
        const auto plan = plan_of_file(scene_file(scene), {"film.size=[400,256]", "film.spp=1",
                                                           "film.sampling=adaptive", "film.layers=[\"color\"]"});
        expect_agreement(*plan, least_share, 0.02, 0.004);
    }
}

const std::string textures = KAGERO_SCENES "/textures/";

/// Returns a scene in flat space with one object in front of a camera.
std::string scene_with(const std::string& object) {
    return "[space]\nhamiltonian = \"flat\"\n[camera]\nposition = [0, -4, 0.7]\nlook_at = [0.1, 0, 0]\nup = [0, 0, 1]\n"
           "fov = 40\n[film]\nsize = [256, 256]\nsampling = \"adaptive\"\n[sky]\ncolor = [0.1, 0.2, 0.3]\n"
           "[[object]]\nname = \"thing\"\n" +
           object;
}

TEST(CellShader, AgreesWithPixelsOfEveryShapeAndPaint) {
    const std::string shapes[] = {
        "shape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1.2\n",
        "shape = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0.2, -0.6, 1]\ninner = 0.3\nouter = 1.5\n",
        "shape = \"rectangle\"\norigin = [-1.2, 0, -1.1]\nedge_u = [2.4, 0.3, 0]\nedge_v = [0, 0.9, 2.2]\n"};
    const std::string paints[] = {"color = [0.5, 0.7, 0.9]\n", "color = [1, 1, 1]\nchecker = [12, 8]\n",
                                  "texture = \"" + textures + "paving.jpg\"\n"};
    const std::string shadings[] = {"", "shading = \"lambert\"\n"};
    for (const std::string& shape : shapes)
        for (const std::string& paint : paints)
            for (const std::string& shading : shadings) {
                if (shape.find("disk") != std::string::npos && !shading.empty()) continue;
                SCOPED_TRACE(shape + paint + shading);
                expect_agreement(*plan_of_text(scene_with(shape + paint + shading), {}), 0.3, 0.02, 0.004);
            }
}

using CellShaderOfFiles = FileMaterials;

// A mesh file states how an image continues beyond its edges, and a factor for its colours. The image is repeated
// several times on each square, so that cells cover more than one copy. Unlit surfaces end rays, as cells require.
TEST_F(CellShaderOfFiles, AgreesWithPixelsOfRepeatedMirroredAndMultipliedImages) {
    constexpr int repeat = 10497, clamp = 33071, mirror = 33648;
    struct Case {
        int along_u, along_v;
        json factor;
    };
    write("texture.png", png());
    for (const auto& [along_u, along_v, factor] : {Case{repeat, repeat, {1, 1, 1, 1}},
                                                   {repeat, clamp, {1, 1, 1, 1}},
                                                   {clamp, repeat, {1, 1, 1, 1}},
                                                   {mirror, mirror, {1, 1, 1, 1}},
                                                   {repeat, repeat, {0.5, 1, 0.25, 1}}}) {
        SCOPED_TRACE(std::to_string(along_u) + " " + std::to_string(along_v) + " " + factor.dump());
        const json transform{{"scale", {6, 6}}, {"offset", {-2.2, -1.7}}};
        json material = textured({{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}});
        material["pbrMetallicRoughness"]["baseColorFactor"] = factor;
        material["extensions"] = {{"KHR_materials_unlit", json::object()}};
        Squares squares;
        squares.add(material).set("images", texture_file).set("textures", {{{"source", 0}, {"sampler", 0}}});
        squares.set("samplers", {{{"wrapS", along_u}, {"wrapT", along_v}}});
        const std::string file = write("model.gltf", embedded(squares.parts));
        const auto plan = plan_of_text("[space]\nhamiltonian = \"flat\"\n[camera]\nposition = [0.7, 0.8, 3]\n"
                                       "look_at = [1, 1, 0]\nup = [0, 1, 0]\nfov = 50\n[film]\nsize = [256, 256]\n"
                                       "sampling = \"adaptive\"\n[sky]\ncolor = [0.1, 0.2, 0.3]\n[[object]]\n"
                                       "name = \"model\"\nshape = \"mesh\"\nmaterials = \"file\"\nfile = \"" +
                                           file + "\"\n",
                                       {});
        expect_agreement(*plan, 0, 0.02, 0.004);
    }
}

// The film of a crop contains parts of cells.
TEST(CellShader, WritesOnlyPixelsOfTheFilm) {
    const Overrides overrides{"film.size=[200,140]", "film.sampling=adaptive"};
    const auto whole = plan_of_file(scene_file("galaxy.toml"), overrides);
    Film expected = film_of(*whole);
    render(*whole, expected);
    Options options;
    options.crop = Tile{13, 7, 171, 101};
    const auto part = plan_of_file(scene_file("galaxy.toml"), overrides, options);
    Film film = film_of(*part);
    render(*part, film);
    for (std::uint32_t y = 7; y < 101; ++y)
        for (std::uint32_t x = 13; x < 171; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_EQ(film.pixel("color", x - 13, y - 7)[c], expected.pixel("color", x, y)[c]) << x << "," << y;
}

TEST(CellShader, RefusesOtherLayers) {
    const auto plan = plan_of_file(scene_file("hole.toml"), {"film.size=[64,64]", "film.sampling=adaptive",
                                                             "film.layers=[\"color\",\"traced\"]"});
    Film film = film_of(*plan);
    RayCell cell{};
    cell.edge = 8;
    EXPECT_FALSE(CellShader(*plan, plan->view.window, film).shade(cell));
}

}  // namespace
}  // namespace kagero::test
