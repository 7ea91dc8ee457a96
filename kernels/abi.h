/// The binary interface between the program and its kernel modules.
///
/// `src/` is compiled for baseline x86-64, each `kagero-kernels-<isa>.so` for one instruction set. Both share the plain
/// structs below and one exported function, `kagero_kernels`. Nothing here owns memory, throws or allocates.
/// Coordinates are those of the Hamiltonian: scene coordinates minus `space.center`.
#pragma once

#include "kernels/formula.h"
#include "kernels/parameter_set.h"
#include "kernels/ray_start.h"
#include "kernels/ray_status.h"
#include "kernels/shading.h"
#include "kernels/surfaces.h"
#include "kernels/unit.h"

#include <cstdint>
#include <limits>

namespace kagero {
inline constexpr std::uint32_t abi_version = 41;
/// How vector lanes are filled: not at all (scalar code), with parts of the work of one ray, or with one ray each.
enum class Strategy : std::uint8_t { scalar, per_ray, packet };
enum class Precision : std::uint8_t { float64, float32 };
/// The variant of a strategy. `gradient`, `stages` (per-ray): lanes hold gradient components, or stages of a Gauss
/// method. `auto_vectorized` (scalar): the compiler vectorizes. `gang` (packet): several packets share one loop.
enum class Form : std::uint8_t { none, gradient, stages, auto_vectorized, gang };

enum class ObserverKind : std::uint8_t { static_, zamo, falling, coordinate };
/// The curve inside a step that is intersected with surfaces: the chord or the dense output.
enum class HitModel : std::uint8_t { chord, hermite };

/// A parameter of a Hamiltonian. Legal values: `least <= value <= greatest`, or `least < value` if `least_open`.
struct ParameterInfo {
    const char* name;
    double default_value;
    double least, greatest;
    bool least_open;
    Unit unit;
    const char* meaning;
};

/// The description of a Hamiltonian, from the members of its header (hamiltonians/hamiltonian.h).
struct HamiltonianInfo {
    const char* name;
    const char* what;       ///< Description in one line.
    const char* formula;    ///< H as text.
    const char* source;     ///< Author, year, equation.
    const char* conserved;  ///< Quantities that are constant along a ray, as text.
    const ParameterInfo* parameters;
    std::uint32_t parameter_count;
    bool spacetime;      ///< Rays are null geodesics with a constant p_t; otherwise H is an index medium without p_t.
    bool rescales;       ///< Declares Ω, which `rescale = "auto"` uses.
    double level;        ///< H0, the value of H on every ray.
    const char* method;  ///< Default integrator.
    double step;         ///< Default step for the default values of the parameters.
    const char* step_goes_with = nullptr;   ///< Formula for a length; the default step is proportional to it.
    const char* index_parameter = nullptr;  ///< Name of the parameter whose inverse scales the default step.
    bool bounded = false;   ///< Declares a domain; rays escape at its edge.
    bool captures = false;  ///< Declares where rays are captured.
    bool discontinuous = false, bounds_steps = false;  ///< Declares a switching function; declares max_step_length.
    bool has_second_sheet = false;  ///< A throat leads to a second sheet, with a separate sky.
    bool cyclic[3] = {};            ///< For x, y, z: true if the integrated Hamiltonian does not depend on it.
    const char* orbit_method = nullptr;  ///< Default integrator with angular steps; null: there is none.
    double orbit_step = 0;               ///< Default step of that integrator, in radians.
};

/// The class of numerical methods that an integrator belongs to.
enum class MethodFamily : std::uint8_t { recipe, composition, exact_split, nystroem, runge_kutta, gauss };

/// The description of an integrator.
struct IntegratorInfo {
    const char* name;
    std::uint32_t order;
    bool symplectic = false, symmetric = false, implicit = false, adaptive = false;
    const char* what;             ///< Description and source in one line.
    bool angular = false, separated = false;  ///< Steps are angles (radians); so are those of the separated motion.
    bool drift_kick = false;      ///< Alternates drifts and kicks, so cyclic coordinates need one update per step.
    bool is_collocation = false;  ///< Implicit for every H; other implicit methods are explicit for |p|²/2 + V(q).
    bool representative = false;  ///< Represents its family where only a few methods are measured or shown.
    MethodFamily family{};              ///< Set from the stepper of the method.
};

/// The momentum of the ray from a unit direction d of an observer's rest frame: p_i = Σ_j matrix[i][j] d_j + offset[i].
struct StartMap {
    double position[3];    ///< Position q at the start of the ray, in the chart of the momentum.
    double matrix[4][3];   ///< Rows for i = x, y, z, t.
    double offset[4];
    double pt;             ///< If nonzero, momenta whose p_t has the same sign are scaled to this p_t.
    bool has_no_surfaces;  ///< The scene has no surfaces. Rays that are not scaled although `pt` ≠ 0 are then captured.
    bool ingoing;          ///< Rays start in ingoing coordinates (kernels/observers/charts.h).
    double metric[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< |d|² = Σ_ij d_i metric[i][j] d_j.
};

/// The rays of a perspective camera: in its rest frame pixel (x, y) has direction corner + (x+½)·right + (y+½)·down.
struct CameraRays {
    std::uint32_t width, height;
    double position[3];
    double clearance;  ///< Lower bound on the distance to the nearest surface; infinity if there are no surfaces.
    double corner[3], right[3], down[3];
    StartMap start;
};

/// The end of one ray: position q, momentum p of H (also if a rescaled H was integrated), unit vector v along dq/dλ.
/// Near a black hole, they are in outgoing coordinates, or in ingoing coordinates if q is inside the horizon.
struct RayEnd {
    double q[3], p[3], v[3];
    double pt;
    double parameter;     ///< λ of H; requires `output_parameter`.
    double energy_error;  ///< Maximum of |H−H0| / (|p·∂H/∂p| + |H0|) over the steps; requires `output_energy`.
    std::uint32_t steps;
    std::uint32_t gradients;   ///< Evaluations of the gradient of H; one of ∂H/∂q or ∂H/∂p alone counts as one.
    std::uint32_t iterations;  ///< Iterations of implicit solves, without those of refinement.
    std::uint32_t queries;     ///< Embree queries.
    float occupancy;           ///< Occupancy of the ray's packet (with refill: up to this ray's end); 0 without steps.
    std::uint32_t surface, primitive;  ///< For `hit`: index into Geometry::surfaces; triangle of that surface.
    Status status;
    Failure failure;
    bool unrefined;  ///< The chord hits the surface, but refinement found no hit; the position is approximate.
    bool cut_off;    ///< The path continues at too many surfaces (src/paths/trace_paths.h); kernels set it to false.
    // Set only if the job requests one of them; otherwise, they keep their values.
    double action;  ///< ∫ p·dq from the start of the ray; requires `output_action` or `output_time`.
    double time;    ///< ∫ ∂H/∂p_t dλ from the start of the ray; requires `output_time`, otherwise 0.
};

enum OutputBits : std::uint32_t { output_energy = 1, output_parameter = 2, output_action = 4, output_time = 8 };
inline constexpr std::uint32_t output_integrals = output_action | output_time;

/// A point of a ray's path, passed to Job::path_sink after every step; step 0 is the start. With Job::path_interval,
/// `step` is k for the point at k·path_interval, where λ of the path includes Job::path_offsets; `parameter` does not.
struct PathPoint {
    std::uint64_t ray;
    std::uint32_t step;
    double parameter, q[3], p[3], v[3], pt, energy;
    double action, time;  ///< As in RayEnd; 0 if they are not requested.
    std::uint32_t segment = 0, medium = 0;  ///< Set where a path continues at surfaces (src/paths/trace_paths.h).
};

/// The path of one ray, and the derivatives of the film coordinates (in pixels) of the ray's end.
struct RayPath {
    const PathPoint* points;  ///< In order from the start.
    std::uint32_t count;
    double normal[3];  ///< Normal of the surface or sphere on which the ray ends, of any length.
    double by_position[2][3], by_direction[2][3];  ///< Derivatives with respect to position and unit direction.
};

/// The data that all rays of a call of KernelInfo::trace share.
struct Job {
    std::uint32_t hamiltonian, integrator;  ///< Indices into Module::hamiltonians and Module::integrators.
    const double* parameters;  ///< In the declared order; for `formula`, the programs that Module::compile wrote.
    bool rescaled;             ///< Ω(q)·(H − H0) is integrated instead of H.
    double step;
    /// Greatest local error of adaptive methods, relative to a scale plus value_weight·|value|; the scale is
    /// position_scale for a component of q, and momentum_scale for a component of p.
    double tolerance;
    double position_scale = 1, momentum_scale = 1, value_weight = 1;
    double first_step_length = 0;  ///< Length of the first step of adaptive methods; 0: it is `step`.
    double max_step_length = std::numeric_limits<double>::infinity();        ///< Bound on |adaptive step|.
    double max_step_radius_ratio = std::numeric_limits<double>::infinity();  ///< Bound on |adaptive step| / |q|.
    /// A ray fails with `momentum_diverges` if |p| exceeds max_momentum while its steps are short, and with
    /// `steps_vanish` after many steps in a row that are shorter than min_step_length.
    double max_momentum = std::numeric_limits<double>::infinity(), min_step_length = 0;
    double solver_tolerance;  ///< Relative residual of implicit equations; 0: the rounding error.
    std::uint32_t max_steps;
    double escape_radius;  ///< Radius |q| of the escape sphere.
    double bending_radius = std::numeric_limits<double>::infinity();  ///< Radius |q| beyond which rays are straight.
    double inner_escape_radius;  ///< A ray with a smaller |q| escapes into the second sheet; 0: there is none.
    /// Rays are captured only where |(x, y, capture_stretch·z)| ≤ capture_radius: no surface lies farther inward.
    double capture_radius = std::numeric_limits<double>::infinity(), capture_stretch = 1;
    /// The black hole at the origin. Rays that start in ingoing coordinates change to outgoing coordinates where they
    /// leave the sphere |q| = chart_radius, or move inward inside it. If chart_radius is 0, rays keep their
    /// coordinates.
    Hole hole;
    double chart_radius;
    bool changes_chart_at_turns;  ///< Rays that turn outward inside that sphere change to ingoing coordinates.
    double parameter_limit;  ///< λ at which every ray ends exactly; infinity: no limit.
    bool use_symmetry;       ///< Cyclic coordinates are updated once per step if the method has `drift_kick`.
    HitModel hit;
    double chord_tolerance;  ///< Steps are cut until each chord is within this distance of the dense output.
    std::uint32_t outputs;   ///< OutputBits.
    const Geometry* geometry;  ///< Null: there are no surfaces.
    const CameraRays* camera;  ///< Null: the rays are those of `rays`.
    bool scanlines;            ///< Packets of camera rays are runs of one row, as in the paper, not blocks of pixels.
    const RayStart* rays;      ///< Null: the rays are those of `camera`.
    const ParameterSet* sets;  ///< For Module::sweep_kernel: ray i has the parameters of set i % set_count.
    std::uint32_t set_count;
    const ParameterSet* const* lane_sets;  ///< The sets of the lanes of one packet; null: all rays share this job's.
    bool refill;               ///< New rays are loaded into lanes whose ray has terminated.
    void (*path_sink)(void* user, const PathPoint*);  ///< Null: paths are not reported.
    void* path_user;
    double path_interval;           ///< If > 0, path_sink gets the points at its multiples λ instead of the steps.
    /// For each ray of `rays`, λ of its path at the start of the ray, to which path_interval refers; null: 0.
    const double* path_offsets = nullptr;
    bool timed;                     ///< Counters::query_ticks and refinement_ticks are measured.
    bool (*cancelled)(void* user);  ///< Called every few dozen steps; if true, the tile is abandoned. May be null.
    void* cancel_user;
};

/// The rays that one call traces: the half-open pixel rectangle of a camera, or [x0, x1) of a list (y0 = 0, y1 = 1).
struct Tile {
    std::uint32_t x0, y0, x1, y1;
};

/// Returns the width in pixels of the block that a packet of camera rays covers.
constexpr std::uint32_t block_width(std::uint32_t lanes) {
    return lanes >= 64 ? 8 : lanes >= 8 ? 4 : lanes >= 4 ? 2 : lanes;
}

/// The work of a call, summed over its rays.
struct Counters {
    std::uint64_t active_lane_steps, issued_lane_steps;
    std::uint64_t active_iterations, issued_iterations;  ///< Lane-iterations of implicit solves.
    std::uint64_t steps, gradients, queries;
    std::uint64_t ended[status_count];            ///< Number of rays with each Status.
    std::uint64_t unrefined;                      ///< Number of rays with RayEnd::unrefined.
    std::uint64_t query_ticks, refinement_ticks;  ///< Ticks of rdtsc in queries and refinement; requires Job::timed.
};

/// The numbers of floating-point operations of a method for one ray (kernels/integrators/costs.h).
struct Operations {
    double per_gradient, per_step;
    /// The same as per_step in a scene without surfaces, where orbit methods stay in the orbit plane.
    double per_step_without_surfaces;
};

/// A space and a method, for KernelInfo::refusal.
struct SpaceAndMethod {
    std::uint32_t hamiltonian;  ///< Index into Module::hamiltonians.
    const double* parameters;   ///< As in Job.
    std::uint32_t integrator;   ///< Index into Module::integrators.
    bool rescaled;              ///< As in Job.
    bool straight;              ///< True if all rays of the space are straight, so that no method is needed.
};

/// A kernel: one combination of strategy, precision and packet width.
struct KernelInfo {
    Strategy strategy;
    Precision precision;
    Form form;
    std::uint32_t lanes, registers;  ///< Rays per packet; registers per variable.
    /// Traces a tile. `ends` receives (x1−x0)·(y1−y0) entries, row by row.
    void (*trace)(const Job*, const Tile*, RayEnd* ends, Counters*);
    /// Returns null if the kernel supports this space and method, else the reason. A null pointer means full support.
    const char* (*refusal)(const SpaceAndMethod*);
};

/// The result of `kagero_kernels()`; valid as long as the module is loaded.
struct Module {
    std::uint32_t abi;  ///< Must equal abi_version.
    const char *isa, *compiler;
    const char* flags;  ///< Options of the compiler that code generation depends on.
    const HamiltonianInfo* hamiltonians;
    std::uint32_t hamiltonian_count;
    const IntegratorInfo* integrators;
    std::uint32_t integrator_count;
    const KernelInfo* kernels;
    std::uint32_t kernel_count;
    KernelInfo sweep_kernel;  ///< Traces lists of rays with different parameters (Job::sets); not one of `kernels`.

    /// Returns null if the integrator supports the Hamiltonian, rescaled or not, else the reason.
    const char* (*refusal)(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled);
    /// Returns true if these parameters make every ray straight, so that no integrator is needed.
    bool (*straight)(std::uint32_t hamiltonian, const double* parameters);
    /// Returns the radius |q| of the throat; the second sheet is inside, mirrored by inversion. 0: there is no throat.
    double (*throat_radius)(std::uint32_t hamiltonian, const double* parameters);
    /// Returns the radius |q| beyond which rays are straight; infinity if no such radius is declared.
    double (*bending_radius)(std::uint32_t hamiltonian, const double* parameters);
    /// Returns the black hole at the origin; a formula has none.
    Hole (*hole)(std::uint32_t hamiltonian, const double* parameters);
    /// Computes the map from directions in the rest frame of an observer at q to momenta. If `ingoing` is true, the
    /// momenta are in ingoing coordinates; this requires a black hole. Inside its horizon, they always are.
    Failure (*observe)(std::uint32_t hamiltonian, const double* parameters, ObserverKind, const double q[3],
                       bool ingoing, StartMap*);
    /// Computes the start of a ray at q with dq/dλ along d and H = H0.
    Failure (*start)(std::uint32_t hamiltonian, const double* parameters, const double q[3], const double d[3],
                     RayStart*);
    /// Computes what the starts of rays at q share.
    void (*prepare_starts)(std::uint32_t hamiltonian, const double* parameters, const double q[3], StartPosition*);
    /// Computes the same start as `start`, for a position that was prepared with the same Hamiltonian and parameters.
    Failure (*start_from)(std::uint32_t hamiltonian, const double* parameters, const StartPosition*, const double d[3],
                          RayStart*);
    /// Computes the continuations of rays at surfaces in this space. A medium without p_t ignores SurfaceRay::pt.
    void (*continue_rays)(std::uint32_t hamiltonian, const double* parameters, const SurfaceRay*, std::uint32_t count,
                          Continuation*);
    /// Computes p_t g_ti/g_tt at the positions of rays in a spacetime. In the rest frame of matter that does not move,
    /// the momentum of a ray is p_i minus this vector.
    void (*time_tilts)(std::uint32_t hamiltonian, const double* parameters, const SurfaceRay*, std::uint32_t count,
                       double (*tilts)[3]);
    /// Returns p · u, the frequency of a ray for matter at q that moves with the velocity v = dx/dt. NaN if |v| is not
    /// below the speed of light; 1 in an index medium.
    double (*frequency)(std::uint32_t hamiltonian, const double* parameters, const double q[3], const double p[3],
                        double pt, const double v[3]);
    ShadingFunctions shading;
    /// Converts the start of a ray from outgoing to ingoing coordinates; the position must be outside the horizon.
    void (*to_ingoing)(const Hole*, RayStart*);
    /// Converts the kernel's state of a ray in ingoing coordinates to the coordinates of the scene.
    void (*to_scene)(const Hole*, double q[3], double p[3], double* pt);
    /// Converts the momentum of a ray at the outgoing position q to that of the time-reversed ingoing form, rotated
    /// about the z axis to the azimuth of q.
    void (*momentum_in_ingoing_form)(const Hole*, const double q[3], double p[3], double* pt);
    /// Returns the Boyer–Lindquist radius r of a position near the hole.
    double (*hole_radius)(const Hole*, const double q[3]);

    /// Differentiates a formula; writes its programs, `program_size` numbers. Returns null on success, else the reason.
    const char* (*compile)(const Formula*, double* programs);
    std::uint32_t program_size;
    /// Returns null if the integrator supports these programs, else the reason.
    const char* (*formula_refusal)(const double* programs, std::uint32_t integrator);
    FormulaFunctions formula_functions;  ///< Functions for the compilation of these programs to machine code.

    /// Returns the numbers of floating-point operations of one ray with this integrator.
    Operations (*operations)(std::uint32_t hamiltonian, const double* parameters, std::uint32_t integrator,
                             bool rescaled);
    /// Writes, for each path, a bound in pixels on the effect of rounding errors on the film position of its end, by a
    /// reverse sweep along the path. `unit_roundoff` is that of the number type: half a unit in the last place of 1.
    void (*bound_roundings)(const Job*, const RayPath*, std::uint32_t count, double unit_roundoff, double* pixels);
    /// Runs multiply-adds at the peak rate of the instruction set. Returns the number of floating-point operations.
    double (*multiply_adds)(Precision, std::uint64_t rounds);
};

}  // namespace kagero

extern "C" {
using KageroKernels = const kagero::Module* (*)();
#ifdef KAGERO_MODULE
__attribute__((visibility("default"))) const kagero::Module* kagero_kernels();
#endif
}
