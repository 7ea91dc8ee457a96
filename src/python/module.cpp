// The extension module _kagero, which the package in src/python/kagero calls.
#include "modules/modules.h"
#include "plan/names.h"
#include "python/errors.h"
#include "python/scene.h"
#include "python/work.h"
#include "report/listing.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace py = pybind11;

namespace kagero {
namespace {

/// Returns the names of the ends of rays, in the order of their codes.
std::vector<std::string> status_names() {
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i < status_count; ++i) names.emplace_back(name_of(static_cast<Status>(i)));
    return names;
}

}  // namespace
}  // namespace kagero

PYBIND11_MODULE(_kagero, module) {
    using namespace kagero;
    translate_exceptions();
    add_scene(module);
    module.attr("version") = KAGERO_VERSION;
    module.def("status_names", &status_names);
    module.def("listing", [](const std::string& topic, const std::string& isa) {
        require_isa("isa", isa);
        return listing_json({topic}, isa, find_scene_directory());
    });
    module.def("before_fork", &before_fork);
    module.def("after_fork_in_child", &after_fork_in_child);
}
