/// Makes the pictures of one page, and keeps what the next picture can use again.
#pragma once

#include "film/write_film.h"
#include "plan/plan.h"
#include "report/json.h"
#include "view/sky/map_picture.h"
#include "view/view_state.h"

#include <atomic>
#include <optional>

namespace kagero {

/// The scene of the viewer, which all pages share.
struct ViewScene {
    std::string file, text;           ///< Path of the scene file, and its text.
    std::vector<Override> overrides;  ///< Those of the command line.
    Options options;
    SceneDescription description;  ///< The description without the changes of any page.
};

/// Loads the scene of the viewer. Throws InputError if the file or an override is invalid.
ViewScene load_view_scene(const std::string& file, std::vector<Override> overrides, const Options& options);

/// Returns the description of the scene with the changes of a page. Throws InputError if they are invalid.
SceneDescription description_of(const ViewScene& scene, const ViewState& state);

/// A picture for a page.
struct LivePicture {
    std::shared_ptr<const Plan> plan;  ///< The plan with which it was made.
    std::shared_ptr<const Film> film;  ///< Null if the picture was made from a map.
    std::vector<unsigned char> rgb;    ///< The picture from a map, in 8-bit sRGB.
    std::uint32_t width = 0, height = 0;
    std::uint32_t reduction = 1;  ///< The picture has 1/reduction of the requested width and height.
    std::uint64_t rays = 0;       ///< Number of traced rays.
    double plan_seconds = 0, trace_seconds = 0, shade_seconds = 0;
    /// Estimates of the error in pixels: of the integration, from a few rays of the last picture with one ray per
    /// pixel, and of interpolated rays. NaN: unknown.
    double integration_error = 0, interpolation_p99 = 0, interpolation_max = 0;
    std::string reuse;                 ///< What was used again from earlier pictures, for the user.
    std::vector<std::string> remarks;  ///< Warnings about the picture, one line each.
    Metadata metadata;                 ///< Attributes of an EXR file.
};

/// Makes pictures. Not more than one thread may use it at a time.
class PictureMaker {
public:
    explicit PictureMaker(const ViewScene& scene) : scene_(scene) {}
    /// Makes a picture. Throws InputError if the state is impossible for the scene, and Interrupted if `stop` is set.
    LivePicture make(const ViewState& state, const std::atomic<bool>& stop);
    /// Returns a plan of the picture with one ray per pixel, as `render` would make it.
    std::shared_ptr<const Plan> full_plan(const ViewState& state, const std::atomic<bool>& stop);

private:
    struct KeptPlan {
        std::string keys;  ///< The keys from which the plan was made.
        std::shared_ptr<const Plan> plan;
    };

    /// Returns the plan that was made from these keys; null if it is not kept.
    std::shared_ptr<const Plan> kept_plan(const std::string& keys) const;
    Plan moving_plan(const ViewState& state, LivePicture& picture, const std::atomic<bool>& stop);
    LivePicture make_moving(ViewState state, const std::atomic<bool>& stop);
    /// Makes the first picture, in a reduced size and without a trial, with the default method of the space.
    LivePicture make_first(ViewState state, const std::atomic<bool>& stop);
    LivePicture make_full(const ViewState& state, const std::atomic<bool>& stop);
    void render_film(LivePicture& picture, double seconds, const std::atomic<bool>& stop);
    void draw_from_map(const ViewState& state, LivePicture& picture);
    /// Chooses `reduction_` for a state, and reduces the size of the state.
    void choose_reduction(ViewState& state);

    const ViewScene& scene_;
    std::shared_ptr<const Plan> tuned_;   ///< The last plan whose method was chosen by trial rays.
    std::vector<KeptPlan> kept_plans_;    ///< The last plans of this kind; the last one was made last.
    std::shared_ptr<const Plan> latest_;  ///< The last plan of a moving picture.
    std::string latest_rays_;             ///< Its keys that determine the rays from a position.
    std::optional<SkyMap> map_;
    std::string map_rays_;   ///< The keys that determine the rays of the map.
    LivePicture last_full_;  ///< The last whole picture, with the keys that determine its light.
    std::string last_full_light_;
    double sampled_error_ = 0;      ///< Error of the last picture with one ray per pixel.
    double seconds_per_pixel_ = 0;  ///< Time per pixel of the last picture; 0: unknown.
    bool has_made_picture_ = false;
    std::uint32_t reduction_ = 1;  ///< That of the last moving picture.
};

}  // namespace kagero
