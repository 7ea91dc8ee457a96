#include "ranks/shared_tiles.h"

#include "error.h"
#include "parts/bytes.h"
#include "parts/identity.h"
#include "ranks/agreement.h"

#include <sstream>

namespace kagero {

void share_tiles(Communicator& ranks, const TileFileHeader& header, const TileResults& results) {
    ByteWriter writer;
    writer.put_text(encode_header(header));
    for (const std::uint64_t index : results.tiles()) writer.put(index);
    agree(ranks);
    ranks.broadcast(writer.bytes);
    agree(ranks);
}

std::unique_ptr<ReceivedTiles> receive_tiles(Communicator& ranks, const Properties& identity) {
    std::string bytes;
    agree(ranks);
    ranks.broadcast(bytes);
    ByteReader reader(bytes);
    std::istringstream in(reader.get_text());
    auto received = std::make_unique<ReceivedTiles>();
    received->header = read_header(in, "the message of rank 0").value();
    const std::string difference = describe_difference(received->header.identity, "rank 0", identity, "this rank");
    if (!difference.empty())
        throw InputError(difference +
                         "; all ranks need the same program and the same files, from a shared file system or by "
                         "--send-files");
    while (!reader.empty()) received->finished.add(reader.get<std::uint64_t>(), {});
    return received;
}

}  // namespace kagero
