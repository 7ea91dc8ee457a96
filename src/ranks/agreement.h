/// Decisions that all ranks of a run make together.
#pragma once

#include "ranks/communicator.h"

#include <string>

namespace kagero {

/// The reason why a rank cannot continue.
struct RankFailure {
    enum class Kind : char { none, wrong_input, failed };

    Kind kind = Kind::none;
    std::string message;
};

/// Thrown by agree() on all ranks if one of them cannot continue. All ranks then end.
class AgreedFailure {
public:
    explicit AgreedFailure(RankFailure failure) : failure_(std::move(failure)) {}
    const RankFailure& failure() const { return failure_; }

private:
    RankFailure failure_;
};

/// Returns the failure that belongs to the exception in flight.
RankFailure failure_in_flight();

/// Collective: returns if all ranks can continue. Otherwise throws AgreedFailure on all ranks, with the failure of the
/// first rank that has one. The message names the rank unless it is rank 0.
///
/// A rank that fails at any other place calls this function with its failure. The others are then in this function, or
/// will call it next. For this reason, every other collective function must follow a call of this one, and no function
/// that can fail may stand between them.
void agree(Communicator& ranks, const RankFailure& own = {});

/// The instruction set and threads of a rank.
struct RankSetup {
    std::string isa;
    unsigned threads;
    std::string remark;  ///< A statement about ranks with different instruction sets; empty if there are none.
};

/// Collective: returns the best instruction set that all ranks support, and the number of threads of this rank. A rank
/// whose user states an instruction set supports only that one. Ranks on the same machine that may use the same
/// processors divide them, unless the number of threads is stated (> 0). Throws InputError on all ranks if they have no
/// instruction set in common.
RankSetup agree_on_setup(Communicator& ranks, const std::string& stated_isa, unsigned stated_threads);

/// Collective: throws AgreedFailure if a property of a rank differs from that of rank 0.
void agree_on_properties(Communicator& ranks, const std::vector<std::pair<std::string, std::string>>& own);

}  // namespace kagero
