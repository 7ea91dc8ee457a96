/// Study of error against run time for a scene's camera rays, over methods, steps and precisions. The kernels and the
/// loop are those of `render`.
#pragma once

#include "accuracy/error_curves.h"
#include "study/picture_error.h"
#include "study/strategy_times.h"

namespace kagero {

/// Options of a study.
struct StudyOptions : CurveOptions {
    unsigned threads = 1;  ///< Number of threads of the timed runs.
    unsigned repeats = 5;  ///< Smallest number of timed runs per point. In a quick study, long runs are timed once.
};

/// The fastest point that meets a bound on the error, see `is_within`.
struct Cheapest {
    double error = 0;                  ///< The bound, in pixels or radians.
    const char* measure = "";          ///< The quantity that is bounded: "pixels" or "direction".
    std::size_t curve = 0, point = 0;  ///< Index of the curve, and of the point on it.
    bool found = false;                ///< False if no point meets the bound.
};

/// Results of a study.
struct ErrorStudy : ErrorCurves {
    StudyOptions options;
    Strategy strategy = Strategy::packet;      ///< Strategy of the curves that the order table and the charts show.
    Precision precision = Precision::float64;  ///< Precision of those curves.
    /// Returns true if a curve has the strategy and the precision above.
    bool shows(const StudyCurve& curve) const { return curve.strategy == strategy && curve.precision == precision; }
    std::vector<Cheapest> cheapest;
    std::vector<StrategyTime> strategies;  ///< Times of all strategies with the scene's method and step.
    /// Energy errors along one ray, for methods at steps of approximately equal work.
    std::vector<EnergyTrace> energy;
    std::vector<PictureError> pictures;  ///< Picture errors of the methods and steps of `energy`.
    ErrorMap map;                        ///< Position error of each pixel of a small picture.
    double seconds = 0;
};

/// Runs a study of the plan's scene.
ErrorStudy study_error(const Plan& plan, const StudyOptions& options, const Progress& progress = {},
                       const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
