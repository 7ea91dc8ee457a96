#include "frames/video.h"

#include "error.h"
#include "film/tone.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

extern char** environ;

namespace kagero {
namespace {

/// A video format: its extension, the name of its container for ffmpeg, and the options of its encoder.
struct VideoFormat {
    const char* extension;
    const char* container;
    std::vector<std::string> encoder;
};

/// Returns all video formats. A quality of 16 for H.264, and of 20 for VP9, is nearly free of visible losses.
const std::vector<VideoFormat>& video_formats() {
    static const std::vector<std::string> h264{"-c:v", "libx264", "-crf", "16", "-preset", "medium"};
    static const std::vector<std::string> vp9{"-c:v",    "libvpx-vp9", "-crf",      "20",   "-b:v",      "0",
                                              "-row-mt", "1",          "-deadline", "good", "-cpu-used", "3"};
    static const std::vector<VideoFormat> formats{{".mp4", "mp4", h264},
                                                  {".webm", "webm", vp9},
                                                  {".mkv", "matroska", h264}};
    return formats;
}

const VideoFormat* video_format_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    for (const VideoFormat& format : video_formats())
        if (extension == format.extension) return &format;
    return nullptr;
}

/// Returns true if a program is found in one of the folders of PATH.
bool is_installed(const std::string& program) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "/usr/local/bin:/usr/bin:/bin");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (access(((folder.empty() ? "." : folder) + "/" + program).c_str(), X_OK) == 0) return true;
    return false;
}

/// Returns the command line of ffmpeg. Pictures arrive as 8-bit sRGB. BT.709 has the same primaries, and players apply
/// the same transfer function to both.
std::vector<std::string> ffmpeg_command(const VideoFormat& format, const std::string& output, std::uint32_t width,
                                        std::uint32_t height, double fps) {
    std::ostringstream rate;
    rate.precision(12);
    rate << fps;
    std::vector<std::string> words{"ffmpeg",
                                   "-hide_banner",
                                   "-loglevel",
                                   "error",
                                   "-nostdin",
                                   "-y",
                                   "-f",
                                   "rawvideo",
                                   "-pixel_format",
                                   "rgb24",
                                   "-video_size",
                                   std::to_string(width) + "x" + std::to_string(height),
                                   "-framerate",
                                   rate.str(),
                                   "-i",
                                   "pipe:0",
                                   "-an",
                                   "-vf",
                                   "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,"
                                   "format=yuv420p"};
    words.insert(words.end(), format.encoder.begin(), format.encoder.end());
    for (const char* word :
         {"-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace", "bt709", "-color_range", "tv"})
        words.emplace_back(word);
    if (std::string(format.container) != "webm") words.insert(words.end(), {"-pix_fmt", "yuv420p"});
    if (std::string(format.container) == "mp4") words.insert(words.end(), {"-movflags", "+faststart"});
    words.insert(words.end(), {"-f", format.container, std::filesystem::absolute(output).string()});
    return words;
}

/// Starts a program with the given standard input and standard error output. The process has its own group, so that
/// Ctrl-C in the terminal does not end it. Returns its number, or −1; errno is then the reason.
pid_t spawn(const std::vector<std::string>& words, int input, int messages) {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, messages, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, messages, STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t defaults;
    sigemptyset(&defaults);
    for (const int signal : {SIGPIPE, SIGINT, SIGTERM}) sigaddset(&defaults, signal);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    pid_t process = -1;
    const int error = posix_spawnp(&process, arguments[0], &files, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    errno = error;
    return error == 0 ? process : -1;
}

/// Returns the last part of a file of messages, in one line.
std::string last_message(int file) {
    constexpr off_t longest = 600;
    const off_t size = lseek(file, 0, SEEK_END), begin = std::max<off_t>(0, size - longest);
    std::string text(static_cast<std::size_t>(std::max<off_t>(0, size - begin)), '\0');
    const ssize_t count = pread(file, text.data(), text.size(), begin);
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

}  // namespace

bool is_video(const std::string& path) { return video_format_of(path) != nullptr; }

void check_video(const std::string& path, const std::vector<std::string>& layers, std::uint32_t width,
                 std::uint32_t height) {
    check_file_writable(path);
    if (std::find(layers.begin(), layers.end(), "color") == layers.end())
        throw InputError("cannot write '" + path + "': a film shows the layer 'color'; add it to film.layers");
    if (width % 2 != 0 || height % 2 != 0)
        throw InputError("cannot write '" + path + "': the frames have " + std::to_string(width) + " x " +
                         std::to_string(height) +
                         " pixels, but the width and height of a film must be even; use --size " +
                         std::to_string(width + width % 2) + "x" + std::to_string(height + height % 2));
    if (!is_installed("ffmpeg"))
        throw InputError("cannot write '" + path +
                         "': the program ffmpeg, which encodes films, is not in a folder of "
                         "PATH; install it, or write the frames as pictures: -o name-%04d.png");
}

VideoEncoder::VideoEncoder(const std::string& path, std::uint32_t width, std::uint32_t height, double fps)
    : file_(path), path_(path) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw RunError(std::string("cannot create a pipe: ") + std::strerror(errno));
    messages_ = memfd_create("messages of ffmpeg", MFD_CLOEXEC);
    process_ = spawn(ffmpeg_command(*video_format_of(path), file_.temporary(), width, height, fps), ends[0], messages_);
    const int error = errno;
    close(ends[0]);
    pictures_ = ends[1];
    previous_handler_ = std::signal(SIGPIPE, SIG_IGN);
    if (process_ >= 0) return;
    close(pictures_);
    close(messages_);
    std::signal(SIGPIPE, previous_handler_);
    throw RunError(std::string("cannot start ffmpeg: ") + std::strerror(error));
}

VideoEncoder::~VideoEncoder() {
    if (pictures_ >= 0) {  // the film is not complete
        kill(process_, SIGKILL);
        close(pictures_);
        wait_for_end();
    }
    close(messages_);
    std::signal(SIGPIPE, previous_handler_);
}

int VideoEncoder::wait_for_end() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

void VideoEncoder::refuse_failure() {
    const std::string message = last_message(messages_);
    throw RunError("ffmpeg could not write the film '" + path_ + "'" +
                   (message.empty() ? "; it ended without a message" : ": " + message));
}

void VideoEncoder::write(const Film& film) {
    const float* color = film.plane("color");
    const std::vector<unsigned char> bytes =
        display_bytes(color, std::size_t{film.width()} * film.height() * 3, film.tone());
    for (std::size_t begin = 0; begin < bytes.size();) {
        const ssize_t written = ::write(pictures_, bytes.data() + begin, bytes.size() - begin);
        if (written < 0 && errno == EINTR) continue;
        if (written >= 0) {
            begin += static_cast<std::size_t>(written);
            continue;
        }
        close(pictures_);
        pictures_ = -1;
        wait_for_end();
        refuse_failure();
    }
}

void VideoEncoder::finish() {
    close(pictures_);
    pictures_ = -1;
    const int status = wait_for_end();
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) refuse_failure();
    file_.complete();
}

}  // namespace kagero
