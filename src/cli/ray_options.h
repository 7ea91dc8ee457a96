/// Options of the verbs that trace lists of rays.
#pragma once

#include "cli/arguments.h"
#include "library/ray_list.h"
#include "rays/start_rays.h"
#include "sweep/parameter_sets.h"

namespace kagero {

/// Adds --rays and --observer.
void add_ray_options(CLI::App& verb, Arguments& arguments);

/// Reads the rays of --rays. Throws InputError.
std::vector<RayInput> rays_of(const Arguments& arguments);

/// Returns the observer of --observer; nothing if the option is not given.
std::optional<ObserverKind> observer_of(const Arguments& arguments);

/// Returns a function that reads the scene of the command line for single rays.
ReadScene scene_reader(const Arguments& arguments, const Options& options);

/// Adds --vary.
void add_swept_keys(CLI::App& verb, Arguments& arguments);

/// Returns the keys of --vary with their values. Throws InputError.
std::vector<SweptKey> keys_of_sweep(const Arguments& arguments);

}  // namespace kagero
