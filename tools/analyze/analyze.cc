#include "tools/analyze/analyze.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/sweep_analysis.h"
#include "tools/analyze/analysis_document.h"
#include "tools/analyze/analysis_figures.h"
#include "tools/analyze/analyze_question.h"
#include "tools/analyze/spectrum_tables.h"
#include "tools/analyze/sweep_document.h"
#include "tools/cli/json.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/document.h"
#include "tools/verbs.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "analyze";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Say how much a trial vibrates within a band, and over which part of it.",
    .examples = {"analyze trial.bin", "analyze --floor drive_off.bin trial.bin --report trial.html",
                 "analyze --json a.bin b.bin c.csv --window 1s:3s"}};

// what all files are asked alike
struct Job {
  dsp::BandQuestion question;
  trial::ImportOptions import;
  int threads = 1;
  std::string plot;
  bool report = false;
  SpectrumQuestion spectrum{};
};

// what could not be read of the file, and what was assumed in reading it
std::vector<std::string> LossesOf(const trial::ReadReport& report) {
  std::vector<std::string> remarks;
  for (const trial::Finding& found : report.AllFindings().list()) {
    remarks.push_back(document::WordsOf(found));
  }
  return remarks;
}

// spectra of the window into their files; and the panel that plot and report show, if any
Result<std::optional<plot::Panel>> TakeSpectra(const trial::RowSource& rows, const Job& job,
                                               const dsp::BandAnalysis& analysis) {
  const bool is_written = !job.spectrum.spectrum.empty() || !job.spectrum.spectrogram.empty();
  const bool is_shown = job.report || !job.plot.empty();
  if (!analysis.numbers || !(is_written || is_shown)) return std::nullopt;
  const auto window = dsp::ReadWindow(rows, analysis, kMostInSpectrum);
  if (!window) return std::unexpected(window.error());
  if (auto written = WriteSpectra(*window, job.spectrum); !written) {
    return std::unexpected(written.error());
  }
  if (!is_shown) return std::nullopt;
  auto panel = SpectrumPanel(*window, job.spectrum);
  if (!panel) return std::unexpected(panel.error());
  // silence has no place on a logarithmic axis
  const std::vector<double>& levels = panel->series.front().y;
  if (std::ranges::none_of(levels, [](double level) { return level > 0; })) return std::nullopt;
  return *std::move(panel);
}

// draws one file into its plot and its part of the report
Result<void> Draw(const trial::RowSource& rows, const Job& job,
                  const std::optional<plot::Panel>& spectrum, ReportedFile& reported) {
  if (job.plot.empty() && !job.report) return {};
  auto panels = AnalysisPanels(rows, *reported.file.analysis);
  if (!panels) return std::unexpected(panels.error());
  if (!job.plot.empty()) {
    std::vector<plot::Panel> all = *panels;
    if (spectrum) all.push_back(*spectrum);
    if (auto drawn = DrawPanels(job.plot, all); !drawn) return drawn;
  }
  if (!job.report) return {};
  reported.figures.push_back(std::move(*panels));
  reported.captions.emplace_back(
      "The record, the filtered signal and a part of it. Grey: no number is of it.");
  if (!spectrum) return {};
  reported.figures.push_back({*spectrum});
  reported.captions.emplace_back("Spectrum of the unfiltered window (Welch, one-sided).");
  return {};
}

// reads, analyses and, where asked, draws one file
ReportedFile Analyze(const std::string& path, const Job& job) {
  ReportedFile reported;
  AnalyzedFile& file = reported.file;
  file.path = path;
  const auto fail = [&](Error error) {
    if (error.where.empty()) error.where = path;
    file.error = std::move(error);
    return reported;
  };
  const auto opened = trial::OpenRows(path, job.import, job.threads);
  if (!opened) return fail(opened.error());
  file.source = opened->rows->head().metadata.source;
  file.remarks = LossesOf(opened->report);
  auto analysis = dsp::AnalyzeBand(*opened->rows, job.question, job.threads);
  if (!analysis) return fail(analysis.error());
  file.analysis = std::move(*analysis);
  const auto spectrum = TakeSpectra(*opened->rows, job, *file.analysis);
  if (!spectrum) return fail(spectrum.error());
  if (auto drawn = Draw(*opened->rows, job, *spectrum, reported); !drawn) {
    return fail(drawn.error());
  }
  file.analysis->filtered_m = {};
  return reported;
}

void PrintLines(const std::vector<AnalysisLine>& lines) {
  for (const AnalysisLine& line : lines) {
    cli::Print(fmt::format("  {:<18} {}\n", line.label, Printable(line.text)));
  }
}

void Print(const AnalyzedFile& file, bool all) {
  if (!file.analysis) return;
  cli::Print(Printable(file.path) + "\n");
  if (!all) return PrintLines(ShortLines(file));
  for (const AnalysisSection& section : AllSections(file)) {
    cli::Print(fmt::format(" {}\n", Printable(section.heading)));
    PrintLines(section.lines);
  }
}

// what a reader of the short lines must know of every uncertainty in them, once
void PrintNotIncluded(const std::vector<ReportedFile>& files) {
  const bool has_numbers = std::ranges::any_of(files, [](const ReportedFile& reported) {
    return reported.file.analysis && reported.file.analysis->numbers;
  });
  if (has_numbers) cli::Print(fmt::format("{} are in no uncertainty\n", dsp::kNotInBudget));
}

// the status of the worst file
int StatusOf(const std::vector<ReportedFile>& files) {
  int status = 0;
  for (const ReportedFile& reported : files) {
    const AnalyzedFile& file = reported.file;
    if (!file.error && file.analysis->answered) continue;
    const Cause cause = file.error ? file.error->cause : Cause::kCannotAnswer;
    status = cli::WorseStatus(status, ExitStatus(cause));
  }
  return status;
}

Result<Job> JobOf(const AnalyzeWords& words) {
  auto question = QuestionOf(words);
  if (!question) return std::unexpected(question.error());
  auto import = cli::ImportOf(words.import);
  if (!import) return std::unexpected(import.error());
  auto spectrum = SpectrumQuestionOf(words.spectrum);
  if (!spectrum) return std::unexpected(spectrum.error());
  Job job{std::move(*question), std::move(*import),    ThreadsOf(words),
          words.plot,           !words.report.empty(), std::move(*spectrum)};
  if (words.floor.empty()) return job;
  auto floor = ReadFloor(words.floor, job.question, job.import, job.threads);
  if (!floor) return std::unexpected(floor.error());
  job.question.floor = std::move(*floor);
  return job;
}

// one sweep, with its points and its drawing; its status
Result<int> AnswerSweep(const std::string& path, const AnalyzeWords& words, const Job& job,
                        nlohmann::ordered_json* trials) {
  const auto opened = trial::OpenRows(path, job.import, job.threads);
  if (!opened) return std::unexpected(opened.error());
  dsp::SweepQuestion question{job.question.band.lower_hz, job.question.band.upper_hz, {}};
  question.resolution_hz = job.spectrum.resolution_hz;
  const auto answer = dsp::AnalyzeSweep(*opened->rows, question);
  if (!answer) return std::unexpected(answer.error());
  if (trials == nullptr) PrintSweep(path, *answer);
  if (trials != nullptr) trials->push_back(SweepJson(path, *answer));
  if (!words.response.empty()) {
    auto written = cli::WriteOutput(words.response, cli::kSpectrumOutput, words.spectrum.overwrite,
                                    SweepCsv(*answer));
    if (!written) return std::unexpected(written.error());
  }
  if (!words.plot.empty() && !answer->points.empty()) {
    if (auto drawn = plot::DrawPanels(words.plot, SweepPanels(*answer)); !drawn) {
      return std::unexpected(drawn.error());
    }
  }
  return answer->answered ? 0 : ExitStatus(Cause::kCannotAnswer);
}

int AnalyzeSweeps(const AnalyzeWords& words, const Job& job, bool json) {
  nlohmann::ordered_json trials = nlohmann::ordered_json::array();
  int status = 0;
  for (const std::string& path : words.files) {
    const auto answered = AnswerSweep(path, words, job, json ? &trials : nullptr);
    if (answered) {
      status = cli::WorseStatus(status, *answered);
      continue;
    }
    Error error = answered.error();
    if (error.where.empty()) error.where = path;
    status = cli::WorseStatus(status, cli::ReportError(kVerb, error));
  }
  if (json) cli::Print(cli::JsonText({{"trials", std::move(trials)}}));
  return status;
}

Result<void> WritePage(const std::string& path, const std::vector<ReportedFile>& files,
                       const std::string& command) {
  const auto page = AnalysisReport(files, command);
  if (!page) return std::unexpected(page.error());
  return report::WriteReport(path, *page);
}

}  // namespace

int RunAnalyze(int argc, const char* const* argv) {
  cli::Options options(kText);
  AnalyzeWords words;
  DeclareAnalyze(&options, &words);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto job = JobOf(words);
  if (!job) return cli::ReportError(kVerb, job.error());
  if (words.sweep) return AnalyzeSweeps(words, *job, options.json());

  // one after the other: an error of one file does not keep the others from their answer
  std::vector<ReportedFile> files;
  files.reserve(words.files.size());
  for (const std::string& path : words.files) {
    files.push_back(Analyze(path, *job));
    const AnalyzedFile& file = files.back().file;
    if (file.error) static_cast<void>(cli::ReportError(kVerb, *file.error));
    if (!options.json()) Print(file, words.all);
  }
  if (!options.json() && !words.all) PrintNotIncluded(files);
  if (options.json()) {
    std::vector<AnalyzedFile> answers;
    answers.reserve(files.size());
    for (const ReportedFile& reported : files) answers.push_back(reported.file);
    cli::Print(AnalysisJson(answers));
  }
  if (!words.report.empty()) {
    const std::vector<std::string> typed(argv, argv + argc);
    if (auto written = WritePage(words.report, files, cli::CommandLine(typed)); !written) {
      return cli::ReportError(kVerb, written.error());
    }
  }
  return StatusOf(files);
}

Result<dsp::NoiseFloor> ReadFloor(const std::string& path, const dsp::BandQuestion& question,
                                  const trial::ImportOptions& import, int threads) {
  const auto fail = [&](Error error) -> Result<dsp::NoiseFloor> {
    if (error.where.empty()) error.where = path;
    return std::unexpected(std::move(error));
  };
  const auto opened = trial::OpenRows(path, import, threads);
  if (!opened) return fail(opened.error());
  dsp::BandQuestion of_silence = question;
  of_silence.choice = dsp::WindowChoice::kAll;
  of_silence.floor.reset();
  of_silence.keep_filtered = false;
  const auto analysis = dsp::AnalyzeBand(*opened->rows, of_silence, threads);
  if (!analysis) return fail(analysis.error());
  const auto floor = dsp::FloorOf(*analysis, path);
  if (floor) return *floor;
  return CannotAnswer(
      path,
      analysis->reasons.empty() ? "tells no noise floor in the band" : analysis->reasons.front(),
      "record the sensor at rest, drive off, as long and as fast as the trials");
}

}  // namespace haptometer::tools
