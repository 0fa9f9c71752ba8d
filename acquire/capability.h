#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/findings.h"

namespace haptometer::acquire {

/// A vibration's RMS in a band, told from the noise there by subtracting the noise's power, which
/// was measured with the drive off.
struct NoiseInBand {
  double rms_m = 0;           ///< of the noise in the band, > 0
  double bandwidth_hz = 0;    ///< of the band, over which the noise is flat; > 0
  double record_s = 0;        ///< length of the record, > 0
  double noise_record_s = 0;  ///< length of the record of the noise alone, > 0
};

/// The smallest RMS in m whose relative standard uncertainty u is `relative` (> 0). That of the RMS
/// of a tone, as a ratio, is
///
///   u^2 = (1 + T/Tn + 2 q) / (4 B T q^2),   q = rms^2 / noise^2.
///
/// A mean square over T of noise with bandwidth B scatters by noise^2 / sqrt(B T) (chi-square with
/// 2 B T degrees of freedom; Bendat, Piersol: Random Data, sect. 8.2), that of the noise alone over
/// Tn likewise, and the product of tone and noise by noise * rms * sqrt(2 / (B T)); the RMS is the
/// root of their difference, so half of its relative scatter. Holds where u is small against 1.
/// Its root is q = (1 + sqrt(1 + (1 + T/Tn) s)) / s with s = 4 B T relative^2.
[[nodiscard]] double SmallestRms(const NoiseInBand& noise, double relative);

/// What each sensor can be asked, before anything is bought, wired or recorded: arithmetic on what
/// makers state and wires carry.

/// What sets the rate of new readings.
enum class RateLimit : std::uint8_t {
  kWire,
  kWireAlone,  ///< of the unit nothing is known
  kWireAndSensor,
  kUnitRefresh,
  kUnitProcessing,
  kAmplifierSampling,
};

/// What a sensor, its wire and its settings give; empty where nobody states it.
struct SensorAbility {
  std::string name{};  ///< "IL-030 through a DL-RS1A, 38400 baud"
  /// How it is asked for, by settings: {"sensor", "keyence-il"}, {"baud", "38400"}.
  std::vector<std::pair<std::string, std::string>> settings{};
  double rate_hz = 0;  ///< fastest new readings a second, > 0
  RateLimit limit = RateLimit::kWire;
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
  Finding reason{};       ///< why it can, or cannot
  double highest_hz = 0;  ///< highest observable frequency: rate / 2.56
  double gain_lower = 1;  ///< of its averaging at the band's lower and upper edge
  double gain_upper = 1;
  std::optional<double> noise_in_band_m{};  ///< RMS; of what of the band lies below half the rate
  std::optional<double> smallest_rms_10_percent_m{};  ///< SmallestRms()
  std::optional<double> smallest_rms_1_percent_m{};
};

/// Judges one sensor: it can answer where rate / 2.56 reaches the band's upper edge, its averaging
/// leaves 0.7071 (-3 dB) there, and its steps are no larger than wanted.
[[nodiscard]] Capability Judge(const SensorAbility& sensor, const CapabilityQuestion& question);

/// Judges all and sorts: those that can answer first, then by the highest observable frequency.
[[nodiscard]] std::vector<Capability> Judge(const std::vector<SensorAbility>& sensors,
                                            const CapabilityQuestion& question);

/// The sensors that this program reads, in the settings that matter: the source of each number
/// stands beside it in acquire/capability.cc.
[[nodiscard]] std::vector<SensorAbility> KnownSensors();

}  // namespace haptometer::acquire
