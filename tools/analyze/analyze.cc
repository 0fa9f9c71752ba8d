#include "tools/analyze/analyze.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/sweep_analysis.h"
#include "tools/analyze/analyze_question.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_dsp.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/verbs.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

using document::Section;

constexpr std::string_view kVerb = "analyze";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary =
        "Determine the band-limited RMS displacement of a recording, and the part of it that is "
        "used.",
    .examples = {"analyze trial.bin", "analyze --floor drive_off.bin trial.bin --report trial.html",
                 "analyze --json a.bin b.bin c.csv --window 1s:3s"}};

// what applies to all files alike
struct Job {
  dsp::BandQuestion question;
  trial::ImportOptions import;
  int threads = 1;
  SpectrumQuestion spectrum{};
  document::Outputs outputs{};
  std::function<document::Provenance()> provenance{};  // of a table that is written at that time
};

// writes the spectra of the window; returns the panel for plot and page, if one is shown
Result<std::optional<plot::Panel>> TakeSpectra(const trial::RowSource& rows, const Job& job,
                                               const dsp::BandAnalysis& analysis) {
  const bool is_written = !job.spectrum.spectrum.empty() || !job.spectrum.spectrogram.empty();
  const bool is_shown = job.outputs.HasFigures();
  // without numbers there is no window whose spectrum could be taken
  if (!analysis.numbers || !(is_written || is_shown)) return std::nullopt;
  const auto window = dsp::ReadWindow(rows, analysis, kMostInSpectrum);
  if (!window) return std::unexpected(window.error());
  if (is_written) {
    auto written = WriteSpectra(*window, job.spectrum, CommentOf(job.provenance(), "# "));
    if (!written) return std::unexpected(written.error());
  }
  if (!is_shown) return std::nullopt;
  auto panel = SpectrumPanel(*window, job.spectrum);
  if (!panel) return std::unexpected(panel.error());
  // a spectrum of zeros has no place on a logarithmic axis
  const std::vector<double>& levels = panel->series.front().y;
  if (std::ranges::none_of(levels, [](double level) { return level > 0; })) return std::nullopt;
  return *std::move(panel);
}

// figures of one trial: record, filtered signal, close-up and spectrum
Result<void> AddFigures(const trial::RowSource& rows, const Job& job,
                        const std::optional<plot::Panel>& spectrum, AnalyzedFile& file) {
  if (!job.outputs.HasFigures()) return {};
  auto panels = AnalysisPanels(rows, *file.analysis);
  if (!panels) return std::unexpected(panels.error());
  file.figures.push_back(
      {"The record, the filtered signal and a part of it. Grey: excluded from analysis.",
       *std::move(panels)});
  if (spectrum) {
    file.figures.push_back({"Spectrum of the unfiltered window (Welch, one-sided).", {*spectrum}});
  }
  return {};
}

// reads and analyses one file, and draws it where requested; an error stays in the result
AnalyzedFile Analyze(const std::string& path, const Job& job) {
  AnalyzedFile file;
  file.path = path;
  const auto fail = [&](Error error) {
    if (error.where.empty()) error.where = path;
    file.error = std::move(error);
    return file;
  };
  const auto opened = trial::OpenRows(path, job.import, job.threads);
  if (!opened) return fail(opened.error());
  const trial::Record& head = opened->rows->head();
  file.source = head.metadata.source;
  file.sources = trial::SourcesOf(head.metadata, opened->report);
  file.findings = opened->report.AllFindings();
  auto analysis = dsp::AnalyzeBand(*opened->rows, job.question, job.threads);
  if (!analysis) return fail(analysis.error());
  file.analysis = std::move(*analysis);
  // resolution of the displacement's source, which limits the digits that are shown
  if (const auto channel = dsp::AnalyzedChannel(head)) {
    file.step_m = head.channels[*channel].resolution;
  }
  const auto spectrum = TakeSpectra(*opened->rows, job, *file.analysis);
  if (!spectrum) return fail(spectrum.error());
  if (auto added = AddFigures(*opened->rows, job, *spectrum, file); !added) {
    return fail(added.error());
  }
  // release the filtered rows, needed by the figures only, before the next file is read
  file.analysis->filtered_m = {};
  return file;
}

// the command line as one question; the noise floor is analysed in the same band as the trials
Result<Job> JobOf(const AnalyzeWords& words) {
  auto question = QuestionOf(words);
  if (!question) return std::unexpected(question.error());
  auto import = cli::ImportOf(words.import);
  if (!import) return std::unexpected(import.error());
  auto spectrum = SpectrumQuestionOf(words.spectrum);
  if (!spectrum) return std::unexpected(spectrum.error());
  Job job{.question = std::move(*question),
          .import = std::move(*import),
          .threads = cli::ThreadsOf(words.threads, kMostThreads),
          .spectrum = std::move(*spectrum),
          .outputs = words.outputs};
  if (words.floor.empty()) return job;
  auto floor = ReadFloor(words.floor, job.question, job.import, job.threads);
  if (!floor) return std::unexpected(floor.error());
  job.question.floor = std::move(*floor);
  return job;
}

// the response of one sweep, with its points written to --response
Result<Section> AnswerSweep(const std::string& path, const AnalyzeWords& words, const Job& job) {
  const auto opened = trial::OpenRows(path, job.import, job.threads);
  if (!opened) return std::unexpected(opened.error());
  // the band is the range in which a sweep is searched; its resolution is that of the spectra
  dsp::SweepQuestion question{job.question.band.lower_hz, job.question.band.upper_hz, {}};
  question.resolution_hz = job.spectrum.resolution_hz;
  const auto answer = dsp::AnalyzeSweep(*opened->rows, question);
  if (!answer) return std::unexpected(answer.error());
  if (!words.response.empty()) {
    auto written = cli::WriteOutput(words.response, cli::kSpectrumOutput, words.spectrum.overwrite,
                                    SweepCsv(*answer, job.provenance()));
    if (!written) return std::unexpected(written.error());
  }
  Section section = SweepSection(path, *answer, words.files.size() == 1);
  section.sources = trial::SourcesOf(opened->rows->head().metadata, opened->report);
  if (section.sources.empty()) section.Add(document::kDataSources, {});
  return section;
}

// an error of one file does not prevent the answers of the others; returns the worst status
int AnalyzeSweeps(const AnalyzeWords& words, const Job& job, document::Presenter& shown) {
  int status = 0;
  for (const std::string& path : words.files) {
    auto answered = AnswerSweep(path, words, job);
    if (answered) {
      shown.Add(*std::move(answered));
      continue;
    }
    Error error = answered.error();
    if (error.where.empty()) error.where = path;
    status = cli::WorseStatus(status, cli::ReportError(kVerb, error));
  }
  return cli::WorseStatus(status, shown.Finish({}));
}

int AnalyzeTrials(const AnalyzeWords& words, const Job& job, document::Presenter& shown) {
  int status = 0;
  bool has_numbers = false;
  for (const std::string& path : words.files) {
    const AnalyzedFile file = Analyze(path, job);
    if (file.error) status = cli::WorseStatus(status, cli::ReportError(kVerb, *file.error));
    has_numbers = has_numbers || (file.analysis && file.analysis->numbers);
    shown.Add(TrialSection(file, words.files.size() == 1));
  }
  return cli::WorseStatus(status, shown.Finish(ClosingSection(has_numbers)));
}

}  // namespace

int RunAnalyze(int argc, const char* const* argv) {
  cli::Options options(kText);
  AnalyzeWords words;
  DeclareAnalyze(&options, &words);
  if (const auto status = options.Parse(argc, argv)) return *status;
  auto job = JobOf(words);
  if (!job) return cli::ReportError(kVerb, job.error());
  job->outputs.json = options.json();
  job->provenance = [&] { return document::ProvenanceOf(kVerb, argc, argv); };
  document::Presenter shown(AnalysisDocument(words.files.front(), words.files.size()), job->outputs,
                            argc, argv);
  return words.sweep ? AnalyzeSweeps(words, *job, shown) : AnalyzeTrials(words, *job, shown);
}

// noise in the band: the whole drive-off record is the window, and no floor is subtracted from it
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
  // no floor: the analysis was refused, or its record has no numbers
  if (floor) return *floor;
  const std::string refusal = document::RefusalOf(analysis->findings);
  return CannotAnswer(path, refusal.empty() ? "holds no noise floor in the band" : refusal,
                      "record the sensor at rest, drive off, as long and as fast as the trials");
}

}  // namespace haptometer::tools
