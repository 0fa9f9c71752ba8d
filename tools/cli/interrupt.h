#pragma once

#include <atomic>

namespace haptometer::cli {

/// From now on SIGINT, SIGTERM and SIGHUP (a closed terminal) only set a flag, so that a verb can
/// finish its file; a second signal of the same kind ends the program at once. SIGPIPE is ignored.
void CatchInterrupts();

/// As if `signal` had come and been caught: for an output that nobody reads any more (SIGPIPE).
void InterruptAsBy(int signal);

/// Set to true by the first signal; a recorder polls it.
[[nodiscard]] const std::atomic<bool>& Interrupted();

/// 130 after SIGINT, 143 after SIGTERM, 129 after SIGHUP, 141 for SIGPIPE, `otherwise` when no
/// signal came.
[[nodiscard]] int InterruptedStatus(int otherwise);

}  // namespace haptometer::cli
