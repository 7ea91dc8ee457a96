/// A scene made ready to run: module, kernel, geometry and the job all rays share.
#pragma once

#include "scene/description.h"
#include "geometry/geometry.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kagero {

/// What the command line may ask for beside the scene.
struct Options {
    std::string isa = "auto";
    std::string strategy = "auto";     ///< auto | scalar | per-ray | packet
    std::string precision = "auto";    ///< auto | double | float
    std::string schedule = "auto";     ///< auto | scanline | tiles | predicted
    unsigned threads = 0;              ///< 0: all
    std::array<std::uint32_t, 4> crop{0, 0, 0, 0};  ///< x0, y0, x1, y1, half-open; all zero: the whole film
    std::string observer = "";         ///< of a plan without a camera: who reads the directions of its rays; empty: the coordinates
    bool energy_error = false;         ///< watch H along every ray
    bool parameter = false;            ///< λ at the ends of listed rays
};

/// Where the camera looks: unit vectors in its observer's rest frame.
struct View {
    ObserverKind observer = ObserverKind::static_;
    Double3 forward{}, right{}, down{};
};

/// How the method was chosen, where the scene states a bound on the error.
struct Pilot {
    std::uint64_t rays = 0;
    double bound = 0, estimate = 0;  ///< pixels; of the error of 99 % of the rays
    bool met = false;
    std::string why_not;  ///< where it is not met
    double ill_conditioned = 0;  ///< share of the rays that turn their neighbours apart so much that their pixels count as larger
};

/// What following some of the rays in float showed, where the options leave the precision open.
struct FloatTrial {
    std::uint64_t rays = 0;
    double apart = 0;     ///< pixels, between the ends in double and in float; of 99 % of the rays
    std::string why_not;  ///< empty: the plan follows float
};

/// Scene, geometry, kernel and job. Pointers in `job` point into this object: it is not copied.
struct Plan {
    SceneDescription scene;
    Options options;
    const Module* module = nullptr;
    const KernelInfo* kernel = nullptr;
    std::unique_ptr<SceneGeometry> geometry;
    std::uint32_t hamiltonian = 0;     ///< of the space: an index into Module::hamiltonians
    std::vector<double> parameters;    ///< of the Hamiltonian; of a formula its programs
    std::vector<double> programs;      ///< of Ω(H − H0), which the job follows, where the scene rescales a compiled H by an expression
    double unit = 1;                   ///< of the lengths in `scene`, `camera` and `job`, in units of the scene as written
    bool straight = false;             ///< every ray is a straight line: no integrator runs
    View view;
    CameraRays camera{};
    double time = 1;                   ///< −1: its rays live where time runs the other way, as those of a falling observer do
    bool spacetime = false;            ///< observers have rest frames, and light has a frequency
    bool each_direction = false;       ///< no map from directions to momenta serves the camera: each is solved for
    Job job{};
    std::optional<Pilot> pilot;
    std::optional<FloatTrial> float_trial;
    unsigned threads = 1;
    double load_seconds = 0;
    std::vector<std::string> remarks;  ///< one line each, of what the user may want to know of the scene

    Plan() = default;
    Plan(const Plan&) = delete;
    Plan& operator=(const Plan&) = delete;
};

/// The diagonal of its objects, or the radius of the escape sphere where there are none, in lengths of the scene as written.
double scene_size(const Plan& plan);

/// The names that scenes may use, from the module for `isa`.
Catalogue catalogue(const std::string& isa);

/// Throws InputError for what the scene or options ask that cannot be done: a refused method, a camera inside a surface …
/// `with_camera` is false for `trace`, which has its own rays and draws nothing.
std::unique_ptr<Plan> make_plan(SceneDescription scene, const Options& options, bool with_camera = true);

/// Whether the scene says by which expression H is rescaled: then its programs are of the rescaled H, whoever asks.
bool states_rescaling(const Plan& plan);

/// Whether Ω, where the scene states it, is not greater than 0 at q, relative to the centre: there is no ray there.
bool lacks_pace(const Plan& plan, const double (&q)[3]);

/// Whether a formula leaves open at q whether rays end there, or how long steps may be: there is no ray there either.
bool lacks_bounds(const Plan& plan, const double (&q)[3]);

/// Whether float would lose H: its terms are |p|², in units of p_t, and what must be left of them is |p|. A thousandth of that may go.
bool needs_double(const Plan& plan, double momentum);
/// What the steps of a method count, with H rescaled or not.
StepKind step_kind(const Plan& plan, std::uint32_t integrator, bool rescaled);
/// Null where a method serves the plan's space, else why not. A formula knows itself whether it is rescaled.
const char* refusal_of(const Plan& plan, std::uint32_t integrator, bool rescaled);

/// Of observer_names().
ObserverKind observer_named(const std::string& name);
const char* name_of(Strategy);
const char* name_of(Precision);
const char* name_of(Status);
/// None of "auto".
std::optional<Strategy> strategy_named(const std::string& name);
std::optional<Precision> precision_named(const std::string& name);
const char* describe(Failure);
/// The same of a ray that failed on its way, with what this scene may have to do with it.
std::string why_failed(const Plan&, Failure);

}  // namespace kagero
