/// A loaded scene with the plans of its runs. The public classes and the Python module share it.
#pragma once

#include "frames/frame_plans.h"
#include "render/run_report.h"

#include <kagero/options.h>

#include <memory>
#include <mutex>

namespace kagero {

/// Options of a list of rays, as the command line has them for `trace`.
struct RayRequest {
    std::string observer{};                  ///< Observer in whose rest frame directions are given; "": coordinates.
    std::optional<std::uint32_t> bounces{};  ///< Number of surfaces through which rays continue; empty: 0.
    std::vector<std::string> columns{};      ///< Integrals along the rays: "action" and "time".
    std::optional<double> parameter{};       ///< Value of λ at which rays end; empty: no limit.
    double every = 0;                        ///< Interval of λ between the points of a path; 0: every step is a point.
    bool energy_error = true;                ///< The error of H is measured.
    bool end_parameter = true;               ///< λ is computed at the ends.
};

/// A rendered picture with the plan of its rays.
struct RenderedPicture {
    std::shared_ptr<const Plan> plan;
    std::optional<Film> film;
    RunReport report;
};

/// A loaded scene that keeps the last plans that it has made. All functions may be called from several threads at once.
class ScenePlans {
public:
    /// Loads the scene; if the source has no text, reads the file. Throws InputError if the scene is invalid.
    explicit ScenePlans(SceneSource source);

    const SceneSource& source() const { return source_; }
    /// Returns the description as it is loaded for single rays: defaults replace a missing camera.
    const SceneDescription& description() const { return description_; }

    /// Returns the plan of a picture. `layers` replaces film.layers unless it is empty. Throws InputError, and
    /// Interrupted if `control.stop` is set during a trial.
    std::shared_ptr<const Plan> picture(const RunOptions& requested, const std::vector<std::string>& layers,
                                        const RunControl& control) const;
    /// Renders a picture, as `kagero render` does: that of frame 0, which is the mean of sub-frames if the shutter is
    /// open. For the arguments and exceptions, see picture().
    RenderedPicture render(const RunOptions& requested, const std::vector<std::string>& layers,
                           const RunControl& control) const;
    /// Returns the plan of a list of rays. Throws InputError.
    std::shared_ptr<const Plan> rays(const RunOptions& requested, const RayRequest& request) const;

private:
    struct KeptPlan {
        std::string key;  ///< All options that determine the plan.
        std::shared_ptr<const Plan> plan;
        std::shared_ptr<FramePlans> frames;  ///< The plans of the sub-frames; null if the picture has none.
    };

    std::optional<KeptPlan> find(const std::string& key) const;
    KeptPlan keep(KeptPlan plan) const;
    KeptPlan kept_picture(const RunOptions& requested, const std::vector<std::string>& layers,
                          const RunControl& control) const;

    SceneSource source_;
    SceneDescription description_;
    mutable std::mutex mutex_;
    mutable std::vector<KeptPlan> kept_;  ///< The last plan is the one that was used last.
};

}  // namespace kagero
