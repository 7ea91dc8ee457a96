/// Classes and functions for the stability cases: plans of scenes in text form, tracing of rays with checks, and a
/// record of failures and measurements.
#pragma once

#include "plan/names.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "scene/vector3.h"

#include <string>
#include <vector>

namespace kagero {

/// Failures, measurements and notes of one case, over all its precisions and strategies.
class Findings {
public:
    /// Records a failure.
    void fail(const std::string& text);
    /// Records a value. The greatest value of each label is kept.
    void measure(const std::string& label, double value);
    /// Records a note for the report.
    void note(const std::string& text);
    bool passed() const { return failures_ == 0; }
    /// Returns the first three failures, then measurements, then notes, as text.
    std::string text() const;

private:
    std::size_t failures_ = 0;
    std::vector<std::string> first_failures_, notes_;
    std::vector<std::pair<std::string, double>> measured_;  ///< Greatest value of each label.
};

/// The run of one case in one precision and with one strategy.
class CaseRun {
public:
    CaseRun(const Options& options, Findings& findings, std::vector<Status>& statuses)
        : options_(options), findings_(findings), statuses_(statuses) {}

    /// Returns true if the precision is float.
    bool in_float() const { return options_.precision == Precision::float32; }
    /// Returns true if the strategy is scalar.
    bool is_scalar() const { return options_.strategy == Strategy::scalar; }
    const Options& options() const { return options_; }

    /// Returns the plan of a scene. If `text` has no camera, a default camera and film are added to it.
    Plan plan(const std::string& text, bool has_camera = false) const;
    /// Returns the description of a scene; the arguments are those of `plan`.
    SceneDescription scene(const std::string& text, bool has_camera = false) const;
    /// Returns the error message for an invalid scene, or "" if the scene is valid. `text` contains camera and film.
    std::string refusal(const std::string& text) const;

    /// Traces rays and returns their ends. Checks that every ray is counted under one status, that ends with the status
    /// `hit`, `escaped` or `step_limit` are finite, and that failed rays have a reason.
    std::vector<RayEnd> ends(const Plan& plan, const std::vector<RayStart>& starts);
    /// Does the same for rays whose directions are in the rest frame of `observer`. Without an observer, the directions
    /// are those of dq/dλ.
    std::vector<RayEnd> ends(const Plan& plan, const std::vector<RayInput>& rays,
                             std::optional<ObserverKind> observer = {});

    /// Records a failure with a message unless the condition holds.
    void expect(bool condition, const std::string& message);
    /// Records a failure if the status of a ray is not `expected`. `ray` describes the ray.
    void expect_status(const RayEnd& end, Status expected, const std::string& ray);
    /// Records a value, and a failure if the value exceeds `bound`.
    void measure(const std::string& label, double value, double bound);
    /// Records a note for the report.
    void note(const std::string& text) { findings_.note(label() + ": " + text); }

private:
    std::string precision_name() const { return name_of(*options_.precision); }
    std::string label() const { return precision_name() + " " + name_of(*options_.strategy); }

    Options options_;
    Findings& findings_;
    std::vector<Status>& statuses_;  ///< Statuses of all rays in the order of tracing, which all strategies must share.
};

/// Returns the tables [space] and [integrator] of a scene text.
std::string space_text(const std::string& hamiltonian, const std::string& parameters, const std::string& integrator);
/// Returns an [[object]] table of a rectangle.
std::string rectangle(const std::string& name, const Double3& origin, const Double3& edge_u, const Double3& edge_v);
/// Returns a number as TOML text with 17 significant digits.
std::string number(double value);
/// Returns a number with three significant digits, for reports.
std::string three_digits(double value);

/// Returns the Euclidean distance of two points.
double distance(const double (&a)[3], const Double3& b);

}  // namespace kagero
