#include "bench/sim_cost_rung.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

namespace haptometer::sim {
namespace {

constexpr int kLeastRuns = 3;
constexpr double kPatienceUs = 0.25e6;

double HalfRms(const Eigen::MatrixXd& samples) {
  const Eigen::RowVectorXd skin = samples.row(kXs);
  return std::sqrt(skin.tail(skin.size() / 2).squaredNorm());
}

std::string FailureOf(const Answer& answer, const Truth& truth, bool lost) {
  if (!answer.failure.empty()) return answer.failure;
  if (lost) return "lost";
  if (answer.events_s.size() == truth.events_s.size()) return "";
  return fmt::format("{} events of {}", answer.events_s.size(), truth.events_s.size());
}

}  // namespace

double BestMicroseconds(int runs, const std::function<void()>& run) {
  double best_us = std::numeric_limits<double>::infinity(), total_us = 0;
  for (int k = 0; k < runs && (k < kLeastRuns || total_us < kPatienceUs); ++k) {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double, std::micro> taken =
        std::chrono::steady_clock::now() - start;
    best_us = std::min(best_us, taken.count());
    total_us += taken.count();
  }
  return best_us;
}

Eigen::VectorXd ErrorsOf(const Eigen::MatrixXd& samples, const Truth& truth) {
  return (samples - truth.samples).cwiseAbs().rowwise().maxCoeff().cwiseQuotient(truth.largest);
}

double RmsErrorOf(const Eigen::MatrixXd& samples, const Truth& truth) {
  return std::abs(HalfRms(samples) / HalfRms(truth.samples) - 1);
}

void Measure(const Rung& rung, const Truth& truth) {
  const auto outputs = static_cast<std::size_t>(truth.samples.cols()) - 1;
  const Answer answer = rung.run(outputs);
  const Eigen::VectorXd errors = ErrorsOf(answer.samples, truth);
  const double worst =
      errors.hasNaN() ? std::numeric_limits<double>::infinity() : errors.maxCoeff();
  const bool lost = !(worst < rung.lost_above);
  std::string line =
      fmt::format("{},{},{},{:.4g},{:.3g},{},{},{},{}", rung.scene, rung.method, rung.setting,
                  BestMicroseconds(rung.runs, [&] { (void)rung.run(outputs); }),
                  BestMicroseconds(rung.runs, [&] { (void)rung.run(1); }), answer.steps,
                  answer.evaluations, answer.events_s.size(), FailureOf(answer, truth, lost));
  const bool known = answer.failure.empty() && !lost;
  const auto add = [&](double error) { line += known ? fmt::format(",{:.3g}", error) : ","; };
  add(RmsErrorOf(answer.samples, truth));
  add(worst);
  for (Eigen::Index s = 0; s < 8; ++s) {
    if (s < errors.size()) {
      add(errors(s));
    } else {
      line += ",";
    }
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

}  // namespace haptometer::sim
