#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "sim/actuator.h"
#include "sim/drive.h"
#include "sim/effects.h"
#include "sim/skin.h"
#include "trial/sensor_head.h"

namespace haptometer::sim {

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

/// What a tolerance is about; each is relative to its own size.
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
  double tolerance = 1e-10;  ///< of the quantity: what effects = "auto" may neglect
  AskedQuantity quantity = AskedQuantity::kSkinRms;
};

/// The stated start; where nothing is stated, rest for a scene with a duration and for a drive that
/// ends, steady otherwise.
[[nodiscard]] Start StartOf(const Scene& scene);

}  // namespace haptometer::sim
