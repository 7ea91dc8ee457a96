#include "report/error/error_json.h"

#include "plan/names.h"
#include "report/json.h"
#include "report/machine.h"

namespace kagero {
namespace {

Json json_of(const Percentiles& spread) {
    return {{"p50", spread.p50}, {"p90", spread.p90}, {"p99", spread.p99}, {"max", spread.max}};
}

Json json_of(const Timing& time) { return {{"median", time.median}, {"min", time.min}, {"max", time.max}}; }

Json json_of(const std::optional<double>& number) { return number ? Json(*number) : Json(); }

Json json_of(const ReferenceSummary& summary) {
    Json status;
    for (std::uint32_t s = 0; s < status_count; ++s) status[name_of(static_cast<Status>(s))] = summary.status[s];
    return {{"method", summary.method},
            {summary.adaptive ? "tolerance" : "step", summary.step},
            {"confirmed_by", summary.confirming_method},
            {summary.confirming_adaptive ? "confirmed_tolerance" : "confirmed_step", summary.confirming_step},
            {"uncertainty", json_of(summary.uncertainty)},
            {"direction_uncertainty", json_of(summary.direction)},
            {"pixels_uncertainty", json_of(summary.pixels)},
            {"decided", summary.confirmed},
            {"undecided", summary.unconfirmed},
            {"status", status}};
}

Json json_of(const StudyPoint& point) {
    const RayErrors& errors = point.errors;
    return {
        {"step", point.stated_step},
        {"ns_per_ray", json_of(point.time)},
        {"gradients_per_ray", point.gradients},
        {"steps_per_ray", point.steps},
        {"position", json_of(errors.position)},
        {"direction", json_of(errors.direction)},
        {"pixels", json_of(errors.pixels)},
        {"flips", errors.flips},
        {"energy_drift",
         {{"max", point.drift.max}, {"first_tenth", point.drift.first_tenth}, {"last_tenth", point.drift.last_tenth}}},
        {"above_quarter_pixel", errors.above_quarter_pixel},
        {"compared", errors.compared},
        {"ill_conditioned",
         {{"rays", errors.compared_ill_conditioned},
          {"pixels_over_conditioning", json_of(errors.ill_conditioned_pixels)}}},
        {"ns_per_ray_without_surfaces", json_of(point.time_without_surfaces)},
        {"steps_per_ray_without_surfaces", point.steps_without_surfaces},
        {"queries_per_ray", point.queries},
        {"iterations_per_ray", point.iterations},
        {"lane_occupancy", point.occupancy},
        {"solver_tolerance", point.solver_tolerance}};
}

Json json_of(const StudyCurve& curve) {
    Json points = Json::array();
    for (const StudyPoint& point : curve.points) points.push_back(json_of(point));
    return {{"method", curve.method},
            {"strategy", name_of(curve.strategy)},
            {"precision", name_of(curve.precision)},
            {"order", json_of(curve.order)},
            {"points", points},
            {"stated_order", curve.info->order},
            {"adaptive", curve.info->adaptive},
            {"rescaled", curve.rescaled},
            {"loose", curve.has_loose_solver},
            {"floor", json_of(curve.floor)},
            {"stopped", curve.stop_reason.empty() ? Json() : Json(curve.stop_reason)}};
}

Json cheapest_json(const ErrorStudy& study) {
    Json all = Json::array();
    for (const CheapestPoint& best : study.cheapest) {
        Json row{{"error", best.bound},
                 {"method", nullptr},
                 {"step", nullptr},
                 {"precision", nullptr},
                 {"ns_per_ray", nullptr}};
        if (best.found) {
            const StudyCurve& curve = study.curves[best.curve];
            const StudyPoint& point = curve.points[best.point];
            row["method"] = curve.method;
            row["step"] = point.stated_step;
            row["precision"] = name_of(curve.precision);
            row["ns_per_ray"] = point.time.median;
        }
        row["measure"] = best.quantity;
        row["solver_tolerance"] =
            best.found ? Json(study.curves[best.curve].points[best.point].solver_tolerance) : Json();
        all.push_back(row);
    }
    return all;
}

Json strategies_json(const ErrorStudy& study) {
    Json all = Json::array();
    for (const StrategyTime& timed : study.strategies)
        all.push_back({{"isa", timed.isa},
                       {"strategy", name_of(timed.kernel->strategy)},
                       {"form", timed.kernel->form == Form::none ? Json() : Json(name_of(timed.kernel->form))},
                       {"precision", name_of(timed.kernel->precision)},
                       {"lanes", timed.kernel->lanes},
                       {"ns_per_ray", json_of(timed.time)}});
    return all;
}

Json pictures_json(const ErrorStudy& study) {
    Json all = Json::array();
    for (const PictureError& picture : study.pictures)
        all.push_back({{"method", picture.method},
                       {"step", picture.step},
                       {"gradients_per_ray", picture.gradients},
                       {"precision", name_of(picture.precision)},
                       {"wrong_pixels", picture.wrong_pixels},
                       {"rms", picture.rms},
                       {"psnr_db", json_of(picture.psnr)},
                       {"seconds", picture.seconds}});
    return all;
}

}  // namespace

std::string error_json(const Plan& plan, const ErrorStudy& study) {
    Json json;
    json["reference"] = json_of(study.reference);
    json["curves"] = Json::array();
    for (const StudyCurve& curve : study.curves) json["curves"].push_back(json_of(curve));
    json["cheapest"] = cheapest_json(study);
    json["strategies"] = strategies_json(study);
    json["pictures"] = pictures_json(study);
    json["refused"] = study.refused;
    json["scene"] = plan.description().path;
    json["hamiltonian"] = plan.description().space.hamiltonian;
    json["integrator"] = plan.method().name;
    json["straight"] = plan.scene->straight;
    json["sample"] = {{"width", study.sample.width},
                      {"height", study.sample.height},
                      {"rays", study.sample.starts.size()},
                      {"ill_conditioned", study.ill_conditioned_rays},
                      {"pixel_angle", study.sample.pixel_angle}};
    json["isa"] = plan.module().isa;
    json["compiler"] = plan.module().compiler;
    json["machine"] = processor_name();
    json["threads"] = study.options.threads;
    json["repetitions"] = study.options.repeats;
    json["seconds"] = study.seconds;
    json["interrupted"] = study.interrupted;
    json["remarks"] = plan.remarks;
    return text_of(json);
}

}  // namespace kagero
