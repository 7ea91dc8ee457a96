#include "appearance/paints.h"

#include "appearance/blackbody.h"
#include "film/read_image.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <sstream>

namespace kagero {

/// Images and their coarser copies, by path, so that each file is read only once.
struct LoadedImages {
    std::map<std::string, std::shared_ptr<const StoredImage>> full;
    std::map<std::pair<std::string, Mapping>, std::shared_ptr<const std::vector<Image>>> coarser;
};

namespace {

/// The images of paints that are being loaded. No file is read unless `enabled` is true.
struct Images : LoadedImages {
    bool enabled;
    const LoadedImages* earlier;  ///< The images of another frame, which are not read again; may be null.
};

/// Returns the value of a key; null if there is none.
template <class Map>
typename Map::mapped_type find_image(const Map& images, const typename Map::key_type& key) {
    const auto found = images.find(key);
    return found == images.end() ? nullptr : found->second;
}

/// Reads an image for a paint, and computes its coarser copies on another thread while the file is read.
void read_texture(LoadedPaint& loaded, Mapping mapping) {
    const Paint& paint = loaded.paint;
    ImageReader reader({paint.texture, paint.image.get(), paint.user}, paint.location);
    const int height = reader.image().height;
    std::atomic<int> rows_read = 0;  // negative if reading failed
    const auto reduce = [&] {
        ImageReduction reduction(reader.image().width, height, mapping);
        for (int added = 0, ready = 0; added < height; added = ready) {
            rows_read.wait(added);
            ready = rows_read;
            if (ready < 0) break;
            reduction.add_rows(reader.image(), ready);
        }
        return reduction.take_images();
    };
    const auto publish = [&](int rows) {
        rows_read = rows;
        rows_read.notify_one();
    };
    // If no thread can be started, the copies are computed at the end.
    std::future<std::vector<Image>> coarser = std::async(std::launch::async | std::launch::deferred, reduce);
    try {
        while (!reader.is_done()) {
            reader.read_strip();
            publish(reader.rows_read());
        }
    } catch (...) {
        publish(-1);
        throw;
    }
    loaded.coarser = std::make_shared<const std::vector<Image>>(coarser.get());
    loaded.image = std::make_shared<const StoredImage>(reader.take_image());
}

LoadedPaint load(const Paint& paint, Mapping mapping, Images& images) {
    LoadedPaint loaded{paint, nullptr, nullptr, nullptr};
    if (paint.kind != Paint::Kind::texture || !images.enabled) return loaded;
    auto& image = images.full[paint.texture];
    auto& coarser = images.coarser[{paint.texture, mapping}];
    if (images.earlier && !image) image = find_image(images.earlier->full, paint.texture);
    if (images.earlier && !coarser) coarser = find_image(images.earlier->coarser, {paint.texture, mapping});
    loaded.image = image;
    loaded.coarser = coarser;
    if (!image) read_texture(loaded, mapping);
    else if (!coarser) loaded.coarser = std::make_shared<const std::vector<Image>>(coarser_images(*image, mapping));
    image = loaded.image;
    coarser = loaded.coarser;
    loaded.levels = std::make_shared<const ImageLevelTable>(*image, *coarser);
    return loaded;
}

LoadedSky load(const SkyDescription& description, Images& images) {
    return {load(description.paint, Mapping::sphere, images), description.pole};
}

/// Throws InputError if an image that is the albedo of a surface has a component greater than 1.
void check_albedo_of_image(const LoadedPaint& loaded) {
    if (!loaded.image) return;
    const float greatest = visit_texels(*loaded.image, [&](const auto& texels) {
        float found = 0;
        const std::size_t count = 3 * std::size_t(texels.width) * std::size_t(texels.height);
        for (std::size_t i = 0; i < count; ++i) found = std::max(found, texels[i]);
        return found;
    });
    if (greatest <= 1) return;
    std::ostringstream message;
    message
        << "the texture has a component of " << greatest << ", which is not legal with material = \"diffuse\": it is "
        << "the albedo, the share of the light that the surface scatters, so the legal range is 0 <= value <= 1; use "
        << "another image, and emission_strength for a surface that emits light";
    throw InputError(loaded.paint.location, message.str());
}

ShadedObject load(const ObjectDescription& object, const ObjectGeometry& geometry, Images& images) {
    ShadedObject shaded;
    shaded.geometry = &geometry;
    shaded.shading = object.shading;
    if (object.shape == Shape::disk) {
        shaded.normal = object.normal;
        shaded.inner = object.inner;
        shaded.outer = object.outer;
        shaded.temperature = object.temperature;
        if (object.temperature > 0) shaded.inverse_luminance = 1 / blackbody_luminance(object.temperature);
    }
    const bool has_faces = object.shape == Shape::box || object.shape == Shape::room;
    const Mapping mapping = object.shape == Shape::sphere ? Mapping::sphere : Mapping::plane;
    if (has_faces)
        for (const Paint& face : object.faces) shaded.paints.push_back(load(face, mapping, images));
    else shaded.paints.push_back(load(object.paint, mapping, images));
    if (object.material == Material::diffuse)
        for (const LoadedPaint& paint : shaded.paints) check_albedo_of_image(paint);
    if (object.emission) shaded.emission = load(*object.emission, mapping, images);
    if (std::any_of(shaded.paints.begin(), shaded.paints.end(), has_pattern) ||
        (shaded.emission && has_pattern(*shaded.emission)))
        shaded.charts = charts_of(geometry.mesh);
    return shaded;
}

}  // namespace

Paints::Paints(const SceneDescription& scene, const SceneGeometry& geometry, bool with_images, const Paints* earlier) {
    Images images{{}, with_images, earlier ? earlier->images_.get() : nullptr};
    sky_ = load(scene.sky, images);
    far_sky_ = load(scene.far_sky, images);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        objects_.push_back(load(scene.objects[i], geometry.objects()[i], images));
    images_ = std::make_shared<const LoadedImages>(std::move(static_cast<LoadedImages&>(images)));
}

Float3 Paints::surface_color(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                             const Double3& ray_direction, double redshift, const Patch& patch,
                             const Float3* black_body) const {
    return object_color(objects_[surface], primitive, point, ray_direction, redshift, patch, black_body);
}

Float3 Paints::sky_color(const Double3& direction, bool on_second_sheet, const SkyFilter& filter) const {
    const LoadedSky& sky = on_second_sheet ? far_sky_ : sky_;
    return kagero::sky_color(sky.paint, sky.axes, direction, filter);
}

SkyFilter Paints::sky_filter(bool on_second_sheet, const Footprint& footprint) const {
    const LoadedPaint& paint = (on_second_sheet ? far_sky_ : sky_).paint;
    return paint.image ? kagero::sky_filter(*paint.image, footprint) : SkyFilter{footprint, {}};
}

bool Paints::sky_has_pattern() const { return has_pattern(sky_.paint) || has_pattern(far_sky_.paint); }

bool Paints::surfaces_have_patterns() const {
    return std::any_of(objects_.begin(), objects_.end(), [](const ShadedObject& object) {
        return std::any_of(object.paints.begin(), object.paints.end(), has_pattern);
    });
}

}  // namespace kagero
