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
  Line("readings", fmt::format("{} in {:.3f} s, {:.6g} a second", a.record.rows,
                               a.record.duration_s, a.record.rate_hz));
  Line("offset", fmt::format("{:.5g} um", a.record.offset_m / kUm));
  Line("peak to peak", fmt::format("{:.5g} um, unfiltered", a.record.peak_to_peak_m / kUm));
}

void PrintBand(const dsp::BandAnalysis& a) {
  Line("band",
       fmt::format("{:g}-{:g} Hz, Butterworth of order {}, forward and backward, -3 dB of {}",
                   a.band.lower_hz, a.band.upper_hz, a.band.order,
                   a.band.corners == dsp::Corners::kWhole ? "both together" : "each"));
  Line("window", fmt::format("{:.4f} s to {:.4f} s", a.numbers->part.window.begin_s,
                             a.numbers->part.window.end_s));
  Line(a.answered ? "RMS in band" : "estimate only",
       fmt::format("{:.5g} um over the window; standard uncertainty {:.2g} um, 95 % interval "
                   "{:.5g} to {:.5g} um",
                   a.numbers->rms.rms_m / kUm, a.numbers->rms.standard_uncertainty_m / kUm,
                   a.numbers->rms.lower_m / kUm, a.numbers->rms.upper_m / kUm));
  if (a.numbers->floor) {
    Line("", fmt::format("{:.5g} um as measured; the floor of {:.3g} um is taken off in power",
                         a.numbers->rms.as_measured_m / kUm, *a.numbers->rms.floor_m / kUm));
  }
  Line("", fmt::format("{:.5g} um over the whole record, unsettled ends included",
                       a.numbers->whole_rms_m / kUm));
  Line("", fmt::format("{:.5g} um peak to peak over the window", a.numbers->peak_to_peak_m / kUm));
  if (!a.numbers->tone) {
    Line("strongest tone", "none stands out of the noise");
    return;
  }
  Line("strongest tone",
       fmt::format("{:.7g} Hz, standard uncertainty {:.2g} Hz (noise and arrival times)",
                   a.numbers->tone->fit.frequency_hz,
                   a.numbers->tone->fit.frequency_uncertainty_hz));
  Line("", fmt::format("{:.5g} um amplitude, standard uncertainty {:.2g} um",
                       a.numbers->tone->amplitude_m / kUm,
                       a.numbers->tone->amplitude_uncertainty_m / kUm));
  Line("", fmt::format("{:.3g} um RMS in band without it", a.numbers->residual_rms_m / kUm));
}

Json BelowBandJson(const std::optional<dsp::BelowBand>& below) {
  if (!below) return nullptr;
  return {{"frequency_hz", below->frequency_hz},
          {"amplitude_m", below->amplitude_m},
          {"leaked_rms_m", below->leaked_rms_m}};
}

Json BudgetJson(const dsp::RmsEstimate& rms) {
  Json budget = Json::array();
  for (const dsp::UncertaintyLine& line : rms.budget) {
    budget.push_back({{"name", line.name},
                      {"type", line.evaluation == dsp::Evaluation::kStatistical ? "A" : "B"},
                      {"standard_uncertainty_m", line.standard_uncertainty_m},
                      {"how", line.how}});
  }
  return budget;
}

Json FaultsJson(const dsp::Faults& faults) {
  Json counts;
  for (std::size_t k = 0; k < dsp::kFaultKindCount; ++k) {
    counts[std::string(Name(static_cast<dsp::FaultKind>(k)))] = {{"count", faults.count[k]},
                                                                 {"readings", faults.rows[k]}};
  }
  return counts;
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
                          "window_because",
                          "band_rms_as_measured_m",
                          "band_rms_interval_95_m",
                          "band_rms_at_most_m",
                          "band_rms_estimate_m",
                          "tone_amplitude_estimate_m",
                          "uncertainty_budget",
                          "noise_from",
                          "sensor_averaging",
                          "sensor_gain_divided_out",
                          "amplitude_verified",
                          "faults",
                          "tone_frequency_interval_95_hz",
                          "tone_amplitude_interval_95_m",
                          "tone_share_of_rms",
                          "tone_velocity_m_per_s",
                          "tone_acceleration_m_per_s2",
                          "known_tone",
                          "thd",
                          "drift_m_per_s",
                          "tremor_rms_m",
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
  trial["readings"] = a.record.rows;
  trial["measured"] = a.record.measured;
  trial["bridged"] = a.record.bridged;
  trial["segments"] = a.record.segments;
  trial["sample_rate_hz"] = a.record.rate_hz;
  trial["new_readings_per_s"] = a.record.fresh_rate_hz;
  trial["duration_s"] = a.record.duration_s;
  trial["observable_upper_hz"] = a.record.observable_upper_hz;
  trial["offset_m"] = a.record.offset_m;
  trial["peak_to_peak_m"] = a.record.peak_to_peak_m;
  trial["faults"] = FaultsJson(a.faults);
  if (a.slow_motion) {
    trial["drift_m_per_s"] = a.slow_motion->drift_per_s;
    trial["tremor_rms_m"] = cli::NumberOrNull(a.slow_motion->tremor_rms);
  }
  if (a.known_tone) {
    trial["known_tone"] = {{"frequency_hz", a.known_tone->fit.frequency_hz},
                           {"amplitude_m", a.known_tone->fit.amplitude},
                           {"standard_uncertainty_m", a.known_tone->fit.amplitude_uncertainty},
                           {"aliased", a.known_tone->aliased}};
  }
}

void FillBand(const dsp::BandAnalysis& a, Json& trial) {
  trial["band"] = {{"lower_hz", a.band.lower_hz},
                   {"upper_hz", a.band.upper_hz},
                   {"order", a.band.order},
                   {"corner", CornerName(a.band.corners)}};
  if (!a.numbers) return;
  const dsp::BandNumbers& n = *a.numbers;
  trial["window_s"] = {n.part.window.begin_s, n.part.window.end_s};
  trial["window_because"] = n.part.why;
  // what is no answer stands under a name of its own
  trial[a.answered ? "band_rms_m" : "band_rms_estimate_m"] = n.rms.rms_m;
  trial["band_rms_as_measured_m"] = n.rms.as_measured_m;
  trial["band_rms_standard_uncertainty_m"] = n.rms.standard_uncertainty_m;
  trial["band_rms_interval_95_m"] = {n.rms.lower_m, n.rms.upper_m};
  if (n.rms.below_floor) trial["band_rms_at_most_m"] = n.rms.at_most_m;
  trial["uncertainty_budget"] = BudgetJson(n.rms);
  trial["band_rms_whole_m"] = n.whole_rms_m;
  trial["band_peak_to_peak_m"] = n.peak_to_peak_m;
  trial["residual_rms_m"] = n.residual_rms_m;
  trial["noise_rms_m"] = cli::NumberOrNull(n.rms.floor_m);
  if (n.floor) trial["noise_from"] = n.floor->source;
  trial["bridged_rms_m"] = n.bridged_rms_m;
  trial["below_band"] = BelowBandJson(n.below_band);
  trial["sensor_averaging"] = Describe(n.sensor.averaging);
  trial["sensor_gain_at_tone"] = cli::NumberOrNull(n.sensor.gain_at_tone);
  trial["sensor_gain_divided_out"] = n.sensor.divided_out;
  trial["amplitude_verified"] = n.sensor.amplitude_verified;
  if (!n.tone) return;
  trial["tone_frequency_hz"] = n.tone->fit.frequency_hz;
  trial["tone_frequency_standard_uncertainty_hz"] = n.tone->fit.frequency_uncertainty_hz;
  trial["tone_frequency_interval_95_hz"] = {n.tone->frequency_lower_hz, n.tone->frequency_upper_hz};
  trial[a.answered ? "tone_amplitude_m" : "tone_amplitude_estimate_m"] = n.tone->amplitude_m;
  trial["tone_amplitude_standard_uncertainty_m"] = n.tone->amplitude_uncertainty_m;
  trial["tone_amplitude_interval_95_m"] = {n.tone->amplitude_lower_m, n.tone->amplitude_upper_m};
  if (n.harmonics) trial["thd"] = cli::NumberOrNull(n.harmonics->thd);
  trial["tone_share_of_rms"] = n.tone->share_of_rms;
  trial["tone_velocity_m_per_s"] = n.tone->velocity_m_per_s;
  trial["tone_acceleration_m_per_s2"] = n.tone->acceleration_m_per_s2;
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
  std::size_t rows = a.numbers->part.rows;
  if (a.numbers->tone) {
    const double ten_periods = std::ceil(10 * a.record.rate_hz / a.numbers->tone->fit.frequency_hz);
    rows = std::min(rows, static_cast<std::size_t>(ten_periods));
  }
  const auto first =
      static_cast<std::ptrdiff_t>(a.numbers->part.first_row + (a.numbers->part.rows - rows) / 2);
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
  if (analysis.numbers) PrintBand(analysis);
  if (!analysis.answered) {
    Line("observable", fmt::format("up to {:.4g} Hz", analysis.record.observable_upper_hz));
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
    return analysis.numbers && row >= analysis.numbers->part.first_row &&
           row < analysis.numbers->part.first_row + analysis.numbers->part.rows;
  };
  const auto measured = [&](std::size_t row) { return IsMeasurement(channel.statuses[row]); };
  const auto used = [&](std::size_t row) { return measured(row) && in_window(row); };
  const auto unused = [&](std::size_t row) { return measured(row) && !in_window(row); };

  std::vector<plot::Panel> panels;
  panels.push_back({fmt::format("distance, about {:.5g} um", analysis.record.offset_m / kUm),
                    "time / s",
                    "distance / um",
                    {{"left out", Lines(plot::kGrey), times_s,
                      Where(channel.values, analysis.record.offset_m, unused)},
                     {"window", Lines(plot::kBlue), times_s,
                      Where(channel.values, analysis.record.offset_m, used)}}});
  if (!analysis.numbers) return panels;

  const std::vector<double> inside = Where(analysis.filtered_m, 0, in_window);
  const auto outside = [&](std::size_t row) { return !in_window(row); };
  panels.push_back(
      {fmt::format("{:g}-{:g} Hz: {:.5g} um RMS over the window", analysis.band.lower_hz,
                   analysis.band.upper_hz, analysis.numbers->rms.rms_m / kUm),
       "time / s",
       "in band / um",
       {{"not settled", Lines(plot::kGrey), times_s, Where(analysis.filtered_m, 0, outside)},
        {"window", Lines(plot::kBlue), times_s, inside}}});
  panels.push_back(CloseUp(times_s, inside, analysis));
  return panels;
}

}  // namespace haptometer::tools
