/// Error against run time for a scene's own rays: methods × steps × precisions, through the kernels and the loop that
/// `render` uses.
#pragma once

#include "accuracy/error_curves.h"
#include "study/picture_error.h"
#include "study/strategy_times.h"

namespace kagero {

struct StudyOptions : CurveOptions {
    unsigned threads = 1;  ///< of the timed runs
    unsigned repeats = 5;  ///< at least; of a quick study 1, for runs that take long
};

/// The quickest point whose 99th percentile of an error stays below a bound, and of whose rays at most 1 % end
/// otherwise.
struct Cheapest {
    double error = 0;
    const char* measure = "";  ///< "pixels" or "direction"
    std::size_t curve = 0, point = 0;
    bool found = false;
};

struct ErrorStudy : ErrorCurves {
    StudyOptions options;
    Strategy strategy = Strategy::packet;          ///< of those that were studied, what tables and charts show,
    Precision precision = Precision::float64;      ///< … with few exceptions
    bool shows(const StudyCurve& curve) const { return curve.strategy == strategy && curve.precision == precision; }
    std::vector<Cheapest> cheapest;
    std::vector<StrategyTime> strategies;  ///< of the scene's own method at its own step
    std::vector<EnergyTrace> energy;   ///< along one ray, as near to equal work as was measured
    std::vector<PictureError> pictures;
    ErrorMap map;
    double seconds = 0;
};

ErrorStudy study_error(const Plan& plan, const StudyOptions& options, const Progress& progress = {},
                       const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
