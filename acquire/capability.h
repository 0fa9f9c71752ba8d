#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/findings.h"
#include "base/band.h"

namespace haptometer::acquire {

/// A vibration's RMS in a band, told from the noise there by subtracting the noise's power, which
/// was measured with the drive off.
struct NoiseInBand {
  double rms_m = 0;           ///< of the noise in the band, > 0
  double bandwidth_hz = 0;    ///< of the band, over which the noise is flat; > 0
  double record_s = 0;        ///< length of the record, > 0
  double noise_record_s = 0;  ///< length of the record of the noise alone, > 0
  /// Share of the noise's own scatter within the record that is not told from the vibration: all
  /// (1) where the noise alone was recorded at another time, less where the same record shows it
  /// beside the drive; >= 0.
  double own_share = 1;
};

/// The smallest RMS in m whose relative standard uncertainty u is `relative` (> 0). That of the RMS
/// of a tone, as a ratio, is
///
///   u^2 = (a + T/Tn + 2 q) / (4 B T q^2),   q = rms^2 / noise^2,   a = own_share.
///
/// A mean square over T of noise with bandwidth B scatters by noise^2 / sqrt(B T) (chi-square with
/// 2 B T degrees of freedom; Bendat, Piersol: Random Data, sect. 8.2), that of the noise alone over
/// Tn likewise, and the product of tone and noise by noise * rms * sqrt(2 / (B T)); the RMS is the
/// root of their difference, so half of its relative scatter. Holds where u is small against 1.
/// Its root is q = (1 + sqrt(1 + (a + T/Tn) s)) / s with s = 4 B T relative^2.
[[nodiscard]] double SmallestRms(const NoiseInBand& noise, double relative);

/// u of `rms_m` (> 0) by the equation of SmallestRms(). Holds where it is small against 1.
[[nodiscard]] double RelativeUncertaintyOf(const NoiseInBand& noise, double rms_m);

/// The length T in s of a record in which the relative standard uncertainty of `rms_m` (> 0) is
/// `relative` (> 0), by the same equation for T; `noise.record_s` is ignored:
///
///   T = (a + 2 q) / (4 B q^2 u^2 - 1/Tn).
///
/// Nothing where u is below 1 / sqrt(4 B Tn q^2), the uncertainty of the noise alone, which no
/// length of the record changes.
[[nodiscard]] std::optional<double> RecordLength(const NoiseInBand& noise, double rms_m,
                                                 double relative);

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
  bool is_polled = false;  ///< each reading is requested
  double wire_s = 0;       ///< a reading on the wire, its request included; 0: not a wire's matter
  double refresh_s = 0;    ///< polled: a value is handed out for so long; 0: not known
};

/// What is wanted.
struct CapabilityQuestion {
  double lower_hz = kDefaultLowerHz;  ///< >= 0
  double upper_hz = kDefaultUpperHz;  ///< > lower_hz
  double resolution_m = 1e-6;         ///< > 0: largest step that is fine enough
  double record_s = 10;               ///< length of the record, and of one of the noise alone; > 0
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

/// -3 dB: what is less is mostly gone, and correcting for it raises the noise by as much.
inline constexpr double kLeastGain = std::numbers::sqrt2 / 2;

/// Judges one sensor: it can answer where rate / 2.56 reaches the band's upper edge, its averaging
/// leaves 0.7071 (-3 dB) there, and its steps are no larger than wanted.
[[nodiscard]] Capability Judge(const SensorAbility& sensor, const CapabilityQuestion& question);

/// Judges all and sorts: those that can answer first, then by the highest observable frequency.
[[nodiscard]] std::vector<Capability> Judge(const std::vector<SensorAbility>& sensors,
                                            const CapabilityQuestion& question);

/// The sensors that this program reads, in the settings that matter: the source of each number
/// stands beside it in acquire/capability.cc.
[[nodiscard]] std::vector<SensorAbility> KnownSensors();

/// The analog output of an IL-030 whose amplifier averages `averages` samples of `sampling_s`: new
/// values at 1 / sampling_s, held in between, in the steps of a converter that is not stated.
[[nodiscard]] SensorAbility AnalogOutput(double sampling_s, int averages);

}  // namespace haptometer::acquire
