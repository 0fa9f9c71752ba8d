#include "tools/analyze/analysis_document.h"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string_view>

#include "base/clock.h"
#include "base/error.h"
#include "tools/cli/json.h"
#include "tools/cli/uncertain_number.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;
using cli::NumberOrNull;

Json Pair(double lower, double upper) {
  return Json::array({NumberOrNull(lower), NumberOrNull(upper)});
}

Json WindowJson(const dsp::TimeWindow& window) { return Pair(window.begin_s, window.end_s); }

Json BandJson(const dsp::BandPass& band) {
  return {{"lower_hz", band.lower_hz},
          {"upper_hz", band.upper_hz},
          {"order", band.order},
          {"corner", band.corners == dsp::Corners::kWhole ? "whole" : "each"}};
}

Json BelowBandJson(const std::optional<dsp::BelowBand>& below) {
  if (!below) return nullptr;
  return {{"frequency_hz", below->frequency_hz},
          {"amplitude_m", below->amplitude_m},
          {"leaked_rms_m", below->leaked_rms_m},
          {"modelled", below->modelled}};
}

Json FaultsJson(const dsp::Faults& faults) {
  Json json = Json::object();
  for (std::size_t k = 0; k < dsp::kFaultKindCount; ++k) {
    const auto kind = static_cast<dsp::FaultKind>(k);
    json[std::string(dsp::Name(kind))] = {{"count", faults.Count(kind)},
                                          {"readings", faults.Rows(kind)}};
  }
  json["list"] = Json::array();
  for (const dsp::Fault& fault : faults.list) {
    json["list"].push_back({{"kind", dsp::Name(fault.kind)},
                            {"first_row", fault.first_row},
                            {"rows", fault.rows},
                            {"size_m", NumberOrNull(fault.size)}});
  }
  return json;
}

Json DriveJson(const dsp::UsedPart& part) {
  Json on = Json::array();
  for (const dsp::OnPart& one : part.drive.on) {
    on.push_back({{"whole_s", WindowJson(one.whole)},
                  {"steady_s", WindowJson(one.steady)},
                  {"steady", one.is_steady}});
  }
  Json quiet = Json::array();
  for (const dsp::TimeWindow& window : part.drive.quiet) quiet.push_back(WindowJson(window));
  return {{"why", part.drive.why},
          {"on", std::move(on)},
          {"quiet_s", std::move(quiet)},
          {"window_is_a_part_of_the_drive", part.from_drive},
          {"told_by_a_drive_channel", part.from_channel}};
}

Json BudgetJson(const dsp::RmsEstimate& rms) {
  Json budget = Json::array();
  for (const dsp::UncertaintyLine& line : rms.budget) {
    budget.push_back({{"name", line.name},
                      {"type", line.evaluation == dsp::Evaluation::kStatistical ? "A" : "B"},
                      {"standard_uncertainty_m", NumberOrNull(line.standard_uncertainty_m)},
                      {"how", line.how}});
  }
  return budget;
}

Json HarmonicsJson(const std::optional<dsp::Harmonics>& harmonics) {
  if (!harmonics || !harmonics->converged) return nullptr;
  Json list = Json::array();
  for (const dsp::Harmonic& harmonic : harmonics->harmonics) {
    list.push_back(
        {{"order", harmonic.order},
         {"frequency_hz", harmonic.frequency_hz},
         {"amplitude_m", harmonic.amplitude},
         {"amplitude_standard_uncertainty_m", NumberOrNull(harmonic.amplitude_uncertainty)},
         {"phase_rad", NumberOrNull(harmonic.phase_rad)},
         {"stands_out", harmonic.stands_out}});
  }
  return {{"list", std::move(list)},
          {"thd", NumberOrNull(harmonics->thd)},
          {"thd_standard_uncertainty",
           harmonics->thd ? NumberOrNull(harmonics->thd_uncertainty) : Json(nullptr)},
          {"thd_at_most", NumberOrNull(harmonics->thd_at_most)}};
}

Json OnsetJson(const std::optional<dsp::OnsetNumbers>& onset) {
  if (!onset) return nullptr;
  const dsp::Edge& edge = onset->edge;
  return {{"time_s", edge.time_s},
          {"time_standard_uncertainty_s", NumberOrNull(edge.time_uncertainty_s)},
          {"level_of_steady", edge.low_level},
          {"rise_s", NumberOrNull(edge.rise_s)},
          {"rise_standard_uncertainty_s",
           edge.rise_s ? NumberOrNull(edge.rise_uncertainty_s) : Json(nullptr)},
          {"rise_at_most_s", NumberOrNull(edge.rise_at_most_s)},
          {"drive_s", NumberOrNull(onset->drive_s)},
          {"latency_s", NumberOrNull(onset->latency_s)},
          {"latency_standard_uncertainty_s",
           onset->latency_s ? NumberOrNull(onset->latency_uncertainty_s) : Json(nullptr)}};
}

Json KinematicsJson(const std::optional<dsp::Kinematics>& motion) {
  if (!motion) return nullptr;
  return {{"velocity_rms_m_per_s", NumberOrNull(motion->velocity_rms)},
          {"velocity_peak_m_per_s", NumberOrNull(motion->velocity_peak)},
          {"acceleration_rms_m_per_s2", NumberOrNull(motion->acceleration_rms)},
          {"acceleration_peak_m_per_s2", NumberOrNull(motion->acceleration_peak)},
          {"relative_error", NumberOrNull(motion->relative_error)}};
}

Json ElectricalJson(const std::optional<dsp::ElectricalState>& state) {
  if (!state) return nullptr;
  const auto estimate = [](const dsp::Estimate& of) {
    return Json{{"value", NumberOrNull(of.value)},
                {"standard_uncertainty", NumberOrNull(of.uncertainty)}};
  };
  return {{"voltage_rms_v", estimate(state->voltage_rms_v)},
          {"current_rms_a", estimate(state->current_rms_a)},
          {"real_power_w", estimate(state->real_power_w)},
          {"apparent_power_va", estimate(state->apparent_power_va)},
          {"phase_rad", estimate(state->phase_rad)},
          {"resistance_ohm", estimate(state->resistance_ohm)},
          {"reactance_ohm", estimate(state->reactance_ohm)}};
}

// every key that a trial may leave unknown
constexpr const char* kKeys[] = {
    // the record
    "readings", "measured", "bridged", "segments", "sample_rate_hz", "new_readings_per_s",
    "duration_s", "observable_upper_hz", "offset_m", "peak_to_peak_m", "faults", "drift_m_per_s",
    "tremor_rms_m", "tremor_frequency_hz",
    // the band
    "band", "window_s", "window_because", "drive", "band_rms_m", "band_rms_standard_uncertainty_m",
    "band_rms_interval_95_m", "band_rms_at_least_m", "band_rms_at_most_m", "band_rms_as_measured_m",
    "band_rms_estimate_m", "band_rms_whole_m", "band_peak_to_peak_m", "residual_rms_m",
    "noise_rms_m", "noise_from", "bridged_rms_m", "below_band", "uncertainty_budget",
    "sensor_averaging", "sensor_gain_at_tone", "sensor_gain_in_band", "sensor_gain_divided_out",
    "amplitude_verified",
    // the tone
    "tone_frequency_hz", "tone_frequency_standard_uncertainty_hz", "tone_frequency_interval_95_hz",
    "tone_amplitude_m", "tone_amplitude_standard_uncertainty_m", "tone_amplitude_interval_95_m",
    "tone_amplitude_at_least_m", "tone_amplitude_estimate_m", "tone_share_of_rms",
    "tone_velocity_m_per_s", "tone_acceleration_m_per_s2", "thd", "harmonics", "onset", "motion",
    "electrical", "known_tone", "frequency_moves_hz"};

// the keys of every trial, all null
Json EmptyTrial(const AnalyzedFile& file) {
  Json trial{{"file", file.path},
             {"answered", false},
             {"reasons", Json::array()},
             {"remarks", file.remarks}};
  trial["source"] = cli::TextOrNull(file.source);
  for (const char* key : kKeys) trial[key] = nullptr;
  return trial;
}

Json KnownToneJson(const dsp::KnownTone& known) {
  return {{"frequency_hz", known.fit.frequency_hz},
          {"amplitude_m", NumberOrNull(known.fit.amplitude)},
          {"standard_uncertainty_m", NumberOrNull(known.fit.amplitude_uncertainty)},
          {"aliased", known.aliased}};
}

void FillSlowMotion(const dsp::SlowMotion& slow, Json& trial) {
  trial["drift_m_per_s"] = NumberOrNull(slow.drift_per_s);
  trial["tremor_rms_m"] = NumberOrNull(slow.tremor_rms);
  if (slow.tremor_rms) trial["tremor_frequency_hz"] = NumberOrNull(slow.tremor_frequency_hz);
}

void FillRecord(const dsp::BandAnalysis& analysis, Json& trial) {
  trial["answered"] = analysis.answered;
  trial["reasons"] = analysis.reasons;
  for (const std::string& remark : analysis.remarks) trial["remarks"].push_back(remark);
  const dsp::RecordFacts& record = analysis.record;
  trial["readings"] = record.rows;
  trial["measured"] = record.measured;
  trial["bridged"] = record.bridged;
  trial["segments"] = record.segments;
  trial["sample_rate_hz"] = NumberOrNull(record.rate_hz);
  trial["new_readings_per_s"] = NumberOrNull(record.fresh_rate_hz);
  trial["duration_s"] = NumberOrNull(record.duration_s);
  trial["observable_upper_hz"] = NumberOrNull(record.observable_upper_hz);
  trial["offset_m"] = NumberOrNull(record.offset_m);
  trial["peak_to_peak_m"] = NumberOrNull(record.peak_to_peak_m);
  trial["faults"] = FaultsJson(analysis.faults);
  trial["band"] = BandJson(analysis.band);
  if (analysis.slow_motion) FillSlowMotion(*analysis.slow_motion, trial);
  if (const auto& move = analysis.frequency_move) {
    trial["frequency_moves_hz"] = Pair(move->from_hz, move->to_hz);
  }
  if (analysis.known_tone) trial["known_tone"] = KnownToneJson(*analysis.known_tone);
}

// what is no answer stands under a name of its own
void FillRms(const dsp::BandNumbers& numbers, bool answered, Json& trial) {
  const dsp::RmsEstimate& rms = numbers.rms;
  trial["band_rms_as_measured_m"] = NumberOrNull(rms.as_measured_m);
  trial["noise_rms_m"] = NumberOrNull(rms.floor_m);
  if (numbers.is_lower_limit) {
    trial["band_rms_at_least_m"] = NumberOrNull(rms.lower_m);
    return;
  }
  trial[answered ? "band_rms_m" : "band_rms_estimate_m"] = NumberOrNull(rms.rms_m);
  trial["band_rms_standard_uncertainty_m"] = NumberOrNull(rms.standard_uncertainty_m);
  trial["band_rms_interval_95_m"] = Pair(rms.lower_m, rms.upper_m);
  if (rms.below_floor) trial["band_rms_at_most_m"] = NumberOrNull(rms.at_most_m);
  trial["uncertainty_budget"] = BudgetJson(rms);
}

void FillSensor(const dsp::SensorNumbers& sensor, Json& trial) {
  trial["sensor_averaging"] = dsp::Describe(sensor.averaging);
  trial["sensor_gain_at_tone"] = NumberOrNull(sensor.gain_at_tone);
  if (sensor.gain_in_band) {
    trial["sensor_gain_in_band"] = Pair(sensor.gain_in_band->least, sensor.gain_in_band->greatest);
  }
  trial["sensor_gain_divided_out"] = sensor.divided_out;
  trial["amplitude_verified"] = sensor.amplitude_verified;
}

void FillTone(const dsp::BandNumbers& numbers, bool answered, Json& trial) {
  const dsp::ToneNumbers& tone = *numbers.tone;
  trial["tone_frequency_hz"] = NumberOrNull(tone.fit.frequency_hz);
  trial["tone_frequency_standard_uncertainty_hz"] = NumberOrNull(tone.fit.frequency_uncertainty_hz);
  trial["tone_frequency_interval_95_hz"] = Pair(tone.frequency_lower_hz, tone.frequency_upper_hz);
  if (numbers.is_lower_limit) {
    trial["tone_amplitude_at_least_m"] = NumberOrNull(tone.amplitude_lower_m);
    return;
  }
  trial[answered ? "tone_amplitude_m" : "tone_amplitude_estimate_m"] =
      NumberOrNull(tone.amplitude_m);
  trial["tone_amplitude_standard_uncertainty_m"] = NumberOrNull(tone.amplitude_uncertainty_m);
  trial["tone_amplitude_interval_95_m"] = Pair(tone.amplitude_lower_m, tone.amplitude_upper_m);
  trial["tone_share_of_rms"] = NumberOrNull(tone.share_of_rms);
  trial["tone_velocity_m_per_s"] = NumberOrNull(tone.velocity_m_per_s);
  trial["tone_acceleration_m_per_s2"] = NumberOrNull(tone.acceleration_m_per_s2);
}

void FillNumbers(const dsp::BandNumbers& numbers, bool answered, Json& trial) {
  trial["window_s"] = WindowJson(numbers.part.window);
  trial["window_because"] = numbers.part.why;
  trial["drive"] = DriveJson(numbers.part);
  FillRms(numbers, answered, trial);
  trial["band_rms_whole_m"] = NumberOrNull(numbers.whole_rms_m);
  trial["band_peak_to_peak_m"] = NumberOrNull(numbers.peak_to_peak_m);
  trial["residual_rms_m"] = NumberOrNull(numbers.residual_rms_m);
  if (numbers.floor) trial["noise_from"] = numbers.floor->source;
  trial["bridged_rms_m"] = NumberOrNull(numbers.bridged_rms_m);
  trial["below_band"] = BelowBandJson(numbers.below_band);
  FillSensor(numbers.sensor, trial);
  if (numbers.tone) FillTone(numbers, answered, trial);
  if (numbers.harmonics && !numbers.is_lower_limit) {
    trial["thd"] = NumberOrNull(numbers.harmonics->thd);
    trial["harmonics"] = HarmonicsJson(numbers.harmonics);
  }
  trial["onset"] = OnsetJson(numbers.onset);
  trial["motion"] = KinematicsJson(numbers.kinematics);
  trial["electrical"] = ElectricalJson(numbers.electrical);
}

Json TrialJson(const AnalyzedFile& file) {
  Json trial = EmptyTrial(file);
  if (file.error) trial["reasons"].push_back(file.error->Text());
  if (!file.analysis) return trial;
  FillRecord(*file.analysis, trial);
  if (file.analysis->numbers) {
    FillNumbers(*file.analysis->numbers, file.analysis->answered, trial);
  }
  return trial;
}

}  // namespace

std::string AnalysisJson(const std::vector<AnalyzedFile>& files) {
  Json trials = Json::array();
  for (const AnalyzedFile& file : files) trials.push_back(TrialJson(file));
  // a path need not be UTF-8
  return cli::JsonText(
      {{"uncertainty_excludes", dsp::kNotInBudget}, {"trials", std::move(trials)}});
}

namespace {

using cli::ToThePlaceOf;
using cli::WithUncertainty;
using Lines = std::vector<AnalysisLine>;

constexpr double kUm = 1e-6;  // in metres
constexpr double kMs = 1e-3;  // in seconds

std::string Um(double metres) { return fmt::format("{:.5g} um", metres / kUm); }

// a number that serves another, to three digits
std::string AboutUm(double metres) { return fmt::format("{:.3g} um", metres / kUm); }

std::string Um(double metres, double uncertainty_m) {
  return WithUncertainty(metres / kUm, uncertainty_m / kUm) + " um";
}

std::string Ms(double seconds, double uncertainty_s) {
  return WithUncertainty(seconds / kMs, uncertainty_s / kMs) + " ms";
}

std::string Seconds(const dsp::TimeWindow& window) {
  return fmt::format("{:.4f} s to {:.4f} s", window.begin_s, window.end_s);
}

std::string BandName(const dsp::BandPass& band) {
  return fmt::format("{:g}-{:g} Hz", band.lower_hz, band.upper_hz);
}

// both ends of an interval to the place of its middle
std::string FromTo(double lower, double upper, double uncertainty) {
  return fmt::format("{} to {}", ToThePlaceOf(uncertainty, lower),
                     ToThePlaceOf(uncertainty, upper));
}

// the RMS and its interval, or the limit where the floor is not exceeded
std::string RmsText(const dsp::BandNumbers& numbers, const dsp::BandPass& band) {
  const dsp::RmsEstimate& rms = numbers.rms;
  if (numbers.is_lower_limit) {
    return fmt::format("at least {} RMS in {}: clipped, so nothing is known above it",
                       Um(rms.lower_m), BandName(band));
  }
  if (rms.below_floor) {
    return fmt::format("at most {} RMS in {} (95 %): not above the noise floor of {}",
                       Um(rms.at_most_m), BandName(band), AboutUm(rms.floor_m.value_or(0)));
  }
  return fmt::format(
      "{} RMS in {}; 95 %: {} um", Um(rms.rms_m, rms.standard_uncertainty_m), BandName(band),
      FromTo(rms.lower_m / kUm, rms.upper_m / kUm, rms.standard_uncertainty_m / kUm));
}

// how the number came from what was measured; nothing where it is the same
std::optional<std::string> CorrectionText(const dsp::BandNumbers& numbers) {
  std::string text = fmt::format("{} as measured", Um(numbers.rms.as_measured_m));
  if (numbers.rms.floor_m) {
    text += fmt::format("; noise floor of {} taken off in power", AboutUm(*numbers.rms.floor_m));
  }
  if (numbers.sensor.divided_out && numbers.sensor.gain_at_tone) {
    text += fmt::format("; sensor gain of {:.4g} divided out of the tone",
                        *numbers.sensor.gain_at_tone);
  }
  if (!numbers.rms.floor_m && !numbers.sensor.divided_out) return std::nullopt;
  return text;
}

std::string ToneText(const dsp::ToneNumbers& tone, bool is_lower_limit) {
  if (is_lower_limit) {
    return fmt::format("{} Hz, amplitude at least {}",
                       WithUncertainty(tone.fit.frequency_hz, tone.fit.frequency_uncertainty_hz),
                       Um(tone.amplitude_lower_m));
  }
  return fmt::format("{} Hz, amplitude {}",
                     WithUncertainty(tone.fit.frequency_hz, tone.fit.frequency_uncertainty_hz),
                     Um(tone.amplitude_m, tone.amplitude_uncertainty_m));
}

// the tone of an answer, or why there is none
std::string ToneText(const dsp::BandAnalysis& analysis) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  if (numbers.tone) return ToneText(*numbers.tone, numbers.is_lower_limit);
  return analysis.frequency_move ? "none: the frequency moves" : "none stands out of the noise";
}

std::string RiseText(const dsp::Edge& edge) {
  if (edge.rise_s) return Ms(*edge.rise_s, edge.rise_uncertainty_s) + " from 10 % to 90 %";
  if (edge.rise_at_most_s) return fmt::format("at most {:.3g} ms", *edge.rise_at_most_s / kMs);
  return "not determined: the noise hides its beginning";
}

std::string LatencyText(const dsp::OnsetNumbers& onset) {
  if (!onset.latency_s) return "not known (rise time only): no drive channel or trigger";
  return fmt::format("{}: {}", Ms(*onset.latency_s, onset.latency_uncertainty_s),
                     LatencyVerdict(*onset.latency_s));
}

void AddRemarks(const AnalyzedFile& file, Lines& lines) {
  for (const std::string& remark : file.remarks) lines.push_back({"remark", remark});
  for (const std::string& remark : file.analysis->remarks) lines.push_back({"remark", remark});
  for (const std::string& reason : file.analysis->reasons) {
    lines.push_back({"not answered", reason});
  }
}

void AddSlowMotion(const dsp::SlowMotion& slow, Lines& lines) {
  lines.push_back(
      {"drift", fmt::format("{} um/s", WithUncertainty(slow.drift_per_s / kUm,
                                                       slow.drift_uncertainty_per_s / kUm))});
  if (!slow.tremor_rms) return;
  lines.push_back({"tremor", fmt::format("{} RMS between 3 and 13 Hz, about {:.3g} Hz",
                                         Um(*slow.tremor_rms, slow.tremor_rms_uncertainty),
                                         slow.tremor_frequency_hz)});
}

AnalysisSection RecordSection(const AnalyzedFile& file) {
  const dsp::RecordFacts& record = file.analysis->record;
  AnalysisSection section{"Record", {}};
  Lines& lines = section.lines;
  if (!file.source.empty()) lines.push_back({"source", file.source});
  lines.push_back(
      {"readings",
       fmt::format("{} in {:.3f} s, {:.6g} a second; {} measured, {} bridged", record.rows,
                   record.duration_s, record.rate_hz, record.measured, record.bridged)});
  lines.push_back({"observable", fmt::format("up to {:.4g} Hz", record.observable_upper_hz)});
  lines.push_back({"offset", Um(record.offset_m)});
  lines.push_back({"peak to peak", Um(record.peak_to_peak_m) + ", unfiltered"});
  if (file.analysis->slow_motion) AddSlowMotion(*file.analysis->slow_motion, lines);
  for (std::size_t k = 0; k < dsp::kFaultKindCount; ++k) {
    const auto kind = static_cast<dsp::FaultKind>(k);
    const dsp::Faults& faults = file.analysis->faults;
    if (faults.Count(kind) == 0) continue;
    lines.push_back({std::string(dsp::Name(kind)),
                     fmt::format("{} times, {} readings", faults.Count(kind), faults.Rows(kind))});
  }
  return section;
}

AnalysisSection VibrationSection(const dsp::BandAnalysis& analysis) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  AnalysisSection section{analysis.answered ? "Vibration" : "Vibration: an estimate, no answer",
                          {}};
  Lines& lines = section.lines;
  lines.push_back({"filter", DescribeFilter(analysis.band)});
  lines.push_back({"window", Seconds(numbers.part.window)});
  lines.push_back({"", numbers.part.why});
  // a driven part's reason ends with the drive's
  if (!numbers.part.why.ends_with(numbers.part.drive.why))
    lines.push_back({"drive", numbers.part.drive.why});
  lines.push_back({"RMS", RmsText(numbers, analysis.band)});
  lines.push_back({"", Um(numbers.rms.as_measured_m) + " as measured in the window"});
  lines.push_back(
      {"", Um(numbers.whole_rms_m) + " over the whole record, unsettled ends included"});
  lines.push_back({"peak to peak", Um(numbers.peak_to_peak_m) + " in the window"});
  lines.push_back({"without the tone", Um(numbers.residual_rms_m) + " RMS in the window"});
  if (numbers.floor) {
    lines.push_back(
        {"noise floor", fmt::format("{} RMS, from {}", AboutUm(numbers.rms.floor_m.value_or(0)),
                                    numbers.floor->source)});
  } else {
    lines.push_back(
        {"noise floor", "not known: no quiet part, and no --floor FILE; not taken off"});
  }
  if (numbers.below_band) {
    lines.push_back(
        {"below the band",
         fmt::format("{} at {:.3g} Hz, of which {:.2g} um RMS leak in{}",
                     AboutUm(numbers.below_band->amplitude_m), numbers.below_band->frequency_hz,
                     numbers.below_band->leaked_rms_m / kUm,
                     numbers.below_band->modelled ? "; modelled and taken out" : "")});
  }
  return section;
}

AnalysisSection UncertaintySection(const dsp::RmsEstimate& rms) {
  AnalysisSection section{"Uncertainty of the RMS", {}};
  for (const dsp::UncertaintyLine& line : rms.budget) {
    section.lines.push_back(
        {line.name,
         fmt::format("{:.2g} um ({}): {}", line.standard_uncertainty_m / kUm,
                     line.evaluation == dsp::Evaluation::kStatistical ? "type A" : "type B",
                     line.how)});
  }
  section.lines.push_back({"together", fmt::format("{:.2g} um (standard uncertainty)",
                                                   rms.standard_uncertainty_m / kUm)});
  section.lines.push_back({"not included", std::string(dsp::kNotInBudget)});
  return section;
}

void AddHarmonics(const dsp::Harmonics& harmonics, Lines& lines) {
  for (const dsp::Harmonic& harmonic : harmonics.harmonics) {
    if (harmonic.order == 1 || !harmonic.stands_out) continue;
    lines.push_back({fmt::format("harmonic {}", harmonic.order),
                     fmt::format("{:.5g} Hz, amplitude {}", harmonic.frequency_hz,
                                 Um(harmonic.amplitude, harmonic.amplitude_uncertainty))});
  }
  if (harmonics.thd) {
    lines.push_back({"THD", fmt::format("{} %", WithUncertainty(100 * *harmonics.thd,
                                                                100 * harmonics.thd_uncertainty))});
  } else if (harmonics.thd_at_most) {
    lines.push_back({"THD", fmt::format("not determined; at most {:.2g} % (95 %)",
                                        100 * *harmonics.thd_at_most)});
  }
}

AnalysisSection ToneSection(const dsp::BandAnalysis& analysis) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  AnalysisSection section{"Strongest tone", {}};
  Lines& lines = section.lines;
  lines.push_back({"tone", ToneText(analysis)});
  // of what is clipped, neither amplitudes nor harmonics are the motion's
  if (!numbers.tone || numbers.is_lower_limit) return section;
  const dsp::ToneNumbers& tone = *numbers.tone;
  lines.push_back(
      {"", fmt::format("95 %: {} Hz, {} um",
                       FromTo(tone.frequency_lower_hz, tone.frequency_upper_hz,
                              tone.fit.frequency_uncertainty_hz),
                       FromTo(tone.amplitude_lower_m / kUm, tone.amplitude_upper_m / kUm,
                              tone.amplitude_uncertainty_m / kUm))});
  lines.push_back({"sine fit", fmt::format("RMS {}: {:.4f} of the filtered RMS",
                                           Um(tone.sine_rms_m), tone.share_of_rms)});
  lines.push_back({"velocity", fmt::format("amplitude {:.4g} mm/s", tone.velocity_m_per_s * 1e3)});
  lines.push_back(
      {"acceleration", fmt::format("amplitude {:.4g} m/s^2", tone.acceleration_m_per_s2)});
  if (numbers.harmonics) AddHarmonics(*numbers.harmonics, lines);
  return section;
}

AnalysisSection SensorSection(const dsp::SensorNumbers& sensor) {
  AnalysisSection section{"Sensor", {}};
  Lines& lines = section.lines;
  lines.push_back({"averaging", dsp::Describe(sensor.averaging)});
  if (sensor.gain_at_tone) {
    lines.push_back({"gain at the tone", fmt::format("{:.4g}{}", *sensor.gain_at_tone,
                                                     sensor.divided_out ? ", divided out" : "")});
  }
  if (sensor.gain_in_band) {
    lines.push_back({"gain in the band", fmt::format("{:.4g} to {:.4g}", sensor.gain_in_band->least,
                                                     sensor.gain_in_band->greatest)});
  }
  return section;
}

AnalysisSection OnsetSection(const dsp::OnsetNumbers& onset) {
  AnalysisSection section{"Onset", {}};
  section.lines.push_back(
      {"begins", fmt::format("{} s ({:.0f} % of the steady amplitude)",
                             WithUncertainty(onset.edge.time_s, onset.edge.time_uncertainty_s),
                             100 * onset.edge.low_level)});
  section.lines.push_back({"rise", RiseText(onset.edge)});
  section.lines.push_back({"latency", LatencyText(onset)});
  return section;
}

AnalysisSection MotionSection(const dsp::Kinematics& motion) {
  return {"Motion in the band",
          {{"velocity", fmt::format("{:.4g} mm/s RMS, {:.4g} mm/s peak", motion.velocity_rms * 1e3,
                                    motion.velocity_peak * 1e3)},
           {"acceleration", fmt::format("{:.4g} m/s^2 RMS, {:.4g} m/s^2 peak",
                                        motion.acceleration_rms, motion.acceleration_peak)}}};
}

AnalysisSection ElectricalSection(const dsp::ElectricalState& state) {
  const auto value = [](const dsp::Estimate& of, double unit, std::string_view name) {
    return fmt::format("{} {}", WithUncertainty(of.value / unit, of.uncertainty / unit), name);
  };
  return {"Electrical, at the tone",
          {{"voltage", value(state.voltage_rms_v, 1, "V RMS")},
           {"current", value(state.current_rms_a, 1e-3, "mA RMS")},
           {"real power", value(state.real_power_w, 1e-3, "mW")},
           {"apparent power", value(state.apparent_power_va, 1e-3, "mVA")},
           {"phase of current", value(state.phase_rad, std::numbers::pi / 180, "degrees")},
           {"resistance", value(state.resistance_ohm, 1, "ohm")},
           {"reactance", value(state.reactance_ohm, 1, "ohm")}}};
}

void AddKnownTone(const dsp::KnownTone& known, Lines& lines) {
  lines.push_back(
      {"at the drive", fmt::format("{:g} Hz: amplitude {}{}", known.fit.frequency_hz,
                                   Um(known.fit.amplitude, known.fit.amplitude_uncertainty),
                                   known.aliased ? ", seen as an alias" : "")});
}

}  // namespace

std::string DescribeFilter(const dsp::BandPass& band) {
  return fmt::format("{}, Butterworth of order {}, forward and backward, -3 dB of {}",
                     BandName(band), band.order,
                     band.corners == dsp::Corners::kWhole ? "both together" : "each");
}

std::vector<AnalysisLine> ShortLines(const AnalyzedFile& file) {
  const dsp::BandAnalysis& analysis = *file.analysis;
  Lines lines;
  if (!analysis.numbers) {
    const AnalysisSection record = RecordSection(file);
    lines = record.lines;
    if (analysis.known_tone) AddKnownTone(*analysis.known_tone, lines);
    AddRemarks(file, lines);
    return lines;
  }
  const dsp::BandNumbers& numbers = *analysis.numbers;
  lines.push_back({analysis.answered ? "vibration" : "estimate", RmsText(numbers, analysis.band)});
  if (const auto correction = CorrectionText(numbers)) lines.push_back({"", *correction});
  lines.push_back(
      {"window", fmt::format("{}: {}", Seconds(numbers.part.window), numbers.part.why)});
  lines.push_back(
      {"whole record", Um(numbers.whole_rms_m) + " RMS, unsettled ends and pauses included"});
  lines.push_back({"tone", ToneText(analysis)});
  if (numbers.onset) {
    lines.push_back({"rise", RiseText(numbers.onset->edge)});
    lines.push_back({"latency", LatencyText(*numbers.onset)});
  }
  AddRemarks(file, lines);
  return lines;
}

std::vector<AnalysisSection> AllSections(const AnalyzedFile& file) {
  const dsp::BandAnalysis& analysis = *file.analysis;
  std::vector<AnalysisSection> sections{RecordSection(file)};
  if (analysis.known_tone) AddKnownTone(*analysis.known_tone, sections.front().lines);
  if (analysis.numbers) {
    const dsp::BandNumbers& numbers = *analysis.numbers;
    sections.push_back(VibrationSection(analysis));
    if (!numbers.is_lower_limit) sections.push_back(UncertaintySection(numbers.rms));
    sections.push_back(ToneSection(analysis));
    if (numbers.onset) sections.push_back(OnsetSection(*numbers.onset));
    if (numbers.kinematics) sections.push_back(MotionSection(*numbers.kinematics));
    if (numbers.electrical) sections.push_back(ElectricalSection(*numbers.electrical));
    sections.push_back(SensorSection(numbers.sensor));
  }
  AnalysisSection remarks{"Remarks", {}};
  AddRemarks(file, remarks.lines);
  if (!remarks.lines.empty()) sections.push_back(std::move(remarks));
  return sections;
}

namespace {

std::vector<std::vector<std::string>> TableRows(const std::vector<AnalysisLine>& lines) {
  std::vector<std::vector<std::string>> rows;
  rows.reserve(lines.size());
  for (const AnalysisLine& line : lines) rows.push_back({line.label, line.text});
  return rows;
}

Result<void> AddFile(const ReportedFile& reported, report::HtmlPage& page) {
  page.Section(reported.file.path);
  if (reported.file.error) {
    page.Warning(reported.file.error->Text());
    return {};
  }
  const dsp::BandAnalysis& analysis = *reported.file.analysis;
  for (const std::string& reason : analysis.reasons) page.Warning("not answered: " + reason);
  page.Table({}, TableRows(ShortLines(reported.file)));
  for (std::size_t k = 0; k < reported.figures.size(); ++k) {
    if (auto drawn = page.Figure(reported.captions[k], reported.figures[k]); !drawn) return drawn;
  }
  for (const AnalysisSection& section : AllSections(reported.file)) {
    if (section.heading == "Remarks") continue;  // stand in the first table
    page.Subsection(section.heading);
    page.Table({}, TableRows(section.lines));
  }
  return {};
}

}  // namespace

Result<report::HtmlPage> AnalysisReport(const std::vector<ReportedFile>& files,
                                        const std::string& command) {
  HAPTOMETER_CHECK(!files.empty(), "a report of no file");
  const std::string title = files.size() == 1 ? fmt::format("Vibration of {}", files[0].file.path)
                                              : fmt::format("Vibration of {} trials", files.size());
  report::HtmlPage page(
      title, fmt::format("haptometer {}, {}: {}", HAPTOMETER_VERSION, UtcNow(), command));
  for (const ReportedFile& file : files) {
    if (auto added = AddFile(file, page); !added) return std::unexpected(added.error());
  }
  return page;
}

namespace {

constexpr double kLatencyCostsS = 0.025;
constexpr double kLatencyPerceivedS = 0.050;

}  // namespace

std::string_view LatencyVerdict(double latency_s) {
  if (latency_s < kLatencyCostsS) return "below 25 ms, where it begins to cost errors";
  if (latency_s < kLatencyPerceivedS) return "above 25 ms, where it costs errors; below 50 ms";
  return "above 50 ms, where it is perceived";
}

std::string_view LatencyVerdict(const sim::SkinRise& rise) {
  const std::string_view verdict = LatencyVerdict(rise.LatencyAtMostS());
  if (verdict == LatencyVerdict(rise.latency_s - rise.uncertainty_s)) return verdict;
  return "too uncertain to be held against 25 and 50 ms";
}

std::optional<double> LatencyBelowS(const sim::SkinRise& rise) {
  return rise.TellsLatency() ? std::nullopt : std::optional(rise.LatencyAtMostS());
}

std::string LatencyText(const sim::SkinRise& rise) {
  if (const auto below_s = LatencyBelowS(rise)) {
    return fmt::format("below {:.3f} ms", std::ceil(*below_s * 1e6) / 1e3);
  }
  return fmt::format("{:.3f} ms, to {:.2g} ms", rise.latency_s * 1e3, rise.uncertainty_s * 1e3);
}

}  // namespace haptometer::tools
