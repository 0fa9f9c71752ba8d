#include <fmt/core.h>
#include <malloc.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/fit/actuator.h"
#include "tools/fit/drop_records.h"
#include "tools/fit/fit_document.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "fit-lra";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit an actuator's constants Kv, Bv, Km to its voltage after a drop.",
    .examples = {"fit-lra impulse.csv",
                 "fit-lra --open o*.csv --load 33ohm l*.csv --held --moving-mass '1.40(3)g'"
                 " --resistance 27ohm",
                 "fit-lra drop.csv --actuator thesis-c10-100 --drop-height 10mm+-0.5mm"
                 " --plot fit.svg"}};

// a verb of its own that an option of this one stands for too
struct OtherVerb {
  std::string_view option;
  int (*run)(int argc, const char* const* argv);
  const char* name;
};

constexpr std::array<OtherVerb, 3> kOtherVerbs{{{"--plan", RunPlanDropTest, "plan-drop-test"},
                                                {"--impedance", RunFitImpedance, "fit-impedance"},
                                                {"--adapter", RunFitAdapter, "fit-adapter"}}};

// The verb that an option asks for, with the other words; what the option names is what that verb
// reads. Nothing where no such option is given.
std::optional<int> RunOtherVerb(int argc, const char* const* argv) {
  for (const OtherVerb& other : kOtherVerbs) {
    std::vector<const char*> words{other.name};
    bool is_asked = false;
    // both `--option value` and `--option=value`
    for (int k = 1; k < argc; ++k) {
      const std::string_view word = argv[k];
      const bool is_option = word.starts_with(other.option);
      const bool has_value = is_option && word.substr(other.option.size()).starts_with('=');
      is_asked = is_asked || word == other.option || has_value;
      if (word == other.option) continue;
      words.push_back(has_value ? argv[k] + other.option.size() + 1 : argv[k]);
    }
    if (is_asked) return other.run(static_cast<int>(words.size()), words.data());
  }
  return std::nullopt;
}

void Declare(cli::Options& options, FitLraOptions& wanted, cli::ImportWords& import,
             FitFiles& files) {
  options.Positionals("files", &wanted.files,
                      "time_s,voltage_v with '# key = value' lines (docs/reference/fit-lra.md)", 0);
  options.Groups("--open", &wanted.open, "FILE...", "Records with open terminals");
  options.Groups("--load", &wanted.loads, "OHM FILE...",
                 "Records with a resistor across the terminals; may be repeated");
  DeclareCase(options, wanted.actuator);
  DeclareCoilAndMass(options, wanted.actuator);
  options.Flag("--robust", &wanted.is_robust,
               "Robust fit (Huber loss): outlying samples have little weight");
  options.Number("--drop-height", &wanted.drop_height_m, Dimension::kLength,
                 "Height of the free fall before the impact; gives Km from one open record");
  options.Number("--rebound", &wanted.rebound, Dimension::kNone,
                 "Ratio of the case's speed after the impact to that before it, 0 to 1");
  options.Number("--release-current", &wanted.release_current_a, Dimension::kCurrent,
                 "Current whose end began the motion, in place of an impact; gives Km");
  options.Number("--voltage-scale", &wanted.voltage_scale, Dimension::kNone,
                 "Ratio of the recorder's voltage to the true voltage, such as '1.00(2)'");
  options.Number("--time-scale", &wanted.time_scale, Dimension::kNone,
                 "Ratio of the recorder's time to the true time, such as 1+-5e-5");
  options.Text("--window", &wanted.window, "A:B",
               "Part of each record to fit, in seconds on its time axis");
  DeclareFiles(options, files, "Draw records, fit, residuals, spectra and poles");
  cli::DeclareImport(&options, &import, cli::Scaled::kVoltage);
  for (const OtherVerb& other : kOtherVerbs) {
    static bool is_asked = false;  // RunOtherVerb has handled it
    options.Flag(other.option, &is_asked, fmt::format("Run the verb {}", other.name),
                 cli::Shown::kHelpAll);
  }
}

// fits what can be fitted; what cannot is excluded
FitLraAnswer Answer(FitLraInput input, const FitLraOptions& wanted) {
  FitLraAnswer answer{.input = std::move(input), .required = wanted.actuator.required};
  if (answer.input.records.empty()) return answer;
  auto fit = fit::FitDropTest(answer.input.prepared, answer.input.knowns,
                              wanted.is_robust ? fit::Loss::kHuber : fit::Loss::kSquares);
  if (!fit) {
    answer.input.left_out.push_back(fit.error());
    for (const auto& record : answer.input.records) {
      answer.input.left_out_drops.push_back({record, fit.error()});
    }
    return answer;
  }
  answer.doubts = fit::FindDoubts(*fit, answer.input.records, answer.input.knowns);
  answer.fit = std::move(*fit);
  return answer;
}

// A fit takes and gives back a few MB again and again: given to the system each time, their pages
// cost a sixth of the whole process.
void KeepMemory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  mallopt(M_TRIM_THRESHOLD, 64 * kMegabyte);
  mallopt(M_TOP_PAD, kMegabyte);
}

}  // namespace

int RunFitLra(int argc, const char* const* argv) {
  // before this verb's own options, because the other verb has its own
  if (const auto status = RunOtherVerb(argc, argv)) return *status;
  KeepMemory();
  cli::Options options(kText);
  FitLraOptions wanted;
  cli::ImportWords import_words;
  FitFiles files;
  Declare(options, wanted, import_words, files);
  if (const auto status = options.Parse(argc, argv)) return *status;
  auto import = cli::ImportOf(import_words);
  if (!import) return cli::ReportError(kVerb, import.error());
  wanted.import = std::move(*import);
  if (auto good = CheckFiles(files); !good) return cli::ReportError(kVerb, good.error());
  auto input = GatherFitLraInput(wanted);
  if (!input) return cli::ReportError(kVerb, input.error());

  const FitLraAnswer answer = Answer(std::move(*input), wanted);
  int status = cli::ReportErrors(kVerb, answer.input.left_out);
  files.outputs.json = options.json();
  if (!answer.fit && !IsShownEmpty(files.outputs)) return status;
  document::Document document = FitLraDocument(answer, files.outputs.HasFigures());
  if (document.root.figures.empty()) files.outputs.plot.clear();  // of files that cannot be read
  status =
      cli::WorseStatus(status, document::Present(std::move(document), files.outputs, argc, argv));
  if (!answer.fit) return status;
  const auto saved =
      SaveActuator(files, FittedActuator(*answer.fit, answer.input.knowns), kVerb, argc, argv);
  if (!saved) status = cli::WorseStatus(status, cli::ReportError(kVerb, saved.error()));
  return status;
}

}  // namespace haptometer::tools
