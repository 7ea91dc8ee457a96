// The MPI module. This is the only file that uses MPI.
#include "ranks/communicator.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <list>
#include <stdexcept>
#include <thread>

namespace kagero {
namespace {

/// Greatest number of bytes of one call of MPI, whose counts are of type int.
constexpr std::size_t max_bytes_per_call = std::size_t{1} << 30;

/// Throws an exception with the text of MPI for an error.
void check(int error, const char* action) {
    if (error == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING];
    int length = 0;
    MPI_Error_string(error, text, &length);
    throw std::runtime_error(std::string("MPI cannot ") + action + ": " + std::string(text, text + length));
}

/// A message in transfer. The object owns the bytes, at an address that does not change.
struct Outgoing {
    std::string bytes;
    MPI_Request request;
};

class MpiCommunicator final : public Communicator {
public:
    MpiCommunicator() {
        MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &size_);
        char name[MPI_MAX_PROCESSOR_NAME];
        int length = 0;
        MPI_Get_processor_name(name, &length);
        host_.assign(name, name + length);
    }
    ~MpiCommunicator() override { MPI_Finalize(); }

    void send(int to, int kind, std::string bytes) override {
        if (bytes.size() > std::size_t{std::numeric_limits<int>::max()})
            throw std::runtime_error("a message of " + std::to_string(bytes.size()) + " bytes is too long for MPI");
        Outgoing& message = outgoing_.emplace_back(Outgoing{std::move(bytes), MPI_REQUEST_NULL});
        check(MPI_Isend(message.bytes.data(), static_cast<int>(message.bytes.size()), MPI_BYTE, to, kind,
                        MPI_COMM_WORLD, &message.request),
              "send a message");
    }

    std::optional<RankMessage> receive() override {
        int found = 0, size = 0;
        MPI_Status status;
        check(MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &found, &status), "look for messages");
        if (!found) return {};
        MPI_Get_count(&status, MPI_BYTE, &size);
        RankMessage message{status.MPI_SOURCE, status.MPI_TAG, std::string(static_cast<std::size_t>(size), '\0')};
        check(MPI_Recv(message.bytes.data(), size, MPI_BYTE, message.from, message.kind, MPI_COMM_WORLD, &status),
              "receive a message");
        return message;
    }

    std::size_t unsent() override {
        std::erase_if(outgoing_, [](Outgoing& message) {
            int done = 0;
            check(MPI_Test(&message.request, &done, MPI_STATUS_IGNORE), "send a message");
            return done != 0;
        });
        return outgoing_.size();
    }

    void broadcast(std::string& bytes) override {
        std::uint64_t size = bytes.size();
        broadcast_raw(&size, sizeof size);
        bytes.resize(size);
        for (std::size_t done = 0; done < size; done += max_bytes_per_call)
            broadcast_raw(bytes.data() + done, std::min<std::size_t>(size - done, max_bytes_per_call));
    }

    std::vector<std::string> gather(const std::string& bytes) override {
        const int own = static_cast<int>(bytes.size()), count = rank_ == 0 ? size_ : 0;
        std::vector<int> sizes(static_cast<std::size_t>(count)), begins(sizes.size());
        MPI_Request request;
        check(MPI_Igather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD, &request), "gather sizes");
        wait(request);
        std::size_t total = 0;
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            begins[i] = static_cast<int>(total);
            total += static_cast<std::size_t>(sizes[i]);
        }
        std::string all(total, '\0');
        check(MPI_Igatherv(bytes.data(), own, MPI_BYTE, all.data(), sizes.data(), begins.data(), MPI_BYTE, 0,
                           MPI_COMM_WORLD, &request),
              "gather texts");
        wait(request);
        std::vector<std::string> texts;
        for (std::size_t i = 0; i < sizes.size(); ++i)
            texts.push_back(all.substr(static_cast<std::size_t>(begins[i]), static_cast<std::size_t>(sizes[i])));
        return texts;
    }

    void end_all_ranks(int status) override { MPI_Abort(MPI_COMM_WORLD, status); }

private:
    void broadcast_raw(void* data, std::size_t size) {
        MPI_Request request;
        check(MPI_Ibcast(data, static_cast<int>(size), MPI_BYTE, 0, MPI_COMM_WORLD, &request), "broadcast");
        wait(request);
    }

    /// Waits for the end of a collective operation. The waiting functions of MPI use the processor all the time, which
    /// another rank may need.
    void wait(MPI_Request& request) {
        constexpr auto first = std::chrono::microseconds(20), longest = std::chrono::microseconds(2000);
        auto pause = first;
        for (int done = 0;;) {
            check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "exchange data");
            if (done) return;
            std::this_thread::sleep_for(pause);
            pause = std::min(2 * pause, longest);
        }
    }

    std::list<Outgoing> outgoing_;
};

std::string join(std::unique_ptr<Communicator>& communicator) try {
    int provided = MPI_THREAD_SINGLE;
    // The thread that exchanges messages is not always the main thread, but there is only one at a time.
    check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided), "start");
    communicator = std::make_unique<MpiCommunicator>();
    if (provided >= MPI_THREAD_SERIALIZED) return "";
    communicator.reset();
    return "this MPI does not support calls from several threads (MPI_THREAD_SERIALIZED)";
} catch (const std::exception& error) {
    return error.what();
}

constexpr CommunicatorModule functions{communicator_abi, join};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::CommunicatorModule* kagero_communicator() {
    return &kagero::functions;
}
