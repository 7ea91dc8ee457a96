/// Keys of a scene that rays of a list do not depend on.
#pragma once

#include "plan/plan.h"

#include <string>
#include <vector>

namespace kagero {

/// Returns a remark for each key of a sweep that cannot change the ends of its rays, because only pictures, or other
/// methods, depend on it. A key is written as in a scene file, such as "camera.fov"; "=value" may follow. `plan` is
/// that of one set; the other sets may differ from it in the values of these keys.
std::vector<std::string> remarks_on_unread_keys(const Plan& plan, const std::vector<std::string>& keys);

}  // namespace kagero
