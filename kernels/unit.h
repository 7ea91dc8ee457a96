/// Units of the parameters of Hamiltonians.
#pragma once

#include <cstdint>

namespace kagero {

/// The unit of a parameter: a power of length. The parameter is scaled by this power if a scene is converted to another
/// unit of length.
enum class Unit : std::uint8_t { number, whole_number, length, per_length, per_length_squared, per_length_cubed };

/// Returns the exponent of length in a unit.
constexpr int power_of_length(Unit unit) {
    switch (unit) {
        case Unit::length: return 1;
        case Unit::per_length: return -1;
        case Unit::per_length_squared: return -2;
        case Unit::per_length_cubed: return -3;
        case Unit::number:
        case Unit::whole_number: break;
    }
    return 0;
}

}  // namespace kagero
