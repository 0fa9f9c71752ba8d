// An independent reference for scenes with effects: Taylor series in long double, events located by
// Bernstein subdivision. Written from the equations of docs/explanation/notation.md and
// docs/reference/scene.md alone; it shares no code with the library.
//
// Reads scenes from standard input, a line `key value` each, an empty line ends a scene; writes a
// line of JSON for each. tests/sim/reference/scene_reference.py names the keys.
//
// Method: all right-hand sides are polynomials in the states (but for a division by the resistance
// where L = 0), so the series of every state follows by recursion (order 24). A step is as long as
// the last terms allow (1e-20 of each state's largest value so far), at most 4 L/R. Guards (gaps,
// forces) are polynomials over a step: a guard whose Bernstein coefficients are all positive has no
// root; else the step is halved until the first root is known to 2^-60 of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using Real = long double;
constexpr int kOrder = 24;
constexpr Real kNever = std::numeric_limits<Real>::infinity();
constexpr Real kPi = 3.14159265358979323846264338327950288L;
using Series = std::array<Real, kOrder + 1>;

enum State { kXv, kVv, kXa, kVa, kXs, kVs, kXp, kI, kTheta, kStates };

struct Tone {
  Real amplitude = 0, omega = 0, phase = 0;
};

// Straight lines between knots; beyond them its first and its last value.
struct Lines {
  std::vector<Real> at, value;

  // value and slope just behind t
  [[nodiscard]] std::pair<Real, Real> Behind(Real t) const {
    const auto next =
        static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), t) - at.begin());
    if (next == 0) return {value.front(), 0};
    if (next == at.size()) return {value.back(), 0};
    const Real slope = (value[next] - value[next - 1]) / (at[next] - at[next - 1]);
    return {value[next - 1] + slope * (t - at[next - 1]), slope};
  }
  // the next knot behind t
  [[nodiscard]] Real Next(Real t) const {
    const auto next = std::upper_bound(at.begin(), at.end(), t);
    return next == at.end() ? kNever : *next;
  }
};

struct Scene {
  Real mv = 0, mc = 0, kv = 0, bv = 0, km = 0, r = 0, l = 0;
  bool adapter = false;
  Real ma1 = 0, ma2 = 0, ka = 0, ba = 0;
  Real ks = 0, bs = 0, preload = 0;
  bool unilateral = false;
  bool stops = false;
  Real gap_up = kNever, gap_down = kNever, restitution = 0;
  Real stop_k = 0, stop_c = 0;  // stop_k == 0: rigid
  Real k3 = 0, gravity = 0;
  Real heat_c = 0, heat_rth = kNever, alpha = 0;  // heat_c == 0: off
  Real source_r = 0, grip_k = 0, grip_b = 0, offset_v = 0;
  std::vector<Tone> drive, tremor;
  Lines envelope;  // of the drive's tones; no knots: 1
  Lines volts;     // added to them; no knots: 0
  Real duration = 0, window = 0, strobe_s = 0, tolerance = 1e-20L;
  std::array<Real, kStates> start{};

  [[nodiscard]] Real CaseMass() const { return mc + (adapter ? ma1 : 0); }
};

// How the moving mass stands to a stop, and the body to the skin.
enum class Stop { kFree, kStuck, kEngaged, kInside };

struct Mode {
  Stop stop = Stop::kFree;
  int side = 0;  // +1 up, -1 down
  bool contact = true;
};

enum class GuardKind {
  kGapUp,
  kGapDown,
  kStuckForce,
  kStopForce,
  kInsideGap,
  kInsideForce,
  kContactForce,
  kSkinGap
};

struct Guard {
  GuardKind kind;
  Series g;
};

struct Result {
  Real begin = 0, end = 0;
  Real xs2 = 0, xa2 = 0, i2 = 0, energy = 0, xs = 0;
  Real peak_window = 0, peak_run = 0, force_least = kNever, theta_peak = 0, theta_end = 0;
  std::map<std::string, int> events;
  std::vector<Real> strobe_xs2, strobe_xv, strobe_xs;
  bool stalled = false;
};

Real Product(const Series& a, const Series& b, int k) {
  Real sum = 0;
  for (int j = 0; j <= k; ++j) sum += a[j] * b[k - j];
  return sum;
}

Real Value(const Series& c, Real t) {
  Real sum = 0;
  for (int k = kOrder; k >= 0; --k) sum = sum * t + c[k];
  return sum;
}

// Integral over [0, h] of a b.
Real IntegralOfProduct(const Series& a, const Series& b, Real h) {
  Real sum = 0;
  Real power = h;
  for (int k = 0; k <= 2 * kOrder; ++k) {
    Real c = 0;
    for (int j = std::max(0, k - kOrder); j <= std::min(k, kOrder); ++j) c += a[j] * b[k - j];
    sum += c * power / (k + 1);
    power *= h;
  }
  return sum;
}

using Bernstein = std::vector<Real>;

// The polynomial sum c_k t^k over [0, h], in Bernstein form.
Bernstein ToBernstein(const std::vector<Real>& c, Real h) {
  const int n = static_cast<int>(c.size()) - 1;
  Bernstein b(n + 1);
  Real power = 1;
  Real binomial = 1;  // C(n, k)
  for (int k = 0; k <= n; ++k) {
    b[k] = c[k] * power / binomial;
    power *= h;
    binomial = binomial * (n - k) / (k + 1);
  }
  for (int k = 1; k <= n; ++k)
    for (int i = n; i >= k; --i) b[i] += b[i - 1];
  return b;
}

void Halve(const Bernstein& b, Bernstein& left, Bernstein& right) {
  const int n = static_cast<int>(b.size()) - 1;
  Bernstein work = b;
  left.resize(n + 1);
  right.resize(n + 1);
  for (int k = 0; k <= n; ++k) {
    left[k] = work[0];
    right[n - k] = work[n - k];
    for (int i = 0; i + k < n; ++i) work[i] = (work[i] + work[i + 1]) / 2;
  }
}

// The first place in [from, to] where the polynomial falls below zero; kNever: nowhere.
Real FirstFall(const Bernstein& b, Real from, Real to, int depth) {
  if (b.front() < 0) return from;
  if (std::all_of(b.begin(), b.end(), [](Real x) { return x >= 0; })) return kNever;
  if (depth == 0) return b.back() < 0 ? to : kNever;
  Bernstein left, right;
  Halve(b, left, right);
  const Real middle = (from + to) / 2;
  const Real first = FirstFall(left, from, middle, depth - 1);
  if (first != kNever) return first;
  return FirstFall(right, middle, to, depth - 1);
}

// Calls visit(t) at every place in (0, h) where the polynomial changes its sign.
void Roots(const Bernstein& b, Real from, Real to, int depth,
           const std::function<void(Real)>& visit) {
  int changes = 0;
  for (std::size_t i = 1; i < b.size(); ++i) changes += (b[i - 1] < 0) != (b[i] < 0);
  if (changes == 0) return;
  if (depth == 0) {
    visit((from + to) / 2);
    return;
  }
  Bernstein left, right;
  Halve(b, left, right);
  const Real middle = (from + to) / 2;
  Roots(left, from, middle, depth - 1, visit);
  Roots(right, middle, to, depth - 1, visit);
}

Real SagUnder(Real weight, Real k, Real k3) {
  Real s = weight / k;
  for (int n = 0; n < 200; ++n) s -= (k * s + k3 * s * s * s - weight) / (k + 3 * k3 * s * s);
  return s;
}

class Integrator {
 public:
  explicit Integrator(const Scene& scene) : s_(scene) {
    sag_ = SagUnder(s_.mv * s_.gravity, s_.kv, s_.k3);
    gap_up_ = s_.gap_up - sag_;
    gap_down_ = s_.gap_down + sag_;
    preload_ = s_.preload + s_.gravity * (s_.mv + s_.mc + (s_.adapter ? s_.ma1 + s_.ma2 : 0));
    x_ = s_.start;
    result_.end = s_.duration;
    result_.begin = std::max<Real>(0, s_.duration - s_.window);
  }

  Result Run() {
    std::size_t strobe = 1;
    long work = 0;
    while (t_ < s_.duration && !result_.stalled) {
      Real limit = s_.duration;
      if (t_ < result_.begin) limit = std::min(limit, result_.begin);
      // behind a knot of the voltage what rested may begin to move: its scale is estimated anew
      const Real knot = std::min(s_.envelope.Next(t_), s_.volts.Next(t_));
      limit = std::min(limit, knot);
      Real strobe_at = kNever;
      if (s_.strobe_s > 0) {
        strobe_at = static_cast<Real>(strobe) * s_.strobe_s;
        limit = std::min(limit, strobe_at);
      }
      const bool reached = Step(limit);
      first_ = first_ || (reached && limit == knot);
      if (reached && limit == strobe_at) {
        result_.strobe_xs2.push_back(strobe_xs2_ / s_.strobe_s);
        result_.strobe_xv.push_back(x_[kXv]);
        result_.strobe_xs.push_back(Skin());
        strobe_xs2_ = 0;
        ++strobe;
      }
      if (++work > 200'000'000) result_.stalled = true;
    }
    result_.theta_end = x_[kTheta];
    return result_;
  }

 private:
  [[nodiscard]] Real Skin() const { return x_[s_.adapter ? kXs : kXa]; }
  [[nodiscard]] bool PadHasMemory() const { return s_.bs > 0; }

  // The series of a sum of tones about t_: amplitude omega^k/k! sin(omega t + phase + k pi/2).
  void TonesSeries(const std::vector<Tone>& tones, Series& out) const {
    out.fill(0);
    for (const Tone& tone : tones) {
      const Real angle = std::fmod(tone.omega * t_, 2 * kPi) + tone.phase;
      const std::array<Real, 4> cycle{std::sin(angle), std::cos(angle), -std::sin(angle),
                                      -std::cos(angle)};
      Real factor = tone.amplitude;
      for (int k = 0; k <= kOrder; ++k) {
        out[k] += factor * cycle[k % 4];
        factor *= tone.omega / (k + 1);
      }
    }
  }

  // e(t) times the tones, e a straight line about t_, and the straight lines of the voltage.
  void DriveSeries() {
    TonesSeries(s_.drive, u_);
    if (!s_.envelope.at.empty()) {
      const auto [level, slope] = s_.envelope.Behind(t_);
      for (int k = kOrder; k > 0; --k) u_[k] = level * u_[k] + slope * u_[k - 1];
      u_[0] *= level;
    }
    u_[0] += s_.offset_v;
    if (s_.volts.at.empty()) return;
    const auto [level, slope] = s_.volts.Behind(t_);
    u_[0] += level;
    u_[1] += slope;
  }

  void Expand() {
    DriveSeries();
    TonesSeries(s_.tremor, xg_);
    for (int k = 0; k < kOrder; ++k) vg_[k] = (k + 1) * xg_[k + 1];
    vg_[kOrder] = 0;
    for (int n = 0; n < kStates; ++n) c_[n][0] = x_[n];
    for (int k = 0; k < kOrder; ++k) ExpandTerm(k);
    Terms(kOrder);
  }

  // All algebraic series to order k from the states' to order k.
  void Terms(int k) {
    d_[k] = c_[kXv][k] - c_[kXa][k];
    w_[k] = c_[kVv][k] - c_[kVa][k];
    const Real hot = s_.r * s_.alpha;
    if (s_.l == 0) {
      Real back = u_[k] + s_.km * w_[k];
      for (int j = 1; j <= k; ++j) back -= hot * c_[kTheta][j] * c_[kI][k - j];
      c_[kI][k] = back / (s_.source_r + s_.r + hot * c_[kTheta][0]);
    }
    const Series& i = c_[kI];
    coil_drop_[k] = s_.r * i[k] + hot * Product(c_[kTheta], i, k);
    square_[k] = Product(d_, d_, k);
    spring_[k] = s_.kv * d_[k] + s_.bv * w_[k];
    if (s_.k3 > 0)
      spring_[k] +=
          s_.k3 * (Product(square_, d_, k) + 3 * sag_ * square_[k] + 3 * sag_ * sag_ * d_[k]);
    stop_[k] = StopForce(k);
    const int xs = s_.adapter ? kXs : kXa;
    const int vs = s_.adapter ? kVs : kVa;
    skin_[k] = s_.ks * (c_[xs][k] - xg_[k]) + s_.bs * (c_[vs][k] - vg_[k]);
    contact_force_[k] = skin_[k] + (k == 0 ? preload_ : 0);
    if (!mode_.contact) skin_[k] = k == 0 ? -preload_ : 0;
    mover_force_[k] = -s_.km * i[k] - spring_[k] - (Signed(mode_) ? mode_.side * stop_[k] : 0);
    const Real coupling =
        s_.adapter ? s_.ka * (c_[kXa][k] - c_[kXs][k]) + s_.ba * (c_[kVa][k] - c_[kVs][k])
                   : skin_[k];
    case_force_[k] = s_.km * i[k] + spring_[k] - coupling - s_.grip_k * c_[kXa][k] -
                     s_.grip_b * c_[kVa][k] + (Signed(mode_) ? mode_.side * stop_[k] : 0);
    body_force_[k] = coupling - skin_[k];
  }

  static bool Signed(const Mode& mode) { return mode.stop == Stop::kEngaged; }

  // k p + c p' with p the penetration on the mode's side.
  Real StopForce(int k) {
    if (mode_.stop != Stop::kEngaged && mode_.stop != Stop::kInside) return 0;
    const Real gap = mode_.side > 0 ? gap_up_ : gap_down_;
    const Real p = mode_.side * d_[k] - (k == 0 ? gap : 0);
    return s_.stop_k * p + s_.stop_c * mode_.side * w_[k];
  }

  void ExpandTerm(int k) {
    Terms(k);
    const Real n = k + 1;
    const Real case_mass = s_.CaseMass();
    c_[kXv][k + 1] = c_[kVv][k] / n;
    c_[kXa][k + 1] = c_[kVa][k] / n;
    Real mover = mover_force_[k] / s_.mv;
    Real motor_case = case_force_[k] / case_mass;
    if (mode_.stop == Stop::kStuck) {
      mover = motor_case = (mover_force_[k] + case_force_[k]) / (s_.mv + case_mass);
      // the force that presses the moving mass on the stop
      stuck_[k] =
          mode_.side * (mover_force_[k] * case_mass - case_force_[k] * s_.mv) / (s_.mv + case_mass);
    }
    c_[kVv][k + 1] = mover / n;
    c_[kVa][k + 1] = motor_case / n;
    c_[kXs][k + 1] = s_.adapter ? c_[kVs][k] / n : 0;
    c_[kVs][k + 1] = s_.adapter ? body_force_[k] / s_.ma2 / n : 0;
    if (!mode_.contact && PadHasMemory()) {
      const Real pad = -((k == 0 ? preload_ : 0) + s_.ks * (c_[kXp][k] - xg_[k])) / s_.bs + vg_[k];
      c_[kXp][k + 1] = pad / n;
    } else {
      c_[kXp][k + 1] = 0;
    }
    if (s_.l > 0)
      c_[kI][k + 1] = (u_[k] - s_.source_r * c_[kI][k] - coil_drop_[k] + s_.km * w_[k]) / s_.l / n;
    if (s_.heat_c > 0)
      c_[kTheta][k + 1] =
          (Product(coil_drop_, c_[kI], k) - c_[kTheta][k] / s_.heat_rth) / s_.heat_c / n;
    else
      c_[kTheta][k + 1] = 0;
  }

  [[nodiscard]] Real StepLength() const {
    Real h = kNever;
    for (int n = 0; n < kStates; ++n) {
      const Real scale = largest_[n];
      if (scale == 0) continue;
      for (const int k : {kOrder - 1, kOrder}) {
        const Real c = std::fabs(c_[n][k]);
        if (c > 0) h = std::min(h, std::pow(s_.tolerance * scale / c, Real(1) / k));
      }
    }
    Real shortest = 0;
    for (const Tone& tone : s_.drive) shortest = std::max(shortest, tone.omega);
    for (const Tone& tone : s_.tremor) shortest = std::max(shortest, tone.omega);
    if (shortest > 0) h = std::min(h, 1 / shortest);
    if (s_.l > 0) h = std::min(h, 4 * s_.l / (s_.r + s_.source_r));
    return h;
  }

  void ListGuards() {
    guards_.clear();
    const auto add = [&](GuardKind kind, const Series& series, Real factor, Real constant) {
      Guard guard{kind, series};
      for (Real& value : guard.g) value *= factor;
      guard.g[0] += constant;
      guards_.push_back(guard);
    };
    if (s_.stops && mode_.stop == Stop::kFree) {
      if (gap_up_ < kNever) add(GuardKind::kGapUp, d_, -1, gap_up_);
      if (gap_down_ < kNever) add(GuardKind::kGapDown, d_, 1, gap_down_);
    }
    if (mode_.stop == Stop::kStuck) {
      stuck_[kOrder] = 0;
      add(GuardKind::kStuckForce, stuck_, 1, 0);
    }
    if (mode_.stop == Stop::kEngaged) add(GuardKind::kStopForce, stop_, 1, 0);
    if (mode_.stop == Stop::kInside) {
      add(GuardKind::kInsideGap, d_, mode_.side, -(mode_.side > 0 ? gap_up_ : gap_down_));
      add(GuardKind::kInsideForce, stop_, -1, 0);
    }
    if (s_.unilateral && mode_.contact) add(GuardKind::kContactForce, contact_force_, 1, 0);
    if (s_.unilateral && !mode_.contact) {
      Series gap{};
      const Series& body = c_[s_.adapter ? kXs : kXa];
      for (int k = 0; k <= kOrder; ++k)
        gap[k] = (PadHasMemory() ? c_[kXp][k] : xg_[k] - (k == 0 ? preload_ / s_.ks : 0)) - body[k];
      add(GuardKind::kSkinGap, gap, 1, 0);
    }
  }

  // Goes on to `limit` at most; whether it was reached.
  bool Step(Real limit) {
    Expand();
    for (int n = 0; n < kStates; ++n) largest_[n] = std::max(largest_[n], std::fabs(x_[n]));
    if (first_) EstimateScales();
    Real h = StepLength();
    bool reaches = false;
    if (t_ + h >= limit) {
      h = limit - t_;
      reaches = true;
    }
    ListGuards();
    const Guard* fallen = nullptr;
    for (const Guard& guard : guards_) {
      int order = 0;
      if (departing_ && departing_kind_ == guard.kind) order = departing_order_;
      const std::vector<Real> rest(guard.g.begin() + order, guard.g.end());
      const Real place = FirstFall(ToBernstein(rest, h), 0, h, 60);
      if (place < kNever && (fallen == nullptr || place < h)) {
        h = place;
        fallen = &guard;
        reaches = false;
      }
    }
    Account(h);
    if (h > 0) {
      for (int n = 0; n < kStates; ++n)
        if (!(n == kI && s_.l == 0)) x_[n] = Value(c_[n], h);
      departing_ = false;
    }
    t_ = reaches ? limit : t_ + h;
    if (fallen != nullptr) {
      crowded_ = h < 1e-15L ? crowded_ + 1 : 0;
      if (crowded_ > 100000) result_.stalled = true;
      const GuardKind kind = fallen->kind;
      Fire(kind);
    }
    return reaches;
  }

  // Scales before anything has moved: what the first terms of the series reach within a step.
  void EstimateScales() {
    first_ = false;
    Real shortest = std::sqrt(s_.kv / s_.mv);
    for (const Tone& tone : s_.drive) shortest = std::max(shortest, tone.omega);
    const Real h = s_.l > 0 ? std::min(1 / shortest, s_.l / s_.r) : 1 / shortest;
    for (int n = 0; n < kStates; ++n) {
      Real power = 1;
      for (int k = 0; k <= 6; ++k) {
        largest_[n] = std::max(largest_[n], std::fabs(c_[n][k]) * power / 1000);
        power *= h;
      }
    }
  }

  void Account(Real h) {
    if (!(h > 0)) return;
    const Series& xs = c_[s_.adapter ? kXs : kXa];
    if (s_.strobe_s > 0) strobe_xs2_ += IntegralOfProduct(xs, xs, h);
    const bool in_window = t_ >= result_.begin;
    if (in_window) {
      result_.xs2 += IntegralOfProduct(xs, xs, h);
      result_.xa2 += IntegralOfProduct(c_[kXa], c_[kXa], h);
      result_.i2 += IntegralOfProduct(c_[kI], c_[kI], h);
      result_.energy += IntegralOfProduct(u_, c_[kI], h);
      // what a moving finger puts in, against the force beyond the preload's
      result_.energy -= IntegralOfProduct(vg_, skin_, h);
    }
    Peaks(d_, h, [&](Real value) {
      result_.peak_run = std::max(result_.peak_run, std::fabs(value));
      if (in_window) result_.peak_window = std::max(result_.peak_window, std::fabs(value));
    });
    if (mode_.contact)
      Peaks(contact_force_, h,
            [&](Real value) { result_.force_least = std::min(result_.force_least, value); });
    else
      result_.force_least = std::min<Real>(result_.force_least, 0);
    if (s_.heat_c > 0)
      Peaks(c_[kTheta], h,
            [&](Real value) { result_.theta_peak = std::max(result_.theta_peak, value); });
  }

  static void Peaks(const Series& c, Real h, const std::function<void(Real)>& take) {
    take(c[0]);
    take(Value(c, h));
    std::vector<Real> rate(kOrder);
    for (int k = 0; k < kOrder; ++k) rate[k] = (k + 1) * c[k + 1];
    Roots(ToBernstein(rate, h), 0, h, 45, [&](Real t) { take(Value(c, t)); });
  }

  void Depart(GuardKind kind, int order) {
    departing_ = true;
    departing_kind_ = kind;
    departing_order_ = order;
  }

  void Count(const char* name) { ++result_.events[name]; }

  void Fire(GuardKind kind) {
    switch (kind) {
      case GuardKind::kGapUp:
        Hit(+1);
        break;
      case GuardKind::kGapDown:
        Hit(-1);
        break;
      case GuardKind::kStuckForce:
        Count("release");
        Depart(mode_.side > 0 ? GuardKind::kGapUp : GuardKind::kGapDown, 3);
        mode_.stop = Stop::kFree;
        break;
      case GuardKind::kStopForce:
        if (s_.stop_c > 0) {
          mode_.stop = Stop::kInside;
          Depart(GuardKind::kInsideForce, 1);
        } else {
          Depart(mode_.side > 0 ? GuardKind::kGapUp : GuardKind::kGapDown, 1);
          mode_.stop = Stop::kFree;
        }
        break;
      case GuardKind::kInsideGap:
        Depart(mode_.side > 0 ? GuardKind::kGapUp : GuardKind::kGapDown, 1);
        mode_.stop = Stop::kFree;
        break;
      case GuardKind::kInsideForce:
        mode_.stop = Stop::kEngaged;
        Depart(GuardKind::kStopForce, 1);
        break;
      case GuardKind::kContactForce:
        Count("take-off");
        x_[kXp] = Skin();
        mode_.contact = false;
        Depart(GuardKind::kSkinGap, PadHasMemory() ? 2 : 1);
        break;
      case GuardKind::kSkinGap:
        Count("landing");
        mode_.contact = true;
        if (!PadHasMemory()) Depart(GuardKind::kContactForce, 1);
        break;
    }
  }

  void Hit(int side) {
    Count(side > 0 ? "up" : "down");
    mode_.side = side;
    const GuardKind gap = side > 0 ? GuardKind::kGapUp : GuardKind::kGapDown;
    const Real edge = side > 0 ? gap_up_ : -gap_down_;
    x_[kXv] = x_[kXa] + edge;
    if (s_.stop_k > 0) {
      mode_.stop = Stop::kEngaged;
      if (s_.stop_c == 0) Depart(GuardKind::kStopForce, 1);
      return;
    }
    const Real m = s_.CaseMass();
    const Real common = (s_.mv * x_[kVv] + m * x_[kVa]) / (s_.mv + m);
    const Real closing = side * (x_[kVv] - x_[kVa]);
    const Real apart = s_.restitution * std::max<Real>(closing, 0);
    x_[kVv] = common - side * apart * m / (s_.mv + m);
    x_[kVa] = common + side * apart * s_.mv / (s_.mv + m);
    if (apart > 1e-12L) {
      Depart(gap, 1);
      return;
    }
    // the bounces have died out: rest, if the bodies are pressed together, else part smoothly
    x_[kVv] = x_[kVa] = common;
    mode_.stop = Stop::kStuck;
    Expand();
    if (stuck_[0] < 0) {
      mode_.stop = Stop::kFree;
      Depart(gap, 2);
      return;
    }
    Count("rest");
  }

  Scene s_;
  Real sag_ = 0, gap_up_ = 0, gap_down_ = 0, preload_ = 0;
  Real t_ = 0;
  std::array<Real, kStates> x_{}, largest_{};
  Mode mode_;
  bool first_ = true, departing_ = false;
  GuardKind departing_kind_ = GuardKind::kGapUp;
  int departing_order_ = 0, crowded_ = 0;
  std::array<Series, kStates> c_{};
  Series u_{}, xg_{}, vg_{}, d_{}, w_{}, square_{}, spring_{}, stop_{}, skin_{}, contact_force_{},
      stuck_{}, mover_force_{}, case_force_{}, body_force_{}, coil_drop_{};
  std::vector<Guard> guards_;
  Real strobe_xs2_ = 0;
  Result result_;
};

bool Read(std::istream& in, Scene& scene) {
  std::map<std::string, Real*> numbers{{"mv", &scene.mv},
                                       {"mc", &scene.mc},
                                       {"kv", &scene.kv},
                                       {"bv", &scene.bv},
                                       {"km", &scene.km},
                                       {"r", &scene.r},
                                       {"l", &scene.l},
                                       {"ma1", &scene.ma1},
                                       {"ma2", &scene.ma2},
                                       {"ka", &scene.ka},
                                       {"ba", &scene.ba},
                                       {"ks", &scene.ks},
                                       {"bs", &scene.bs},
                                       {"preload", &scene.preload},
                                       {"gap_up", &scene.gap_up},
                                       {"gap_down", &scene.gap_down},
                                       {"restitution", &scene.restitution},
                                       {"stop_k", &scene.stop_k},
                                       {"stop_c", &scene.stop_c},
                                       {"k3", &scene.k3},
                                       {"gravity", &scene.gravity},
                                       {"heat_c", &scene.heat_c},
                                       {"heat_rth", &scene.heat_rth},
                                       {"alpha", &scene.alpha},
                                       {"source_r", &scene.source_r},
                                       {"grip_k", &scene.grip_k},
                                       {"grip_b", &scene.grip_b},
                                       {"offset_v", &scene.offset_v},
                                       {"duration", &scene.duration},
                                       {"window", &scene.window},
                                       {"strobe", &scene.strobe_s},
                                       {"tolerance", &scene.tolerance},
                                       {"start_xv", &scene.start[kXv]},
                                       {"start_vv", &scene.start[kVv]},
                                       {"start_xa", &scene.start[kXa]},
                                       {"start_va", &scene.start[kVa]},
                                       {"start_xs", &scene.start[kXs]},
                                       {"start_vs", &scene.start[kVs]},
                                       {"start_i", &scene.start[kI]}};
  std::string line;
  bool any = false;
  while (std::getline(in, line) && !line.empty()) {
    any = true;
    std::istringstream words(line);
    std::string key, value;
    words >> key >> value;
    if (key == "drive" || key == "tremor") {  // amplitude frequency phase
      Tone tone{std::stold(value)};
      words >> value;
      tone.omega = 2 * kPi * std::stold(value);
      if (words >> value) tone.phase = std::stold(value);
      (key == "drive" ? scene.drive : scene.tremor).push_back(tone);
    } else if (key == "envelope" || key == "volts") {  // time value
      Lines& lines = key == "envelope" ? scene.envelope : scene.volts;
      lines.at.push_back(std::stold(value));
      words >> value;
      lines.value.push_back(std::stold(value));
    } else if (key == "adapter") {
      scene.adapter = value == "1";
    } else if (key == "unilateral") {
      scene.unilateral = value == "1";
    } else if (key == "stops") {
      scene.stops = value == "1";
    } else if (numbers.contains(key)) {
      *numbers[key] = std::stold(value);
    } else {
      std::fprintf(stderr, "unknown key %s\n", key.c_str());
      std::exit(2);
    }
  }
  return any;
}

void PrintList(const char* name, const std::vector<Real>& values) {
  std::printf(", \"%s\": [", name);
  for (std::size_t i = 0; i < values.size(); ++i)
    std::printf("%s%.17Lg", i == 0 ? "" : ", ", values[i]);
  std::printf("]");
}

void Print(const Result& r) {
  const Real length = r.end - r.begin;
  std::printf(
      "{\"begin_s\": %.17Lg, \"end_s\": %.17Lg, \"skin_rms_m\": %.19Lg, \"case_rms_m\": %.19Lg, "
      "\"current_rms_a\": %.19Lg, \"power_w\": %.19Lg, \"mover_peak_m\": %.19Lg, "
      "\"mover_peak_of_run_m\": %.19Lg, \"temperature_rise_k\": %.19Lg, \"temperature_peak_k\": "
      "%.19Lg, "
      "\"stalled\": %s",
      r.begin, r.end, std::sqrt(r.xs2 / length), std::sqrt(r.xa2 / length),
      std::sqrt(r.i2 / length), r.energy / length, r.peak_window, r.peak_run, r.theta_end,
      r.theta_peak, r.stalled ? "true" : "false");
  std::printf(", \"contact_force_least_n\": %.19Lg, \"events\": {", r.force_least);
  bool first = true;
  for (const auto& [name, count] : r.events) {
    std::printf("%s\"%s\": %d", first ? "" : ", ", name.c_str(), count);
    first = false;
  }
  std::printf("}");
  if (!r.strobe_xs2.empty()) {
    PrintList("period_mean_square_m2", r.strobe_xs2);
    PrintList("period_mover_m", r.strobe_xv);
    PrintList("period_skin_m", r.strobe_xs);
  }
  std::printf("}\n");
  std::fflush(stdout);
}

}  // namespace

int main() {
  while (true) {
    Scene scene;
    if (!Read(std::cin, scene)) break;
    Print(Integrator(scene).Run());
  }
}
