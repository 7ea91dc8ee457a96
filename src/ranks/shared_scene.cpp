#include "ranks/shared_scene.h"

#include "error.h"
#include "film/partial_file.h"
#include "geometry/mesh_files.h"
#include "parts/bytes.h"
#include "ranks/agreement.h"
#include "scene/files.h"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <set>

namespace kagero {
namespace {

namespace fs = std::filesystem;

std::string absolute_path(const std::string& path) { return fs::absolute(path).lexically_normal().string(); }

/// Returns the files that the scene names, and the files that these name.
std::set<std::string> files_to_send(const SceneDescription& scene) {
    std::set<std::string> paths;
    for (const auto& [use, path] : files_of(scene)) {
        if (path.empty() || path == scene.path) continue;
        paths.insert(absolute_path(path));
        for (const std::string& other : files_of_mesh(path)) paths.insert(absolute_path(other));
    }
    return paths;
}

std::string content_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (!in.is_open() || in.bad()) throw InputError("the file " + path + " cannot be read");
    return bytes;
}

}  // namespace

TemporaryFolder::TemporaryFolder() : path((fs::temp_directory_path() / "kagero-files-XXXXXX").string()) {
    if (!mkdtemp(path.data()))
        throw RunError("cannot make a folder for the files of the scene in '" + fs::temp_directory_path().string() +
                       "': " + std::strerror(errno) + "; set TMPDIR to another folder");
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
}

void share_scene(Communicator& ranks, const SceneDescription& scene, bool sends_files) {
    const std::set<std::string> paths = sends_files ? files_to_send(scene) : std::set<std::string>{};
    ByteWriter writer;
    writer.put_text(absolute_path(scene.path));
    writer.put_text(scene.text);
    writer.put(static_cast<std::uint8_t>(sends_files));
    writer.put(std::uint64_t{paths.size()});
    for (const std::string& path : paths) writer.put_text(path);
    agree(ranks);
    ranks.broadcast(writer.bytes);
    for (const std::string& path : paths) {
        std::string bytes = content_of(path);
        agree(ranks);
        ranks.broadcast(bytes);
    }
}

ReceivedScene::ReceivedScene(Communicator& ranks) {
    std::string bytes;
    agree(ranks);
    ranks.broadcast(bytes);
    ByteReader reader(bytes);
    path_ = reader.get_text();
    text_ = reader.get_text();
    if (reader.get<std::uint8_t>() == 0) return;
    folder_ = std::make_unique<TemporaryFolder>();
    path_ = folder_->path + path_;
    for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
        const std::string file = folder_->path + reader.get_text();
        fs::create_directories(fs::path(file).parent_path());
        std::string content;
        agree(ranks);
        ranks.broadcast(content);
        write_text_file(file, content);
    }
}

void ReceivedScene::check_paths(const SceneDescription& scene) const {
    if (!folder_) return;
    for (const auto& [use, path] : files_of(scene))
        if (!path.empty() && !absolute_path(path).starts_with(folder_->path + "/"))
            throw InputError("--send-files: " + use + " has the absolute path '" + path +
                             "'; state it relative to the scene file, or use a shared file system without "
                             "--send-files");
}

}  // namespace kagero
