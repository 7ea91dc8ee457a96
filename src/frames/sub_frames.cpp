#include "frames/sub_frames.h"

#include "accuracy/end_errors.h"

#include <chrono>
#include <cmath>

namespace kagero {
namespace {

/// The sums of the layers of several films with one sample per pixel.
class FilmSums {
public:
    explicit FilmSums(const Film& film) {
        for (const LayerInfo* layer : film.layers())
            layers_.push_back(
                {layer, std::vector<double>(std::size_t{film.width()} * film.height() * layer->channels.size())});
    }
    void add(const Film& film) {
        for (auto& [layer, values] : layers_) {
            const float* plane = film.plane(layer->name);
            for (std::size_t i = 0; i < values.size(); ++i) add(layer->of_rays, double(plane[i]), values[i]);
        }
        ++count_;
    }
    /// Writes the values of pixels with all samples to a film.
    void write_to(Film& film) const {
        for (const auto& [layer, values] : layers_) {
            const double divisor = layer->of_rays == LayerInfo::OfRays::mean ? std::max(1.0, double(count_)) : 1;
            float* plane = film.plane(layer->name);
            for (std::size_t i = 0; i < values.size(); ++i) plane[i] = static_cast<float>(values[i] / divisor);
        }
    }

private:
    /// Adds a sample. A value that is not a number makes the sum or the greatest value not a number.
    void add(LayerInfo::OfRays of_rays, double sample, double& value) const {
        if (of_rays == LayerInfo::OfRays::mean) value += sample;
        else if (count_ == 0) value = sample;
        else if (of_rays == LayerInfo::OfRays::greatest && !std::isnan(value) && !(sample <= value)) value = sample;
    }

    std::vector<std::pair<const LayerInfo*, std::vector<double>>> layers_;
    std::uint32_t count_ = 0;
};

/// Returns the control of one sub-frame of `count`. `totals` receives the reports of its tiles.
RunControl control_of_sub_frame(const RunControl& control, std::uint32_t index, std::uint32_t count, double begun,
                                std::mutex& adding, RunTotals& totals) {
    RunControl sub;
    sub.stop = control.stop;
    sub.time_limit = control.time_limit - begun;
    sub.progress = [&control, index, count, begun](double done, double seconds) {
        if (control.progress) control.progress((index + done) / count, begun + seconds);
    };
    sub.tile_finished = [&](const Tile&, const TileReport& report) {
        const std::lock_guard lock(adding);
        totals.add(report);
    };
    return sub;
}

}  // namespace

bool has_sub_frames(const SceneDescription& scene) { return scene.camera.shutter > 0 && has_changing_frames(scene); }

RunReport render_sub_frames(FramePlans& plans, const Plan& plan, double frame, Film& film, const RunControl& control) {
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    const std::uint32_t count = plan.description().film.spp;
    FilmSums sums(film);
    RunTotals totals;
    std::mutex adding;
    RunReport report;
    for (std::uint32_t sample = 0; sample < count && !report.interrupted; ++sample) {
        const Plan sub_plan = plans.sub_frame(frame, sample);
        Film sub_film = film_of(sub_plan);
        report = render_with_errors(sub_plan, sub_film,
                                    control_of_sub_frame(control, sample, count, seconds(), adding, totals));
        if (!report.interrupted) sums.add(sub_film);
    }
    sums.write_to(film);
    totals.write_to(report);
    report.seconds = seconds();
    return report;
}

}  // namespace kagero
