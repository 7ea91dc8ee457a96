/// What must be the same for all parts of a picture, and for a run that continues a journal.
#pragma once

#include "parts/tile_file.h"
#include "plan/plan.h"

namespace kagero {

/// Returns the version, the instruction set, the scene with its overrides, the contents of all files that the scene
/// names, and the options that determine pixels. None of them depends on a trial, on threads or on the path of a file.
Properties identity_of(const Plan& plan, const Options& options);

/// Returns the size and the hash of a file's content, as a text. Throws InputError if the file cannot be read.
std::string content_of_file(const std::string& path);

/// Returns a clause that states the first difference of two lists, such as "the instruction set is avx2 in a.part, but
/// avx512 in b.part"; empty if they are equal. `first_name` and `second_name` name the owners of the lists.
std::string describe_difference(const Properties& first, const std::string& first_name, const Properties& second,
                                const std::string& second_name);

}  // namespace kagero
