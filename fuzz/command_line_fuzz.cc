// The command line of every verb, and the words within its options: read or refused, without any
// file or device, because --help stands before all else. The first byte chooses the verb; words end
// at a line end, and a byte from 0x80 on stands for an option's name or a usual value.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/sensor/pipe_sensor.h"
#include "base/error.h"
#include "base/quantity.h"
#include "fuzz/seeds.h"
#include "fuzz/verb_run.h"
#include "tools/acquire/recording.h"
#include "tools/analyze/analyze_question.h"
#include "tools/cli/shared_options.h"
#include "tools/compare/compare.h"
#include "tools/fit/plan_drop_test.h"
#include "tools/study/manifest.h"
#include "tools/sweep/sweep.h"
#include "tools/verbs.h"

namespace {

using namespace haptometer;

struct Verb {
  int (*run)(int argc, const char* const* argv);
  std::vector<std::string> words;
};

const std::vector<Verb>& Verbs() {
  static const std::vector<Verb> verbs{{tools::RunAcquire, {"acquire"}},
                                       {tools::RunCalibrate, {"calibrate"}},
                                       {tools::RunSession, {"session", "new"}},
                                       {tools::RunSession, {"session", "relabel"}},
                                       {tools::RunSession, {"session", "redo"}},
                                       {tools::RunTrial, {"trial", "info"}},
                                       {tools::RunTrial, {"trial", "label"}},
                                       {tools::RunTrial, {"trial", "exclude"}},
                                       {tools::RunTrial, {"trial", "include"}},
                                       {tools::RunTrial, {"trial", "plot"}},
                                       {tools::RunTrial, {"trial", "export"}},
                                       {tools::RunAnalyze, {"analyze"}},
                                       {tools::RunStudy, {"study"}},
                                       {tools::RunStudy, {"study", "compare"}},
                                       {tools::RunStudy, {"study", "matching"}},
                                       {tools::RunStudy, {"study", "linearity"}},
                                       {tools::RunFitLra, {"fit-lra"}},
                                       {tools::RunFitImpedance, {"fit-impedance"}},
                                       {tools::RunFitAdapter, {"fit-adapter"}},
                                       {tools::RunPlanDropTest, {"plan-drop-test"}},
                                       {tools::RunFitSkin, {"fit-skin"}},
                                       {tools::RunSimulate, {"simulate"}},
                                       {tools::RunSweep, {"sweep"}},
                                       {tools::RunTune, {"tune"}},
                                       {tools::RunCompare, {"compare"}},
                                       {tools::RunReproduce, {"reproduce"}},
                                       {tools::RunEmulate, {"emulate"}}};
  return verbs;
}

constexpr auto kUsual = std::to_array<std::string_view>(
    {"--sensor",       "--port",        "--duration",    "--rate",
     "--channels",     "--label",       "--trigger",     "--reconnect",
     "--format",       "--baud",        "--band",        "--window",
     "--order",        "--corner",      "--floor",       "--frequency",
     "--columns",      "--scale",       "--threads",     "--plot",
     "--json",         "--drop-height", "--moving-mass", "--case-mass",
     "--resistance",   "--inductance",  "--load",        "--open",
     "--plan",         "--want",        "--guess",       "--actuator",
     "--impedance",    "--vary",        "--samples",     "--seed",
     "--shard",        "--merge",       "--best",        "--springs",
     "--contact-area", "--latency",     "--contrast",    "--pattern",
     "--scene",        "--tcp",         "--link",        "--fault",
     "10mm",           "1.40(3)g",      "130uH",         "33ohm",
     "20-500Hz",       "1s:3s",         "Km 2%",         "a=1:2:3",
     "stock:cone",     "subject=3",     "trigger>2.5V",  "displacement:um,voltage:V"});

constexpr std::array<std::string_view, 3> kSeeds{
    "--drop-height\n10mm\n--load\n33ohm\na.csv\n", "--band\n20-500Hz\n--window\n1s:3s\n",
    "--vary\nskin.stiffness_n_per_m=log:600:2000:7\n--samples\n30\n"};

std::vector<std::string> WordsIn(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '\n') {
      if (words.size() == 24) return words;
      words.emplace_back();
    } else if (code >= 0x80) {
      words.back() += kUsual[code % kUsual.size()];
    } else if (c != '\0') {
      words.back() += c;
    }
  }
  return words;
}

// a word is read, or refused in words
template <class T>
void RequireReason(const Result<T>& read) {
  fuzz::Require(read.has_value() || !read.error().what.empty());
}

// the readers of words that stand behind options
void ReadWord(const std::string& word) {
  for (int k = 0; k <= static_cast<int>(Dimension::kArea); ++k) {
    const auto dimension = static_cast<Dimension>(k);
    const auto quantity = ParseQuantity(word, dimension, "--x");
    if (!quantity) continue;
    fuzz::Require(PossibleQuantity(*quantity, dimension, "--x").has_value());
    fuzz::Require(quantity->standard_uncertainty >= 0);
  }
  RequireReason(cli::ParseBand(word));
  RequireReason(cli::ReadKeyValues({word}, "--label", "subject=3"));
  RequireReason(tools::ReadBestWish(word));
  RequireReason(tools::ReadVaryWord(word, tools::RangesAre::kGrid));
  RequireReason(tools::ReadVaryWord(word, tools::RangesAre::kSampled));
  RequireReason(tools::ReadInputs({word}));
  RequireReason(tools::ParseContrast(word));
  RequireReason(tools::ParseWish(word));
  RequireReason(tools::ParseGuesses({word}));
  RequireReason(tools::ParseTrigger(word));
  RequireReason(acquire::ReadPipeChannels(word, acquire::SampleFormat::kText, ""));
  tools::AnalyzeWords analyze;
  analyze.window = word;
  RequireReason(tools::QuestionOf(analyze));
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return fuzz::MutateFromSeeds(kSeeds, 1, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::vector<std::string> given =
      WordsIn({reinterpret_cast<const char*>(data) + 1, size - 1});
  const Verb& verb = Verbs()[data[0] % Verbs().size()];
  std::vector<std::string> words = verb.words;
  words.emplace_back("--help");
  words.insert(words.end(), given.begin(), given.end());
  fuzz::RunVerb(verb.run, words);
  for (const std::string& word : given) ReadWord(word);
  return 0;
}
