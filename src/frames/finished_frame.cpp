#include "frames/finished_frame.h"

#include "frames/manifest.h"
#include "parts/bytes.h"
#include "report/run_json.h"

namespace kagero {
namespace {

void put_film(ByteWriter& writer, const Film& film) {
    writer.put(film.width());
    writer.put(film.height());
    writer.put(film.window());
    writer.put(film.tone().exposure);
    writer.put(static_cast<std::uint32_t>(film.tone().curve));
    writer.put(std::uint64_t{film.layers().size()});
    for (const LayerInfo* layer : film.layers()) writer.put_text(layer->name);
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t floats = std::size_t{film.width()} * film.height() * layer->channels.size();
        writer.put_raw(film.plane(layer->name), floats * sizeof(float));
    }
}

Film get_film(ByteReader& reader) {
    const auto width = reader.get<std::uint32_t>(), height = reader.get<std::uint32_t>();
    const auto window = reader.get<CropWindow>();
    Tone tone;
    tone.exposure = reader.get<double>();
    tone.curve = static_cast<ToneCurve>(reader.get<std::uint32_t>());
    std::vector<std::string> layers(reader.get<std::uint64_t>());
    for (std::string& layer : layers) layer = reader.get_text();
    Film film(width, height, layers, window, tone);
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t floats = std::size_t{width} * height * layer->channels.size();
        reader.get_raw(film.plane(layer->name), floats * sizeof(float));
    }
    return film;
}

}  // namespace

FinishedFrame finish_frame(RenderedFrame& frame) {
    FinishedFrame finished{frame.frame, std::move(frame.film), {}, {}, {}, {}, false, 0, 0};
    finished.metadata = picture_metadata(frame.plan, frame.report);
    finished.description = frame_json(frame);
    finished.remarks = frame.plan.remarks;
    finished.warnings = warnings_of_picture(frame.plan, frame.report);
    finished.misses_bound = misses_stated_bound(frame.plan);
    finished.rays = static_cast<double>(frame.report.rays);
    finished.seconds = frame.report.seconds;
    return finished;
}

std::string encode_frame(const FinishedFrame& frame) {
    ByteWriter writer;
    const auto put_texts = [&](const auto& texts) {
        writer.put(std::uint64_t{texts.size()});
        for (const std::string& text : texts) writer.put_text(text);
    };
    writer.put(frame.frame);
    put_film(writer, frame.film);
    std::vector<std::string> metadata, warnings;
    for (const auto& [name, value] : frame.metadata) metadata.insert(metadata.end(), {name, value});
    for (const Warning& warning : frame.warnings) warnings.insert(warnings.end(), {warning.key, warning.text});
    put_texts(metadata);
    put_texts(frame.remarks);
    put_texts(warnings);
    writer.put_text(frame.description.dump(-1, ' ', false, Json::error_handler_t::replace));
    writer.put(static_cast<std::uint8_t>(frame.misses_bound));
    writer.put(frame.rays);
    writer.put(frame.seconds);
    return std::move(writer.bytes);
}

FinishedFrame decode_frame(std::string_view bytes) {
    ByteReader reader(bytes);
    const auto get_texts = [&] {
        std::vector<std::string> texts(reader.get<std::uint64_t>());
        for (std::string& text : texts) text = reader.get_text();
        return texts;
    };
    const auto number = reader.get<std::uint32_t>();
    FinishedFrame frame{number, get_film(reader), {}, {}, {}, {}, false, 0, 0};
    const std::vector<std::string> metadata = get_texts();
    for (std::size_t i = 0; i + 1 < metadata.size(); i += 2) frame.metadata.emplace_back(metadata[i], metadata[i + 1]);
    frame.remarks = get_texts();
    const std::vector<std::string> warnings = get_texts();
    for (std::size_t i = 0; i + 1 < warnings.size(); i += 2) frame.warnings.push_back({warnings[i], warnings[i + 1]});
    frame.description = Json::parse(reader.get_text());
    frame.misses_bound = reader.get<std::uint8_t>() != 0;
    frame.rays = reader.get<double>();
    frame.seconds = reader.get<double>();
    return frame;
}

}  // namespace kagero
