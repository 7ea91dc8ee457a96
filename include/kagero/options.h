/// Arguments and results that all calls of the library share: the scene, the options of a run, and the choices made for
/// it.
#pragma once

#include <kagero/export.h>

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// A scene as the command line takes it: a TOML file, and keys set from outside, "key.path=value" as with -D.
struct SceneSource {
    std::string file;
    std::vector<std::string> overrides{};
};

/// As the flags of the command line, with the same defaults.
struct RunOptions {
    std::string isa = "auto";        ///< "sse2", "avx2", "avx512": an instruction set that this processor has
    std::string strategy = "auto";   ///< "scalar", "per-ray", "packet"
    std::string precision = "auto";  ///< "double", "float"
    unsigned threads = 0;            ///< 0: one for each processor
    std::function<void(double done, double seconds)>
        progress{};                           ///< called now and then with the finished share, from any thread
    const std::atomic<bool>* stop = nullptr;  ///< set by the caller to end early; what is done is kept
};

/// The choices made for a scene, as `kagero explain` prints them.
struct RunChoices {
    std::string hamiltonian, integrator;
    std::string isa, strategy, precision;
    unsigned lanes = 1, threads = 1;
    double step = 0;               ///< in the unit of the method, see `kagero print`
    double max_pixel_error = 0;    ///< the bound that the scene states (integrator.max_pixel_error); 0: none
    double estimated_error = 0;    ///< pixels, of the error of 99 % of trial rays; only where a bound is stated and met
    bool bound_is_met = true;      ///< false: no method was seen to meet it
    std::vector<std::string> remarks;  ///< what the user may not have meant, one line each
    std::string explanation;           ///< every decision with its reason
};

}  // namespace kagero
