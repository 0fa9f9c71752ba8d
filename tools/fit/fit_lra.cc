#include <fmt/core.h>
#include <malloc.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "fit/drop_test/drop_test_fit.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/fit/drop_records.h"
#include "tools/fit/fit_adapter.h"
#include "tools/fit/fit_figures.h"
#include "tools/fit/fit_impedance.h"
#include "tools/fit/fit_lra_document.h"
#include "tools/fit/plan_drop_test.h"
#include "tools/fit/saved_actuator.h"
#include "tools/plot/gnuplot.h"
#include "tools/report/html_page.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "fit-lra";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit an actuator's constants Kv, Bv, Km to the voltage it gives after a drop.",
    .examples = {"fit-lra impulse.csv",
                 "fit-lra --open o*.csv --load 33ohm l*.csv --held --moving-mass '1.40(3)g'"
                 " --resistance 27ohm",
                 "fit-lra drop.csv --actuator thesis-c10-100 --drop-height 10mm+-0.5mm"
                 " --plot fit.svg"}};

// the constants that --require names, by the names that it may name
std::vector<std::pair<std::string_view, const fit::FittedValue*>> Constants(
    const fit::DropTestFit& fit) {
  return {{"Kv", &fit.stiffness}, {"Bv", &fit.damping}, {"Km", &fit.force_constant}};
}

Result<void> CheckRequired(const std::vector<std::string>& required) {
  const fit::DropTestFit none;
  for (const std::string& name : required) {
    const auto is_named = [&name](const auto& constant) { return constant.first == name; };
    if (std::ranges::none_of(Constants(none), is_named)) {
      return Usage("--require", fmt::format("{} is none of Kv, Bv, Km", name),
                   "write --require Km");
    }
  }
  return {};
}

// says which of the required constants are missing; status 3 then
int ReportRequired(const fit::DropTestFit& fit, const std::vector<std::string>& required) {
  int status = 0;
  for (const auto& [name, value] : Constants(fit)) {
    if (value->determined || std::ranges::find(required, name) == required.end()) continue;
    const auto why =
        std::ranges::find_if(fit.undetermined, [&name](const auto& s) { return s.contains(name); });
    status = cli::ReportError(
        kVerb,
        CannotAnswer("", fmt::format("{} is required and not determined", name),
                     why != fit.undetermined.end() ? *why
                     : value->at_most ? "more drops, less noise or a load nearer to the coil's ohms"
                                      : "see the result")
            .error());
  }
  return status;
}

// the files that are asked for beside the answer, and one that is read
struct FitLraFiles {
  std::string plot;
  std::string report;
  std::string save;
  bool overwrite = false;  // of `save`
  std::string impedance;   // a sweep in place of drops
};

void Declare(cli::Options& options, FitLraOptions& wanted, cli::ImportWords& import,
             FitLraFiles& files) {
  options.Positionals("files", &wanted.files,
                      "time_s,voltage_v with '# key = value' lines (docs/reference/fit-lra.md)", 0);
  options.Groups("--open", &wanted.open, "FILE...", "Records with open terminals");
  options.Groups("--load", &wanted.loads, "OHM FILE...",
                 "Records with a resistor across the terminals; may be repeated");
  options.Flag("--held", &wanted.held, "The case was fixed to something heavy");
  options.Flag("--free", &wanted.is_free, "The case was free in the air");
  options.Flag("--robust", &wanted.is_robust, "A few samples far off shall hardly count");
  options.Number("--moving-mass", &wanted.moving_mass_kg, Dimension::kMass, "Mv");
  options.Number("--case-mass", &wanted.case_mass_kg, Dimension::kMass, "Mc");
  options.Number("--resistance", &wanted.resistance_ohm, Dimension::kResistance, "R of the coil");
  options.Number("--inductance", &wanted.inductance_h, Dimension::kInductance, "L of the coil");
  options.Number("--drop-height", &wanted.drop_height_m, Dimension::kLength,
                 "Height of the free fall; gives Km from one open record");
  options.Number("--rebound", &wanted.rebound, Dimension::kNone,
                 "Speed of the case after the impact over that before it (0 to 1)");
  options.Number("--release-current", &wanted.release_current_a, Dimension::kCurrent,
                 "The motion began with the end of this current, not with a blow; gives Km");
  options.Number("--voltage-scale", &wanted.voltage_scale, Dimension::kNone,
                 "Volts shown by the recorder over true ones: '1.00(2)'");
  options.Number("--time-scale", &wanted.time_scale, Dimension::kNone,
                 "Seconds shown over true ones: 1+-5e-5");
  options.Text("--window", &wanted.window, "A:B",
               "Fit this part of each record alone, from and to seconds on its time axis");
  options.Text("--actuator", &wanted.actuator, "NAME|FILE",
               "Takes masses, R and L from an actuator file or thesis-c10-100");
  options.Repeated("--require", &wanted.required, "Kv|Bv|Km",
                   "Status 3 where this constant is not determined; may be repeated");
  options.Output(
      "--save", &files.save, "FILE.toml",
      "Write the actuator with uncertainties and correlations, for scenes and --actuator");
  options.Output("--plot", &files.plot, "FILE.svg|png|pdf",
                 "Draw records, fit, residuals, spectra and poles");
  options.Output("--report", &files.report, "FILE.html",
                 "Write one page with figures, budget, assumptions and settings");
  options.Flag("--overwrite", &files.overwrite, "Replace what --save wrote earlier");
  options.Text(
      "--impedance", &files.impedance, "FILE.csv",
      "The constants from a sweep frequency_hz,impedance_ohm,phase_deg, in place of drops");
  cli::DeclareImport(&options, &import, cli::Scaled::kVoltage);
}

// where the files shall stand; to be asked before long work
Result<void> CheckPaths(const FitLraFiles& files) {
  if (!files.plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(files.plot); !drawable) return drawable;
  }
  if (!files.save.empty()) {
    auto free = cli::CheckOutput(files.save, cli::kActuatorOutput, files.overwrite);
    if (!free) return free;
  }
  return files.report.empty() ? Result<void>{} : report::CheckReportPath(files.report);
}

Result<void> WritePage(const std::string& path, const ReportedFit& reported) {
  const auto page = FitLraReport(reported);
  if (!page) return std::unexpected(page.error());
  return report::WriteReport(path, *page);
}

// `command` is how the program was called
Result<void> WriteFiles(const FitLraFiles& files, const fit::DropTestFit& fit,
                        const std::vector<std::string>& doubts, const FitLraInput& input,
                        const std::string& command) {
  if (!files.save.empty()) {
    auto saved = SaveActuator(files.save, files.overwrite, FittedActuator(fit, input.knowns));
    if (!saved) return saved;
  }
  if (files.plot.empty() && files.report.empty()) return {};
  auto figures = FitLraFigures(fit, input.records, input.left_out_drops);
  if (!files.plot.empty()) {
    if (auto drawn = DrawFigures(files.plot, figures); !drawn) return drawn;
  }
  if (files.report.empty()) return {};
  return WritePage(files.report,
                   {fit, doubts, input.remarks, input.left_out, std::move(figures), command});
}

// the status of drops of which none could be fitted; a plot shows them nonetheless
int DrawUnfitted(const FitLraFiles& files, const std::vector<LeftOutDrop>& drops, int status) {
  if (files.plot.empty() || drops.empty()) return status;
  const auto drawn = DrawFigures(files.plot, UnfittedFigures(drops));
  return drawn ? status : cli::WorseStatus(status, cli::ReportError(kVerb, drawn.error()));
}

// what is asked in place of drops goes with few of the others
Result<void> CheckTogether(const PlanWords& plan, const AdapterWords& adapter,
                           const FitLraFiles& files) {
  const std::string written = files.plot + files.report + files.save;
  if (!plan.asked) {
    if (auto checked = CheckNotPlanned(plan); !checked) return checked;
  } else if (!written.empty() || !files.impedance.empty() || adapter.given()) {
    return Usage("--plan", "goes without --plot, --report, --save, --impedance and --adapter",
                 "make the drops, then fit them without --plan");
  }
  if (adapter.given() && !written.empty()) {
    return Usage("--adapter", "goes without --plot, --report and --save", "leave these out");
  }
  if (!files.impedance.empty() && !files.report.empty()) {
    return Usage("--report", "is for drops", "leave it out beside --impedance");
  }
  return {};
}

// fits the drops, and answers what can be answered
int AnswerDrops(const FitLraOptions& wanted, const FitLraFiles& files, const std::string& command,
                bool json) {
  const auto input = GatherFitLraInput(wanted);
  if (!input) return cli::ReportError(kVerb, input.error());
  int status = 0;
  for (const Error& error : input->left_out) {
    status = cli::WorseStatus(status, cli::ReportError(kVerb, error));
  }
  if (input->records.empty()) {
    if (json)
      fmt::print("{}", FitLraJson(NothingDetermined(), {}, input->remarks, input->left_out));
    return DrawUnfitted(files, input->left_out_drops, status);
  }
  for (const auto& remark : input->remarks) cli::Remark(kVerb, remark);

  const auto fit = fit::FitDropTest(input->prepared, input->knowns,
                                    wanted.is_robust ? fit::Loss::kHuber : fit::Loss::kSquares);
  if (!fit) {
    auto left_out = input->left_out;
    left_out.push_back(fit.error());
    if (json) fmt::print("{}", FitLraJson(NothingDetermined(), {}, input->remarks, left_out));
    std::vector<LeftOutDrop> drops = input->left_out_drops;
    for (const auto& record : input->records) drops.push_back({record, fit.error()});
    return DrawUnfitted(files, drops, cli::ReportError(kVerb, fit.error()));
  }
  const auto doubts = fit::FindDoubts(*fit, input->records, input->knowns);
  cli::Print(json ? FitLraJson(*fit, doubts, input->remarks, input->left_out)
                  : FitLraText(*fit, doubts));
  status = cli::WorseStatus(status, ReportRequired(*fit, wanted.required));
  if (!fit->contradictions.empty()) {
    status = cli::WorseStatus(
        status, cli::ReportError(kVerb, CannotAnswer("", "the records contradict each other",
                                                     fit->contradictions.front())
                                            .error()));
  }
  if (!fit->natural_frequency.determined || !fit->quality_factor.determined) {
    const std::string why =
        fit->undetermined.empty() ? "record at least three decay times" : fit->undetermined.front();
    status = cli::WorseStatus(
        status,
        cli::ReportError(kVerb, CannotAnswer("", "f0 or Q is not determined", why).error()));
  }
  if (auto written = WriteFiles(files, *fit, doubts, *input, command); !written) {
    status = cli::WorseStatus(status, cli::ReportError(kVerb, written.error()));
  }
  return status;
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
  KeepMemory();
  cli::Options options(kText);
  FitLraOptions wanted;
  cli::ImportWords import_words;
  FitLraFiles files;
  PlanWords plan;
  Declare(options, wanted, import_words, files);
  AdapterWords adapter;
  DeclareAdapter(&options, &adapter);
  DeclarePlan(options, plan);
  if (const auto status = options.Parse(argc, argv)) return *status;
  auto import = cli::ImportOf(import_words);
  if (!import) return cli::ReportError(kVerb, import.error());
  wanted.import = std::move(*import);
  if (auto good = CheckTogether(plan, adapter, files); !good) {
    return cli::ReportError(kVerb, good.error());
  }
  if (plan.asked) return RunFitPlan(plan, wanted, options.json());
  const bool has_drops = !wanted.files.empty() || !wanted.open.empty() || !wanted.loads.empty() ||
                         !files.impedance.empty();
  if (adapter.given()) return AnswerAdapter(adapter, wanted.import, has_drops, options.json());
  if (auto good = CheckPaths(files); !good) return cli::ReportError(kVerb, good.error());
  if (auto named = CheckRequired(wanted.required); !named) {
    return cli::ReportError(kVerb, named.error());
  }
  if (!files.impedance.empty()) {
    return AnswerImpedance({files.impedance, files.plot, files.save, files.overwrite}, wanted,
                           options.json());
  }
  const std::vector<std::string> typed(argv, argv + argc);
  return AnswerDrops(wanted, files, cli::CommandLine(typed), options.json());
}

}  // namespace haptometer::tools
