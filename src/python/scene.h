/// The class of the Python module that contains a scene.
#pragma once

#include <pybind11/pybind11.h>

namespace kagero {

/// Adds the class Scene to the module. The classes and functions of src/python/kagero call it.
void add_scene(pybind11::module_& module);

}  // namespace kagero
