#include "stability/case_run.h"

#include "error.h"
#include "scene/load/load.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero {

namespace {

/// Number of failures of a case whose text is reported.
constexpr std::size_t shown_failures = 3;

constexpr const char* default_camera = R"(
[camera]
position = [0, -10, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [8, 8]
)";

std::string text_of(const Double3& a) {
    std::string text = "[";
    text += number(a[0]) + ", " + number(a[1]) + ", " + number(a[2]);
    return text += "]";
}

bool is_finite(const RayEnd& end) {
    double sum = end.parameter + end.pt;
    for (int k = 0; k < 3; ++k) sum += std::abs(end.q[k]) + std::abs(end.v[k]);
    return std::isfinite(sum) && std::isfinite(end.p[0]) && std::isfinite(end.p[1]) && std::isfinite(end.p[2]);
}

}  // namespace

void Findings::fail(const std::string& text) {
    if (++failures_ <= shown_failures) first_failures_.push_back(text);
}

void Findings::measure(const std::string& label, double value) {
    const auto found =
        std::find_if(measured_.begin(), measured_.end(), [&](const auto& entry) { return entry.first == label; });
    if (found == measured_.end()) measured_.emplace_back(label, value);
    else if (!(value <= found->second)) found->second = value;
}

void Findings::note(const std::string& text) { notes_.push_back(text); }

std::string Findings::text() const {
    std::string all;
    const auto add = [&](const std::string& text) { all += (all.empty() ? "" : "; ") + text; };
    for (const std::string& failure : first_failures_) add(failure);
    if (failures_ > shown_failures) add("and " + std::to_string(failures_ - shown_failures) + " more failures");
    for (const auto& [label, value] : measured_) add(label + " " + three_digits(value));
    for (const std::string& note : notes_) add(note);
    return all.empty() ? "as expected" : all;
}

SceneDescription CaseRun::scene(const std::string& text, bool has_camera) const {
    return load_scene_text(text + (has_camera ? "" : default_camera), "scene", {}, catalogue(options_.isa));
}

Plan CaseRun::plan(const std::string& text, bool has_camera) const {
    return make_plan(scene(text, has_camera), options_, has_camera ? Purpose::picture : Purpose::ray_list);
}

std::string CaseRun::refusal(const std::string& text) const {
    try {
        plan(text, true);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

std::vector<RayEnd> CaseRun::ends(const Plan& plan, const std::vector<RayStart>& starts) {
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan, starts, ends);
    std::uint64_t counted = 0;
    for (const std::uint64_t count : report.counters.ended) counted += count;
    expect(counted == starts.size(), "the counters contain " + std::to_string(counted) + " statuses for " +
                                         std::to_string(starts.size()) + " rays");
    for (const RayEnd& end : ends) {
        statuses_.push_back(end.status);
        const bool must_be_finite =
            end.status == Status::hit || end.status == Status::escaped || end.status == Status::step_limit;
        expect(!must_be_finite || is_finite(end),
               std::string("a ray end with status ") + name_of(end.status) + " is not finite");
        expect(end.status != Status::failed || end.failure != Failure::none, "a failed ray states no reason");
    }
    return ends;
}

std::vector<RayEnd> CaseRun::ends(const Plan& plan, const std::vector<RayInput>& rays,
                                  std::optional<ObserverKind> observer) {
    return ends(plan, start_rays(plan, rays, observer));
}

void CaseRun::expect(bool condition, const std::string& message) {
    if (!condition) findings_.fail(label() + ": " + message);
}

void CaseRun::expect_status(const RayEnd& end, Status expected, const std::string& ray) {
    if (end.status == expected) return;
    std::string got = name_of(end.status);
    if (end.status == Status::failed) got += std::string(" (") + describe(end.failure) + ")";
    expect(false, got + " instead of " + name_of(expected) + " at " + ray);
}

void CaseRun::measure(const std::string& label, double value, double bound) {
    findings_.measure(label + " (" + precision_name() + ")", value);
    expect(value <= bound, label + " is " + three_digits(value) + ", above the bound " + three_digits(bound));
}

std::string three_digits(double value) {
    std::ostringstream text;
    text.precision(3);
    text << value;
    return text.str();
}

std::string space_text(const std::string& hamiltonian, const std::string& parameters, const std::string& integrator) {
    return "[space]\nhamiltonian = \"" + hamiltonian + "\"\n" + parameters + "\n[integrator]\n" + integrator + "\n";
}

std::string rectangle(const std::string& name, const Double3& origin, const Double3& edge_u, const Double3& edge_v) {
    return "[[object]]\nname = \"" + name + "\"\nshape = \"rectangle\"\norigin = " + text_of(origin) +
           "\nedge_u = " + text_of(edge_u) + "\nedge_v = " + text_of(edge_v) + "\n";
}

std::string number(double value) {
    std::ostringstream text;
    text.precision(17);
    text << value;
    const std::string written = text.str();
    return written.find_first_of(".en") == std::string::npos ? written + ".0" : written;
}

double distance(const double (&a)[3], const Double3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

}  // namespace kagero
