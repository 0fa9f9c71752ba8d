#include "tools/analyze/analyze_question.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/mapped.h"
#include "tools/cli/output_file.h"
#include "tools/plot/gnuplot.h"
#include "trial/calibration.h"

namespace haptometer::tools {
namespace {

// "1s:3s": begin and end in s of the record, in this order
Result<dsp::TimeWindow> ParseWindow(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) {
    return Usage("--window", fmt::format("'{}' is not a window", text),
                 "give auto, all, or two times as 1s:3s");
  }
  HAPTOMETER_LET(const auto begin_s,
                 ParseQuantity(text.substr(0, colon), Dimension::kTime, "--window"));
  HAPTOMETER_LET(const auto end_s,
                 ParseQuantity(text.substr(colon + 1), Dimension::kTime, "--window"));
  if (!(end_s.value > begin_s.value)) {
    return Usage("--window", fmt::format("'{}' ends before it begins", text),
                 "give the earlier time first");
  }
  return dsp::TimeWindow{begin_s.value, end_s.value};
}

// outputs before any analysis: a wrong path must not cost a computed result
Result<void> CheckPictures(const AnalyzeWords& words) {
  HAPTOMETER_TRY(document::CheckOutputs(words.outputs));
  if (!words.outputs.plot.empty() && words.files.size() > 1) {
    return Usage("--plot", fmt::format("draws one trial, not {}", words.files.size()),
                 "give one file, or --report FILE.html for several");
  }
  // these options write one file each: a second trial would replace the first one's table
  const std::array<std::pair<std::string_view, const std::string*>, 3> tables{
      {{"--spectrum", &words.spectrum.spectrum},
       {"--spectrogram", &words.spectrum.spectrogram},
       {"--response", &words.response}}};
  for (const auto& [option, path] : tables) {
    if (path->empty() || words.files.size() < 2) continue;
    return Usage(std::string(option),
                 fmt::format("applies to one trial, not to {}", words.files.size()),
                 "give one file");
  }
  const bool has_report = !words.outputs.report.empty();
  // a sweep has neither a window with a steady drive nor a floor
  if (words.sweep && (has_report || words.window != "auto" || !words.floor.empty())) {
    return Usage("--sweep", "cannot be combined with --window, --floor and --report",
                 "analyse the trial as a whole with --plot and --response");
  }
  if (words.sweep && !(words.expect.empty() && words.table.empty())) {
    return Usage("--sweep", "cannot be combined with --expect and --table",
                 "give --response for its points");
  }
  if (!words.table.empty()) {
    HAPTOMETER_TRY(
        cli::CheckOutput(words.table, cli::kTrialsTableOutput, words.spectrum.overwrite));
  }
  if (!words.sweep && !words.response.empty()) {
    return Usage("--response", "applies to a sweep only", "give --sweep too");
  }
  // the response exists for a sweep only, so its place is checked last
  if (!words.response.empty()) {
    HAPTOMETER_TRY(
        cli::CheckOutput(words.response, cli::kSpectrumOutput, words.spectrum.overwrite));
  }
  // --resolution needs a spectrum or a sweep on which it has an effect
  const bool has_spectrum =
      !words.spectrum.spectrum.empty() || !words.spectrum.spectrogram.empty() || has_report;
  if (words.spectrum.resolution_hz && !words.sweep && !has_spectrum) {
    return Usage("--resolution", "applies to a spectrum or a sweep only",
                 "give --spectrum FILE, --spectrogram FILE, --report FILE or --sweep too");
  }
  return {};
}

// auto: the steady drive (default of the question); all: all rows free of transients; or times
Result<void> TakeWindow(const std::string& text, dsp::BandQuestion& question) {
  if (text == "auto") return {};
  if (text == "all") {
    question.choice = dsp::WindowChoice::kAll;
    return {};
  }
  const auto window = ParseWindow(text);
  if (!window) return std::unexpected(window.error());
  question.choice = dsp::WindowChoice::kGiven;
  question.window = *window;
  return {};
}

}  // namespace

void DeclareAnalyze(cli::Options* options, AnalyzeWords* words) {
  options->Positionals(
      "files", &words->files,
      "Trials (trial.bin), CSV with time_s,displacement_m, HDF5, NPY, MAT, WAV, LabVIEW "
      ".lvm, or folders of them");
  cli::DeclareBand(options, &words->band, cli::Shown::kHelp);
  options->Text("--window", &words->window, "auto|all|FROM:TO",
                "Part to use: the steady drive (auto), all that is free of filter transients "
                "(all), or an interval such as 1s:3s");
  options->Text("--floor", &words->floor, "FILE.bin|csv|h5|lvm",
                "Drive-off trial whose noise in the band is subtracted (mean square)");
  options->Choice("--hum", &words->hum, {"subtract", "keep"},
                  "Hum of the mains: subtracted, or counted as vibration", cli::Shown::kHelpAll);
  options->Text("--calibration-uncertainty", &words->calibration_uncertainty, "SHARE",
                "Relative standard uncertainty of the sensor's gain, linearity included, as 0.5%; "
                "it replaces what the file's calibration states",
                cli::Shown::kHelpAll);
  options->Text("--expect", &words->expect, "LIST",
                "What a trial should show, as 'tone=225Hz+-1Hz, change<5%, source=device'; a trial "
                "that differs is a doubt, with exit status 3",
                cli::Shown::kHelpAll);
  options->Output("--table", &words->table, "FILE.csv",
                  "Write a row per trial, with the kinds of its findings");
  options->Flag("--all", &words->outputs.all, "Print all numbers, with the uncertainty budget");
  options->Output("--plot", &words->outputs.plot, "FILE.svg|png|pdf",
                  "Draw the trial and the part that is used");
  options->Output("--report", &words->outputs.report, "FILE.html",
                  "Write one page with figures, numbers, assumptions and settings");
  options->Flag("--sweep", &words->sweep,
                "Analyse a drive of changing frequency: amplitude over frequency, f0 and Q",
                cli::Shown::kHelpAll);
  options->Output("--response", &words->response, "FILE.csv", "Write the points of a sweep",
                  cli::Shown::kHelpAll);
  options
      ->Number("--drive-frequency", &words->drive_frequency_hz, Dimension::kFrequency,
               cli::Above(0),
               "Frequency of the drive, which is fitted where a record is too slow for the band",
               cli::Shown::kHelpAll)
      .Default("what the file states");
  options
      ->Count("--threads", &words->threads, 1, kMostThreads,
              "Number of threads; no result depends on it", cli::Shown::kHelpAll)
      .Default("the number of cores");
  DeclareSpectrum(options, &words->spectrum);
  cli::DeclareImport(options, &words->import);
  DeclareResults(*options, words->results);
  options->Flag("--verify", &words->results.verify,
                "Compare every trial with its checksum; status 1 where one changed while its size "
                "and time stayed",
                cli::Shown::kHelpAll);
  options->Exclude("--shard",
                   {"--table", "--plot", "--report", "--spectrum", "--spectrogram", "--sweep"},
                   "a shard analyses its trials; they are shown by --merge");
  options->Exclude("--slurm",
                   {"--verify", "--plot", "--report", "--spectrum", "--spectrogram", "--sweep"},
                   "give it to a later run");
}

Result<dsp::BandQuestion> QuestionOf(const AnalyzeWords& words) {
  HAPTOMETER_TRY(CheckPictures(words));
  // an empty band means the default in other verbs
  if (words.band.band.empty()) return Usage("--band", "is empty", "write it as 20-500Hz");
  HAPTOMETER_LET(auto asked, cli::BandQuestionOf(words.band));
  dsp::BandQuestion question = std::move(asked);
  // the filtered record is kept in memory only where it is drawn
  question.keep_filtered = words.outputs.HasFigures();
  question.keep_hum = words.hum == "keep";
  if (!words.calibration_uncertainty.empty()) {
    HAPTOMETER_LET(const auto relative, trial::ParseGainUncertainty(words.calibration_uncertainty,
                                                                    "--calibration-uncertainty"));
    question.gain_uncertainty = relative;
  }
  question.drive_frequency_hz = words.drive_frequency_hz;
  HAPTOMETER_TRY(TakeWindow(words.window, question));
  return question;
}

namespace {

// names of --spectrum-window
constexpr std::array<std::pair<std::string_view, dsp::WindowShape>, 5> kWindows{
    {{"hann", dsp::WindowShape::kHann},
     {"rectangular", dsp::WindowShape::kRectangular},
     {"hamming", dsp::WindowShape::kHamming},
     {"blackman-harris", dsp::WindowShape::kBlackmanHarris},
     {"flat-top", dsp::WindowShape::kFlatTop}}};

// whether a CSV or, by any other ending, a picture can be written there
Result<void> CheckPlace(const std::string& path, const cli::OutputKind& table, bool overwrite) {
  if (path.empty()) return {};
  if (std::filesystem::path(path).extension() != ".csv") return plot::CheckPlotPath(path);
  return cli::CheckOutput(path, table, overwrite);
}

}  // namespace

std::string_view NameOf(dsp::WindowShape window) {
  const auto found = std::ranges::find(kWindows, window, &decltype(kWindows)::value_type::second);
  HAPTOMETER_CHECK(found != kWindows.end(), "window {}", static_cast<int>(window));
  return found->first;
}

void DeclareSpectrum(cli::Options* options, SpectrumWords* words) {
  options->Output("--spectrum", &words->spectrum, "FILE.csv|svg|png|pdf",
                  "Write Welch's spectrum of the unfiltered window, one-sided",
                  cli::Shown::kHelpAll);
  options->Output("--spectrogram", &words->spectrogram, "FILE.csv|svg|png|pdf",
                  "Write the spectrum over time", cli::Shown::kHelpAll);
  options
      ->Number("--resolution", &words->resolution_hz, Dimension::kFrequency, cli::Above(0),
               "Resolution of the spectra", cli::Shown::kHelpAll)
      .Default("1 Hz, or eight segments in a short window");
  options->Choice("--spectrum-window", &words->window,
                  Mapped<std::string>(kWindows, &decltype(kWindows)::value_type::first),
                  "Window function of each segment; the output states its noise bandwidth",
                  cli::Shown::kHelpAll);
  options
      ->Number("--overlap", &words->overlap, Dimension::kNone, cli::Within(0, 0.95),
               "Overlap of consecutive segments as a share of their length", cli::Shown::kHelpAll)
      .Default("0.5");
  options->Flag("--overwrite", &words->overwrite,
                "Replace older tables of --table, --spectrum, --spectrogram and --response",
                cli::Shown::kHelpAll);
  options->Choice(
      "--scaling", &words->scaling, {"density", "amplitude"},
      "Scaling of the spectra: density in m^2/Hz for noise, or amplitude of a tone in m",
      cli::Shown::kHelpAll);
}

Result<SpectrumQuestion> SpectrumQuestionOf(const SpectrumWords& words) {
  for (const auto& [path, table] : {std::pair(words.spectrum, cli::kSpectrumOutput),
                                    std::pair(words.spectrogram, cli::kSpectrogramOutput)}) {
    HAPTOMETER_TRY(CheckPlace(path, table, words.overwrite));
  }
  SpectrumQuestion question{words.spectrum, words.spectrogram, {}, {}, 0.5, false, words.overwrite};
  question.resolution_hz = words.resolution_hz;
  question.overlap = words.overlap.value_or(question.overlap);
  // Choice() has checked that the name exists
  question.window = std::ranges::find(kWindows, std::string_view(words.window),
                                      &decltype(kWindows)::value_type::first)
                        ->second;
  question.amplitude = words.scaling == "amplitude";
  return question;
}

}  // namespace haptometer::tools
