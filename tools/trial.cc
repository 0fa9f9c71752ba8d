// trial: what can be done with recordings, a word each (tools/trial/).
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "tools/cli/report.h"
#include "tools/trial/words.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

struct Word {
  std::string_view name;
  int (*run)(int argc, const char* const* argv);
  std::string_view summary;
  std::string_view example;
};

constexpr std::array<Word, 4> kWords{
    {{"info", RunTrialInfo, "What a recording holds: channels, times, gaps, labels, losses.",
      "haptometer trial info trial.bin"},
     {"label", RunTrialLabel, "Add labels to a trial.",
      "haptometer trial label trial.bin subject=3 condition=stock"},
     {"plot", RunTrialPlot, "Draw a recording.", "haptometer trial plot trial.bin -o trial.svg"},
     {"export", RunTrialExport, "Write recordings as CSV, HDF5, NumPy, WAV or MATLAB files.",
      "haptometer trial export trial.bin -o trial.h5"}}};

void PrintHelp() {
  cli::Print("What a recording holds; label it, draw it, export it.\n\n");
  for (const Word& word : kWords)
    cli::Print(fmt::format("  haptometer trial {:<7} {}\n", word.name, word.summary));
  cli::Print("\nExamples:\n");
  for (const Word& word : kWords) cli::Print(fmt::format("  {}\n", word.example));
}

}  // namespace

int RunTrial(int argc, const char* const* argv) {
  const std::string_view name = argc > 1 ? argv[1] : "--help";
  const auto word = std::ranges::find(kWords, name, &Word::name);
  if (word != kWords.end()) return word->run(argc - 1, argv + 1);
  if (name == "--help" || name == "-h" || name == "--help-all") {
    PrintHelp();
    return argc > 1 ? 0 : 2;
  }
  std::vector<std::string> names;
  names.reserve(std::size(kWords));
  for (const Word& each : kWords) names.emplace_back(each.name);
  const std::string nearest = Nearest(name, names);
  return cli::ReportError("trial",
                          {Cause::kUsage, std::string(name), "is not something trial can do",
                           nearest.empty() ? "see haptometer trial --help"
                                           : fmt::format("did you mean trial {}?", nearest)});
}

}  // namespace haptometer::tools
