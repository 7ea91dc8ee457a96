#include <kagero/picture.h>

#include "film/standard_error.h"
#include "film/write_film.h"
#include "library/picture_content.h"
#include "report/run_json.h"

#include <kagero/scene.h>

#include <algorithm>

namespace kagero {

Picture::Picture(std::unique_ptr<Content> content) : content_(std::move(content)) {}
Picture::Picture(Picture&&) noexcept = default;
Picture& Picture::operator=(Picture&&) noexcept = default;
Picture::~Picture() = default;

std::uint32_t Picture::width() const {
    return content_->film.width();
}

std::uint32_t Picture::height() const {
    return content_->film.height();
}

std::vector<std::string> Picture::layers() const {
    std::vector<std::string> names;
    for (const LayerInfo* layer : content_->film.layers()) names.push_back(layer->name);
    return names;
}

std::uint32_t Picture::channels(const std::string& layer) const {
    const auto& layers = content_->film.layers();
    const auto found =
        std::find_if(layers.begin(), layers.end(), [&](const LayerInfo* info) { return info->name == layer; });
    return found == layers.end() ? 0 : static_cast<std::uint32_t>((*found)->channels.size());
}

const float* Picture::pixels(const std::string& layer) const {
    return static_cast<const Film&>(content_->film).plane(layer);
}

const RunChoices& Picture::choices() const {
    return content_->choices;
}

bool Picture::interrupted() const {
    return content_->report.interrupted;
}

std::uint64_t Picture::rays() const {
    return content_->report.rays;
}

double Picture::seconds() const {
    return content_->report.seconds;
}

StandardError Picture::standard_error() const { return summarize_standard_error(content_->film); }

void Picture::write(const std::string& path) const {
    check_writable(path, layers(), width(), height());
    write_film(content_->film, path, picture_metadata(*content_->plan, content_->report));
}

Picture render_scene(const SceneSource& source, const RunOptions& options) { return load(source).render(options); }

}  // namespace kagero
