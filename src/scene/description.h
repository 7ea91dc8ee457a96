/// The description of a scene: plain values with all defaults filled in. The description contains the paths of meshes
/// and images, not their content. Lengths are in units of the scene file until `convert_lengths` (src/plan/units.h)
/// converts them to the unit of the kernels.
#pragma once

#include "error.h"
#include "film/tone.h"
#include "formula/formula.h"
#include "kernels/abi.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// A vector: x, y, z or red, green, blue.
using Double3 = std::array<double, 3>;

/// A velocity dq/dt whose components are numbers or formulas in x y z.
struct VelocityDescription {
    std::array<std::string, 3> components;  ///< The components as TOML values.
    FormulaScope scope;                     ///< Nodes of the formulas.
    std::array<std::int32_t, 3> nodes{};    ///< Indices of their roots in `scope.nodes`.
    double length_unit = 1;                 ///< Unit of positions, in units of the x y z of the formulas.
    FileLocation location;                  ///< Position of the value, for messages.
};

/// A Hamiltonian that is written in the scene file: the texts of its formulas, and the parsed formulas.
struct FormulaDescription {
    std::string table = "space";                   ///< Name of its table, for messages: "space" or "medium.NAME".
    std::string energy;                            ///< Text of H.
    double level = 0;                              ///< H0, the value of H on every ray.
    std::vector<std::string> parts;                ///< Texts of H_A and H_B, or empty.
    /// Texts of the optional formulas; "" if the key is missing.
    std::string domain, capture, length_scale, far_domain;
    std::vector<std::pair<std::string, double>> constants;     ///< Names and values in [space.constants].
    std::vector<std::pair<std::string, std::string>> helpers;  ///< Names and formulas in [space.let].

    FormulaScope scope;                            ///< Nodes of all these formulas.
    /// For each formula, the index of its root in `scope.nodes`; −1 if the key is missing. `parsed.nodes` is null.
    Formula parsed{nullptr, 0, -1, -1, -1, -1, -1, {-1, -1}, 0, 0};
    std::int32_t far_domain_node = -1;             ///< Root of `far_domain`; −1 if the key is missing.
    FileLocation location;                         ///< Position of the key H.
};

/// The table [space], or the space of a [[medium]].
struct SpaceDescription {
    std::string hamiltonian;
    std::optional<FormulaDescription> formula;     ///< Only if `hamiltonian` is "formula".
    std::vector<std::pair<std::string, double>> parameters;  ///< In HamiltonianInfo::parameters' order.
    Double3 center{0, 0, 0};
    bool has_second_sheet = false;                 ///< True if a second sky, `[sky.far]`, is legal.
    std::optional<VelocityDescription> sky_frame;  ///< Velocity of the distant observers who see the sky.
};

/// The expression Ω with which the scene rescales a built-in Hamiltonian.
struct RescalingDescription {
    FormulaScope scope;      ///< Nodes of the expression.
    std::int32_t node = -1;  ///< Index of the root of the expression in `scope.nodes`.
};

/// The unit of a step: a length if H is integrated, a pure number if the rescaled H of a spacetime is integrated, and
/// radians if an orbit method is used.
enum class StepKind { length, number, angle };

/// Use of refill. `automatic` enables refill for those kernels for which measurements found it to be faster.
enum class Refill { automatic, on, off };
/// Returns the names of the values of Refill in scene files, in the same order.
const std::vector<std::string>& refill_names();

/// The table [integrator], or [medium.integrator].
struct IntegratorDescription {
    std::string method;                ///< Stated or default method; never empty after loading.
    /// Positions of the keys, for messages; empty if the scene does not state the key.
    std::optional<FileLocation> method_location, step_location, tolerance_location, lanes_location, rescale_location;
    double step = 0;                   ///< Stated or default step; the first step of adaptive methods.
    std::array<double, 3> default_step{};  ///< Default steps, indexed by StepKind.
    double tolerance = 1e-6;           ///< Adaptive methods: bound on the local error of x, relative to 1 + |x|.
    double solver_tolerance = 0;       ///< Relative residual of implicit stages; 0: as small as rounding permits.
    std::uint32_t max_steps = 20000;
    double escape_radius = 50;
    HitModel hit = HitModel::hermite;  ///< Curve that is intersected with surfaces: chord or dense output.
    bool cull = true;                  ///< True if queries are left out for steps that cannot meet a surface.
    bool use_symmetry = true;          ///< Permits orbit methods and cyclic coordinates; false for symmetry = "none".
    Refill refill = Refill::automatic;
    /// Bound on the pixel error; 0: no bound. To meet it, a trial chooses the step and the precision, and the method if
    /// the scene states none.
    double max_pixel_error = 0;
    std::uint32_t lanes = 0;           ///< Rays per packet; 0: chosen for the machine.
    std::string rescale = "auto";      ///< "auto", "none" or an expression.
    /// The parsed expression `rescale` for a built-in Hamiltonian; for a formula, it is in FormulaDescription::parsed.
    std::optional<RescalingDescription> rescaling;
};

/// One table [[medium]]: a space inside the surfaces that bound it. Index 0 of a medium is [space], and index i is
/// SceneDescription::media[i - 1].
struct MediumDescription {
    std::string name;
    SpaceDescription space;
    IntegratorDescription integrator;
    FileLocation location;
};

/// Returns "static", "zamo", "falling", "coordinate": the names of the values of ObserverKind, in the same order.
const std::vector<std::string>& observer_names();
inline const std::string& name_of(ObserverKind observer) {
    return observer_names()[static_cast<std::size_t>(observer)];
}

enum class CameraType { perspective, equirectangular, orthographic };
/// Returns the names of the values of CameraType in scene files, in the same order.
const std::vector<std::string>& camera_type_names();
inline const std::string& name_of(CameraType type) { return camera_type_names()[static_cast<std::size_t>(type)]; }

/// The table [camera].
struct CameraDescription {
    CameraType type = CameraType::perspective;
    Double3 position{}, look_at{}, up{0, 1, 0};
    double fov = 60;                   ///< Vertical field of view of a perspective camera, degrees.
    double height = 2;                 ///< Height of the picture of an orthographic camera, a length.
    double shutter = 0;                ///< Share of the time of a frame during which the shutter is open, from 0 to 1.
    double aperture_radius = 0;        ///< Radius of a thin lens, a length; 0: a pinhole.
    bool states_focus_distance = false;  ///< False: focus_distance is that of look_at.
    double focus_distance = 0;           ///< Distance at which a lens shows points sharply.
    ObserverKind observer = ObserverKind::static_;
    std::optional<VelocityDescription> velocity;  ///< Replaces `observer` if the scene states it.
    FileLocation position_location;    ///< Position of the key `position`, for messages.
    std::string medium = "auto";       ///< The medium around the camera: a name, or "auto".
    std::optional<std::uint32_t> medium_index;  ///< Index of the stated medium; empty for "auto".
    /// Positions of the keys; empty if the scene does not state the key.
    std::optional<FileLocation> fov_location, observer_location, medium_location, aperture_location;
};

/// The table [film].
/// The rays of a picture that are traced: all, or only as many as are necessary to interpolate the others.
enum class Sampling { full, adaptive };
/// Returns the names of the values of Sampling in scene files, in the same order.
inline const std::vector<std::string>& sampling_names() {
    static const std::vector<std::string> names{"full", "adaptive"};
    return names;
}

struct FilmDescription {
    std::uint32_t width = 0, height = 0;
    std::uint32_t spp = 1;             ///< Rays per pixel.
    std::uint32_t seed = 0;            ///< Seed for the positions of rays in a pixel, if spp > 1.
    std::vector<std::string> layers{"color"};
    std::uint32_t max_bounces = 8;  ///< Greatest number of surfaces on the path of a pixel that send its light on.
    Tone tone;                      ///< Conversion of the colours for displays.
    Sampling sampling = Sampling::full;
    double max_interpolation_error = 0.25;  ///< Bound on the error of interpolated ray ends, in pixels.
};

/// Continuation of an image beyond its edges: repetitions of the image, the texels at the edges, or repetitions of
/// which every second one is mirrored.
enum class BeyondEdge { repeat, clamp, mirror };

/// The paint of a surface or a sky.
struct Paint {
    enum class Kind { color, texture, checker };
    Kind kind = Kind::color;
    Double3 color{0.8, 0.8, 0.8};
    std::string texture;               ///< Absolute path of an image.
    std::array<double, 2> checker{8, 8};  ///< Numbers of squares along u and v.
    FileLocation location;
    // The other members differ from their defaults only in paints of mesh files.
    Double3 factor{1, 1, 1};                                                ///< Factor of the colours of an image.
    BeyondEdge along_u = BeyondEdge::repeat, along_v = BeyondEdge::repeat;  ///< Continuations of the image on a mesh.
    std::shared_ptr<const std::string> image{};  ///< Bytes of an image that a mesh file contains; `texture` names it.
    std::string user{};                          ///< For messages: the material and the mesh file that use the image.
};

/// The table [sky] or [sky.far].
struct SkyDescription {
    Paint paint{Paint::Kind::color, {0, 0, 0}, {}, {}, {}};
    Double3 pole{0, 0, 1};
};

enum class Shape { rectangle, box, room, sphere, mesh, disk };
/// Returns the names of the values of Shape in scene files, in the same order.
const std::vector<std::string>& shape_names();
/// Returns the names of the faces of a box or room, in the order of ObjectDescription::faces.
const std::vector<std::string>& face_names();
enum class Shading { emission, lambert };

/// The effect of a surface on rays: it ends them, reflects them, is the boundary of two media, or scatters them evenly.
enum class Material { surface, mirror, boundary, diffuse };
/// Returns the names of the values of Material in scene files, in the same order.
const std::vector<std::string>& material_names();

/// The light that a boundary transmits and reflects. `automatic` divides it by Fresnel's equations where paths are
/// sampled, and otherwise follows the stronger part. `transmit` transmits all light where that is possible, and `none`
/// applies no Fresnel factor.
enum class Fresnel { automatic, transmit, none };
/// Returns "auto", "transmit", "none": the names of the values of Fresnel in scene files, in the same order.
const std::vector<std::string>& fresnel_names();

struct FileMesh;

/// The triangles of a mesh file that have one of its materials.
struct MeshPart {
    std::shared_ptr<const FileMesh> file;  ///< The content of the mesh file.
    std::uint32_t material = 0;            ///< Index of the material in the file.
};

/// One table [[object]], or a part of one: an object with materials = "file" is divided into one part for each material
/// of its file (geometry/file_materials.h).
struct ObjectDescription {
    std::string name;
    Shape shape{};
    Double3 origin{}, edge_u{}, edge_v{};          // rectangle
    Double3 min{}, max{};                          // box, room
    std::array<Paint, 6> faces;                    // box, room: px nx py ny pz nz; default: `paint`
    Double3 center{}; double radius = 0;           // sphere; disk: only center
    Double3 normal{0, 0, 1};                       // disk: axis, about which its matter orbits right-handed
    double inner = 0, outer = 0;                   // disk: radii
    std::optional<VelocityDescription> velocity;   // disk: of its matter, if stated
    double temperature = 0;                        // disk: kelvin at the inner edge; 0: the disk has a paint instead
    FileLocation center_location, normal_location;  // disk: positions of the keys, for messages
    std::string file;                              // mesh: absolute path
    FileLocation file_location;                    // mesh: position of the key `file`
    Double3 translate{}, rotate{}; double scale = 1;  // mesh; rotate in degrees
    Paint paint;
    Shading shading = Shading::emission;
    Material material = Material::surface;
    std::uint32_t interior = 0, exterior = 0;  // boundary: indices of the media
    Fresnel fresnel = Fresnel::automatic;      // boundary
    Double3 tint{1, 1, 1};                     // mirror, boundary: factor for the light
    double emission_strength = 0;              // diffuse: the surface emits its colour times this
    bool has_file_materials = false;           // mesh: materials = "file"
    bool states_material = false;              // mesh with materials = "file": the scene states material = "surface"
    std::optional<MeshPart> part;              // set only in parts of meshes
    std::optional<Paint> emission;             // part: the light that it emits; if empty, see emission_strength
    std::uint32_t scene_index = 0;             // index of the table in the scene file
    /// Positions of the keys; that of the object if the scene does not state the key.
    FileLocation material_location, interior_location, exterior_location;
    FileLocation location;
};

/// One number of an animated key: a number, or a formula in frame, u, w and s.
struct AnimatedNumber {
    std::string text;  ///< The number or formula as a TOML value.
    FileLocation location;
};

/// A key of a scene whose value depends on the frame.
struct AnimatedKey {
    std::string key;                ///< As written, such as "camera.position".
    std::vector<std::string> path;  ///< The parts of the key: "camera", "position".
    std::vector<AnimatedNumber> numbers;
    bool is_array = false;  ///< True if the value is an array, even if it has one element.
    FileLocation location;  ///< Position of the key, for messages.
};

/// The table [animation], and the frame of which the other tables of a description have their values.
struct AnimationDescription {
    std::uint32_t frames = 1;
    double fps = 24;                ///< Frames per second.
    std::vector<AnimatedKey> keys;  ///< The table [animation.set], without keys that an override sets.
    double frame = 0;               ///< Number of the frame from 0; a fraction lies between two frames.
    std::vector<std::pair<std::string, std::string>> values;  ///< The animated keys with their values as TOML.
};

/// A whole scene.
struct SceneDescription {
    std::string path;                              ///< Path of the scene file, as stated by the user.
    std::string text;                              ///< Text of the scene file, for the metadata of the picture.
    std::vector<std::string> overrides;            ///< Texts of the overrides.
    SpaceDescription space;
    IntegratorDescription integrator;
    CameraDescription camera;
    FilmDescription film;
    SkyDescription sky;
    SkyDescription far_sky;                        ///< Sky of the second sheet, or of the region of far_domain.
    std::vector<ObjectDescription> objects;
    std::vector<MediumDescription> media;
    std::optional<AnimationDescription> animation;  ///< Only if the scene has the table [animation].
};

/// Returns the name of the medium with this index: "space" for 0.
const std::string& name_of_medium(const SceneDescription& scene, std::uint32_t index);

/// Returns true if an object of the scene has this material, or if it may get it from a mesh file.
bool has_material(const SceneDescription& scene, Material material);

/// Returns true if the object or the camera of a scene states the medium with this index.
bool uses_medium(const SceneDescription& scene, std::uint32_t index);

/// Returns the names in a table of Hamiltonians or integrators.
template <class Info>
std::vector<std::string> names_of(const Info* infos, std::uint32_t count) {
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i < count; ++i) names.emplace_back(infos[i].name);
    return names;
}

/// The Hamiltonians, integrators and layers whose names a scene may use.
struct Catalogue {
    const HamiltonianInfo* hamiltonians = nullptr;
    std::uint32_t hamiltonian_count = 0;
    const IntegratorInfo* integrators = nullptr;
    std::uint32_t integrator_count = 0;
    std::vector<std::string> layers;
    /// Returns the Hamiltonian with this name, or nullptr.
    const HamiltonianInfo* hamiltonian_named(const std::string& name) const;
    /// Returns nullptr if the integrator can integrate the Hamiltonian, rescaled if `rescaled` is true; otherwise the
    /// reason. The numbers are indices into `integrators` and `hamiltonians`.
    const char* (*refusal)(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled) = nullptr;
};

/// A key that is set from outside the scene file.
struct Override {
    std::string text;    ///< "key.path=value" in TOML syntax; a value without quotes may be a string.
    std::string option;  ///< Option as written by the user, for messages; empty: "-D " and `text`.

    Override(const char* t) : text(t) {}
    Override(std::string t, std::string as_written = {}) : text(std::move(t)), option(std::move(as_written)) {}
};

}  // namespace kagero
