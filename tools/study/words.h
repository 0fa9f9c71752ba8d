#pragma once

namespace haptometer::tools {

/// What `haptometer study` can do, each in the file of its name; the return value is the program's
/// exit status.
int RunStudyTrials(int argc, const char* const* argv);
int RunStudyMatching(int argc, const char* const* argv);
int RunStudyLinearity(int argc, const char* const* argv);

}  // namespace haptometer::tools
