/// Study of error against run time for a scene's camera rays, over methods, steps and precisions. The kernels are those
/// of `render`.
#pragma once

#include "study/picture_error.h"
#include "study/point_measurements.h"
#include "study/strategy_times.h"

namespace kagero {

/// The fastest measured point that meets a bound on the error, see `is_within`.
struct CheapestPoint {
    double bound = 0;                  ///< The bound on the 99th percentile of the error, in pixels or radians.
    const char* quantity = "";         ///< The error that is bounded: "pixels" or "direction".
    std::size_t curve = 0, point = 0;  ///< Index of the curve, and of the point on it.
    bool found = false;                ///< False if no point meets the bound.
};

/// Results of a study.
struct ErrorStudy : ErrorCurves {
    StudyOptions options;
    /// Strategy and precision of the main curves, which the table of orders and the charts show. The charts also show
    /// some curves of the other precision.
    Strategy main_strategy = Strategy::packet;
    Precision main_precision = Precision::float64;
    bool is_main(const StudyCurve& curve) const {
        return curve.strategy == main_strategy && curve.precision == main_precision;
    }
    std::vector<CheapestPoint> cheapest;   ///< The cheapest point for each of several bounds.
    std::vector<StrategyTime> strategies;  ///< Times of all strategies with the scene's method and step.
    /// Energy errors along one ray, for several methods with steps that need about equally many gradients per ray.
    std::vector<EnergyTrace> energy_traces;
    std::vector<PictureError> pictures;  ///< Errors of small pictures, with the methods and steps of `energy_traces`.
    ErrorMap map;                        ///< Errors of the pixels of a small picture with the scene's method and step.
    double seconds = 0;                  ///< Duration of the study.
};

/// Runs a study of the plan's scene.
ErrorStudy study_error(const Plan& plan, const StudyOptions& options, const Progress& progress = {},
                       const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
