// Times the joint fit of drops that lie in memory, for tests/long/fit_rate.py. Standard input:
//   Kv Bv Km^2 Mv R L, the number of records, and for each
//     samples load/ohm noise/V speed voltage/V impact/s offset/V, then time/s and voltage/V of
//     every sample;
//   then `fit`, any number of times.
// Each fit starts there, ends at the least squares to rounding, and answers with a line: seconds,
// Kv, Bv, Km^2 and their standard deviations by the residuals.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "fit/drop_test/ring_down_problem.h"
#include "fit/identifiability.h"

namespace haptometer::fit {
namespace {

double Read() {
  std::string word;  // "inf" is no number to a stream
  std::cin >> word;
  return std::stod(word);
}

struct Task {
  RingDownProblem problem{{}, 0};
  RingDownPoint start;
};

void ReadRecord(Task& task) {
  RingDownSamples record;
  const auto samples = static_cast<std::size_t>(Read());
  record.load_ohm = Read();
  record.noise_v = Read();
  record.polarity = -1;
  std::array<double, kOwnCount> own{};
  own[Index(Own::kAmplitude)] = std::log(Read());
  own[Index(Own::kImpact)] = Read();
  own[Index(Own::kOffset)] = Read();
  for (std::size_t n = 0; n < samples; ++n) {
    record.times_s.push_back(Read());
    record.voltages_v.push_back(Read());
  }
  record.step_s =
      (record.times_s.back() - record.times_s.front()) / static_cast<double>(samples - 1);
  task.start.own.push_back(own);
  task.problem.records().push_back(std::move(record));
}

Task ReadTask() {
  Task task;
  auto& shared = task.start.shared;
  shared[Index(Shared::kStiffness)] = std::log(Read());
  shared[Index(Shared::kDamping)] = std::log(Read());
  shared[Index(Shared::kForceConstantSquared)] = Read();
  shared[Index(Shared::kMass)] = std::log(Read());
  shared[Index(Shared::kResistance)] = std::log(Read());
  task.problem.set_inductance_h(Read());
  const auto records = static_cast<std::size_t>(Read());
  for (std::size_t r = 0; r < records; ++r) ReadRecord(task);
  return task;
}

// Kv, Bv, Km^2 and each record's amplitude, impact and offset
std::vector<bool> FreeColumns(std::size_t records) {
  std::vector<bool> is_free(kSharedCount + kOwnCount * records, false);
  for (const Shared shared :
       {Shared::kStiffness, Shared::kDamping, Shared::kForceConstantSquared}) {
    is_free[Index(shared)] = true;
  }
  for (std::size_t r = 0; r < records; ++r) {
    for (const Own own : {Own::kAmplitude, Own::kImpact, Own::kOffset})
      is_free[Column(r, own)] = true;
  }
  return is_free;
}

struct Answer {
  RingDownPoint point;
  std::vector<double> deviations;  // of the parameters, per column
};

Answer Fit(const Task& task) {
  const auto& problem = task.problem;
  const auto is_free = FreeColumns(problem.records().size());
  Answer answer{task.start, {}};
  Jacobian at;
  if (!problem.Minimise(is_free, &answer.point, &at).converged) std::cerr << "not converged\n";
  const auto seen = FindIdentifiability(at, is_free, std::vector<bool>(is_free.size(), false));
  double squares = 0;
  for (const double residual : at.residuals) squares += residual * residual;
  double degrees = -static_cast<double>(std::ranges::count(is_free, true));
  for (const auto& record : problem.records())
    degrees += static_cast<double>(record.times_s.size());
  for (std::size_t k = 0; k < at.columns; ++k) {
    answer.deviations.push_back(std::sqrt(squares / degrees * seen.covariance[k * at.columns + k]));
  }
  return answer;
}

void Time(const Task& task) {
  const auto begin = std::chrono::steady_clock::now();
  const auto [point, deviations] = Fit(task);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  const auto& shared = point.shared;
  const double stiffness = std::exp(shared[Index(Shared::kStiffness)]);
  const double damping = std::exp(shared[Index(Shared::kDamping)]);
  std::cout.precision(17);
  std::cout << taken.count() << ' ' << stiffness << ' ' << damping << ' '
            << shared[Index(Shared::kForceConstantSquared)] << ' '
            << stiffness * deviations[Index(Shared::kStiffness)] << ' '
            << damping * deviations[Index(Shared::kDamping)] << ' '
            << deviations[Index(Shared::kForceConstantSquared)] << std::endl;
}

}  // namespace
}  // namespace haptometer::fit

int main() {
  const auto task = haptometer::fit::ReadTask();
  std::string command;
  while (std::cin >> command) haptometer::fit::Time(task);
}
