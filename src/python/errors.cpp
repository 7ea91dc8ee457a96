#include "python/errors.h"

#include "error.h"

#include <pybind11/pybind11.h>

#include <exception>

namespace py = pybind11;

namespace kagero {
namespace {

/// Sets a Python exception of the class `name` of kagero/_errors.py.
template <class... Arguments>
void set_error(const char* name, const Arguments&... arguments) {
    const py::object type = py::module_::import("kagero._errors").attr(name);
    PyErr_SetObject(type.ptr(), type(arguments...).ptr());
}

py::object known(int number) { return number > 0 ? py::object(py::int_(number)) : py::none(); }

void translate(std::exception_ptr exception) {
    try {
        if (exception) std::rethrow_exception(exception);
    } catch (const InputError& error) {
        const FileLocation& location = error.location;
        set_error("InputError", error.what(), location.file.empty() ? py::object(py::none()) : py::str(location.file),
                  known(location.line), known(location.column));
    } catch (const RunError& error) {
        set_error("RunError", error.what());
    } catch (const Interrupted& interrupted) {
        PyErr_SetString(PyExc_KeyboardInterrupt, interrupted.what());
    }
}

}  // namespace

void translate_exceptions() { py::register_exception_translator(translate); }

}  // namespace kagero
