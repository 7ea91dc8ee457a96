#include "python/arrays.h"

#include "error.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace py = pybind11;

namespace kagero {
namespace {

/// Returns the number of vectors in an array of shape (3,) or (N, 3), and sets `stride`.
std::size_t count_of(const py::array& vectors, const char* name, std::size_t& stride) {
    const bool is_one = vectors.ndim() == 1 && vectors.shape(0) == 3;
    const bool are_several = vectors.ndim() == 2 && vectors.shape(1) == 3;
    if (!py::isinstance<py::array_t<double>>(vectors) || !(vectors.flags() & py::array::c_style) ||
        !(is_one || are_several))
        throw InputError(std::string(name) + ": expected an array of float64 in C order with the shape (N, 3) or (3,)");
    stride = is_one ? 0 : 3;
    return is_one ? 1 : static_cast<std::size_t>(vectors.shape(0));
}

void check_vectors(const double* vectors, std::size_t count, std::size_t stride, const char* name) {
    const std::size_t numbers = stride == 0 ? 3 : 3 * count;
    constexpr std::size_t block = 4096;
    for (std::size_t first = 0; first < numbers; first += block) {
        const std::size_t last = std::min(first + block, numbers);
        double sum = 0;  // not finite if a number is not finite
        for (std::size_t i = first; i < last; ++i) sum += 0 * vectors[i];
        if (sum == 0) continue;
        std::size_t i = first;
        while (std::isfinite(vectors[i])) ++i;
        throw InputError(std::string(name) + "[" + (stride == 0 ? "" : std::to_string(i / 3) + ", ") +
                         std::to_string(i % 3) + "] is " + std::to_string(vectors[i]) + "; expected a finite number");
    }
}

}  // namespace

RayArrays ray_arrays(const py::array& positions, const py::array& directions) {
    RayArrays rays{};
    const std::size_t n = count_of(positions, "position", rays.position_stride),
                      m = count_of(directions, "direction", rays.direction_stride);
    if (rays.position_stride == 3 && rays.direction_stride == 3 && n != m)
        throw InputError("position has " + std::to_string(n) + " vectors, and direction has " + std::to_string(m) +
                         "; expected equal numbers, or one vector of shape (3,) for all rays");
    rays.count = rays.position_stride == 3 ? n : m;
    if (rays.count == 0) throw InputError("position and direction have no vectors; expected at least one ray");
    if (rays.count > 0xfffffffeu)
        throw InputError(std::to_string(rays.count) + " rays are too many; expected at most 4294967294");
    rays.positions = static_cast<const double*>(positions.data());
    rays.directions = static_cast<const double*>(directions.data());
    return rays;
}

void check_finite(const RayArrays& rays) {
    check_vectors(rays.positions, rays.count, rays.position_stride, "position");
    check_vectors(rays.directions, rays.count, rays.direction_stride, "direction");
}

py::array owning_array(std::vector<float> numbers, const std::vector<py::ssize_t>& shape) {
    auto owner = std::make_unique<std::vector<float>>(std::move(numbers));
    const float* data = owner->data();
    const py::capsule capsule(owner.release(), [](void* memory) { delete static_cast<std::vector<float>*>(memory); });
    return py::array_t<float>(shape, data, capsule);
}

py::array text_array(const std::vector<std::string>& texts, const std::vector<std::uint32_t>& indices) {
    std::vector<py::str> strings;
    for (const std::string& text : texts) strings.emplace_back(text);
    py::array array(py::dtype("O"), static_cast<py::ssize_t>(indices.size()));
    // The references to each text are counted first and added together.
    auto* objects = static_cast<PyObject**>(array.mutable_data());
    std::vector<Py_ssize_t> uses(texts.size());
    for (std::size_t i = 0; i < indices.size(); ++i) {
        Py_XDECREF(objects[i]);
        objects[i] = strings[indices[i]].ptr();
        ++uses[indices[i]];
    }
    for (std::size_t i = 0; i < strings.size(); ++i)
        Py_SET_REFCNT(strings[i].ptr(), Py_REFCNT(strings[i].ptr()) + uses[i]);
    return array;
}

}  // namespace kagero
