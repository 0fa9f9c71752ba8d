#include "bench/sim_cost_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "base/error.h"
#include "tests/sim/reference/events_reference.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/reference/smooth_reference.h"

namespace haptometer::sim {
namespace {

__extension__ typedef __float128 Quad;

constexpr std::size_t kOrder = 36;
constexpr double kStepsPerSecond = 12e4;
constexpr int kProbes = 8;  // of a guard within a step
constexpr int kHalvings = 110;

using Values = std::array<Quad, kMostBodyStates>;
using Coefficients = std::array<Quad, kOrder + 1>;

// the coefficients of a product, one at a time
Quad Product(const Coefficients& a, const Coefficients& b, std::size_t k) {
  Quad sum = 0;
  for (std::size_t j = 0; j <= k; ++j) sum += a[j] * b[k - j];
  return sum;
}

Quad Evaluate(const Coefficients& series, Quad t) {
  Quad sum = 0;
  for (std::size_t k = kOrder + 1; k-- > 0;) sum = sum * t + series[k];
  return sum;
}

// the question's constants
struct QuadBodies {
  Quad Mv, Mc1, Kv, Bv, Km, R, L, Ma2, Ka, Ba, Ks, Bs, volt, K3, sag, preload, C, Rth;

  explicit QuadBodies(const Question& question) {
    const auto in = [](double value) { return static_cast<Quad>(value); };
    const Bodies& b = question.bodies;
    Mv = in(b.Mv), Mc1 = in(b.Mc) + in(b.Ma1), Kv = in(b.Kv), Bv = in(b.Bv), Km = in(b.Km);
    R = in(b.R), L = in(b.L), Ma2 = in(b.Ma2), Ka = in(b.Ka), Ba = in(b.Ba);
    Ks = in(b.Ks), Bs = in(b.Bs), volt = in(b.volt), K3 = in(question.cubic_n_per_m3);
    sag = in(question.sag_m), preload = in(question.preload_n);
    C = in(question.heat_capacity_j_per_k), Rth = in(question.thermal_resistance_k_per_w);
  }
};

// One step's series of all states: the equations of RateOf(), coefficient by coefficient. Two
// products are carried as series of their own: the cube of the spring's length and the heated
// coil's R i.
class Series {
 public:
  Series(const Question& question, bool contact)
      : question_(&question), bodies_(question), contact_(contact) {
    // pi in two parts
    const auto high = static_cast<Quad>(std::numbers::pi_v<long double>);
    const auto low = static_cast<Quad>(-5.01655761266833202355e-20L);
    omega_ = 2 * (high + low) * static_cast<Quad>(question.bodies.frequency_hz);
  }

  void Expand(const Values& y, Quad sine, Quad cosine) {
    for (std::size_t s = 0; s < kMostBodyStates; ++s) states_[s][0] = y[s];
    sine_[0] = sine;
    cosine_[0] = cosine;
    for (std::size_t k = 0; k < kOrder; ++k) Next(k);
  }

  [[nodiscard]] Values At(Quad t) const {
    Values y{};
    for (std::size_t s = 0; s < question_->states(); ++s) y[s] = Evaluate(states_[s], t);
    return y;
  }
  [[nodiscard]] std::pair<Quad, Quad> DriveAt(Quad t) const {
    return {Evaluate(sine_, t), Evaluate(cosine_, t)};
  }

 private:
  // coefficient k + 1 from those up to k
  void Next(std::size_t k) {
    const QuadBodies& b = bodies_;
    const Quad one = k == 0 ? 1 : 0;  // a constant's coefficient
    const auto of = [&](std::size_t state) { return states_[state][k]; };
    const Quad travel = of(kXv) - of(kXa), speed = of(kVv) - of(kVa);
    Quad spring = b.Kv * travel + b.Bv * speed;
    if (b.K3 > 0) {
      length_[k] = travel + one * b.sag;
      square_[k] = Product(length_, length_, k);
      spring += b.K3 * (Product(square_, length_, k) - one * b.sag * b.sag * b.sag);
    }
    const Quad joint = b.Ka * (of(kXa) - of(kXs)) + b.Ba * (of(kVa) - of(kVs));
    const Quad skin = contact_ ? b.Ks * of(kXs) + b.Bs * of(kVs) : -one * b.preload;
    drop_[k] = b.R * of(kCurrent);
    if (b.C > 0) {
      resistance_[k] = b.R * (one + static_cast<Quad>(kRisePerK) * of(kEighth));
      drop_[k] = Product(resistance_, states_[kCurrent], k);
    }

    Values rate{};
    rate[kXv] = of(kVv);
    rate[kVv] = -(b.Km * of(kCurrent) + spring) / b.Mv;
    rate[kXa] = of(kVa);
    rate[kVa] = (b.Km * of(kCurrent) + spring - joint) / b.Mc1;
    rate[kXs] = of(kVs);
    rate[kVs] = (joint - skin) / b.Ma2;
    rate[kCurrent] = (b.volt * sine_[k] - drop_[k] + b.Km * speed) / b.L;
    if (b.C > 0) {
      rate[kEighth] = (Product(drop_, states_[kCurrent], k) - of(kEighth) / b.Rth) / b.C;
    } else if (!contact_) {
      rate[kEighth] = -(one * b.preload + b.Ks * of(kEighth)) / b.Bs;
    }
    const Quad by = Quad(1) / static_cast<Quad>(k + 1);
    for (std::size_t s = 0; s < kMostBodyStates; ++s) states_[s][k + 1] = rate[s] * by;
    sine_[k + 1] = omega_ * cosine_[k] * by;
    cosine_[k + 1] = -omega_ * sine_[k] * by;
  }

  const Question* question_;
  QuadBodies bodies_;
  bool contact_;
  Quad omega_ = 0;
  std::array<Coefficients, kMostBodyStates> states_{};
  Coefficients sine_{}, cosine_{}, length_{}, square_{}, resistance_{}, drop_{};
};

struct Fall {
  Quad tau;
  std::size_t guard;
};

// the first guard that falls below zero within a step
std::optional<Fall> FirstFall(const Question& question, bool contact, const Series& series,
                              Quad step) {
  const auto value = [&](std::size_t guard, Quad t) {
    return GuardsOf(question, contact, series.At(t).data())[guard];
  };
  std::optional<Fall> first;
  for (int probe = 1; probe <= kProbes; ++probe) {
    const Quad end = step * probe / kProbes;
    const auto guards = GuardsOf(question, contact, series.At(end).data());
    for (std::size_t guard = 0; guard < guards.size(); ++guard) {
      if (guards[guard] >= 0) continue;
      Quad low = step * (probe - 1) / kProbes, high = end;
      for (int k = 0; k < kHalvings; ++k) {
        const Quad middle = (low + high) / 2;
        (value(guard, middle) < 0 ? high : low) = middle;
      }
      if (!first || low < first->tau) first = Fall{low, guard};
    }
    if (first) return first;
  }
  return std::nullopt;
}

// a motion in 113 bits
class QuadMotion {
 public:
  explicit QuadMotion(const Question& question) : question_(question) {}

  // by `step_s`, through the events within
  void Advance(Quad step_s) {
    const bool guarded = question_.gap_m > 0 || question_.preload_n > 0;
    while (step_s > 0) {
      Series series(question_, contact_);
      series.Expand(y_, sine_, cosine_);
      const auto fall = guarded ? FirstFall(question_, contact_, series, step_s) : std::nullopt;
      const Quad taken = fall ? fall->tau : step_s;
      y_ = series.At(taken);
      std::tie(sine_, cosine_) = series.DriveAt(taken);
      time_s_ += taken;
      step_s -= taken;
      if (!fall) return;
      events_s_.push_back(static_cast<double>(time_s_));
      HAPTOMETER_CHECK(events_s_.size() < 10000, "events without end at {} s", events_s_.back());
      Cross(question_, fall->guard, &contact_, y_.data());
    }
  }

  [[nodiscard]] const std::vector<double>& events_s() const { return events_s_; }
  [[nodiscard]] Eigen::VectorXd Compared() const {
    Eigen::VectorXd out(static_cast<Eigen::Index>(question_.compared()));
    for (std::size_t s = 0; s < question_.compared(); ++s) {
      out(static_cast<Eigen::Index>(s)) = static_cast<double>(y_[s]);
    }
    return out;
  }

 private:
  Question question_;
  Values y_{};
  Quad sine_ = 0, cosine_ = 1, time_s_ = 0;
  bool contact_ = true;
  std::vector<double> events_s_;
};

}  // namespace

Truth TruthOf(const Question& question) {
  QuadMotion motion(question);
  const auto outputs = static_cast<Eigen::Index>(question.outputs);
  Truth truth{.samples = motion.Compared().replicate(1, outputs + 1), .largest{}, .events_s{}};
  const int inner = std::max(1, static_cast<int>(std::ceil(kStepsPerSecond / question.rate_hz)));
  const Quad step_s = 1 / (static_cast<Quad>(question.rate_hz) * inner);
  for (Eigen::Index i = 1; i <= outputs; ++i) {
    for (int k = 0; k < inner; ++k) motion.Advance(step_s);
    truth.samples.col(i) = motion.Compared();
  }
  truth.largest = truth.samples.cwiseAbs().rowwise().maxCoeff();
  truth.events_s = motion.events_s();
  return truth;
}

namespace {

template <typename Expected>
double Apart(const Question& question, const Expected& expected) {
  const Truth truth = TruthOf(question);
  double worst = 0;
  for (Eigen::Index s = 0; s < 7; ++s) {
    const double off = truth.samples(s, truth.samples.cols() - 1) - expected(s);
    worst = std::max(worst, std::abs(off) / truth.largest(s));
  }
  return worst;
}

}  // namespace

ReferenceDifferences DifferencesToReferences() {
  const Question linear{.name = "linear", .outputs = 123};
  const Question short_run{.name = "short", .rate_hz = 9600, .outputs = 300};
  Question stops = short_run, contact = short_run, smooth = short_run;
  stops.gap_m = 0.3e-3;
  stops.restitution = 0.5;
  contact.preload_n = 0.07;
  smooth.cubic_n_per_m3 = 3e9;
  smooth.sag_m = 5e-5;
  smooth.heat_capacity_j_per_k = 1e-3;
  smooth.thermal_resistance_k_per_w = 100;
  const auto of = [](const double* values) {
    return [values](Eigen::Index s) { return values[s]; };
  };
  // SciPy's begin with the current
  const auto current_first = [](Eigen::Index s) { return tests::kSmoothState[(s + 1) % 7]; };
  return {.fifty_digits = std::max({Apart(linear, of(tests::kAdapterState)),
                                    Apart(stops, of(tests::kStopsState)),
                                    Apart(contact, of(tests::kContactState))}),
          .scipy = Apart(smooth, current_first)};
}

}  // namespace haptometer::sim
