// study: several trials, or several settings, as one answer; a word each for what is no table of
// trials (tools/study/).
#include <string_view>

#include "tools/study/words.h"
#include "tools/verbs.h"

namespace haptometer::tools {

int RunStudy(int argc, const char* const* argv) {
  const std::string_view word = argc > 1 ? argv[1] : "";
  if (word == "matching") return RunStudyMatching(argc - 1, argv + 1);
  if (word == "linearity") return RunStudyLinearity(argc - 1, argv + 1);
  return RunStudyTrials(argc, argv);
}

}  // namespace haptometer::tools
