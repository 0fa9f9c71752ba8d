#pragma once

#include "tools/document/document.h"

/// Keys that several verbs have; each key of one verb stands where its value is added.
namespace haptometer::document {

inline constexpr Key kAgrees{"agrees"};
inline constexpr Key kAmplitudeVerified{"amplitude_verified", "amplitude verified"};
inline constexpr Key kAmplitude{"amplitude_m", "amplitude", kMetre};
inline constexpr Key kAnswered{"answered"};
inline constexpr Key kBand{"band"};
inline constexpr Key kBandRms{"band_rms_m"};
inline constexpr Key kBest{"best"};
inline constexpr Key kBirgeRatio{"birge_ratio"};
inline constexpr Key kBvOverMass{"bv_over_mass", "Bv over mass", kPerSecond};
inline constexpr Key kBytes{"bytes"};
inline constexpr Key kCombinedUncertainty{"combined_standard_uncertainty"};
inline constexpr Key kCommand{"command"};
inline constexpr Key kContactArea{"contact_area_m2"};
inline constexpr Key kConverged{"converged", "converged"};
inline constexpr Key kCorner{"corner"};
inline constexpr Key kCorrelation{"correlation"};
inline constexpr Key kCount{"count"};
inline constexpr Key kCurrentRms{"current_rms_a", "current (RMS)", kAmpere};
inline constexpr Key kDataSources{"data_source"};
inline constexpr Key kDecayRate{"decay_per_s", "decay rate", kPerSecond};
inline constexpr Key kDegreesOfFreedom{"degrees_of_freedom", "degrees of freedom"};
inline constexpr Key kDeviation{"deviation"};
inline constexpr Key kDuration{"duration_s", "duration", kSecond};
inline constexpr Key kEvents{"events", "events"};
inline constexpr Key kExplained{"explained"};
inline constexpr Key kFile{"file"};
inline constexpr Key kFirst{"first_s"};
inline constexpr Key kFirstRow{"first_row", "first row"};
inline constexpr Key kFrequency{"frequency_hz", "frequency", kHertz};
inline constexpr Key kGain{"gain", "gain"};
inline constexpr Key kGaps{"gaps", "gaps"};
inline constexpr Key kHighestObservable{"highest_observable_hz", "observable to", kHertz};
inline constexpr Key kInput{"input", "given"};
inline constexpr Key kInputs{"inputs"};
inline constexpr Key kInterval95{"interval_95"};
inline constexpr Key kIterations{"iterations", "iterations"};
inline constexpr Key kKey{"key"};
inline constexpr Key kKind{"kind"};
inline constexpr Key kKvOverMass{"kv_over_mass", "Kv over mass", kPerSecondSquared};
inline constexpr Key kLatency{"latency_s", "latency to 10 %", kSecond};
inline constexpr Key kLength{"length_s"};
inline constexpr Key kList{"list"};
inline constexpr Key kLoad{"load_ohm"};
inline constexpr Key kLowerHz{"lower_hz"};
inline constexpr Key kMass{"mass", "mass"};
inline constexpr Key kMeasured{"measured"};
inline constexpr Key kMoverPeak{"mover_peak_m", "mover travel to either side", kMetre};
inline constexpr Key kMovingMass{"moving_mass_kg", "moving mass Mv", kKilogram};
inline constexpr Key kName{"name"};
inline constexpr Key kNaturalFrequency{"natural_frequency", "natural frequency f0", kHertz,
                                       Form::kEstimate};
inline constexpr Key kNaturalFrequencyHz{"natural_frequency_hz", "natural frequency f0", kHertz};
inline constexpr Key kNewReadings{"new_readings_per_s", "new readings", kPerSecond};
inline constexpr Key kNoiseRms{"noise_rms_m"};
inline constexpr Key kNotes{"notes", "notes"};
inline constexpr Key kObservableUpper{"observable_upper_hz", "observable to", kHertz};
inline constexpr Key kOffsetM{"offset_m", "offset", kMetre};
inline constexpr Key kOn{"on"};
inline constexpr Key kOrder{"order"};
inline constexpr Key kParameters{"parameters"};
inline constexpr Key kPhase{"phase_rad", "phase of the current", kRadian};
inline constexpr Key kPlot{"plot", "plot"};
inline constexpr Key kPoints{"points", "points"};
inline constexpr Key kPort{"port"};
inline constexpr Key kPower{"power_w", "electrical power", kWatt};
inline constexpr Key kQualityFactor{"quality_factor", "quality factor Q"};
inline constexpr Key kRate{"rate_hz", "rate", kHertz};
inline constexpr Key kReadings{"readings", "readings"};
inline constexpr Key kReasons{"reasons"};
inline constexpr Key kRelativeUncertainty{"relative_standard_uncertainty"};
inline constexpr Key kResidualRms{"residual_rms_m"};
inline constexpr Key kResistance{"resistance_ohm"};
inline constexpr Key kRise{"rise_s", "rise from 10 % to 90 %", kSecond};
inline constexpr Key kRiseAtMost{"rise_at_most_s", "rise from 10 % to 90 %, at most", kSecond};
inline constexpr Key kRms{"rms_m"};
inline constexpr Key kRows{"rows", "rows"};
inline constexpr Key kSampleRate{"sample_rate_hz", "sample rate", kHertz};
inline constexpr Key kSamples{"samples", "samples"};
inline constexpr Key kScene{"scene"};
inline constexpr Key kSensor{"sensor", "sensor"};
inline constexpr Key kSensorAveraging{"sensor_averaging", "averaging"};
inline constexpr Key kSensors{"sensors"};
inline constexpr Key kSkinForcePeak{"skin_force_peak_n", "force on the skin, amplitude", kNewton};
inline constexpr Key kSkinRms{"skin_rms_m", "skin displacement (RMS)", kMetre};
inline constexpr Key kSmallestRms1{"smallest_rms_1_percent_m", "smallest RMS to 1 %", kMetre};
inline constexpr Key kSmallestRms10{"smallest_rms_10_percent_m", "smallest RMS to 10 %", kMetre};
inline constexpr Key kSource{"source", "source"};
inline constexpr Key kStandardUncertainty{"standard_uncertainty"};
inline constexpr Key kState{"state"};
inline constexpr Key kSubject{"subject", "subject"};
inline constexpr Key kText{"text"};
inline constexpr Key kTime{"time_s"};
inline constexpr Key kTimeUncertainty{"time_uncertainty_s", "standard uncertainty of a time",
                                      kSecond};
inline constexpr Key kToneFrequency{"tone_frequency_hz"};
inline constexpr Key kTrials{"trials", "trials"};
inline constexpr Key kType{"type", "type"};
inline constexpr Key kUnit{"unit"};
inline constexpr Key kUpperHz{"upper_hz"};
inline constexpr Key kUtc{"utc"};
inline constexpr Key kValue{"value"};
inline constexpr Key kVerdict{"verdict"};
inline constexpr Key kWhat{"what"};
inline constexpr Key kWindowS{"window_s", "window", kSecond};

}  // namespace haptometer::document
