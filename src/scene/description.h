/// A scene as written: plain values, every default filled in, nothing loaded yet.
#pragma once

#include "error.h"
#include "formula/formula.h"
#include "kernels/abi.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

using Double3 = std::array<double, 3>;

/// A Hamiltonian written in the scene: its texts as given, and what they were parsed to.
struct FormulaDescription {
    std::string energy;
    double level = 0;                              ///< H0
    std::vector<std::string> parts;                ///< two or none
    std::string domain, capture, length_scale;     ///< "" where there is none
    std::vector<std::pair<std::string, double>> constants;
    std::vector<std::pair<std::string, std::string>> helpers;

    FormulaScope scope;                            ///< all nodes; the formula below has no pointer to them
    Formula parsed{nullptr, 0, -1, -1, -1, -1, -1, {-1, -1}, 0, 0};
    Place place;                                   ///< of H
};

struct SpaceDescription {
    std::string hamiltonian;
    std::optional<FormulaDescription> formula;     ///< where hamiltonian is "formula"
    std::vector<std::pair<std::string, double>> parameters;  ///< in the Hamiltonian's declared order, all present
    Double3 center{0, 0, 0};
    bool far_sided = false;            ///< it has another universe, with a sky of its own: `[sky.far]`
};

/// An expression by which the scene rescales a compiled Hamiltonian.
struct RescalingDescription {
    FormulaScope scope;
    std::int32_t node = -1;
};

/// The unit of a method's step: a length for the parameter of H, a number for that of a spacetime's rescaled H, radians
/// along an orbit.
enum class StepKind { length, number, angle };

/// Whether new rays are loaded into lanes whose rays have ended; automatic: where a measurement says that it pays.
enum class Refill { automatic, on, off };
/// As scenes write them, in the same order.
const std::vector<std::string>& refill_names();

struct IntegratorDescription {
    std::string method;                ///< resolved: never empty after loading
    std::optional<Place> method_place, step_place, tolerance_place, lanes_place,
        rescale_place;                 ///< where the scene states them, for what is said later
    double step = 0;                   ///< resolved; adaptive methods start with it
    std::array<double, 3> default_step{};  ///< by StepKind: where none is stated
    double tolerance = 1e-6;           ///< local error of adaptive methods, relative to 1 + |value|
    double solver_tolerance = 0;       ///< 0: to rounding
    std::uint32_t max_steps = 20000;
    double escape_radius = 50;
    HitModel hit = HitModel::hermite;
    bool cull = true;
    bool use_symmetry = true;  ///< the plane of an orbit, and cyclic coordinates, may be used; symmetry = "none": never
    Refill refill = Refill::automatic;
    double max_pixel_error =
        0;  ///< step, precision, and the method unless it is stated, are chosen to meet it; 0: nothing is
    std::uint32_t lanes = 0;           ///< rays per packet; 0: as many as suit the machine
    std::string rescale = "auto";      ///< "auto" | "none" | an expression
    std::optional<RescalingDescription>
        rescaling;  ///< … of a compiled Hamiltonian; those of a formula are among its nodes
};

/// "static", "zamo", "falling", "coordinate", as ObserverKind has them.
const std::vector<std::string>& observer_names();
inline const std::string& name_of(ObserverKind observer) {
    return observer_names()[static_cast<std::size_t>(observer)];
}

enum class CameraType { perspective, equirectangular, orthographic };
/// As scenes write them, in the same order.
const std::vector<std::string>& camera_type_names();
inline const std::string& name_of(CameraType type) { return camera_type_names()[static_cast<std::size_t>(type)]; }

struct CameraDescription {
    CameraType type = CameraType::perspective;
    Double3 position{}, look_at{}, up{0, 1, 0};
    double fov = 60;                   ///< perspective: vertical, degrees
    double height = 2;                 ///< orthographic: of the picture, scene units
    ObserverKind observer = ObserverKind::static_;
    Place position_place;              ///< for messages found later
    std::optional<Place> fov_place, observer_place;  ///< where the scene states them
};

struct FilmDescription {
    std::uint32_t width = 0, height = 0;
    std::uint32_t spp = 1;             ///< rays per pixel
    std::uint32_t seed = 0;            ///< of where in the pixel they lie, if more than one
    std::vector<std::string> layers{"color"};
};

/// The source of the colour of a surface or a sky. Exactly one of the three kinds is in use.
struct Paint {
    enum class Kind { color, texture, checker };
    Kind kind = Kind::color;
    Double3 color{0.8, 0.8, 0.8};
    std::string texture;               ///< absolute path
    std::array<double, 2> checker{8, 8};
    Place place;
};

struct SkyDescription {
    Paint paint{Paint::Kind::color, {0, 0, 0}, {}, {}, {}};
    Double3 pole{0, 0, 1};
};

enum class Shape { rectangle, box, room, sphere, mesh, disk };
/// Their names in scenes, in the same order; and the faces of a box or room, in that of ObjectDescription::faces.
const std::vector<std::string>& shape_names();
const std::vector<std::string>& face_names();
enum class Shading { emission, lambert };

struct ObjectDescription {
    std::string name;
    Shape shape{};
    Double3 origin{}, edge_u{}, edge_v{};          // rectangle
    Double3 min{}, max{};                          // box, room
    std::array<Paint, 6> faces;  // box, room: px nx py ny pz nz; all equal to `paint` unless `faces` says otherwise
    Double3 center{}; double radius = 0;           // sphere; center: disk too
    Double3 normal{0, 0, 1};                       // disk: its matter orbits in the right-handed sense about it
    double inner = 0, outer = 0;                   // disk: radii
    double temperature = 0;                        // disk: kelvin at the inner edge; 0: it has a paint instead
    Place center_place, normal_place;              // disk: for what only the space tells
    std::string file;                              // mesh: absolute path
    Place file_place;
    Double3 translate{}, rotate{}; double scale = 1;
    Paint paint;
    Shading shading = Shading::emission;
    Place place;
};

struct SceneDescription {
    std::string path;                              ///< as given
    std::string text;                              ///< the file's text, for the picture's metadata
    std::vector<std::string> overrides;            ///< texts of those that were given
    SpaceDescription space;
    IntegratorDescription integrator;
    CameraDescription camera;
    FilmDescription film;
    SkyDescription sky;
    SkyDescription far_sky;                        ///< of a wormhole's other universe
    std::vector<ObjectDescription> objects;
};

/// The names of a table of Hamiltonians or integrators.
template <class Info>
std::vector<std::string> names_of(const Info* infos, std::uint32_t count) {
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i < count; ++i) names.emplace_back(infos[i].name);
    return names;
}

/// The names a scene may use; taken from a loaded kernel module.
struct Catalogue {
    const HamiltonianInfo* hamiltonians = nullptr;
    std::uint32_t hamiltonian_count = 0;
    const IntegratorInfo* integrators = nullptr;
    std::uint32_t integrator_count = 0;
    std::vector<std::string> layers;
    /// Null where there is none of that name.
    const HamiltonianInfo* hamiltonian_named(const std::string& name) const;
    /// Null where a method serves a space, whose H is rescaled or not; else why not.
    const char* (*refusal)(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled) = nullptr;
};

/// A key set from outside the scene.
struct Override {
    std::string text;  ///< "key.path=value" in TOML syntax; a bare word is taken as a string
    std::string said;  ///< how the user said it, for messages; empty: as -D and the text

    Override(const char* t) : text(t) {}
    Override(std::string t, std::string how = {}) : text(std::move(t)), said(std::move(how)) {}
};

}  // namespace kagero
