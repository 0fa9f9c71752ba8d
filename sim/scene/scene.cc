#include "sim/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/elementary_functions.h"
#include "base/error.h"

namespace haptometer::sim {

Drive::operator SineDrive() const {
  HAPTOMETER_CHECK(kind == DriveKind::kSine, "a drive of kind {} is not a sine", Name(kind));
  return {.amplitude_v = amplitude_v, .frequency_hz = frequency_hz, .offset_v = offset_v};
}

std::string_view Name(DriveKind kind) {
  constexpr std::array<std::string_view, 6> kNames{"sine",  "tones", "burst",
                                                   "chirp", "pulse", "samples"};
  return kNames[static_cast<std::size_t>(kind)];
}

double HighestFrequencyHz(const Drive& drive) {
  double highest_hz = 0;
  switch (drive.kind) {
    case DriveKind::kSine:
    case DriveKind::kBurst:
      return drive.frequency_hz;
    case DriveKind::kChirp:
      return std::max(drive.frequency_hz, drive.end_frequency_hz);
    case DriveKind::kTones:
      for (const Tone& tone : drive.tones) highest_hz = std::max(highest_hz, tone.frequency_hz);
      return highest_hz;
    case DriveKind::kPulse:
    case DriveKind::kSamples:
      return 0;
  }
  return 0;
}

bool IsLasting(const Drive& drive) {
  return drive.kind == DriveKind::kSine || drive.kind == DriveKind::kTones;
}

double EndOfDriveS(const Drive& drive) {
  switch (drive.kind) {
    case DriveKind::kSine:
    case DriveKind::kTones:
      return std::numeric_limits<double>::infinity();
    case DriveKind::kBurst:
      return drive.start_s + drive.rise_s + drive.hold_s + drive.fall_s;
    case DriveKind::kChirp:
      return drive.start_s + drive.duration_s;
    case DriveKind::kPulse:
      return drive.start_s + drive.hold_s;
    case DriveKind::kSamples:
      return static_cast<double>(drive.samples->voltages_v.size() - 1) / drive.samples->rate_hz;
  }
  return 0;
}

double LargestVoltageV(const Drive& drive) {
  double largest_v = 0;
  if (drive.kind == DriveKind::kTones) {
    // tones may add up at some time
    for (const Tone& tone : drive.tones) largest_v += std::abs(tone.amplitude);
  } else if (drive.kind == DriveKind::kSamples) {
    for (const double voltage_v : drive.samples->voltages_v) {
      largest_v = std::max(largest_v, std::abs(voltage_v));
    }
  } else {
    largest_v = std::abs(drive.amplitude_v);
  }
  return largest_v + std::abs(drive.offset_v);
}

std::string_view Name(SensorTarget target) {
  // in the order of the enumerators
  static constexpr std::array<std::string_view, 3> kNames{"skin", "case", "mover"};
  return kNames[static_cast<std::size_t>(target)];
}

Sensor IdealSensor() {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Sensor sensor;
  sensor.head = {
      .name = "ideal", .sampling_s = 1e-4, .range_min_m = -kInfinite, .range_max_m = kInfinite};
  sensor.rate_hz = 1e4;
  return sensor;
}

Start StartOf(const Scene& scene) {
  const bool settles = IsLasting(scene.drive) && !scene.duration_s;
  return scene.start.value_or(settles ? Start::kSteady : Start::kRest);
}

double SagUnder(double force_n, double stiffness_n_per_m, double cubic_n_per_m3) {
  const double Kv = stiffness_n_per_m, K3 = cubic_n_per_m3;
  HAPTOMETER_CHECK(Kv >= 0 && K3 >= 0 && Kv + K3 > 0, "Kv {} N/m, K3 {} N/m^3", Kv, K3);
  if (!(K3 > 0)) return force_n / Kv;
  if (!(Kv > 0)) return Cbrt(force_n / K3);
  // the only real root of Kv s + K3 s^3 = F, in closed form with p = sqrt(Kv / (3 K3))
  const double p_m = std::sqrt(Kv / (3 * K3));
  return 2 * p_m * Sinh(Asinh(3 * force_n / (2 * p_m * Kv)) / 3);
}

}  // namespace haptometer::sim
