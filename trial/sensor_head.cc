#include "trial/sensor_head.h"

#include <cmath>
#include <numbers>

#include "base/error.h"

namespace haptometer::trial {
namespace {

// splitmix64: a bijection of 64 bits that passes tests of randomness (Steele, Lea, Flood,
// OOPSLA 2014, p. 462)
std::uint64_t Mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

// uniform in (0, 1], from the upper 53 bits
double Uniform(std::uint64_t bits) { return static_cast<double>((bits >> 11) + 1) * 0x1p-53; }

// standard normal from (seed, number) by Box and Muller: any sample is available in any order
double NormalAt(std::uint64_t seed, std::int64_t number) {
  const std::uint64_t key = Mixed(seed ^ Mixed(static_cast<std::uint64_t>(number)));
  // sqrt(-2 ln u1) cos(2 pi u2)
  const double radius = std::sqrt(-2 * std::log(Uniform(key)));
  return radius * std::cos(2 * std::numbers::pi * Uniform(Mixed(key)));
}

}  // namespace

SensorHead Il030() {
  // values of the data sheet; noise of a raw sample so that 128 averages leave 1 um
  return {.name = "IL-030",
          .sampling_s = 1e-3,
          .averages = 16,
          .resolution_m = 1e-6,
          .noise_rms_m = 11e-6,
          .range_min_m = -15e-3,
          .range_max_m = 10e-3};
}

SensorHead Stream10kHz() {
  return {.name = "stream-10kHz",
          .sampling_s = 1e-4,
          .averages = 1,
          .resolution_m = 1e-7,
          .noise_rms_m = 0.5e-6,
          .range_min_m = -10e-3,
          .range_max_m = 10e-3};
}

double AveragingGain(double frequency_hz, double sampling_s, int averages) {
  HAPTOMETER_CHECK(averages >= 1, "averages = {}", averages);
  // |sin(n x) / (n sin(x))| with x = pi f Ts
  const double half_angle = std::numbers::pi * frequency_hz * sampling_s;
  const double one = std::sin(half_angle);
  // f is a multiple of the sampling rate: every raw sample has the same phase
  if (std::abs(one) < 1e-12) return 1;
  return std::abs(std::sin(half_angle * averages) / (averages * one));
}

HeadReading ReadingAt(const SensorHead& head, const Displacement& displacement, std::int64_t k,
                      std::uint64_t seed) {
  HAPTOMETER_CHECK(head.sampling_s > 0 && head.averages >= 1, "sampling {} s, {} averages",
                   head.sampling_s, head.averages);
  // mean of the last `averages` raw samples, each with its own noise
  double sum = 0;
  for (std::int64_t sample = k - head.averages + 1; sample <= k; ++sample) {
    const double t_s = static_cast<double>(sample) * head.sampling_s;
    sum += displacement(t_s) + head.noise_rms_m * NormalAt(seed, sample);
  }
  const double mean = sum / head.averages;
  // the range is that of the mean, before it is rounded
  if (mean > head.range_max_m) return {head.range_max_m, SampleStatus::kOver};
  if (mean < head.range_min_m) return {head.range_min_m, SampleStatus::kUnder};
  if (head.resolution_m == 0) return {mean, SampleStatus::kOk};
  return {std::round(mean / head.resolution_m) * head.resolution_m, SampleStatus::kOk};
}

}  // namespace haptometer::trial
