/// Checks that a PLY file holds what its header declares; the importer fills gaps with made-up faces instead.
#pragma once

#include <string>

namespace kagero {

bool is_ply(const std::string& path);

/// Throws InputError, placed in the PLY file, when elements are missing, left over or cut short.
void check_ply(const std::string& path);

}  // namespace kagero
