/// Arguments and results that all functions of the library share: the scene, the options of a run, and the choices that
/// the program makes.
#pragma once

#include <kagero/export.h>

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace kagero {

/// A scene: a TOML file and overrides of its keys.
struct SceneSource {
    std::string file;  ///< Path of the file. Messages contain it, and relative paths in the scene start at its folder.
    std::vector<std::string> overrides{};  ///< "key.path=value", as with -D on the command line.
    std::optional<std::string> text{};     ///< TOML text of the scene. Without it, the file is read.
};

/// The options of a run. They correspond to flags of the command line and have the same defaults.
struct RunOptions {
    std::string isa = "auto";        ///< "auto", "sse2", "avx2" or "avx512"; the processor must support it.
    std::string strategy = "auto";   ///< "auto", "scalar", "per-ray" or "packet".
    std::string precision = "auto";  ///< "auto", "double" or "float".
    unsigned threads = 0;            ///< 0: one per processor.
    std::function<void(double done, double seconds)>
        progress{};  ///< Called repeatedly, from any thread. `done` is the finished fraction; `seconds` have elapsed.
    const std::atomic<bool>* stop = nullptr;  ///< If *stop becomes true, the run ends early; finished pixels are kept.
};

/// The choices of the program for a scene, as `kagero explain` prints them.
struct RunChoices {
    std::string hamiltonian, integrator;
    std::string isa, strategy, precision;
    unsigned lanes = 1, threads = 1;
    double step = 0;               ///< As integrator.step in a scene file; its unit depends on the method.
    double max_pixel_error = 0;    ///< Bound in pixels of the trial that chose the method; 0: there was no trial.
    double estimated_error = 0;    ///< 99th percentile of the pixel errors of trial rays; 0 if no trial met the bound.
    bool bound_is_met = true;      ///< False if there was a trial that did not confirm that the bound is met.
    std::vector<std::string> remarks;  ///< Notes on settings that may be mistakes, and warnings about the trial that
                                       ///< chose the method, one line each.
    std::string explanation;           ///< Every decision with its reason.
};

}  // namespace kagero
