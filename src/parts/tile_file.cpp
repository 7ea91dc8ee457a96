#include "parts/tile_file.h"

#include "error.h"
#include "film/partial_file.h"
#include "kernels/assertion.h"
#include "parts/record.h"
#include "parts/tile_pixels.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <istream>
#include <new>
#include <ostream>

namespace kagero {
namespace {

constexpr std::string_view magic{"KAGERO-TILES\r\n\x1a\0", 16};
constexpr std::uint32_t format_version = 8;

/// Returns the state of a file that ends with a record that is not valid.
TileFileEnd end_of(RecordState state) {
    return state == RecordState::damaged ? TileFileEnd::damaged : TileFileEnd::incomplete;
}

void put_properties(ByteWriter& writer, const Properties& properties) {
    writer.put(std::uint64_t{properties.size()});
    for (const auto& [name, value] : properties) {
        writer.put_text(name);
        writer.put_text(value);
    }
}

Properties get_properties(ByteReader& reader) {
    Properties properties;
    for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
        std::string name = reader.get_text();
        properties.emplace_back(std::move(name), reader.get_text());
    }
    return properties;
}

const LayerInfo& layer_named(const std::string& name) {
    for (const LayerInfo& layer : all_layers())
        if (layer.name == name) return layer;
    throw InputError("it contains the layer " + name + ", which this program does not have");
}

TileFileHeader decode_header(std::string_view content) {
    ByteReader reader(content);
    TileFileHeader header;
    header.identity = get_properties(reader);
    header.choices = get_properties(reader);
    header.metadata = get_properties(reader);
    header.misses_bound = reader.get<std::uint8_t>() != 0;
    for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
        header.layers.push_back(reader.get_text());
        if (layer_named(header.layers.back()).channels.size() != reader.get<std::uint32_t>())
            throw InputError("its layer " + header.layers.back() + " has another number of channels");
    }
    header.width = reader.get<std::uint32_t>();
    header.height = reader.get<std::uint32_t>();
    header.window = reader.get<CropWindow>();
    header.tone.exposure = reader.get<double>();
    header.tone.curve = static_cast<ToneCurve>(reader.get<std::uint32_t>());
    header.grid = reader.get<TileGrid>();
    header.part = reader.get<PartNumber>();
    const Tile& window = header.grid.window;
    const bool legal = header.grid.width > 0 && header.grid.height > 0 && window.x0 < window.x1 &&
                       window.y0 < window.y1 && header.part.number >= 1 && header.part.number <= header.part.count &&
                       header.part.count <= max_parts && std::abs(header.tone.exposure) <= max_exposure &&
                       static_cast<std::size_t>(header.tone.curve) < tone_curve_names().size();
    if (!legal || !reader.empty()) throw InputError("its header is not legal");
    return header;
}

void put_values(ByteWriter& writer, const ValueCounts& values) {
    writer.put(values.max);
    writer.put_list(values.listed);
    writer.put_list(values.bins);
}

ValueCounts get_values(ByteReader& reader) {
    ValueCounts values;
    values.max = reader.get<double>();
    values.listed = reader.get_list<std::uint16_t>();
    values.bins = reader.get_list<ValueCounts::Bin>();
    if (!values.is_legal()) throw InputError("a record has impossible counts of values");
    return values;
}

void put_report(ByteWriter& writer, const TileReport& report) {
    writer.put(report.rays);
    writer.put(report.counters);
    writer.put(report.path_lengths.bounces);
    writer.put(std::uint64_t{report.path_lengths.greatest});
    writer.put(report.path_lengths.cut_off);
    writer.put(report.failures);
    writer.put_list(report.generations);
    put_values(writer, report.energy_errors);
    writer.put(report.pixels);
    writer.put(report.interpolated_pixels);
    put_values(writer, report.interpolation_errors);
}

TileReport get_report(ByteReader& reader) {
    TileReport report;
    report.rays = reader.get<std::uint64_t>();
    report.counters = reader.get<Counters>();
    report.path_lengths.bounces = reader.get<std::uint64_t>();
    report.path_lengths.greatest = static_cast<std::uint32_t>(reader.get<std::uint64_t>());
    report.path_lengths.cut_off = reader.get<std::uint64_t>();
    report.failures = reader.get<decltype(report.failures)>();
    report.generations = reader.get_list<GenerationCount>();
    report.energy_errors = get_values(reader);
    report.pixels = reader.get<std::uint64_t>();
    report.interpolated_pixels = reader.get<std::uint64_t>();
    report.interpolation_errors = get_values(reader);
    return report;
}

/// Adds a tile to film and results. Returns false if the bytes are not those of a new tile of the part.
bool add_tile(const TileFileHeader& header, std::string_view record, Film& film, TileResults& results) try {
    ByteReader reader(record_content(record));
    const auto index = reader.get<std::uint64_t>();
    const auto tile = reader.get<Tile>();
    if (index >= header.grid.count() || !header.part.contains(index) || results.has(index)) return false;
    const Tile expected = header.grid.tile(index);
    if (std::memcmp(&tile, &expected, sizeof tile) != 0) return false;
    TileReport report = get_report(reader);
    get_pixels(reader, tile, film);
    return reader.empty() &&
           results.add(index, std::move(report), std::string(results.keeps_records() ? record : std::string_view()));
} catch (const InputError&) {
    return false;
}

}  // namespace

std::uint64_t PartNumber::tiles_of(const TileGrid& grid) const {
    const std::uint64_t all = grid.count();
    return all / count + (all % count >= number ? 1 : 0);
}

Film TileFileHeader::film(Planes planes) const {
    try {
        return Film(width, height, layers, window, tone, planes);
    } catch (const std::bad_alloc&) {
        throw RunError("not enough memory for the film of " + std::to_string(width) + " x " + std::to_string(height) +
                       " pixels");
    }
}

bool is_tile_file(const std::string& path) {
    std::string begin(magic.size(), '\0');
    std::ifstream in(path, std::ios::binary);
    return in.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == magic;
}

std::optional<TileFileHeader> read_header(std::istream& in, const std::string& path) {
    std::string begin(std::min<std::uint64_t>(magic.size(), bytes_left(in)), '\0');
    in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
    if (!magic.starts_with(begin))
        throw InputError(path + " is not a part or journal of kagero: its first bytes are others");
    std::uint32_t version = 0;
    if (!in.read(reinterpret_cast<char*>(&version), sizeof version)) return {};
    if (version != format_version)
        throw InputError(path + " has version " + std::to_string(version) +
                         " of the format; this program reads version " + std::to_string(format_version) +
                         "; use the kagero that wrote the file, or remove it and render again");
    const Record record = read_record(in);
    if (record.state == RecordState::incomplete) return {};
    if (record.state == RecordState::damaged || record.kind != RecordKind::header)
        throw InputError(path + " is damaged: its header differs from what was written");
    try {
        return decode_header(record_content(record.bytes));
    } catch (const InputError& error) {
        throw InputError(path + " cannot be used: " + error.what());
    }
}

TilesRead read_tiles(std::istream& in, const TileFileHeader& header, Film& film, TileResults& results) {
    for (std::uint64_t tiles = 0;; ++tiles) {
        const auto valid = static_cast<std::uint64_t>(in.tellg());
        const Record record = read_record(in);
        if (record.state != RecordState::valid) return {end_of(record.state), valid};
        if (record.kind == RecordKind::end) {
            const std::string_view content = record_content(record.bytes);
            const bool matches = content.size() == sizeof tiles && ByteReader(content).get<std::uint64_t>() == tiles &&
                                 tiles == header.part.tiles_of(header.grid) && bytes_left(in) == 0;
            if (!matches) return {TileFileEnd::damaged, valid};
            return {TileFileEnd::complete, static_cast<std::uint64_t>(in.tellg())};
        }
        if (record.kind != RecordKind::tile || !add_tile(header, record.bytes, film, results))
            return {TileFileEnd::damaged, valid};
    }
}

std::string encode_header(const TileFileHeader& header) {
    ByteWriter content;
    begin_record(content, RecordKind::header);
    put_properties(content, header.identity);
    put_properties(content, header.choices);
    put_properties(content, header.metadata);
    content.put(static_cast<std::uint8_t>(header.misses_bound));
    content.put(std::uint64_t{header.layers.size()});
    for (const std::string& layer : header.layers) {
        content.put_text(layer);
        content.put(static_cast<std::uint32_t>(layer_named(layer).channels.size()));
    }
    content.put(header.width);
    content.put(header.height);
    content.put(header.window);
    content.put(header.tone.exposure);
    content.put(static_cast<std::uint32_t>(header.tone.curve));
    content.put(header.grid);
    content.put(header.part);
    finish_record(content);
    ByteWriter file;
    file.put_raw(magic.data(), magic.size());
    file.put(format_version);
    return file.bytes + content.bytes;
}

std::string_view encode_tile(const TileFileHeader& header, std::uint64_t index, const TileReport& report,
                             const Film& film) {
    thread_local ByteWriter record;  // memory that was used shortly before is in the processor's cache
    const Tile tile = header.grid.tile(index);
    begin_record(record, RecordKind::tile);
    record.put(index);
    record.put(tile);
    put_report(record, report);
    put_pixels(record, tile, film);
    finish_record(record);
    return record.bytes;
}

bool add_tile_record(const TileFileHeader& header, std::string_view record, Film& film, TileResults& results) {
    return is_record(record, RecordKind::tile) && add_tile(header, record, film, results);
}

void write_part(const std::string& path, const TileFileHeader& header, const TileResults& results) {
    KAGERO_ASSERT(results.keeps_records());
    write_file(path, [&](std::ostream& out) {
        const auto write = [&](const std::string& bytes) {
            out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        };
        write(encode_header(header));
        for (const auto& [index, record] : results.records()) write(record);
        if (results.count() != header.part.tiles_of(header.grid)) return;
        ByteWriter end;
        begin_record(end, RecordKind::end);
        end.put(results.count());
        finish_record(end);
        write(end.bytes);
    });
}

}  // namespace kagero
