#include "tools/reproduce/generated_trials.h"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "tools/reproduce/passing_file.h"
#include "tools/simulated_trial.h"
#include "trial/record.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kRateHz = 2000;
constexpr std::size_t kRows = 2400;
constexpr double kTrialsBetweenSubjects = 0.25;
constexpr double kWithinCondition = 0.12;
constexpr double kBetweenTrials = 0.05;

struct TrialTruth {
  double rms_m = 0;
  double frequency_hz = 0;
  std::uint64_t seed = 0;
};

// tone, tremor, distance and drift; phases and sizes are drawn
trial::Displacement MotionOf(const TrialTruth& truth) {
  std::mt19937_64 random(truth.seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  const double phase = between(0, kTwoPi), tremor_phase = between(0, kTwoPi);
  const double tremor_hz = between(8, 11), tremor_m = between(20e-6, 40e-6);
  const double offset_m = between(1e-3, 3e-3), drift_m_per_s = between(-30e-6, 30e-6);
  const double amplitude_m = std::numbers::sqrt2 * truth.rms_m;
  return [=, frequency_hz = truth.frequency_hz](double t_s) {
    return offset_m + drift_m_per_s * t_s +
           amplitude_m * std::sin(kTwoPi * frequency_hz * t_s + phase) +
           tremor_m * std::sin(kTwoPi * tremor_hz * t_s + tremor_phase);
  };
}

trial::Record RecordOf(const TrialTruth& truth) {
  const trial::SensorHead head{.name = "generated",
                               .sampling_s = 1 / kRateHz,
                               .averages = 1,
                               .resolution_m = 1e-7,
                               .noise_rms_m = 0.5e-6,
                               .range_min_m = -10e-3,
                               .range_max_m = 10e-3};
  const trial::Displacement motion = MotionOf(truth);
  trial::Channel channel{.name = "displacement",
                         .role = trial::ChannelRole::kDisplacement,
                         .unit = "m",
                         .values = {},
                         .statuses = {},
                         .range_min = head.range_min_m,
                         .range_max = head.range_max_m,
                         .resolution = head.resolution_m};
  channel.values.reserve(kRows);
  channel.statuses.reserve(kRows);
  for (std::size_t row = 0; row < kRows; ++row) {
    const auto reading = trial::ReadingAt(head, motion, static_cast<std::int64_t>(row), truth.seed);
    channel.values.push_back(reading.value_m);
    channel.statuses.push_back(reading.status);
  }
  trial::Record record;
  record.rows = kRows;
  record.channels.push_back(std::move(channel));
  record.stretches.push_back({.first_row = 0, .rows = kRows, .start_s = 0, .rate_hz = kRateHz});
  record.metadata.source = "simulated: generated with a known truth, not measured";
  record.metadata.sensor = "sensor model";
  record.metadata.head = head.name;
  record.metadata.sampling_s = head.sampling_s;
  record.metadata.averages = head.averages;
  record.metadata.hold = "sample";
  record.metadata.nominal_rate_hz = kRateHz;
  record.metadata.drive_frequency_hz = truth.frequency_hz;
  return record;
}

}  // namespace

std::vector<double> CentredDeviates(std::mt19937_64& random, int count, double standard_deviation) {
  std::normal_distribution<double> normal(0, standard_deviation);
  std::vector<double> deviates(static_cast<std::size_t>(count));
  for (double& deviate : deviates) deviate = normal(random);
  const double mean = std::reduce(deviates.begin(), deviates.end()) / count;
  for (double& deviate : deviates) deviate -= mean;
  return deviates;
}

Result<void> GenerateTrials(const std::vector<GeneratedCondition>& conditions, double frequency_hz,
                            std::uint64_t seed, const std::filesystem::path& folder) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> between_trials(0, kBetweenTrials);
  const auto subjects = CentredDeviates(random, kGeneratedSubjects, kTrialsBetweenSubjects);
  for (const GeneratedCondition& condition : conditions) {
    const auto own = CentredDeviates(random, kGeneratedSubjects, kWithinCondition);
    for (std::size_t s = 0; s < subjects.size(); ++s) {
      for (int repeat = 1; repeat <= kGeneratedRepeats; ++repeat) {
        const double log = subjects[s] + own[s] + between_trials(random);
        trial::Record record = RecordOf({condition.rms_m * std::exp(log), frequency_hz, random()});
        record.metadata.labels = {{"subject", std::to_string(s + 1)},
                                  {"condition", condition.name},
                                  {"repeat", std::to_string(repeat)}};
        const std::string path =
            folder / fmt::format("s{}_{}_{}.bin", s + 1, condition.name, repeat);
        auto written = WriteSimulatedTrialIn(MakePassingFile(path), path, record);
        if (!written) return written;
      }
    }
  }
  return {};
}

}  // namespace haptometer::tools
