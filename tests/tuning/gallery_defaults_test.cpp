// Tests the default pictures of the gallery: the rays of a picture whose scene states neither method nor step must end
// within 0.05 pixels of a reference that two other methods agree on. Errors above half a pixel are permitted only where
// the picture magnifies more than 1000 times. KAGERO_GRID=N compares N × N rays of each scene.
#include "tests/support/plan_fixture.h"

#include "accuracy/reference.h"
#include "tuning/resolve.h"

#include <gtest/gtest.h>

#include <regex>

namespace kagero::test {
namespace {

/// Returns the text of a scene of the gallery without the keys that state how rays are integrated. The paths of files
/// in the scene are relative to the folder of the gallery.
std::string without_method(const std::string& name) {
    const std::regex key("\n(method|step|tolerance|rescale) *=[^\n]*");
    const std::string text = std::regex_replace(scene_text(name), key, "");
    return std::regex_replace(text, std::regex("\"(textures|meshes)/"), "\"" KAGERO_SCENES "/$1/");
}

class GalleryDefaults : public testing::TestWithParam<const char*> {};

TEST_P(GalleryDefaults, AreWithinATwentiethOfAPixel) {
    const char* edge = std::getenv("KAGERO_GRID");
    const std::uint32_t grid = edge ? std::uint32_t(std::stoul(edge)) : 48;
    const auto first = plan_of_text(without_method(GetParam()), {});
    const SampleRays sample = sample_rays(*first, grid, grid);
    ReferenceSummary summary;
    const ReferenceRays reference = trace_reference(*first, sample, summary);
    ASSERT_LT(summary.pixels.p99, 0.005);
    const Plan plan = choose_by_trial(*first);
    std::vector<RayEnd> ends;
    trace(plan, sample.starts, ends);
    std::size_t compared = 0, above_bound = 0, above_half = 0, outliers = 0, flips = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (!reference.confirmed[i]) continue;
        const double error = pixel_error(plan, to_hamiltonian_coordinates(plan, reference.ends[i]),
                                         to_hamiltonian_coordinates(plan, ends[i]));
        if (std::isnan(error)) {
            ++flips;
            continue;
        }
        ++compared;
        above_bound += error > 0.05;
        above_half += error > 0.5;
        outliers += error > 0.5 && reference.conditioning[i] < conditioning_limit;
    }
    std::cout << GetParam() << ": of " << compared << " rays, " << above_bound << " above 0.05 pixel, " << above_half
              << " above 0.5 pixel, " << outliers << " of them without great magnification; " << flips << " flips\n";
    EXPECT_LE(double(above_bound), 0.01 * double(compared));
    EXPECT_EQ(outliers, 0);
    EXPECT_LE(double(flips), 0.01 * double(ends.size()));
}

INSTANTIATE_TEST_SUITE_P(Scenes, GalleryDefaults,
                         testing::Values("fisheye.toml", "formula-anisotropic.toml", "formula-mirage.toml",
                                         "formula-morris-thorne.toml", "formula-reissner-nordstrom.toml",
                                         "formula-strange.toml", "galaxy.toml", "hole.toml",
                                         "kerr-boyer-lindquist.toml", "kerr.toml", "luneburg.toml", "mirage.toml",
                                         "room-mesh.toml", "room.toml", "shimmer.toml", "wormhole.toml"));

}  // namespace
}  // namespace kagero::test
