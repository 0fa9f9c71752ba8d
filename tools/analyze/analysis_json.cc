#include "tools/analyze/analysis_json.h"

#include <nlohmann/json.hpp>

#include "tools/cli/json.h"

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

}  // namespace haptometer::tools
