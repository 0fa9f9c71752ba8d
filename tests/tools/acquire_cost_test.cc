// docs/acquire_cost.csv, which is made by a script of its own, against the program's functions.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "acquire/capability.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/wire.h"
#include "base/band.h"
#include "tests/residual.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

constexpr const char* kDigits = "the file has ten digits";

struct Row {
  std::string sweep;
  std::string setting;
  std::vector<double> numbers;  // in the order of the columns behind them

  [[nodiscard]] double rate_hz() const { return numbers[0]; }
  [[nodiscard]] double sampling_s() const { return numbers[1]; }
  [[nodiscard]] int averages() const { return static_cast<int>(numbers[2]); }
  [[nodiscard]] double duration_s() const { return numbers[3]; }
  [[nodiscard]] double lower_hz() const { return numbers[4]; }
  [[nodiscard]] double upper_hz() const { return numbers[5]; }
  [[nodiscard]] double tone_hz() const { return numbers[6]; }
  [[nodiscard]] double gain() const { return numbers[7]; }
  [[nodiscard]] double noise_m() const { return numbers[8]; }
  [[nodiscard]] double tenth_m() const { return numbers[9]; }
  [[nodiscard]] double hundredth_m() const { return numbers[10]; }
};

std::vector<Row> Rows() {
  std::ifstream file(std::string(HAPTOMETER_FIXTURES) + "/../docs/acquire_cost.csv");
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.starts_with("sweep,")) continue;
    const auto quote = line.find('"');
    const auto end = line.find('"', quote + 1);
    Row row{line.substr(0, quote - 1), line.substr(quote + 1, end - quote - 1), {}};
    std::istringstream rest(line.substr(end + 2));
    for (std::string field; std::getline(rest, field, ',');)
      row.numbers.push_back(std::stod(field));
    EXPECT_EQ(row.numbers.size(), 11U) << line;
    rows.push_back(std::move(row));
  }
  return rows;
}

TEST(AcquireCost, EveryRowIsWhatTheProgramSays) {
  const std::vector<Row> rows = Rows();
  ASSERT_EQ(rows.size(), 31U);
  for (const Row& row : rows) {
    SCOPED_TRACE(row.sweep + " " + row.setting);
    EXPECT_REL(trial::AveragingGain(row.tone_hz(), row.sampling_s(), row.averages()), row.gain(),
               1e-9, kDigits);
    const acquire::NoiseInBand noise{row.noise_m(), row.upper_hz() - row.lower_hz(),
                                     row.duration_s(), row.duration_s()};
    EXPECT_REL(acquire::SmallestRms(noise, 0.1) / row.gain(), row.tenth_m(), 1e-8, kDigits);
    EXPECT_REL(acquire::SmallestRms(noise, 0.01) / row.gain(), row.hundredth_m(), 1e-8, kDigits);
    if (row.upper_hz() < 500) {
      EXPECT_REL(HighestObservableHz(row.rate_hz()), row.upper_hz(), 1e-9, kDigits);
    } else {
      EXPECT_GE(HighestObservableHz(row.rate_hz()), 500);
    }
  }
}

TEST(AcquireCost, PolledRatesAreThoseOfTheWire) {
  int compared = 0;
  for (const Row& row : Rows()) {
    if (row.sweep != "wire" || !row.setting.starts_with("DL-RS1A ")) continue;
    const int baud = std::stoi(row.setting.substr(8));
    EXPECT_REL(1 / SecondsFromNs(acquire::dl_rs1a::PollPeriodNs(baud, 1)), row.rate_hz(), 1e-7,
               "periods are whole nanoseconds");
    ++compared;
  }
  EXPECT_EQ(compared, 5);
}

TEST(AcquireCost, WithoutAveragingTheNoiseIsWhiteOverHalfTheRate) {
  int compared = 0;
  for (const Row& row : Rows()) {
    if (row.averages() != 1) continue;
    const double sample_m = row.setting.starts_with("stream") ? 0.5e-6 : 11e-6;
    EXPECT_REL(row.noise_m(),
               sample_m * std::sqrt(2 * (row.upper_hz() - row.lower_hz()) / row.rate_hz()), 1e-9,
               kDigits);
    ++compared;
  }
  EXPECT_EQ(compared, 13);
}

// with a reading for every sample the noise is |H|^2 of the moving average over the white noise
TEST(AcquireCost, AveragedNoiseIsTheIntegralOfTheGain) {
  int compared = 0;
  for (const Row& row : Rows()) {
    if (row.sweep != "averaging") continue;
    constexpr int kSteps = 4800;
    const double step_hz = (row.upper_hz() - row.lower_hz()) / kSteps;
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double gain = trial::AveragingGain(row.lower_hz() + (k + 0.5) * step_hz,
                                               row.sampling_s(), row.averages());
      sum += gain * gain * step_hz;
    }
    EXPECT_REL(row.noise_m(), 11e-6 * std::sqrt(2 * row.sampling_s() * sum), 1e-5,
               "midpoints every 0.1 Hz, lobes of 24 Hz");
    ++compared;
  }
  EXPECT_EQ(compared, 8);
}

}  // namespace
}  // namespace haptometer::tools
