#pragma once

#include <optional>
#include <string>
#include <vector>

/// What each sensor can be asked, before anything is bought, wired or recorded: arithmetic on what
/// makers state and wires carry.
namespace haptometer::acquire {

/// What a sensor, its wire and its settings give; empty where nobody states it.
struct SensorAbility {
  std::string name{};     ///< "IL-030 through a DL-RS1A, 38400 baud"
  std::string option{};   ///< how acquire is told: "--sensor keyence-il --baud 38400"
  double rate_hz = 0;     ///< fastest new readings a second, > 0
  std::string limit{};    ///< what sets the rate: "the wire", "the unit's refresh"
  double sampling_s = 0;  ///< of the raw samples in an averaged reading; 0: no averaging is known
  int averages = 1;       ///< raw samples in a reading
  std::optional<double> resolution_m{};  ///< one step
  std::optional<double> noise_rms_m{};   ///< of one reading, white
  std::optional<double> range_min_m{};
  std::optional<double> range_max_m{};
};

/// What is wanted.
struct CapabilityQuestion {
  double lower_hz = 20;        ///< >= 0
  double upper_hz = 500;       ///< > lower_hz
  double resolution_m = 1e-6;  ///< > 0: largest step that is fine enough
  double record_s = 10;        ///< length of the record, and of one of the noise alone; > 0
};

/// One sensor's answer.
struct Capability {
  SensorAbility sensor{};
  bool can_answer = false;
  std::string reason{};   ///< in one sentence
  double highest_hz = 0;  ///< highest observable frequency: rate / 2.56
  double gain_lower = 1;  ///< of its averaging at the band's lower and upper edge
  double gain_upper = 1;
  std::optional<double> noise_in_band_m{};  ///< RMS; of what of the band lies below half the rate
  std::optional<double> smallest_rms_10_percent_m{};  ///< ability/smallest_rms.h
  std::optional<double> smallest_rms_1_percent_m{};
};

/// Judges one sensor: it can answer where rate / 2.56 reaches the band's upper edge, its averaging
/// leaves 0.7071 (-3 dB) there, and its steps are no larger than wanted.
[[nodiscard]] Capability Judge(const SensorAbility& sensor, const CapabilityQuestion& question);

/// Judges all and sorts: those that can answer first, then by the highest observable frequency.
[[nodiscard]] std::vector<Capability> Judge(const std::vector<SensorAbility>& sensors,
                                            const CapabilityQuestion& question);

/// The sensors that this program reads, in the settings that matter: ability/known_sensors.cc says
/// where each number is from.
[[nodiscard]] std::vector<SensorAbility> KnownSensors();

}  // namespace haptometer::acquire
