// The tracing loop on gangs of packets.
#include "kernels/tracing/packets.h"
#include "kernels/tracing/trace_tile.h"

namespace kagero {
#define KAGERO_GANG(V, LANES) template void trace_entry<V, LANES>(const Job*, const Tile*, RayEnd*, Counters*);
KAGERO_GANG(PacketDouble, 128)
KAGERO_GANG(PacketDouble, 256)
KAGERO_GANG(PacketFloat, 128)
KAGERO_GANG(PacketFloat, 256)
#undef KAGERO_GANG
}
