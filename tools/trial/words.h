#pragma once

namespace haptometer::tools {

/// What `haptometer trial` can do, a word each; argv[0] is the word. The return value is the
/// program's exit status.
int RunTrialInfo(int argc, const char* const* argv);
int RunTrialLabel(int argc, const char* const* argv);
int RunTrialExport(int argc, const char* const* argv);
int RunTrialPlot(int argc, const char* const* argv);

}  // namespace haptometer::tools
