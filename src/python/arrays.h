/// NumPy arrays as arguments and results.
#pragma once

#include "rays/start_rays.h"

#include <pybind11/numpy.h>

#include <string>
#include <vector>

namespace kagero {

/// Returns a view of positions and directions, which must be arrays of float64 in C order with the shape (3,) or
/// (N, 3). One vector applies to all rays. Throws InputError for other arrays. The arrays must outlive the view.
RayArrays ray_arrays(const pybind11::array& positions, const pybind11::array& directions);

/// Throws InputError if a component of a position or direction is not finite.
void check_finite(const RayArrays& rays);

/// Returns an array that owns the numbers of a vector, which are not copied.
pybind11::array owning_array(std::vector<float> numbers, const std::vector<pybind11::ssize_t>& shape);

/// Returns an array of objects, which contains the string texts[i] for each index of `indices`.
pybind11::array text_array(const std::vector<std::string>& texts, const std::vector<std::uint32_t>& indices);

}  // namespace kagero
