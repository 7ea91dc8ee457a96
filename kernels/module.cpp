// The exported function of a kernel module, and the tables of Hamiltonians, integrators and kernels that it returns.
#include "kernels/formula/compiled_functions.h"
#include "kernels/formula/operations.h"
#include "kernels/simd/peak.h"
#include "kernels/comparison/compared.h"
#include "kernels/observers/chart_functions.h"
#include "kernels/observers/observers.h"
#include "kernels/adjoint/paths.h"
#include "kernels/interaction/continuations.h"
#include "kernels/lane_parameters/lane_kernels.h"
#include "kernels/shading/shading.h"
#include "kernels/trace/trace_entry.h"
#include "all_hamiltonians.inc"

namespace kagero {

template void fill_uniforms<double>(const Node*, const int*, int, const double*, double*);

namespace {

template <class H>
HamiltonianInfo info_of() {
    HamiltonianInfo info{
        .name = H::name,
        .what = H::what,
        .formula = H::formula,
        .source = H::source,
        .conserved = H::conserved,
        .parameters = H::parameters.data(),
        .parameter_count = static_cast<std::uint32_t>(H::parameters.size()),
        .spacetime = H::spacetime,
        .rescales = Rescalable<H>,
        .level = H::level,
        .method = H::method,
        .step = H::step,
        .bounded = Bounded<H>,
        .captures = Capturing<H>,
        .discontinuous = HasDiscontinuity<H>,
        .bounds_steps = BoundsSteps<H>,
        .has_second_sheet = TwoSheeted<H>,
    };
    const Axes cyclic = space_kernel<H, double>(Rescalable<H>).cyclic;
    info.cyclic[0] = cyclic.x;
    info.cyclic[1] = cyclic.y;
    info.cyclic[2] = cyclic.z;
    if constexpr (requires { H::step_goes_with; }) info.step_goes_with = H::step_goes_with;
    if constexpr (requires { H::index_parameter; }) info.index_parameter = H::index_parameter;
    if constexpr (requires { H::orbit_method; }) {
        info.orbit_method = H::orbit_method;
        info.orbit_step = H::orbit_step;
    }
    return info;
}
const HamiltonianInfo hamiltonian_infos[] = {
#define KAGERO_HAMILTONIAN(TYPE) info_of<hamiltonians::TYPE>(),
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
    {.name = "formula",
     .what = "a Hamiltonian that is written in the scene",
     .formula = "space.H = \"...\" in x y z px py pz pt",
     .source = "docs/how-to/write-a-hamiltonian.md",
     .conserved = "",
     .parameters = nullptr,
     .parameter_count = 0,
     .spacetime = false,
     .rescales = false,
     .level = 0,
     .method = "gauss8",
     .step = 0.1,
     .bounded = true,
     .captures = true,
     .bounds_steps = true},
};
constexpr std::uint32_t formula_index = std::size(hamiltonian_infos) - 1;

constexpr auto integrator_infos = [] {
    std::array<IntegratorInfo, methods.size()> infos{};
    for (std::size_t i = 0; i < infos.size(); ++i) infos[i] = info_of(methods[i]);
    return infos;
}();

template <class V>
constexpr KernelInfo kernel_of(Strategy strategy, Precision precision) {
    return {strategy, precision, Form::none, lane_count<V>, ValueTraits<V>::registers, trace_entry<V>, nullptr};
}

/// The list of kernels, filled at compile time.
struct Kernels {
    KernelInfo list[64]{};
    std::uint32_t count = 0;

    constexpr void add(const KernelInfo& kernel) { list[count++] = kernel; }
    /// Adds the gangs with the given numbers of rays that consist of more than one packet.
    template <class V, int... ray_counts>
    constexpr void add_gangs(Precision precision, std::integer_sequence<int, ray_counts...>) {
        const auto add_gang = [&]<int rays>() {
            constexpr std::uint32_t packets = rays / lane_count<V>;
            if (packets > 1)
                add({Strategy::packet, precision, Form::gang, rays, ValueTraits<V>::registers * packets,
                     gang_entry<V, rays>, nullptr});
        };
        (add_gang.template operator()<ray_counts>(), ...);
    }
};
using GangRayCounts = std::integer_sequence<int,
#include "gangs.inc"
                                            >;

/// All kernels. The first kernel of each strategy and precision is the default, so it must support every space. Gangs
/// are last, so that a packet of the same number of lanes has precedence.
constexpr Kernels kernels = [] {
    Kernels all;
    all.add(kernel_of<PacketDouble>(Strategy::packet, Precision::float64));
    all.add(kernel_of<PacketFloat>(Strategy::packet, Precision::float32));
    all.add(kernel_of<double>(Strategy::scalar, Precision::float64));
    all.add(kernel_of<float>(Strategy::scalar, Precision::float32));
#define KAGERO_VECTORIZATION(VECTORIZATION) all.add(compared_kernel_info<VECTORIZATION>());
    KAGERO_VECTORIZATIONS(KAGERO_VECTORIZATION)
#undef KAGERO_VECTORIZATION
    all.add_gangs<PacketDouble>(Precision::float64, GangRayCounts{});
    all.add_gangs<PacketFloat>(Precision::float32, GangRayCounts{});
    return all;
}();

/// Calls visit.operator()<H>() with the Hamiltonian type of an index, which must not be that of `formula`.
template <class Visit>
auto visit_hamiltonian(std::uint32_t index, const Visit& visit) {
    std::uint32_t i = 0;
#define KAGERO_HAMILTONIAN(TYPE) \
    if (i++ == index) return visit.template operator()<hamiltonians::TYPE>();
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
    return decltype(visit.template operator()<hamiltonians::Flat>()){};
}

const char* formula_refusal(const double* programs, std::uint32_t integrator) {
    const formula::Programs& p = formula::programs_in(programs);
    const StepperKind kind = methods[integrator].kind;
    if (kind == StepperKind::recipe && !p.parted && !p.rescaled)
        return "the formula does not state the parts H_A and H_B (space.parts)";
    return formula::space_kernel<double>(p).refusal[static_cast<int>(kind)];
}

const char* compile(const Formula* formula, double* programs) {
    formula::Programs& out = *new (programs) formula::Programs;
    if (formula->energy >= 0) return formula::compile(*formula, nullptr, out);
    return visit_hamiltonian(formula->hamiltonian, [&]<class H>() -> const char* {
        if (HasDiscontinuity<H> && formula->rescale >= 0)
            return "the gradient of its H is discontinuous at a surface, so H cannot be rescaled";
        return formula::compile(*formula, &formula::rerecorded<H>, out);
    });
}

const char* refusal(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled) {
    if (hamiltonian == formula_index) return "support depends on the formula; call formula_refusal";
    return visit_hamiltonian(hamiltonian, [&]<class H>() -> const char* {
        if (rescaled && !Rescalable<H>) return "its Hamiltonian does not declare a time rescaling";
        return space_kernel<H, double>(rescaled).refusal[static_cast<int>(methods[integrator].kind)];
    });
}

template <std::size_t n>
void copy(const double* from, double (&to)[n]) {
    for (std::size_t i = 0; i < n; ++i) to[i] = from[i];
}

double throat_radius(std::uint32_t hamiltonian, const double* parameters) {
    if (hamiltonian == formula_index) return 0;
    return visit_hamiltonian(hamiltonian, [&]<class H>() -> double {
        if constexpr (TwoSheeted<H>) return H::throat_radius(make_parameters<H>(parameters));
        else return 0;
    });
}

double bending_radius(std::uint32_t hamiltonian, const double* parameters) {
    constexpr double not_declared = std::numeric_limits<double>::infinity();
    if (hamiltonian == formula_index) return not_declared;
    return visit_hamiltonian(hamiltonian, [&]<class H>() -> double {
        if constexpr (requires { H::bending_radius(make_parameters<H>(parameters)); })
            return H::bending_radius(make_parameters<H>(parameters));
        else return not_declared;
    });
}

Hole hole(std::uint32_t hamiltonian, const double* parameters) {
    if (hamiltonian == formula_index) return {};
    return visit_hamiltonian(hamiltonian, [&]<class H>() -> Hole {
        if constexpr (requires { H::hole(make_parameters<H>(parameters)); })
            return H::hole(make_parameters<H>(parameters));
        else return {};
    });
}

/// Negates the momenta of a map.
void negate_momenta(StartMap& map) {
    for (double& entry : map.offset) entry = -entry;
    for (auto& row : map.matrix)
        for (double& entry : row) entry = -entry;
}

/// Computes the map from directions to momenta for a `static` or `coordinate` observer in the spacetime of a formula.
/// Other observers are not defined there.
Failure observe_formula(ObserverKind kind, const formula::Programs& programs, const double (&q)[3], StartMap& map) {
    map = {};
    std::copy(q, q + 3, map.position);
    if (kind == ObserverKind::zamo || kind == ObserverKind::falling) return Failure::no_observer;
    Matrix<4> inverse_metric, g;
    if (!formula::inverse_metric_of(programs, q, inverse_metric)) return Failure::no_rest_frame;
    if (!metric_of(inverse_metric, g)) return Failure::singular_start;
    map.pt = programs.pt;
    const bool is_static = kind == ObserverKind::static_;
    const Failure failure = compute_rest_frame_map(
        inverse_metric, g, is_static ? std::array{g[0][3], g[1][3], g[2][3], g[3][3]} : std::array{0.0, 0.0, 0.0, -1.0},
        map);
    if (programs.pt < 0) negate_momenta(map);  // H is −½ g^{ab} p_a p_b
    return failure;
}

Failure observe(std::uint32_t hamiltonian, const double* parameters, ObserverKind kind, const double position[3],
                bool ingoing, StartMap* map) {
    double q[3];
    copy(position, q);
    if (hamiltonian == formula_index) return observe_formula(kind, formula::programs_in(parameters), q, *map);
    return visit_hamiltonian(
        hamiltonian, [&]<class H>() { return compute_start_map<H>(kind, parameters, q, ingoing, *map); });
}

Failure start(std::uint32_t hamiltonian, const double* parameters, const double position[3], const double direction[3],
              RayStart* out) {
    double q[3], d[3];
    copy(position, q);
    copy(direction, d);
    if (hamiltonian == formula_index) return formula::start_along(formula::programs_in(parameters), q, d, *out);
    return visit_hamiltonian(hamiltonian, [&]<class H>() { return start_along<H>(parameters, q, d, *out); });
}

void prepare_starts(std::uint32_t hamiltonian, const double* parameters, const double position[3], StartPosition* at) {
    double q[3];
    copy(position, q);
    if (hamiltonian == formula_index) *at = {{q[0], q[1], q[2]}, 0, {}, {}, 0, Failure::none};
    else *at = visit_hamiltonian(hamiltonian, [&]<class H>() { return start_position<H>(parameters, q); });
}

Failure start_from_position(std::uint32_t hamiltonian, const double* parameters, const StartPosition* at,
                            const double direction[3], RayStart* out) {
    double d[3];
    copy(direction, d);
    if (hamiltonian == formula_index) return start(hamiltonian, parameters, at->q, direction, out);
    return start_from(*at, d, *out);
}

double frequency(std::uint32_t hamiltonian, const double* parameters, const double position[3],
                 const double momentum[3], double pt, const double velocity[3]) {
    double q[3], p[3], v[3];
    copy(position, q);
    copy(momentum, p);
    copy(velocity, v);
    if (hamiltonian == formula_index) {
        Matrix<4> inverse_metric;
        const formula::Programs& programs = formula::programs_in(parameters);
        if (!formula::inverse_metric_of(programs, q, inverse_metric)) return 1;
        return frequency_in(inverse_metric, p, pt, v) * (programs.pt > 0 ? 1 : -1);
    }
    return visit_hamiltonian(hamiltonian, [&]<class H>() { return frequency_at<H>(parameters, q, p, pt, v); });
}

Operations operations(std::uint32_t hamiltonian, const double* parameters, std::uint32_t integrator, bool rescaled) {
    const Method& method = methods[integrator];
    if (hamiltonian == formula_index) {
        const formula::Programs& p = formula::programs_in(parameters);
        return operations_of(method, {formula::flops_of(p.derivatives), formula::flops_of(p.force),
                                      formula::flops_of(p.velocity), formula::flops_of(p.event_functions)});
    }
    return visit_hamiltonian(hamiltonian, [&]<class H>() {
        return operations_of(method, space_kernel<H, double>(rescaled && Rescalable<H>).operations);
    });
}

double multiply_adds(Precision precision, std::uint64_t n) {
    return precision == Precision::float32 ? kagero::multiply_adds<float>(n) : kagero::multiply_adds<double>(n);
}

const Module module{
    .abi = abi_version,
    .isa = KAGERO_ISA,
    .compiler = "" __VERSION__,
    .flags = KAGERO_FLAGS,
    .hamiltonians = hamiltonian_infos, .hamiltonian_count = std::size(hamiltonian_infos),
    .integrators = integrator_infos.data(), .integrator_count = integrator_infos.size(),
    .kernels = kernels.list,
    .kernel_count = kernels.count,
    .sweep_kernel = sweep_kernel_info(),
    .refusal = refusal,
    .straight = is_straight,
    .throat_radius = throat_radius,
    .bending_radius = bending_radius,
    .hole = hole,
    .observe = observe,
    .start = start,
    .prepare_starts = prepare_starts,
    .start_from = start_from_position,
    .continue_rays = continue_rays,
    .time_tilts = time_tilts,
    .frequency = frequency,
    .shading = shading_functions,
    .to_ingoing = chart_functions::to_ingoing,
    .to_scene = chart_functions::to_scene,
    .momentum_in_ingoing_form = chart_functions::momentum_in_ingoing_form,
    .hole_radius = chart_functions::hole_radius,
    .compile = compile,
    .program_size = sizeof(formula::Programs) / sizeof(double),
    .formula_refusal = formula_refusal,
    .formula_functions = {formula::describe_functions, formula::use_functions, formula::set_parameters},
    .operations = operations,
    .bound_roundings = bound_roundings<PacketDouble>,
    .multiply_adds = multiply_adds,
};

}  // namespace

bool is_straight(std::uint32_t hamiltonian, const double* parameters) {
    if (hamiltonian == formula_index) return false;
    return visit_hamiltonian(hamiltonian, [&]<class H>() {
        if constexpr (SometimesStraight<H>) return H::straight(make_parameters<H>(parameters));
        else return false;
    });
}

}  // namespace kagero

extern "C" const kagero::Module* kagero_kernels() { return &kagero::module; }
