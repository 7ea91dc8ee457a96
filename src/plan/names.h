/// The names of the values of enumerations, as the command line, scenes and reports write them.
#pragma once

#include "plan/options.h"

#include <string>
#include <vector>

namespace kagero {

const char* name_of(Strategy);
const char* name_of(Precision);
const char* name_of(Status);
const char* name_of(Schedule);
/// Returns "gradient", "stages", "auto-vectorized" or "gang"; "" for Form::none.
const char* name_of(Form);
/// Returns the unit in words, for example "scene lengths" or "1/length".
const char* name_of(Unit);

/// Returns the strategy of this name; nullopt if there is none, as for "auto".
std::optional<Strategy> strategy_named(const std::string& name);
/// Returns the precision of this name; nullopt if there is none, as for "auto".
std::optional<Precision> precision_named(const std::string& name);
/// Returns the schedule of this name; nullopt if there is none, as for "auto".
std::optional<Schedule> schedule_named(const std::string& name);
/// Returns the names of the values of Schedule, in the same order.
const std::vector<std::string>& schedule_names();

/// Returns the names of the integrals along rays that Options can request: "action" and "time".
const std::vector<std::string>& integral_names();
/// Requests the integral of this name, which must be one of integral_names().
void request_integral(Options& options, const std::string& name);

/// Returns the observer of this name. If there is none, throws InputError with the names of all observers.
ObserverKind observer_named(const std::string& name);

/// Returns the reason why a ray failed, as a clause; "" for Failure::none.
const char* describe(Failure);

}  // namespace kagero
