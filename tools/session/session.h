#pragma once

namespace haptometer::tools {

/// `haptometer session new|next|redo|reject|relabel|floor|note|skip|status`
/// (docs/reference/session.md); argv[0] is the verb. The return value is the program's exit status.
int RunSession(int argc, const char* const* argv);

}  // namespace haptometer::tools
