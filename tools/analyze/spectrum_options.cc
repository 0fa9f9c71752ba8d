#include "tools/analyze/spectrum_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "tools/cli/output_file.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

constexpr std::array<std::pair<std::string_view, dsp::WindowShape>, 5> kWindows{
    {{"hann", dsp::WindowShape::kHann},
     {"rectangular", dsp::WindowShape::kRectangular},
     {"hamming", dsp::WindowShape::kHamming},
     {"blackman-harris", dsp::WindowShape::kBlackmanHarris},
     {"flat-top", dsp::WindowShape::kFlatTop}}};

std::vector<std::string> WindowNames() {
  std::vector<std::string> names;
  names.reserve(kWindows.size());
  for (const auto& [name, shape] : kWindows) names.emplace_back(name);
  return names;
}

// a CSV or a picture can be written there
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
                  "Welch's spectrum of the unfiltered window, one-sided", cli::Shown::kHelpAll);
  options->Output("--spectrogram", &words->spectrogram, "FILE.csv|svg|png|pdf",
                  "The same over time", cli::Shown::kHelpAll);
  options->Number("--resolution", &words->resolution_hz, Dimension::kFrequency,
                  "Of the spectra (default: 1 Hz, or eight segments in a short window)",
                  cli::Shown::kHelpAll);
  options->Choice("--spectrum-window", &words->window, WindowNames(),
                  "Of each segment; the output states its noise bandwidth", cli::Shown::kHelpAll);
  options->Number("--overlap", &words->overlap, Dimension::kNone,
                  "Share of a segment that the next one repeats, 0 to 0.95 (default: 0.5)",
                  cli::Shown::kHelpAll);
  options->Flag("--overwrite", &words->overwrite,
                "Replace older tables of --spectrum, --spectrogram and --response",
                cli::Shown::kHelpAll);
  options->Choice("--scaling", &words->scaling, {"density", "amplitude"},
                  "m^2/Hz for noise, or m for the amplitude of a tone", cli::Shown::kHelpAll);
}

Result<SpectrumQuestion> SpectrumQuestionOf(const SpectrumWords& words) {
  for (const auto& [path, table] : {std::pair(words.spectrum, cli::kSpectrumOutput),
                                    std::pair(words.spectrogram, cli::kSpectrogramOutput)}) {
    auto writable = CheckPlace(path, table, words.overwrite);
    if (!writable) return std::unexpected(writable.error());
  }
  SpectrumQuestion question{words.spectrum, words.spectrogram, {}, {}, 0.5, false, words.overwrite};
  if (words.resolution_hz) {
    if (!(words.resolution_hz->value > 0)) {
      return Usage("--resolution", "must be above 0", "give it as 1Hz");
    }
    question.resolution_hz = words.resolution_hz->value;
  }
  if (words.overlap) question.overlap = words.overlap->value;
  if (!(question.overlap >= 0) || question.overlap > 0.95) {
    return Usage("--overlap", fmt::format("of {:g} is not possible", question.overlap),
                 "give a share from 0 to 0.95");
  }
  question.window = std::ranges::find(kWindows, std::string_view(words.window),
                                      &decltype(kWindows)::value_type::first)
                        ->second;
  question.amplitude = words.scaling == "amplitude";
  return question;
}

}  // namespace haptometer::tools
