#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/hard_cases/hard_case.h"
#include "trial/byte_io.h"
#include "trial/sensor_head.h"
#include "trial/time_base.h"

namespace haptometer::hard_cases {
namespace {

TEST(HardCasesTrial, AveragingGainAtTheSamplingRate) {
  const double f = 1000, t = 1e-3;
  const double sine = std::sin(0.0 * f);
  Check({"trial", "averaging of a tone at the sampling rate", "sin(pi f n T)/sin(pi f T) is 0/0",
         "the formula as printed, its sines rounded to 0", 0},
        {1, trial::AveragingGain(f, t, 16), sine / (16 * sine)});
}

TEST(HardCasesTrial, AveragingGainOfAveragesOfDiscreteSamples) {
  // sin(pi 225 0.016)/(16 sin(pi 225 0.001)) with arguments below a turn
  const long double pi = 3.14159265358979323846264338327950288L;
  const long double truth = std::fabs(std::sin(pi * 1.6L)) / (16 * std::sin(pi * 0.225L));
  const double x = static_cast<double>(pi) * 225 * 16e-3;
  Check({"trial", "averaging of 16 samples of 1 ms at 225 Hz", "samples are points, not areas",
         "sin(pi f n T)/(pi f n T)", 1e-15},
        {truth, trial::AveragingGain(225, 1e-3, 16), std::fabs(std::sin(x)) / x});
}

// lines of a 10 kHz source that arrive in bursts: each waits for the next multiple of `burst_s`
std::vector<std::int64_t> Bursts(std::size_t rows, double rate_hz, std::int64_t burst_ns) {
  std::vector<std::int64_t> time_ns;
  for (std::size_t k = 0; k < rows; ++k) {
    const auto sent_ns =
        static_cast<std::int64_t>(std::llround(1e9 * static_cast<double>(k) / rate_hz));
    time_ns.push_back((sent_ns / burst_ns + 1) * burst_ns);
  }
  return time_ns;
}

TEST(HardCasesTrial, RateOfLinesInBursts) {
  constexpr double kRate = 10'000;
  const auto time_ns = Bursts(30'000, kRate, 16'000'000);
  const auto stretches = trial::FitArrivalTimes(time_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 1U);
  // the last burst is cut off, so that its arrival is late: one burst in 3 s
  const double naive = 29'999 / (1e-9 * static_cast<double>(time_ns.back() - time_ns.front()));
  Check({"trial", "rate of lines in bursts of 16 ms, 3 s", "arrival is late by up to a burst",
         "rows over the time from the first to the last", 1e-6},
        {static_cast<long double>(kRate), stretches.front().rate_hz, naive});
}

TEST(HardCasesTrial, TimesOfARowFarOut) {
  trial::UniformGrid grid(44'100);
  grid.Append(0, 100'000'000);
  const trial::Stretch& stretch = grid.stretches().front();
  const double ours = stretch.start_s + 99'999'999 / stretch.rate_hz;
  float sum = 0;
  for (int k = 0; k < 1'000'000; ++k) sum += 1 / 44'100.0F;
  Check({"trial", "time of row 1e8 at 44.1 kHz", "the interval is no binary number",
         "the interval added up in float, here 1e6 times and scaled", 2.3e-16},
        {99'999'999.0L / 44'100, ours, static_cast<double>(sum) * 99.999999});
}

TEST(HardCasesTrial, TwoBytesThatChangedPlaces) {
  const std::array<std::byte, 4> right{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}};
  const std::array<std::byte, 4> wrong{std::byte{1}, std::byte{3}, std::byte{2}, std::byte{4}};
  const auto sum = [](const auto& bytes) {
    int total = 0;
    for (const std::byte byte : bytes) total += std::to_integer<int>(byte);
    return total;
  };
  Check({"trial", "two bytes that changed places", "their sum is the same",
         "a checksum that adds bytes: 1 where it differs", 0},
        {1, trial::Crc32(right) != trial::Crc32(wrong) ? 1.0 : 0.0,
         sum(right) != sum(wrong) ? 1.0 : 0.0});
}

}  // namespace
}  // namespace haptometer::hard_cases
