#include "tools/analyze/analyze_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUm = 1e-6;  // in metres

// "  label           text"
void Line(std::string_view label, std::string_view text) {
  fmt::print("  {:<16}{}\n", label, text);
}

std::string_view CornerName(dsp::Corners corners) {
  return corners == dsp::Corners::kWhole ? "whole" : "each";
}

void PrintKnown(const dsp::BandAnalysis& a) {
  Line("readings", fmt::format("{} in {:.3f} s, {:.6g} a second", a.rows, a.duration_s, a.rate_hz));
  Line("offset", fmt::format("{:.5g} um", a.offset_m / kUm));
  Line("peak to peak", fmt::format("{:.5g} um, unfiltered", a.peak_to_peak_m / kUm));
}

void PrintBand(const dsp::BandAnalysis& a) {
  Line("band",
       fmt::format("{:g}-{:g} Hz, Butterworth of order {}, forward and backward, -3 dB of {}",
                   a.band.lower_hz, a.band.upper_hz, a.band.order,
                   a.band.corners == dsp::Corners::kWhole ? "both together" : "each"));
  Line("window", fmt::format("{:.4f} s to {:.4f} s", a.window->begin_s, a.window->end_s));
  Line("RMS in band",
       fmt::format("{:.5g} um over the window; standard uncertainty {:.2g} um (noise "
                   "only, flat over the band)",
                   *a.band_rms_m / kUm, *a.band_rms_uncertainty_m / kUm));
  Line("", fmt::format("{:.5g} um over the whole record, unsettled ends included",
                       *a.band_rms_whole_m / kUm));
  Line("", fmt::format("{:.5g} um peak to peak over the window", *a.band_peak_to_peak_m / kUm));
  if (!a.tone) {
    Line("strongest tone", "none stands out of the noise");
    return;
  }
  Line("strongest tone",
       fmt::format("{:.7g} Hz, standard uncertainty {:.2g} Hz (noise and arrival times)",
                   a.tone->frequency_hz, a.tone->frequency_uncertainty_hz));
  Line("", fmt::format("{:.5g} um amplitude, standard uncertainty {:.2g} um",
                       a.tone->amplitude / kUm, a.tone->amplitude_uncertainty / kUm));
  Line("", fmt::format("{:.3g} um RMS in band without it", *a.residual_rms_m / kUm));
}

Json BelowBandJson(const std::optional<dsp::BelowBand>& below) {
  if (!below) return nullptr;
  return {{"frequency_hz", below->frequency_hz},
          {"amplitude_m", below->amplitude_m},
          {"leaked_rms_m", below->leaked_rms_m}};
}

// the keys of every trial, all null
Json EmptyTrial(const AnalyzedFile& file) {
  Json trial{{"file", file.path},
             {"answered", false},
             {"reasons", Json::array()},
             {"remarks", file.remarks}};
  trial["source"] = cli::TextOrNull(file.source);
  for (const char* key : {"readings",
                          "measured",
                          "bridged",
                          "segments",
                          "sample_rate_hz",
                          "new_readings_per_s",
                          "duration_s",
                          "observable_upper_hz",
                          "offset_m",
                          "peak_to_peak_m",
                          "band",
                          "window_s",
                          "band_rms_m",
                          "band_rms_standard_uncertainty_m",
                          "band_rms_whole_m",
                          "band_peak_to_peak_m",
                          "residual_rms_m",
                          "noise_rms_m",
                          "bridged_rms_m",
                          "below_band",
                          "sensor_gain_at_tone",
                          "tone_frequency_hz",
                          "tone_frequency_standard_uncertainty_hz",
                          "tone_amplitude_m",
                          "tone_amplitude_standard_uncertainty_m"}) {
    trial[key] = nullptr;
  }
  return trial;
}

void FillKnown(const dsp::BandAnalysis& a, Json& trial) {
  trial["answered"] = a.answered;
  trial["reasons"] = a.reasons;
  for (const std::string& remark : a.remarks) trial["remarks"].push_back(remark);
  trial["readings"] = a.rows;
  trial["measured"] = a.measured;
  trial["bridged"] = a.bridged;
  trial["segments"] = a.segments;
  trial["sample_rate_hz"] = a.rate_hz;
  trial["new_readings_per_s"] = a.fresh_rate_hz;
  trial["duration_s"] = a.duration_s;
  trial["observable_upper_hz"] = a.observable_upper_hz;
  trial["offset_m"] = a.offset_m;
  trial["peak_to_peak_m"] = a.peak_to_peak_m;
}

// noise_rms_m stays null: only a stretch without drive would tell it
void FillBand(const dsp::BandAnalysis& a, Json& trial) {
  trial["band"] = {{"lower_hz", a.band.lower_hz},
                   {"upper_hz", a.band.upper_hz},
                   {"order", a.band.order},
                   {"corner", CornerName(a.band.corners)}};
  if (a.window) trial["window_s"] = {a.window->begin_s, a.window->end_s};
  trial["band_rms_m"] = cli::NumberOrNull(a.band_rms_m);
  trial["band_rms_standard_uncertainty_m"] = cli::NumberOrNull(a.band_rms_uncertainty_m);
  trial["band_rms_whole_m"] = cli::NumberOrNull(a.band_rms_whole_m);
  trial["band_peak_to_peak_m"] = cli::NumberOrNull(a.band_peak_to_peak_m);
  trial["residual_rms_m"] = cli::NumberOrNull(a.residual_rms_m);
  trial["bridged_rms_m"] = cli::NumberOrNull(a.bridged_rms_m);
  trial["below_band"] = BelowBandJson(a.below_band);
  trial["sensor_gain_at_tone"] = cli::NumberOrNull(a.sensor_gain_at_tone);
  if (!a.tone) return;
  trial["tone_frequency_hz"] = a.tone->frequency_hz;
  trial["tone_frequency_standard_uncertainty_hz"] = a.tone->frequency_uncertainty_hz;
  trial["tone_amplitude_m"] = a.tone->amplitude;
  trial["tone_amplitude_standard_uncertainty_m"] = a.tone->amplitude_uncertainty;
}

// `values` in um about `offset_m` where `keep` says so, NaN elsewhere
template <typename Keep>
std::vector<double> Where(const std::vector<double>& values, double offset_m, const Keep& keep) {
  std::vector<double> shown(values.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (keep(row)) shown[row] = (values[row] - offset_m) / kUm;
  }
  return shown;
}

std::string Lines(std::string_view colour) { return fmt::format("lines lc rgb '{}'", colour); }

// the middle of the window, ten periods of the tone (or all of the window) long
plot::Panel CloseUp(const std::vector<double>& times_s, const std::vector<double>& filtered_um,
                    const dsp::BandAnalysis& a) {
  std::size_t rows = a.window_rows;
  if (a.tone) {
    const double ten_periods = std::ceil(10 * a.rate_hz / a.tone->frequency_hz);
    rows = std::min(rows, static_cast<std::size_t>(ten_periods));
  }
  const auto first = static_cast<std::ptrdiff_t>(a.window_first_row + (a.window_rows - rows) / 2);
  const auto last = first + static_cast<std::ptrdiff_t>(rows);
  return {"a part of the window",
          "time / s",
          "in band / um",
          {{"",
            Lines(plot::kBlue),
            {times_s.begin() + first, times_s.begin() + last},
            {filtered_um.begin() + first, filtered_um.begin() + last}}}};
}

}  // namespace

void PrintAnalysis(const AnalyzedFile& file) {
  if (!file.analysis) return;
  fmt::print("{}\n", file.path);
  if (!file.source.empty()) Line("source", file.source);
  const dsp::BandAnalysis& analysis = *file.analysis;
  PrintKnown(analysis);
  if (analysis.answered) {
    PrintBand(analysis);
  } else {
    Line("observable", fmt::format("up to {:.4g} Hz", analysis.observable_upper_hz));
  }
  for (const std::string& remark : file.remarks) Line("remark", remark);
  for (const std::string& remark : analysis.remarks) Line("remark", remark);
  for (const std::string& reason : analysis.reasons) Line("not answered", reason);
}

std::string AnalysisJson(const std::vector<AnalyzedFile>& files) {
  Json trials = Json::array();
  for (const AnalyzedFile& file : files) {
    Json trial = EmptyTrial(file);
    if (file.error) trial["reasons"].push_back(file.error->Text());
    if (file.analysis) {
      FillKnown(*file.analysis, trial);
      FillBand(*file.analysis, trial);
    }
    trials.push_back(std::move(trial));
  }
  // a path need not be UTF-8
  return cli::JsonText({{"trials", std::move(trials)}});
}

std::vector<plot::Panel> AnalysisPanels(const trial::Record& record,
                                        const dsp::BandAnalysis& analysis) {
  const trial::Channel& channel = *record.Find(trial::ChannelRole::kDisplacement);
  std::vector<double> times_s(record.rows);
  for (std::size_t row = 0; row < record.rows; ++row) times_s[row] = TimeOf(record, row);
  const auto in_window = [&](std::size_t row) {
    return row >= analysis.window_first_row &&
           row < analysis.window_first_row + analysis.window_rows;
  };
  const auto measured = [&](std::size_t row) { return IsMeasurement(channel.statuses[row]); };
  const auto used = [&](std::size_t row) { return measured(row) && in_window(row); };
  const auto unused = [&](std::size_t row) { return measured(row) && !in_window(row); };

  std::vector<plot::Panel> panels;
  panels.push_back(
      {fmt::format("distance, about {:.5g} um", analysis.offset_m / kUm),
       "time / s",
       "distance / um",
       {{"left out", Lines(plot::kGrey), times_s, Where(channel.values, analysis.offset_m, unused)},
        {"window", Lines(plot::kBlue), times_s, Where(channel.values, analysis.offset_m, used)}}});
  if (!analysis.answered) return panels;

  const std::vector<double> inside = Where(analysis.filtered_m, 0, in_window);
  const auto outside = [&](std::size_t row) { return !in_window(row); };
  panels.push_back(
      {fmt::format("{:g}-{:g} Hz: {:.5g} um RMS over the window", analysis.band.lower_hz,
                   analysis.band.upper_hz, *analysis.band_rms_m / kUm),
       "time / s",
       "in band / um",
       {{"not settled", Lines(plot::kGrey), times_s, Where(analysis.filtered_m, 0, outside)},
        {"window", Lines(plot::kBlue), times_s, inside}}});
  panels.push_back(CloseUp(times_s, inside, analysis));
  return panels;
}

}  // namespace haptometer::tools
