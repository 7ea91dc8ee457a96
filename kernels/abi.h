/// The wall between the program and its kernel modules.
///
/// `src/` is ordinary baseline x86-64; each `kagero-kernels-<isa>.so` is compiled for one instruction set. They share
/// the plain structs below and one exported function, `kagero_kernels`. Nothing here owns memory, throws or allocates.
/// Coordinates on this side of the wall are those of the Hamiltonian: scene coordinates minus `space.center`.
#pragma once

#include "kernels/unit.h"

#include <cstdint>
#include <limits>

namespace kagero {

inline constexpr std::uint32_t abi_version = 27;
enum class Strategy : std::uint8_t { scalar, per_ray, packet };
enum class Precision : std::uint8_t { float64, float32 };
/// What a strategy puts into vectors where it has a choice: per-ray the components of the gradient or the stages of a
/// Gauss method; `auto_vectorized` is the scalar code as the compiler regroups it by itself, a `gang` many packets in
/// lockstep.
enum class Form : std::uint8_t { none, gradient, stages, auto_vectorized, gang };

/// How a ray ended. Every ray ends in exactly one of these.
enum class Status : std::uint8_t { hit, escaped, captured, step_limit, failed };
inline constexpr std::uint32_t status_count = 5;

/// Why a ray `failed`; `none` of all others.
enum class Failure : std::uint8_t {
    none,
    zero_direction,   ///< the direction has length zero
    nonfinite_start,  ///< a coordinate of the start or direction is infinite or not a number
    singular_start,   ///< H or its derivatives do not exist at the start
    too_far,          ///< squares of the start's coordinates are out of the range of the number type
    no_observer,      ///< the space has no such observer, or none can be here
    no_rest_frame,    ///< H is no light in a spacetime: its rays start along directions in coordinates
    no_momentum,      ///< no real momentum has this direction and H = H0 (inside a horizon, a negative index …)
    not_converged,    ///< a step found no solution, or none within its tolerance, however often it was shortened
    not_landed,       ///< the end of its last step leads to no place on what it meets, however often that was halved
    not_finite,  ///< the state left the range of the number type, or Ω or the greatest length of a step is not greater
                 ///< than 0
    no_pace,     ///< Ω is not greater than 0 at the start
    no_bounds,   ///< what a formula states of domain, capture or length of steps is no number at the start, or no such
                 ///< length
    untraced,    ///< the run was interrupted before
    energy_lost,   ///< a step loses H, even after halving it: what it leads to is no ray
    needs_double,  ///< the momentum is so large here that float would lose H at once
};

enum class ObserverKind : std::uint8_t { static_, zamo, falling, coordinate };
enum class HitModel : std::uint8_t { chord, hermite };

/// One parameter that a Hamiltonian declares; `least <= value <= greatest` is the legal range (`least_open`: `least <
/// value`).
struct ParameterInfo {
    const char* name;
    double fallback;
    double least, greatest;
    bool least_open;
    Unit unit;
    const char* meaning;
    bool odd = false;  ///< of the other sign where time runs the other way
};

/// What a Hamiltonian's header says of itself.
struct HamiltonianInfo {
    const char* name;
    const char* what;       ///< one line
    const char* formula;    ///< H as text
    const char* source;     ///< author, year, equation
    const char* conserved;  ///< quantities constant along a ray, as text
    const ParameterInfo* parameters;
    std::uint32_t parameter_count;
    bool spacetime;          ///< null rays with p_t; else an index medium without p_t
    bool rescales;           ///< declares a time transformation, used by `rescale = "auto"`
    double level;            ///< H0, the level set rays are started on
    const char* method;      ///< default integrator
    double step;             ///< its default step …
    const char* step_goes_with = nullptr;  ///< … for the parameters' defaults: a formula in them and escape_radius, of
                                           ///< the length that it goes with
    const char* index_parameter = nullptr;  ///< an index of refraction: the step goes with its inverse too
    bool bounded = false, captures = false;  ///< rays may end at the edge of the medium, or captured
    bool discontinuous = false, bounds_steps = false;  ///< H is not smooth somewhere; it bounds the length of steps
    bool far_sided = false;  ///< there is another universe, with a sky of its own
    bool cyclic[3] = {};                     ///< coordinates that do not occur in what is integrated
    const char* orbit_method = nullptr;      ///< integrator in the plane of the orbit, taken unasked; null: none
    double orbit_step = 0;                   ///< its default step, radians
};

/// What matter orbits at the origin of a space: lengths GM/c² and angular momentum per mass, along +z. Mass 0: nothing.
struct Hole {
    double mass = 0, spin = 0;
};

/// What methods have in common.
enum class Family : std::uint8_t { recipe, composition, exact_split, nystroem, runge_kutta, gauss };

/// One integrator.
struct IntegratorInfo {
    const char* name;
    std::uint32_t order;
    bool symplectic = false, symmetric = false, implicit = false, adaptive = false;
    const char* what;      ///< one line with its source
    bool angular = false;  ///< steps are angles, not lengths of the integration parameter
    bool drifts = false;   ///< drifts along p and kicks in turn, so that cyclic coordinates can wait for a step's end
    bool collocates = false;  ///< implicit for every H; others that are implicit are not for |p|²/2 + V(q)
    bool typical = false;  ///< stands for its family where few methods are measured, or shown
    Family family{};       ///< as its kind of step says
};

/// One surface of the scene, which is one object (a box has one surface, so has a mesh), in the order of the scene's
/// objects and of Embree's geometry identifiers; in double, for refinement.
struct Surface {
    enum class Kind : std::uint8_t { triangles, sphere };
    Kind kind;
    const double* vertices;          ///< 3 per vertex (triangles)
    const std::uint32_t* triangles;  ///< 3 indices per triangle
    const double* planes;            ///< 4 per triangle: unit normal n and d of n·q = d
    double center[3];                ///< sphere
    double radius;
};

/// Boxes without a surface, found by the cell of a grid that a place is in. All surfaces lie within the grid.
struct ClearanceGrid {
    const float* box;       ///< of each cell, x fastest: which of `boxes`
    const float* boxes;     ///< six numbers each, in cells from the origin: lower x, y, z, upper x, y, z. The first six
                            ///< are what lies beyond the grid's faces
    std::uint32_t cells[3];
    double origin[3], cell[3];  ///< where the first cell begins; edges of a cell
};

/// What rays can meet. Embree works in float on coordinates shifted and scaled to order one: e = (q − shift) · scale.
struct Geometry {
    void* embree_scene;  ///< RTCScene, committed
    double shift[3];
    double scale;
    const Surface* surfaces;
    std::uint32_t surface_count;
    const ClearanceGrid* clearance;  ///< null: every segment is queried
};

/// The momentum of a ray that an observer sees in the unit direction d of its rest frame: p_i = Σ_j matrix[i][j] d_j +
/// offset[i] for i = x, y, z, t; where `pt` is not 0 scaled to this p_t, if p_t > 0. Rays of other p_t, inside an
/// ergosphere, were never outside: where there is the sky alone they are captured at once. Directions have unit length
/// where Σ_ij d_i metric[i][j] d_j = 1.
struct StartMap {
    double matrix[4][3];
    double offset[4];
    double pt;
    bool sky_alone;
    double metric[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};

/// One ray given by its canonical state.
struct RayStart {
    double q[3], p[3], pt;
    Failure failure;  ///< a start that cannot be used ends as `failed` at once
    bool captured;    ///< no light comes from this direction: the ray ends as `captured` at once
    bool escaped;     ///< it starts beyond the escape sphere, outward, where H cannot be evaluated: it ends there, as
                      ///< `escaped`
};

/// Rays of a perspective camera: pixel (x, y) looks along corner + (x+½)·right + (y+½)·down in the observer's rest
/// frame.
struct CameraRays {
    std::uint32_t width, height;
    double position[3];
    double clear;  ///< no surface is closer to it than this; infinity without any
    double corner[3], right[3], down[3];
    StartMap start;
};

/// The end of one ray. Positions q, momenta p of H (also when a rescaled H was integrated), v the unit direction of
/// dq/dλ.
struct RayEnd {
    double q[3], p[3], v[3];
    double pt;
    double parameter;     ///< λ of H; only with `output_parameter`
    double energy_error;  ///< max |H−H0| / (|p·∂H/∂p| + |H0|); only with `output_energy`
    std::uint32_t steps;
    std::uint32_t gradients;  ///< evaluations of the derivative program, one-sided ones included
    std::uint32_t iterations;  ///< of implicit solves, those of finding the hit aside
    std::uint32_t queries;     ///< of the scene
    float occupancy;  ///< of the lanes of its packet over the packet's steps (with refill: up to this ray's end); 0
                      ///< without steps
    std::uint32_t surface, primitive;  ///< if `hit`: index into Geometry::surfaces, and of what was met of it
    Status status;
    Failure failure;
    bool unrefined;  ///< the hit is the chord's: it meets a surface that the ray, within its tolerance, misses
};

enum OutputBits : std::uint32_t { output_energy = 1, output_parameter = 2 };

/// One point of a ray's path, handed to Job::path_sink after every step (step 0 is the start).
struct PathPoint {
    std::uint64_t ray;
    std::uint32_t step;
    double parameter, q[3], p[3], v[3], pt, energy;
};

/// The path of one ray, and what is seen at its end, to first order: two numbers, in pixels of the film, and how they
/// move with the end and with the unit direction there.
struct RayPath {
    const PathPoint* points;  ///< from the start
    std::uint32_t count;
    double normal[3];         ///< of what the ray ends on, of any length
    double by_position[2][3], by_direction[2][3];
};

enum class Op : std::uint8_t;  // kernels/operation.h

/// One operation of a formula; its operands are earlier nodes of the list. `a` of an input is its place in x y z px py
/// pz pt.
struct FormulaNode {
    Op op;
    std::int32_t a, b;
    double value;  ///< of a constant
};

/// A Hamiltonian written in a scene: expressions as places in one list of nodes, −1 where there is none. Where `energy`
/// is −1, H and what it states are those of the compiled Hamiltonian `hamiltonian`, and `rescale` is the only
/// expression.
struct Formula {
    const FormulaNode* nodes;
    std::uint32_t node_count;
    std::int32_t energy;
    std::int32_t domain, capture;  ///< the ray is escaped, captured, where they are ≤ 0
    std::int32_t length_scale;     ///< no step is longer
    std::int32_t rescale;          ///< Ω(q): the rays are those of Ω·(H − H0)
    std::int32_t parts[2];         ///< H_A and H_B: both or none
    double level;                  ///< H0
    double pt;
    std::uint32_t hamiltonian = 0;  ///< where `energy` is −1: an index into Module::hamiltonians, and its parameters
    const double* parameters = nullptr;
};
inline constexpr std::uint32_t formula_limit = 4096;  ///< nodes

/// Everything that all rays of a job share.
struct Job {
    std::uint32_t hamiltonian, integrator;  ///< indices into Module::hamiltonians, ::integrators
    const double* parameters;  ///< of the Hamiltonian, in its declared order; of `formula` what Module::compile wrote
    bool rescaled;                          ///< integrate Ω(q)·(H − H0) instead of H
    double step;
    double tolerance;         ///< local error of adaptive methods, relative to 1 + |value|
    /// In a space that bounds its steps adaptive methods go no farther than this share of |q|: they leap over what lies
    /// between their stages.
    double longest_share = std::numeric_limits<double>::infinity();
    double solver_tolerance;  ///< of implicit equations, relative; 0: to rounding
    std::uint32_t max_steps;
    double escape_radius,
        bends_within = std::numeric_limits<double>::infinity();  ///< of |q|; beyond the second rays are straight
    double inner_escape_radius;  ///< rays that fall below it are escaped too, into a wormhole's other universe; 0:
                                 ///< there is none
    /// A ray that falls inward and will not come out is captured at once where nothing can be met further in: within
    /// this |(x, y, stretch z)|.
    double capture_within = std::numeric_limits<double>::infinity(), capture_stretch = 1;
    double parameter_limit;  ///< infinity, or the λ at which every ray is ended exactly
    bool use_symmetry;       ///< leave to each step's end the coordinates that do not occur in H, where the method can
    HitModel hit;
    double chord_tolerance;  ///< chords closer than this to the dense output are not split
    std::uint32_t outputs;   ///< OutputBits
    const Geometry* geometry;  ///< null: nothing to meet
    const CameraRays* camera;  ///< either this
    bool scanlines;            ///< … in packets that are runs of a row, as the paper's, instead of blocks
    const RayStart* rays;      ///< or a list
    bool refill;               ///< new rays into finished lanes
    void (*path_sink)(void* user, const PathPoint*);  ///< null: no paths
    void* path_user;
    bool timed;  ///< fill Counters::query_ticks and landing_ticks
    bool (*halted)(void* user);  ///< asked every few dozen steps; true: the call returns at once, its tile half done.
                                 ///< Null: never asked
    void* halted_user;
};

/// The rays one call traces: the half-open pixel rectangle of a camera, or [x0, x1) of a list (y0 = 0, y1 = 1).
struct Tile {
    std::uint32_t x0, y0, x1, y1;
};

/// A packet of so many rays of a camera is a block of pixels so wide.
constexpr std::uint32_t block_width(std::uint32_t lanes) {
    return lanes >= 64 ? 8 : lanes >= 8 ? 4 : lanes >= 4 ? 2 : lanes;
}

/// Work done, summed over a call.
struct Counters {
    std::uint64_t active_lane_steps, issued_lane_steps;
    std::uint64_t active_iterations, issued_iterations;  ///< lane-iterations of implicit solves
    std::uint64_t steps, gradients, queries;
    std::uint64_t ended[status_count];  ///< rays, by Status
    std::uint64_t unrefined;            ///< … of which RayEnd says so
    std::uint64_t query_ticks,
        landing_ticks;  ///< of the processor's clock (rdtsc), in queries and in refining hits; only with Job::timed
};

/// Floating-point operations of a method, counted in what it runs: see kernels/integrators/costs.h.
struct Operations {
    double per_gradient, per_step;
    double per_step_alone;  ///< where rays meet nothing, and the method need not come back to points of space
};

/// One way of running a job.
struct KernelInfo {
    Strategy strategy;
    Precision precision;
    Form form;
    std::uint32_t lanes, registers;  ///< rays per packet, registers per variable
    /// Traces a tile. `ends` receives (x1−x0)·(y1−y0) entries, row by row.
    void (*trace)(const Job*, const Tile*, RayEnd* ends, Counters*);
    /// Null when it serves the space and the method (which straight rays have none of) as far as the module does, else
    /// why not. A null pointer: it serves them all.
    const char* (*refusal)(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled, bool straight);
};

/// What `kagero_kernels()` returns; lives as long as the module is loaded.
struct Module {
    std::uint32_t abi;  ///< must equal abi_version
    const char *isa, *compiler;
    const HamiltonianInfo* hamiltonians;
    std::uint32_t hamiltonian_count;
    const IntegratorInfo* integrators;
    std::uint32_t integrator_count;
    const KernelInfo* kernels;
    std::uint32_t kernel_count;

    /// Null when the integrator serves the Hamiltonian, rescaled or as it is, else why not.
    const char* (*refusal)(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled);
    /// True where these parameters make every ray straight, so that no integrator is needed.
    bool (*straight)(std::uint32_t hamiltonian, const double* parameters);
    /// The radius |q| inside of which lies another universe, mirrored by inversion; 0 where there is none.
    double (*throat_radius)(std::uint32_t hamiltonian, const double* parameters);
    /// The radius |q| beyond which rays are straight; infinity where none is known.
    double (*bends_within)(std::uint32_t hamiltonian, const double* parameters);
    /// The hole at its origin; of a formula none is known.
    Hole (*hole)(std::uint32_t hamiltonian, const double* parameters);
    /// The momenta an observer of this kind at q assigns to directions of its rest frame.
    Failure (*observe)(std::uint32_t hamiltonian, const double* parameters, ObserverKind, const double q[3], StartMap*);
    /// The state with dq/dλ along d and H = H0.
    Failure (*start)(std::uint32_t hamiltonian, const double* parameters, const double q[3], const double d[3],
                     RayStart*);
    /// p · u: the frequency of a ray as matter at q sees it that moves with the velocity v = dx/dt; `time` is −1 for
    /// rays of a falling observer, else 1. Not a number where v is no velocity of matter; 1 in an index medium, where
    /// nothing moves and the frequency is the same everywhere.
    double (*frequency)(std::uint32_t hamiltonian, const double* parameters, const double q[3], const double p[3],
                        double pt, const double v[3], double time);

    /// Differentiates a formula and writes its programs, which stand for the parameters of the Hamiltonian `formula`,
    /// to `program_size` numbers. Null when that worked, else why not.
    const char* (*compile)(const Formula*, double* programs);
    std::uint32_t program_size;
    /// Null when the integrator serves these programs, else why not.
    const char* (*formula_refusal)(const double* programs, std::uint32_t integrator);

    /// What a gradient and a step of this integrator cost one ray.
    Operations (*operations)(std::uint32_t hamiltonian, const double* parameters, std::uint32_t integrator,
                             bool rescaled);
    /// The most that the roundings of this method, in the job's space, can do to what is seen at the ends of rays,
    /// where numbers have this half of a last place: pixels, by a reverse sweep along their paths.
    void (*bound_roundings)(const Job*, const RayPath*, std::uint32_t count, double half_place, double* pixels);
    /// Multiply-adds that wait for nothing: the most this instruction set can do. Returns the floating-point operations
    /// done.
    double (*multiply_adds)(Precision, std::uint64_t rounds);
};

}  // namespace kagero

extern "C" {
using KageroKernels = const kagero::Module* (*)();
#ifdef KAGERO_MODULE
__attribute__((visibility("default"))) const kagero::Module* kagero_kernels();
#endif
}
