#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/quantity.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/analyze/analyze_output.h"
#include "tools/cli/band.h"
#include "tools/cli/import_words.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/plot/gnuplot.h"
#include "tools/verbs.h"
#include "trial/open_rows.h"
#include "trial/row_source.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "analyze";
constexpr std::int64_t kMostThreads = 64;

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Say how much a trial vibrates within a band, and over which part of it.",
    .examples = {"analyze trial.bin", "analyze --json a.bin b.bin c.csv",
                 "analyze trial.bin --band 40-400Hz --order 4 --plot trial.svg"}};

struct Wanted {
  std::vector<std::string> files;
  std::string band = "20-500Hz";
  std::optional<std::int64_t> order;
  std::string corner = "whole";
  std::string plot;
  std::string window = "auto";
  std::string floor;
  std::string drive_frequency;
  std::optional<std::int64_t> threads;
  cli::ImportWords import;
};

void Declare(cli::Options& options, Wanted& wanted) {
  options.Positionals("files", &wanted.files,
                      "Trials (trial.bin) or CSV with time_s,displacement_m");
  options.Text("--band", &wanted.band, "LOWER-UPPERHz", "Corners of the band-pass; 20-500Hz");
  options.Count("--order", &wanted.order, 1, dsp::kHighestOrder,
                "Butterworth order, kept whatever it leaves settled (default: 6, lowered where a "
                "record is too short for it)");
  options.Choice("--corner", &wanted.corner, {"whole", "each"},
                 "-3 dB at the corners of both passes together or of each", cli::Shown::kHelpAll);
  options.Text("--window", &wanted.window, "auto|all|BEGIN:END",
               "Which part is measured: the steady part of the drive (auto), all that has settled, "
               "or a stretch of time as 1s:3s");
  options.Text("--floor", &wanted.floor, "FILE",
               "A trial without drive: its RMS in the band is taken off in power");
  options.Text("--drive-frequency", &wanted.drive_frequency, "F",
               "Of a trial too slow for the band: fit a tone at this frequency",
               cli::Shown::kHelpAll);
  options.Text("--plot", &wanted.plot, "FILE.svg|png|pdf",
               "Draw the trial and what was used of it");
  options.Count(
      "--threads", &wanted.threads, 1, kMostThreads,
      "Threads that filter (default: as many as there are cores); no number depends on it",
      cli::Shown::kHelpAll);
  cli::DeclareImport(&options, &wanted.import);
}

// "auto", "all", "1s:3s"
Result<void> TakeWindow(const std::string& text, dsp::BandQuestion* question) {
  if (text == "auto") return {};
  if (text == "all") {
    question->choice = dsp::WindowChoice::kAll;
    return {};
  }
  const auto colon = text.find(':');
  if (colon == std::string::npos) {
    return Usage("--window", fmt::format("'{}' is no window", text), "write auto, all or 1s:3s");
  }
  const auto begin = ParseQuantity(text.substr(0, colon), Dimension::kTime, "--window");
  if (!begin) return std::unexpected(begin.error());
  const auto end = ParseQuantity(text.substr(colon + 1), Dimension::kTime, "--window");
  if (!end) return std::unexpected(end.error());
  if (!(end->value > begin->value)) {
    return Usage("--window", fmt::format("'{}' ends before it begins", text), "write it as 1s:3s");
  }
  question->choice = dsp::WindowChoice::kGiven;
  question->window = {begin->value, end->value};
  return {};
}

// what a drive-off trial leaves in the band
Result<dsp::NoiseFloor> ReadFloor(const Wanted& wanted, const trial::ImportOptions& import,
                                  dsp::BandQuestion question, int threads) {
  question.choice = dsp::WindowChoice::kAll;
  question.keep_filtered = false;
  const auto named = [&](Error error) {
    if (error.where.empty()) error.where = wanted.floor;
    return std::unexpected(std::move(error));
  };
  const auto opened = trial::OpenRows(wanted.floor, import);
  if (!opened) return named(opened.error());
  const auto analysis = dsp::AnalyzeBand(*opened->rows, question, threads);
  if (!analysis) return named(analysis.error());
  auto floor = dsp::FloorOf(*analysis, wanted.floor);
  if (!floor) return CannotAnswer(wanted.floor, "gives no floor: " + analysis->reasons.front());
  return *floor;
}

Result<dsp::BandQuestion> QuestionOf(const Wanted& wanted) {
  if (!wanted.plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(wanted.plot); !drawable) {
      return std::unexpected(drawable.error());
    }
    if (wanted.files.size() > 1) {
      return Usage("--plot", fmt::format("draws one trial, not {}", wanted.files.size()),
                   "give one file");
    }
  }
  const auto band = cli::ParseBand(wanted.band);
  if (!band) return std::unexpected(band.error());
  dsp::BandQuestion question;
  question.band.lower_hz = band->lower_hz;
  question.band.upper_hz = band->upper_hz;
  if (auto taken = TakeWindow(wanted.window, &question); !taken) {
    return std::unexpected(taken.error());
  }
  if (!wanted.drive_frequency.empty()) {
    const auto frequency =
        ParseQuantity(wanted.drive_frequency, Dimension::kFrequency, "--drive-frequency");
    if (!frequency) return std::unexpected(frequency.error());
    question.drive_frequency_hz = frequency->value;
  }
  question.may_lower_order = !wanted.order.has_value();
  question.band.order = static_cast<int>(wanted.order.value_or(question.band.order));
  question.band.corners = wanted.corner == "whole" ? dsp::Corners::kWhole : dsp::Corners::kEach;
  // whether the band is one, before any file is read
  const auto possible = dsp::DesignBandPass(question.band, 4 * question.band.upper_hz);
  if (!possible) return std::unexpected(possible.error());
  return question;
}

// what could not be read of the file
std::vector<std::string> LossesOf(const trial::ReadReport& report) {
  std::vector<std::string> remarks;
  remarks.reserve(report.losses.size() + 1);
  for (const trial::Loss& loss : report.losses) remarks.push_back(Describe(loss));
  for (const std::string& remark : report.remarks) remarks.push_back(remark);
  if (!report.closed) remarks.emplace_back("the file was not finished by its writer");
  return remarks;
}

// reads, analyses and, where asked, draws one file
AnalyzedFile Analyze(const std::string& path, const dsp::BandQuestion& question,
                     const trial::ImportOptions& import, const std::string& plot, int threads) {
  AnalyzedFile file;
  file.path = path;
  const auto fail = [&](Error error) {
    if (error.where.empty()) error.where = path;
    file.error = std::move(error);
    return file;
  };
  const auto opened = trial::OpenRows(path, import);
  if (!opened) return fail(opened.error());
  file.source = opened->rows->head().metadata.source;
  file.remarks = LossesOf(opened->report);
  dsp::BandQuestion asked = question;
  asked.keep_filtered = !plot.empty();
  auto analysis = dsp::AnalyzeBand(*opened->rows, asked, threads);
  if (!analysis) return fail(analysis.error());
  if (!plot.empty()) {
    // what is drawn is in memory as a whole
    const auto record = trial::ReadAllRows(*opened->rows);
    if (!record) return fail(record.error());
    if (auto drawn = DrawPanels(plot, AnalysisPanels(*record, *analysis)); !drawn) {
      return fail(drawn.error());
    }
  }
  file.analysis = std::move(*analysis);
  return file;
}

int ThreadsOf(const Wanted& wanted) {
  const auto cores = std::max<std::int64_t>(1, std::thread::hardware_concurrency());
  return static_cast<int>(wanted.threads.value_or(std::min(cores, kMostThreads)));
}

// 0, or the status of the worst file: failing outranks not answering
int StatusOf(const std::vector<AnalyzedFile>& files) {
  int status = 0;
  for (const AnalyzedFile& file : files) {
    if (file.error && file.error->cause != Cause::kCannotAnswer)
      return ExitStatus(file.error->cause);
    if (file.error || !file.analysis->answered) status = ExitStatus(Cause::kCannotAnswer);
  }
  return status;
}

}  // namespace

int RunAnalyze(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  Declare(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  auto question = QuestionOf(wanted);
  if (!question) return cli::ReportError(kVerb, question.error());
  const auto import = cli::ImportOf(wanted.import);
  if (!import) return cli::ReportError(kVerb, import.error());
  if (!wanted.floor.empty()) {
    auto floor = ReadFloor(wanted, *import, *question, ThreadsOf(wanted));
    if (!floor) return cli::ReportError(kVerb, floor.error());
    question->floor = std::move(*floor);
  }

  // one after the other: an error of one file does not keep the others from their answer
  std::vector<AnalyzedFile> files;
  for (const std::string& path : wanted.files) {
    files.push_back(Analyze(path, *question, *import, wanted.plot, ThreadsOf(wanted)));
    AnalyzedFile& file = files.back();
    if (file.error) static_cast<void>(cli::ReportError(kVerb, *file.error));
    if (!options.json()) PrintAnalysis(file);
    if (file.analysis) file.analysis->filtered_m = {};
  }
  if (options.json()) fmt::print("{}", AnalysisJson(files));
  return StatusOf(files);
}

}  // namespace haptometer::tools
