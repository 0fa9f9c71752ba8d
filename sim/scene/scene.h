#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/scene/actuator.h"
#include "sim/scene/effects.h"
#include "sim/skin/skin.h"
#include "trial/sensor_head.h"

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

/// The mechanical amplifier between case and skin (Lindsay 2013, section 2.1): a mass on the
/// motor's side, a spring and damper, a mass on the skin's side.
struct Adapter {
  double motor_side_mass_kg = 0;  ///< Ma1 >= 0, rigid with the case
  double skin_side_mass_kg = 0;   ///< Ma2 > 0
  double stiffness_n_per_m = 0;   ///< Ka > 0
  double damping_n_s_per_m = 0;   ///< Ba >= 0
};

/// What the bodies do at t = 0.
enum class Start : std::uint8_t {
  kRest,    ///< static equilibrium without voltage, or the stated InitialState
  kSteady,  ///< as if the drive had been on forever
};

/// What the states are at t = 0, from where the bodies rest; 0 where nothing is stated.
struct InitialState {
  double mover_m = 0, mover_m_per_s = 0;
  double case_m = 0, case_m_per_s = 0;
  double skin_m = 0, skin_m_per_s = 0;  ///< with an adapter; without one the case's
  double current_a = 0;                 ///< of a coil with inductance

  /// Whether anything but rest is stated.
  [[nodiscard]] bool Any() const {
    return mover_m != 0 || mover_m_per_s != 0 || case_m != 0 || case_m_per_s != 0 || skin_m != 0 ||
           skin_m_per_s != 0 || current_a != 0;
  }
};

/// The body that the laser's spot lies on; positions are absolute, towards the skin positive.
enum class SensorTarget : std::uint8_t { kSkin, kCase, kMover };

/// "skin", "case", "mover".
[[nodiscard]] std::string_view Name(SensorTarget target);

/// What `simulate --explain` compares runs by; each is relative to its own size.
enum class AskedQuantity : std::uint8_t {
  kSkinRms,       ///< RMS of xs over the window
  kSkinWaveform,  ///< largest deviation of xs from what it should be, over its peak
  kMoverPeak,     ///< largest abs(xv - xa)
  kCurrentRms,    ///< RMS of i
};

/// As [run] quantity calls them, in the order of AskedQuantity.
inline constexpr std::array<std::string_view, 4> kAskedQuantityNames{
    "skin_rms_m", "skin_waveform_m", "mover_peak_m", "current_rms_a"};

/// The least tolerance that may be asked for: rounding stays below it.
inline constexpr double kLeastTolerance = 1e-11;

/// The longest run that the time response covers.
inline constexpr double kLongestRunS = 1e6;

/// A displacement sensor over the scene.
struct Sensor {
  trial::SensorHead head;
  SensorTarget target = SensorTarget::kSkin;
  double rate_hz = 0;      ///< readings handed out; 1 / head.sampling_s divided by a whole number
  double latency_s = 0;    ///< a reading of time t shows the motion of t - latency_s
  std::uint64_t seed = 1;  ///< of the head's noise
};

/// A perfect sensor on the skin: 10 kHz, no averaging, rounding, noise, range or delay.
[[nodiscard]] Sensor IdealSensor();

/// A scene. Without effects it is linear and contact is bilateral: the skin also
/// pulls. Without an adapter the case itself touches the skin, directly or through a
/// rigid massless cone; the two differ only in the skin's constants.
struct Scene {
  Actuator actuator;
  ActuatorCovariance actuator_covariance{};  ///< how well its numbers are known; 0: exactly
  std::optional<Adapter> adapter;
  Skin skin;
  Drive drive;
  std::optional<double> duration_s;  ///< absent: steady state only
  std::optional<Start> start;        ///< as stated; StartOf() gives the default
  std::optional<Sensor> sensor;
  Effects effects{};
  Grip grip{};             ///< of the case to ground; 0: free
  FingerMotion finger{};   ///< where tremor is on; no tones: it rests
  InitialState initial{};  ///< of a start from rest
  /// A constant force on the moving mass, towards the skin positive, as its weight is: it moves the
  /// mover by Kv s + K3 s^3 = F in its case and adds to what presses on the skin. Positions count
  /// from static equilibrium, so linear motions do not feel it.
  double mover_preload_n = 0;
  double tolerance =
      1e-10;  ///< largest relative error of any number, what "auto" neglects included
  AskedQuantity quantity = AskedQuantity::kSkinRms;
};

/// The stated start; where nothing is stated, rest for a scene with a duration and for a drive that
/// ends, steady otherwise.
[[nodiscard]] Start StartOf(const Scene& scene);

}  // namespace haptometer::sim
