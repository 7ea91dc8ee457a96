/// What a case works with: scenes from text, rays, and a record of what held and what did not.
#pragma once

#include "rays/start_rays.h"
#include "render/trace.h"
#include "plan/names.h"
#include "scene/vector3.h"

#include <string>
#include <vector>

namespace kagero {

/// What is gathered over all ways of running one case.
class Findings {
public:
    void fail(const std::string& text);
    void measure(const std::string& label, double value);
    void note(const std::string& text);
    bool holds() const { return failures_ == 0; }
    /// First what failed, then what was measured.
    std::string text() const;

private:
    std::size_t failures_ = 0;
    std::vector<std::string> first_failures_, notes_;
    std::vector<std::pair<std::string, double>> measured_;  ///< the greatest of each label
};

/// One case in one precision and strategy.
class Trial {
public:
    Trial(const Options& options, Findings& findings, std::vector<Status>& statuses)
        : options_(options), findings_(findings), statuses_(statuses) {}

    bool in_float() const { return options_.precision == Precision::float32; }
    bool in_scalar() const { return options_.strategy == Strategy::scalar; }
    const Options& options() const { return options_; }

    /// The plan of a scene; camera and film are those of `text`, or any where `camera` is false.
    Plan plan(const std::string& text, bool camera = false) const;
    SceneDescription scene(const std::string& text, bool camera = false) const;
    /// The message with which a scene is refused, or "".
    std::string refusal(const std::string& text) const;

    /// Traces, and checks what holds for every ray: one status, finite numbers, a reason for each failure.
    std::vector<RayEnd> ends(const Plan& plan, const std::vector<RayStart>& starts);
    std::vector<RayEnd> ends(const Plan& plan, const std::vector<RayInput>& rays,
                             std::optional<ObserverKind> observer = {});

    /// Records a failure unless `holds`.
    void expect(bool holds, const std::string& otherwise);
    void expect_status(const RayEnd& end, Status expected, const std::string& ray);
    /// Records a value, which fails beyond its bound.
    void measure(const std::string& label, double value, double bound);
    /// A remark for the report.
    void note(const std::string& text) { findings_.note(label() + ": " + text); }

private:
    std::string precision_name() const { return name_of(*options_.precision); }
    std::string label() const { return precision_name() + " " + name_of(*options_.strategy); }

    Options options_;
    Findings& findings_;
    std::vector<Status>& statuses_;  ///< of all rays in order, to compare strategies with
};

// Texts of scenes.
std::string space_text(const std::string& hamiltonian, const std::string& parameters, const std::string& integrator);
std::string rectangle(const std::string& name, const Double3& origin, const Double3& u, const Double3& v);
std::string number(double value);
/// For people.
std::string three_digits(double value);

// Vectors.
double distance(const double (&a)[3], const Double3& b);

}  // namespace kagero
