#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/spectrum/welch.h"
#include "tools/analyze/analyze.h"
#include "tools/cli/output_file.h"
#include "tools/document/keys.h"

namespace haptometer::tools {
namespace {

// resolution of Welch's segments without --resolution, Hz
constexpr double kDefaultResolutionHz = 1;
constexpr std::size_t kSegmentsOfShort = 8;  // half overlapping, in a window too short for 1 Hz
constexpr double kUm = 1e-6;                 // in metres
constexpr std::string_view kDensity = "density_m2_per_hz";

// length N of a segment: resolution = f_s / N
Result<dsp::WelchOptions> OptionsOf(const dsp::WindowSamples& window,
                                    const SpectrumQuestion& question) {
  const std::size_t size = window.values_m.size();
  std::size_t segment = 0;
  if (question.resolution_hz) {
    segment = static_cast<std::size_t>(std::round(window.rate_hz / *question.resolution_hz));
  } else {
    const auto at_1_hz =
        static_cast<std::size_t>(std::round(window.rate_hz / kDefaultResolutionHz));
    // k segments that overlap by half need (k + 1) N / 2 samples: N = 2 size / (k + 1)
    segment = std::min(at_1_hz, 2 * size / (kSegmentsOfShort + 1));
  }
  // a segment longer than the window is refused, with the least possible resolution f_s / size
  if (segment < 2 || segment > size) {
    const double least_hz = window.rate_hz / static_cast<double>(size);
    return CannotAnswer(
        "--resolution",
        fmt::format("the window of {} samples does not hold a segment of {}", size, segment),
        fmt::format("ask for {:.3g} Hz or more, or a longer --window", least_hz));
  }
  return dsp::WelchOptions{window.rate_hz, segment, question.window, question.overlap,
                           dsp::Detrend::kMean};
}

// what a reader needs to use the table: noise bandwidth, degrees of freedom, 95 % interval factors
std::string HeadOf(const dsp::SpectrumGrid& grid, const SpectrumQuestion& question) {
  return fmt::format(
      "# window = {}\n# overlap = {:g}\n# segments = {}\n# resolution_hz = {:.12g}\n"
      "# noise_bandwidth_hz = {:.12g}\n# degrees_of_freedom = {:.6g}\n"
      "# interval_95_percent = times {:.6g} to {:.6g} (power)\n",
      NameOf(question.window), question.overlap, grid.segments, grid.resolution_hz,
      grid.noise_bandwidth_hz, grid.degrees_of_freedom, grid.lower_factor, grid.upper_factor);
}

std::string SpectrumCsv(const dsp::PowerSpectrum& spectrum, const SpectrumQuestion& question) {
  std::string text = HeadOf(spectrum.grid, question);
  // amplitude in m (peak of a tone) or one-sided density in m^2/Hz
  const std::vector<double> values =
      question.amplitude ? dsp::AmplitudeSpectrum(spectrum) : spectrum.density;
  text += fmt::format("{},{}\n", document::kFrequency.name,
                      question.amplitude ? document::kAmplitude.name : kDensity);
  for (std::size_t k = 0; k < values.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g}\n",
                   static_cast<double>(k) * spectrum.grid.resolution_hz, values[k]);
  }
  return text;
}

std::string SpectrogramCsv(const dsp::Spectrogram& spectrogram, const SpectrumQuestion& question,
                           double start_s) {
  std::string text =
      fmt::format("# window = {}\n# overlap = {:g}\n# noise_bandwidth_hz = {:.12g}\n",
                  NameOf(question.window), question.overlap, spectrogram.noise_bandwidth_hz);
  text += fmt::format("{},{},{}\n", document::kTime.name, document::kFrequency.name, kDensity);
  for (std::size_t n = 0; n < spectrogram.density.size(); ++n) {
    // time of a column counts from the record's start, not from that of the window
    const double time_s =
        start_s + spectrogram.start_s + static_cast<double>(n) * spectrogram.step_s;
    for (std::size_t k = 0; k < spectrogram.density[n].size(); ++k) {
      fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g},{:.9g}\n", time_s,
                     static_cast<double>(k) * spectrogram.resolution_hz, spectrogram.density[n][k]);
    }
  }
  return text;
}

// levels in dB re 1 um^2/Hz over time and frequency
plot::Map SpectrogramMap(const dsp::Spectrogram& spectrogram, double start_s) {
  plot::Map map{"spectrogram",
                "time / s",
                "frequency / Hz",
                "dB re 1 um^2/Hz",
                start_s + spectrogram.start_s,
                spectrogram.step_s,
                0,
                spectrogram.resolution_hz,
                spectrogram.density};
  for (std::vector<double>& column : map.values) {
    // 1e-30 (-300 dB) replaces 0, whose logarithm is not finite
    for (double& value : column) value = 10 * std::log10(std::max(value / (kUm * kUm), 1e-30));
  }
  return map;
}

bool IsCsv(const std::string& path) { return std::filesystem::path(path).extension() == ".csv"; }

plot::Panel PanelOf(const dsp::PowerSpectrum& spectrum, const SpectrumQuestion& question) {
  plot::Panel panel{
      fmt::format(
          "spectrum of the unfiltered window: {} window, {:.3g} Hz noise bandwidth, {} segments",
          NameOf(question.window), spectrum.grid.noise_bandwidth_hz, spectrum.grid.segments),
      "frequency / Hz",
      question.amplitude ? "amplitude / um" : "density / (um^2/Hz)",
      {{"", plot::Lines(plot::kBlue)}},
      plot::LogAxes::kBoth};
  std::vector<double> values =
      question.amplitude ? dsp::AmplitudeSpectrum(spectrum) : spectrum.density;
  // um for an amplitude, um^2/Hz for a density
  const double unit = question.amplitude ? kUm : kUm * kUm;
  plot::Series& series = panel.series.front();
  // from k = 1: 0 Hz has no place on a logarithmic axis
  for (std::size_t k = 1; k < values.size(); ++k) {
    series.x.push_back(static_cast<double>(k) * spectrum.grid.resolution_hz);
    series.y.push_back(values[k] / unit);
  }
  return panel;
}

// discs on the curve at some frequencies
plot::Series TonesOn(const plot::Series& curve, std::string title, plot::Colour colour,
                     const std::vector<double>& frequencies_hz) {
  plot::Series tones{std::move(title), plot::Points(colour, 1)};
  for (const double frequency_hz : frequencies_hz) {
    // the highest of the bins about it
    const auto after = std::ranges::lower_bound(curve.x, frequency_hz) - curve.x.begin();
    const auto first = std::max<std::ptrdiff_t>(0, after - 2);
    const auto last = std::min<std::ptrdiff_t>(std::ssize(curve.x), after + 2);
    if (first >= last) continue;
    const auto top = std::max_element(curve.y.begin() + first, curve.y.begin() + last);
    tones.x.push_back(curve.x[static_cast<std::size_t>(top - curve.y.begin())]);
    tones.y.push_back(*top);
  }
  return tones;
}

// corners of the band, tones and the level of the noise
void MarkSpectrum(const dsp::BandAnalysis& analysis, const SpectrumQuestion& question,
                  plot::Panel& panel) {
  const plot::Series curve = panel.series.front();
  if (!analysis.numbers || curve.x.empty()) return;
  const dsp::BandNumbers& numbers = *analysis.numbers;
  // a vertical line at each corner, a NaN between
  const auto [least, most] = std::ranges::minmax_element(curve.y);
  const double lower_hz = analysis.band.lower_hz;
  const double upper_hz = analysis.band.upper_hz;
  const double bottom = std::max(*least, *most * 1e-12);
  panel.series.push_back({"corners of the band",
                          plot::Lines(plot::kBlack, 1, 2),
                          {lower_hz, lower_hz, lower_hz, upper_hz, upper_hz},
                          {bottom, *most, std::nan(""), bottom, *most}});
  // noise in the band, as a density
  if (numbers.floor && !question.amplitude) {
    const double density = numbers.floor->power.mean_square / (upper_hz - lower_hz) / (kUm * kUm);
    panel.series.push_back(
        {"noise", plot::Lines(plot::kGreen, 2, 2), {lower_hz, upper_hz}, {density, density}});
  }
  std::vector<double> harmonics_hz;
  if (numbers.harmonics) {
    for (const dsp::Harmonic& one : numbers.harmonics->harmonics) {
      if (one.order > 1 && one.stands_out) harmonics_hz.push_back(one.frequency_hz);
    }
  }
  std::vector<double> drive_hz;
  if (numbers.tone) drive_hz.push_back(numbers.tone->fit.frequency_hz);
  const auto of_hum = numbers.hum | std::views::transform(&dsp::SteadyLine::frequency_hz);
  const std::vector<double> hum_hz(of_hum.begin(), of_hum.end());
  for (plot::Series& tones :
       std::array{TonesOn(curve, "strongest tone", plot::kOrange, drive_hz),
                  TonesOn(curve, "its harmonics", plot::kYellow, harmonics_hz),
                  TonesOn(curve, "hum (subtracted)", plot::kPurple, hum_hz)}) {
    if (!tones.x.empty()) panel.series.push_back(std::move(tones));
  }
}

Result<void> WriteSpectrum(const dsp::WindowSamples& window, const SpectrumQuestion& question,
                           const std::string& comment) {
  // Welch's average over the window, which is not filtered
  HAPTOMETER_LET(const auto options, OptionsOf(window, question));
  HAPTOMETER_LET(const auto spectrum, dsp::WelchSpectrum(window.values_m, options));
  if (!IsCsv(question.spectrum)) {
    return plot::DrawPanels(question.spectrum, {PanelOf(spectrum, question)});
  }
  return cli::WriteOutput(question.spectrum, cli::kSpectrumOutput, question.overwrite,
                          comment + SpectrumCsv(spectrum, question));
}

// the same segments as those of the spectrum, not averaged: one column for each
Result<void> WriteSpectrogram(const dsp::WindowSamples& window, const SpectrumQuestion& question,
                              const std::string& comment) {
  HAPTOMETER_LET(const auto options, OptionsOf(window, question));
  HAPTOMETER_LET(const auto spectrogram, dsp::MakeSpectrogram(window.values_m, options));
  if (!IsCsv(question.spectrogram)) {
    return plot::DrawMap(question.spectrogram, SpectrogramMap(spectrogram, window.start_s));
  }
  return cli::WriteOutput(question.spectrogram, cli::kSpectrogramOutput, question.overwrite,
                          comment + SpectrogramCsv(spectrogram, question, window.start_s));
}

}  // namespace

Result<void> WriteSpectra(const dsp::WindowSamples& window, const SpectrumQuestion& question,
                          const std::string& comment) {
  if (!question.spectrum.empty()) {
    HAPTOMETER_TRY(WriteSpectrum(window, question, comment));
  }
  return question.spectrogram.empty() ? Result<void>{}
                                      : WriteSpectrogram(window, question, comment);
}

Result<plot::Panel> SpectrumPanel(const dsp::WindowSamples& window,
                                  const SpectrumQuestion& question,
                                  const dsp::BandAnalysis& analysis) {
  HAPTOMETER_LET(const auto options, OptionsOf(window, question));
  HAPTOMETER_LET(const auto spectrum, dsp::WelchSpectrum(window.values_m, options));
  plot::Panel panel = PanelOf(spectrum, question);
  MarkSpectrum(analysis, question, panel);
  return panel;
}

}  // namespace haptometer::tools
