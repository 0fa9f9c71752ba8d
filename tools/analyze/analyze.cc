#include "tools/analyze/analyze.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/jobs.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/sweep_analysis.h"
#include "dsp/analysis/window/window_remarks.h"
#include "tools/analyze/analyze_question.h"
#include "tools/cli/output_file.h"
#include "tools/cli/recording_files.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_dsp.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/document/provenance.h"
#include "tools/document/render.h"
#include "tools/results/kept_answers.h"
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
  Expectation expected{};
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
  HAPTOMETER_LET(const auto window, dsp::ReadWindow(rows, analysis, kMostInSpectrum));
  if (is_written) {
    HAPTOMETER_TRY(WriteSpectra(window, job.spectrum, CommentOf(job.provenance(), "# ")));
  }
  if (!is_shown) return std::nullopt;
  auto panel = SpectrumPanel(window, job.spectrum, analysis);
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
      {"The record with its artifacts, the states of the drive, the filtered signal and a part of "
       "it. Grey lines and shades: excluded from the RMS.",
       *std::move(panels)});
  if (spectrum) {
    file.figures.push_back(
        {"Spectrum of the unfiltered window (Welch, one-sided). The RMS is of what "
         "lies between the corners of the band.",
         {*spectrum}});
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
  file.metadata = head.metadata;
  file.sources = trial::SourcesOf(head.metadata, opened->report);
  file.findings = opened->report.AllFindings();
  auto analysis = dsp::AnalyzeBand(*opened->rows, job.question, job.threads);
  if (!analysis) return fail(analysis.error());
  file.analysis = std::move(*analysis);
  file.deviations = DeviationsFrom(job.expected, *file.analysis, file.sources);
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
  std::vector<std::string> read = words.files;
  if (!words.floor.empty()) read.push_back(words.floor);
  auto import = cli::ImportOf(words.import, read);
  if (!import) return std::unexpected(import.error());
  auto spectrum = SpectrumQuestionOf(words.spectrum);
  if (!spectrum) return std::unexpected(spectrum.error());
  Job job{.question = std::move(*question),
          .import = std::move(*import),
          .threads = cli::ThreadsOf(words.threads, kMostThreads),
          .spectrum = std::move(*spectrum),
          .outputs = words.outputs};
  if (!words.expect.empty()) {
    auto expected = ParseExpectation(words.expect);
    if (!expected) return std::unexpected(expected.error());
    if (expected->most_off_repeats) {
      return Usage("--expect", "repeats<... is for a session, which has earlier trials",
                   "leave it out");
    }
    job.expected = *expected;
  }
  if (words.floor.empty()) return job;
  auto floor = ReadFloor(words.floor, job.question, job.import, job.threads);
  if (!floor) return std::unexpected(floor.error());
  job.question.floor = std::move(*floor);
  return job;
}

// the response of one sweep, with its points written to --response
Result<Section> AnswerSweep(const std::string& path, const AnalyzeWords& words, const Job& job) {
  HAPTOMETER_LET(const auto opened, trial::OpenRows(path, job.import, job.threads));
  // the band is the range in which a sweep is searched; its resolution is that of the spectra
  dsp::SweepQuestion question{job.question.band.lower_hz, job.question.band.upper_hz, {}};
  question.resolution_hz = job.spectrum.resolution_hz;
  HAPTOMETER_LET(const auto answer, dsp::AnalyzeSweep(*opened.rows, question));
  if (!words.response.empty()) {
    HAPTOMETER_TRY(cli::WriteOutput(words.response, cli::kSpectrumOutput, words.spectrum.overwrite,
                                    SweepCsv(answer, job.provenance())));
  }
  Section section = SweepSection(path, answer, words.files.size() == 1);
  section.sources = trial::SourcesOf(opened.rows->head().metadata, opened.report);
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

// a folder stands for its recordings, in the order of their paths
Result<std::vector<std::string>> FilesOf(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  for (const std::string& word : words) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(word, ignored)) {
      files.push_back(word);
      continue;
    }
    HAPTOMETER_LET(const auto found, cli::RecordingsIn(word));
    for (const cli::RecordingFile& file : found) {
      if (!file.is_table) files.push_back(file.path);
    }
  }
  return files;
}

ShownTrial Shown(const AnalyzedFile& file, bool is_alone) {
  const bool has_numbers = file.analysis && file.analysis->numbers;
  return {.section = TrialSection(file, is_alone),
          .row = TableRow(file),
          .error = file.error,
          .deviates = !file.deviations.list().empty(),
          .has_numbers = has_numbers,
          .excludes_calibration = has_numbers && !file.analysis->gain_uncertainty};
}

// the same as it was kept in an earlier run, or by `analyze` now
Result<ShownTrial> KeptOr(const std::string& path, std::string_view further, TrialResults& results,
                          const std::function<ShownTrial()>& analyze) {
  const auto compute = [&]() -> KeptAnswer {
    const ShownTrial shown = analyze();
    return {.bytes = BytesOf(shown), .is_error = shown.error.has_value()};
  };
  HAPTOMETER_LET(const auto bytes,
                 results.Answer(path, fmt::format("path = {}\n{}", path, further), compute));
  auto shown = ShownTrialOf(bytes);
  if (!shown) return NotReadable(path);
  return *std::move(shown);
}

// what is shown of the trials, taken one by one in the order of the files
class Answers {
 public:
  Answers(const AnalyzeWords& words, document::Presenter& shown) : words_(words), shown_(shown) {}

  void Take(ShownTrial trial) {
    if (trial.error) Fail(*trial.error);
    // a violated expectation ends with the status of a question that is not answered
    if (trial.deviates) status_ = cli::WorseStatus(status_, ExitStatus(Cause::kCannotAnswer));
    has_numbers_ = has_numbers_ || trial.has_numbers;
    excludes_calibration_ = excludes_calibration_ || trial.excludes_calibration;
    if (!words_.table.empty()) table_.sections.push_back(std::move(trial.row));
    shown_.Add(std::move(trial.section));
  }

  void Fail(const Error& error) {
    status_ = cli::WorseStatus(status_, cli::ReportError(kVerb, error));
  }

  [[nodiscard]] int Finish(const Job& job) {
    if (!words_.table.empty()) {
      const auto written =
          cli::WriteOutput(words_.table, cli::kTrialsTableOutput, words_.spectrum.overwrite,
                           document::CsvOf(table_, job.provenance()));
      if (!written) Fail(written.error());
    }
    return cli::WorseStatus(status_, shown_.Finish(ClosingSection(
                                         excludes_calibration_ || !has_numbers_, has_numbers_)));
  }

 private:
  const AnalyzeWords& words_;
  document::Presenter& shown_;
  Section table_{.shape = Section::Shape::kTable};
  int status_ = 0;
  bool has_numbers_ = false;
  bool excludes_calibration_ = false;  // of a trial with numbers
};

// the files of a shard, each answered by earlier results or now, on a thread of its own; `take` is
// called in the order of the files
Result<void> AnalyzeEach(const AnalyzeWords& words, const Job& job, TrialResults& results,
                         const std::function<void(ShownTrial)>& take) {
  const auto count = static_cast<std::size_t>(results.shard().RowsOf(words.files.size()));
  const auto path_of = [&](std::size_t i) -> const std::string& {
    return words.files[static_cast<std::size_t>(results.shard().PointOf(i))];
  };
  // inputs are noted in the order of the files, independent of the threads
  for (std::size_t i = 0; i < count; ++i) NoteInput(path_of(i));
  Job single = job;
  single.threads = 1;
  const bool is_alone = words.files.size() == 1;
  const std::string further = fmt::format("alone = {}\nexpected = {}\n", is_alone, words.expect);
  const auto make_worker = [&]() -> OrderedWorker {
    return [&](std::size_t i) -> Result<Finish> {
      if (cli::Interrupted()) return Finish{};
      const auto analyze = [&] { return Shown(Analyze(path_of(i), single), is_alone); };
      if (!results.IsUsed()) {
        return [&take, shown = std::make_shared<ShownTrial>(analyze())] { take(*shown); };
      }
      HAPTOMETER_LET(auto kept, KeptOr(path_of(i), further, results, analyze));
      return [&take, shown = std::make_shared<ShownTrial>(std::move(kept))] { take(*shown); };
    };
  };
  HAPTOMETER_TRY(RunJobsInOrder(count, job.threads, make_worker));
  cli::LeaveIfInterrupted();
  return results.Finish();
}

// one trial on all threads, or several trials with a thread each
int AnalyzeTrials(const AnalyzeWords& words, const Job& job, TrialResults& results,
                  document::Presenter& shown) {
  Answers answers(words, shown);
  if (words.files.size() == 1 && !results.IsUsed()) {
    // where only one thread has work, another computes the checksum that the provenance states
    std::optional<document::HashAhead> hash;
    if (job.threads > 1) hash.emplace(words.files.front());
    answers.Take(Shown(Analyze(words.files.front(), job), true));
    return answers.Finish(job);
  }
  const auto all =
      AnalyzeEach(words, job, results, [&](ShownTrial trial) { answers.Take(std::move(trial)); });
  if (!all) return cli::ReportError(kVerb, all.error());
  RemarkOnCache(kVerb, results, words.files.size());
  for (const Error& error : results.ChangeErrors()) answers.Fail(error);
  return answers.Finish(job);
}

// the trials of one shard; they are shown by --merge
Result<int> AnalyzeShard(const AnalyzeWords& words, const Job& job, TrialResults& results, int argc,
                         const char* const* argv) {
  int status = 0;
  HAPTOMETER_TRY(AnalyzeEach(words, job, results, [&](const ShownTrial& trial) {
    if (trial.error) status = cli::WorseStatus(status, cli::ReportError(kVerb, *trial.error));
  }));
  return cli::WorseStatus(
      status, document::Present(ShardDocument(kVerb, words.results, results, words.files.size()),
                                job.outputs, argc, argv));
}

Result<int> BeginCampaignOf(const AnalyzeWords& words, const Job& job, const std::string& source,
                            int argc, const char* const* argv) {
  Job single = job;
  single.threads = 1;
  HAPTOMETER_LET(
      auto planned,
      BeginTrialCampaign(words.results.slurm, source, {argv, static_cast<std::size_t>(argc)},
                         {"--table"}, words.threads, words.files.size(),
                         [&](std::uint64_t place) { (void)Analyze(words.files[place], single); }));
  return document::Present(std::move(planned), job.outputs, argc, argv);
}

// folders are answered by earlier results too; pictures and spectra need the samples themselves
Result<TrialResults> ResultsOf(const AnalyzeWords& words, const Job& job, bool has_folder) {
  const bool needs_samples = words.sweep || job.outputs.HasFigures() ||
                             !words.spectrum.spectrum.empty() ||
                             !words.spectrum.spectrogram.empty();
  if (needs_samples && !words.results.merge.empty()) {
    return Usage("--merge", "has no samples to draw or to transform",
                 "analyse the trials themselves with --plot, --report, --spectrum or --sweep");
  }
  ResultsWords wanted = words.results;
  wanted.overwrite = words.spectrum.overwrite;
  return TrialResults::Open(wanted, TrialQuestionText(kVerb, job.question, job.import),
                            has_folder && !needs_samples);
}

}  // namespace

int RunAnalyze(int argc, const char* const* argv) {
  cli::Options options(kText);
  AnalyzeWords words;
  DeclareAnalyze(&options, &words);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const bool has_folder = std::ranges::any_of(words.files, [](const std::string& word) {
    std::error_code ignored;
    return std::filesystem::is_directory(word, ignored);
  });
  const std::string source = words.files.front();
  auto files = FilesOf(words.files);
  if (!files) return cli::ReportError(kVerb, files.error());
  words.files = *std::move(files);
  auto job = JobOf(words);
  if (!job) return cli::ReportError(kVerb, job.error());
  job->outputs.json = options.json();
  job->provenance = [&] { return document::ProvenanceOf(kVerb, argc, argv); };
  if (words.results.slurm.jobs) {
    const auto status = BeginCampaignOf(words, *job, source, argc, argv);
    return status ? *status : cli::ReportError(kVerb, status.error());
  }
  auto results = ResultsOf(words, *job, has_folder);
  if (!results) return cli::ReportError(kVerb, results.error());
  if (!words.results.shard.empty()) {
    const auto status = AnalyzeShard(words, *job, *results, argc, argv);
    return status ? *status : cli::ReportError(kVerb, status.error());
  }
  document::Presenter shown(AnalysisDocument(words.files.front(), words.files.size()), job->outputs,
                            argc, argv);
  return words.sweep ? AnalyzeSweeps(words, *job, shown)
                     : AnalyzeTrials(words, *job, *results, shown);
}

Result<AnalyzedFile> AnalyzeByDefault(const std::string& path) {
  HAPTOMETER_LET(const auto job, JobOf(AnalyzeWords{}));
  return Analyze(path, job);
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
