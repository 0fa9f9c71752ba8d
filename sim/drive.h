#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace haptometer::sim {

/// v(t) = offset_v + amplitude_v sin(2 pi frequency_hz t), from t = 0 on.
struct SineDrive {
  double amplitude_v = 0;
  double frequency_hz = 0;  ///< > 0
  double offset_v = 0;
};

/// amplitude sin(2 pi frequency_hz t + phase_rad), from t = 0 on; V, or m of a finger.
struct Tone {
  double amplitude = 0;
  double frequency_hz = 0;  ///< > 0
  double phase_rad = 0;
};

/// As [drive] kind calls them.
enum class DriveKind : std::uint8_t { kSine, kTones, kBurst, kChirp, kPulse, kSamples };

/// "sine", "tones", "burst", "chirp", "pulse", "samples".
[[nodiscard]] std::string_view Name(DriveKind kind);

/// Voltages at equal times, straight lines between them, 0 before and after.
struct VoltageSamples {
  double rate_hz = 0;  ///< > 0; the first is at t = 0
  std::vector<double> voltages_v;
};

/// The terminal voltage over time: offset_v from t = 0 on, and on top of it what the kind plays.
/// What belongs to other kinds is not looked at.
///
///   sine     amplitude_v sin(2 pi frequency_hz t)
///   tones    the sum of `tones`
///   burst    e(t) amplitude_v sin(2 pi frequency_hz (t - start_s)), e rising in a straight line
///            from 0 at start_s over rise_s, 1 for hold_s, falling over fall_s; 0 elsewhere
///   chirp    amplitude_v sin(2 pi (f0 s + (f1 - f0) s^2 / (2 duration_s))), s = t - start_s, f0 =
///            frequency_hz, f1 = end_frequency_hz, for 0 <= s <= duration_s; 0 elsewhere. Played by
///            cubics through value and slope, within hold_tolerance amplitude_v of it
///   pulse    amplitude_v from start_s on for hold_s; 0 elsewhere
///   samples  the file's voltages
struct Drive {
  double amplitude_v = 0;
  double frequency_hz = 0;
  DriveKind kind = DriveKind::kSine;
  double source_resistance_ohm = 0;  ///< >= 0, between the source and the coil
  std::vector<Tone> tones{};
  double start_s = 0;
  double rise_s = 0;
  double hold_s = 0;
  double fall_s = 0;
  double end_frequency_hz = 0;
  double duration_s = 0;
  double hold_tolerance = 1e-8;
  std::shared_ptr<const VoltageSamples> samples{};
  double offset_v = 0;  ///< constant, from t = 0 on for good

  /// The drive as a sine, which it must be: most of what is said of a steady state asks for one.
  operator SineDrive() const;  // NOLINT(google-explicit-constructor): scenes mostly have one
};

/// The highest frequency that a sine, tones, a burst or a chirp play; 0 of a pulse and of samples,
/// which have none of their own.
[[nodiscard]] double HighestFrequencyHz(const Drive& drive);

/// Whether the drive goes on forever as it is, so that motions may settle to a steady one: of a
/// sine and of tones.
[[nodiscard]] bool IsLasting(const Drive& drive);

/// When the voltage is constant for good, at its offset; infinite where the drive lasts.
[[nodiscard]] double EndOfDriveS(const Drive& drive);

/// The largest voltage that the drive may come to: amplitude, sum of the tones', largest sample;
/// with the offset's magnitude.
[[nodiscard]] double LargestVoltageV(const Drive& drive);

/// The finger's own motion under the skin: the sum of tones in m, towards the skin's far side
/// positive as all positions are. Tremor, or whatever shakes the hand.
struct FingerMotion {
  std::vector<Tone> tones;
};

/// What holds the case from outside, between it and ground.
struct Grip {
  double stiffness_n_per_m = 0;  ///< >= 0
  double damping_n_s_per_m = 0;  ///< >= 0
  bool holds = false;            ///< rigidly: the case does not move; without an adapter
};

}  // namespace haptometer::sim
