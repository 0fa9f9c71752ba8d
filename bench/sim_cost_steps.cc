// Boost.odeint and fixed steps (sim_cost_peers.h).
#include <algorithm>
#include <array>
#include <boost/numeric/odeint/integrate/integrate_times.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>
#include <exception>

#include "bench/sim_cost_peers.h"

namespace haptometer::sim {
namespace {

using Values = std::array<double, kMostBodyStates>;

void Keep(const Values& y, Eigen::Index output, Answer* answer) {
  const Eigen::Index rows = answer->samples.rows();
  answer->samples.col(output) = Eigen::Map<const Eigen::VectorXd>(y.data(), rows);
}

Values Sum(const Values& y, double by, const Values& rate) {
  Values sum;
  for (std::size_t k = 0; k < y.size(); ++k) sum[k] = y[k] + by * rate[k];
  return sum;
}

// equal steps through whatever happens
class Steps {
 public:
  Steps(const Question& question, FixedStep method, double h_s)
      : question_(question),
        method_(method),
        h_s_(h_s),
        omega_rad_per_s_(AngularFrequency(question)) {}

  void Step(std::int64_t number, Answer* answer) {
    const double t_s = static_cast<double>(number) * h_s_;
    if (method_ == FixedStep::kRungeKutta4) {
      RungeKutta4(t_s);
    } else {
      SemiImplicitEuler(t_s);
    }
    if (!(question_.gap_m > 0) && !(question_.preload_n > 0)) return;
    const auto guards = GuardsOf(question_, contact_, y_.data());
    for (std::size_t guard = 0; guard < guards.size(); ++guard) {
      if (guards[guard] < 0 && Approaching(guard)) {
        answer->events_s.push_back(t_s + h_s_);
        Cross(question_, guard, &contact_, y_.data());
      }
    }
  }
  [[nodiscard]] const Values& y() const { return y_; }

 private:
  [[nodiscard]] Values RateAt(double t_s, const Values& y) const {
    Values rate{};
    RateOf(question_, contact_, question_.bodies.volt * std::sin(omega_rad_per_s_ * t_s), y.data(),
           rate.data());
    return rate;
  }
  void RungeKutta4(double t_s) {
    const Values k1 = RateAt(t_s, y_);
    const Values k2 = RateAt(t_s + h_s_ / 2, Sum(y_, h_s_ / 2, k1));
    const Values k3 = RateAt(t_s + h_s_ / 2, Sum(y_, h_s_ / 2, k2));
    const Values k4 = RateAt(t_s + h_s_, Sum(y_, h_s_, k3));
    for (std::size_t s = 0; s < y_.size(); ++s) {
      y_[s] += h_s_ / 6 * (k1[s] + 2 * k2[s] + 2 * k3[s] + k4[s]);
    }
  }
  void SemiImplicitEuler(double t_s) {
    const Values rate = RateAt(t_s, y_);
    for (const std::size_t s : {kVv, kVa, kVs, kCurrent, kEighth}) y_[s] += h_s_ * rate[s];
    for (const std::size_t s : {kXv, kXa, kXs}) y_[s] += h_s_ * y_[s + 1];
  }
  // a stop that is being left is not hit again
  [[nodiscard]] bool Approaching(std::size_t guard) const {
    const double closing = y_[kVv] - y_[kVa];
    return guard == 2 || (guard == 0 ? closing > 0 : closing < 0);
  }

  Question question_;
  FixedStep method_;
  double h_s_;
  double omega_rad_per_s_;
  bool contact_ = true;
  Values y_{};
};

}  // namespace

Answer ByFixedSteps(const Question& question, std::size_t outputs, FixedStep method, int inner) {
  Answer answer = EmptyAnswer(question, outputs);
  Steps steps(question, method, 1 / (question.rate_hz * inner));
  for (std::size_t i = 0; i < outputs; ++i) {
    for (int k = 0; k < inner; ++k) steps.Step(answer.steps++, &answer);
    Keep(steps.y(), static_cast<Eigen::Index>(i) + 1, &answer);
    if (!std::isfinite(steps.y()[kCurrent])) {
      answer.failure = "unstable";
      break;
    }
  }
  answer.evaluations = answer.steps * (method == FixedStep::kRungeKutta4 ? 4 : 1);
  return answer;
}

Answer ByDopri5(const Question& question, std::size_t outputs, const Tolerance& tolerance) {
  namespace odeint = boost::numeric::odeint;
  Answer answer = EmptyAnswer(question, outputs);
  Values unit;
  unit.fill(1);
  for (Eigen::Index k = 0; k < tolerance.largest.size(); ++k) {
    unit[static_cast<std::size_t>(k)] = tolerance.largest(k);
  }
  const double omega_rad_per_s = AngularFrequency(question);
  const auto rate = [&](const Values& scaled, Values& scaled_rate, double t_s) {
    ++answer.evaluations;
    Values y, y_rate{};
    for (std::size_t k = 0; k < y.size(); ++k) y[k] = scaled[k] * unit[k];
    RateOf(question, true, question.bodies.volt * std::sin(omega_rad_per_s * t_s), y.data(),
           y_rate.data());
    for (std::size_t k = 0; k < y.size(); ++k) scaled_rate[k] = y_rate[k] / unit[k];
  };
  std::vector<double> times_s;
  for (std::size_t i = 0; i <= outputs; ++i) times_s.push_back(question.TimeOf(i));
  Eigen::Index output = 0;
  const auto observe = [&](const Values& scaled, double /*t_s*/) {
    Values y;
    for (std::size_t k = 0; k < y.size(); ++k) y[k] = scaled[k] * unit[k];
    Keep(y, output++, &answer);
  };
  Values start{};
  try {
    answer.steps = static_cast<std::int64_t>(odeint::integrate_times(
        odeint::make_controlled(0.1 * tolerance.relative, tolerance.relative,
                                odeint::runge_kutta_dopri5<Values>()),
        rate, start, times_s, 1e-6, observe));
  } catch (const std::exception&) {
    answer.failure = "gave up";
  }
  return answer;
}

}  // namespace haptometer::sim
