#include <kagero/rays.h>

#include <kagero/scene.h>

namespace kagero {

std::vector<TracedRay> trace_rays(const SceneSource& source, const std::vector<Ray>& rays, const std::string& observer,
                                  const RunOptions& options, const std::vector<std::string>& columns) {
    TraceOptions request;
    request.observer = observer;
    request.columns = columns;
    return load(source).trace(rays, request, options);
}

}  // namespace kagero
