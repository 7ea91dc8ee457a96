#include "frames/manifest.h"

#include "error.h"
#include "film/partial_file.h"
#include "parts/identity.h"
#include "plan/names.h"
#include "report/run_json.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace kagero {
namespace {

constexpr const char* manifest_kind = "kagero frames 1";

/// A lock on the folder of the manifest, so that processes change the manifest one after another. File systems without
/// locks are used without one.
class FolderLock {
public:
    explicit FolderLock(const std::string& path) {
        const std::string folder = std::filesystem::path(path).parent_path().string();
        file_ = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (file_ >= 0) flock(file_, LOCK_EX);
    }
    ~FolderLock() {
        if (file_ >= 0) close(file_);
    }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int file_ = -1;
};

Json to_json(const Properties& properties) {
    Json object = Json::object();
    for (const auto& [name, value] : properties) object[name] = value;
    return object;
}

/// Returns the manifest at a path; null if there is no file, or if the file is not a manifest.
Json read_manifest(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    Json json = in ? Json::parse(in, nullptr, false) : Json();
    const bool is_manifest = json.is_object() && json.contains("kind") && json["kind"] == manifest_kind &&
                             json["identity"].is_object() && json["frames"].is_array();
    return is_manifest ? json : Json();
}

Properties identity_in(const Json& manifest) {
    Properties identity;
    for (const auto& [name, value] : manifest["identity"].items())
        if (value.is_string()) identity.emplace_back(name, value);
    return identity;
}

/// Adds the frames of a manifest that a list does not contain.
void add_frames(const Json& manifest, std::map<std::uint32_t, Json>& frames) {
    for (const Json& frame : manifest["frames"])
        if (frame.is_object() && frame.contains("frame") && frame["frame"].is_number_unsigned())
            frames.emplace(frame["frame"], frame);
}

std::string name_in_folder(const std::string& file) { return std::filesystem::path(file).filename().string(); }

}  // namespace

Manifest::Manifest(std::string path, Properties identity, bool must_continue)
    : path_(std::move(path)), identity_(std::move(identity)) {
    const Json manifest = read_manifest(path_);
    if (manifest.is_null()) {
        if (must_continue && std::filesystem::exists(path_))
            throw InputError(path_ +
                             " is not a manifest of frames, so --resume cannot continue; remove it, or choose "
                             "other names with -o");
        return;
    }
    const std::string difference = describe_difference(identity_in(manifest), path_, identity_, "this run");
    if (difference.empty()) add_frames(manifest, frames_);
    else if (must_continue)
        throw InputError("the frames belong to another render: " + difference + "; render as before, or remove " +
                         path_ + " to begin again");
}

bool Manifest::has_complete(std::uint32_t frame, const std::string& file) const {
    const auto found = frames_.find(frame);
    if (found == frames_.end() || found->second.value("file", "") != name_in_folder(file)) return false;
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) return false;
    return found->second.value("content", "") == content_of_file(file);
}

Json Manifest::add(Json json, const std::string& file) {
    json["file"] = name_in_folder(file);
    json["content"] = content_of_file(file);
    const std::lock_guard lock(adding_);
    frames_[json["frame"]] = json;
    is_written_ = false;
    if (std::chrono::steady_clock::now() >= next_write_) write();
    return json;
}

void Manifest::complete() {
    const std::lock_guard lock(adding_);
    if (!is_written_) write();
}

/// Writes the manifest, with frames that other processes have added in the meantime.
void Manifest::write() {
    constexpr int pause = 20;  // in times of writing, so that a long manifest takes at most 5 % of the time
    const auto begin = std::chrono::steady_clock::now();
    const FolderLock lock(path_);
    const Json other = read_manifest(path_);
    if (!other.is_null() && describe_difference(identity_in(other), "", identity_, "").empty())
        add_frames(other, frames_);
    Json json;
    json["kind"] = manifest_kind;
    json["identity"] = to_json(identity_);
    json["frames"] = Json::array();
    for (const auto& [frame, description] : frames_) json["frames"].push_back(description);
    write_text_file(path_, text_of(json));
    is_written_ = true;
    const auto now = std::chrono::steady_clock::now();
    next_write_ = now + pause * (now - begin);
}

Json frame_json(const RenderedFrame& frame) {
    Json json;
    json["frame"] = frame.frame;
    json["values"] = Json::object();
    if (const auto& animation = frame.plan.description().animation)
        for (const auto& [key, value] : animation->values) json["values"][key] = Json::parse(value, nullptr, false);
    json["integrator"] = frame.plan.method().name;
    json[frame.plan.method().adaptive ? "tolerance" : "step"] =
        frame.plan.method().adaptive ? frame.plan.run.tolerance : stated_step(*frame.plan.scene, frame.plan.run);
    json["precision"] = name_of(frame.plan.run.kernel->precision);
    json["seconds"] = frame.report.seconds;
    json["load_s"] = frame.plan.load_seconds;
    json["write_s"] = nullptr;
    json.update(counts_json(frame.report));
    json.erase("interrupted");
    return json;
}

std::string frames_json(const Plan& first, const FramesReport& report, std::uint64_t kept, std::vector<Json> frames) {
    std::sort(frames.begin(), frames.end(),
              [](const Json& a, const Json& b) { return a["frame"].get<std::uint32_t>() < b["frame"]; });
    std::uint64_t rays = 0;
    for (const Json& frame : frames) rays += frame["rays"].get<std::uint64_t>();
    const Tile& window = first.view.window;
    Json json;
    json["scene"] = first.description().path;
    json["isa"] = first.module().isa;
    json["threads"] = first.run.threads;
    json["width"] = window.x1 - window.x0;
    json["height"] = window.y1 - window.y0;
    json["fps"] = first.description().animation->fps;
    json["rays"] = rays;
    json["seconds"] = report.seconds;
    json["frames_rendered"] = report.written;
    json["frames_kept"] = kept;
    json["interrupted"] = report.interrupted;
    json["out_of_time"] = report.out_of_time;
    json["frames"] = std::move(frames);
    return text_of(json);
}

}  // namespace kagero
