/// The names of modes and of outcomes, as the command line, scenes and reports write them.
#pragma once

#include "plan/options.h"

#include <string>
#include <vector>

namespace kagero {

const char* name_of(Strategy);
const char* name_of(Precision);
const char* name_of(Status);
const char* name_of(Schedule);
/// "", "gradient", "stages", "auto-vectorized" or "gang".
const char* name_of(Form);
/// "scene lengths", "1/length" …
const char* name_of(Unit);

/// Empty for "auto", and for a name that is none.
std::optional<Strategy> strategy_named(const std::string& name);
std::optional<Precision> precision_named(const std::string& name);
std::optional<Schedule> schedule_named(const std::string& name);
const std::vector<std::string>& schedule_names();

/// Throws InputError, which lists the observers, for a name that is none.
ObserverKind observer_named(const std::string& name);

/// Why a ray failed, as a clause; "" for Failure::none.
const char* describe(Failure);

}  // namespace kagero
