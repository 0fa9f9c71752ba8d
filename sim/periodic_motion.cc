#include "sim/periodic_motion.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <expected>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/jobs.h"
#include "sim/linear/complex_equations.h"

namespace haptometer::sim {
namespace {

constexpr int kMostHalvings = 8;
// over the map's error: Newton's steps below kDone are not taken, residuals below kFixed are those
// of a fixed point
constexpr double kDone = 3;
constexpr double kFixed = 1e3;
// over each state's largest value: two motions closer than this may be the same
constexpr double kSame = 1e-5;
// of each state's largest value: nothing recurs above kNear, the transient is over within kThere
constexpr double kNear = 0.2;
constexpr double kThere = 1e-7;
// largest error of the linear map over the decay in a period, for the rest to count as known
constexpr double kForetold = 0.3;
// the coil's temperature, which may take 1e6 periods, is led to its value in so many steps
constexpr int kWarmingSteps = 8;
constexpr int kPeriodsPerWarmingStep = 64;
// exponent over 32 x 32 = 1024 periods, averages over 32 x 128 = 4096 (sim/periodic_motion.h)
constexpr int kBatches = 32;
constexpr int kPairPeriodsPerBatch = 32;
constexpr int kMeanPeriodsPerBatch = 128;
constexpr double kSure = 4;  // standard uncertainties

// largest magnitude among states over their scale, dimensionless
double Size(const Eigen::VectorXd& scaled) { return scaled.cwiseAbs().maxCoeff(); }

// The map, whose work a search counts; beyond its limit nothing is known of any point.
class CountedMap {
 public:
  CountedMap(const PeriodMap& map, std::int64_t most_steps, PeriodicSearch& search)
      : map_(map), most_steps_(most_steps), search_(search) {}

  bool IsSpent() const { return search_.steps > most_steps_; }
  std::expected<PeriodStep, FindingKind> After(const PeriodPoint& point, int periods,
                                               bool with_means = false,
                                               const PeriodMap::Visit& visit = {}) {
    if (IsSpent()) return std::unexpected(FindingKind::kTooManySteps);
    auto step = map_.After(point, periods, with_means, visit);
    search_.periods_played += periods;
    if (step) search_.steps += step->steps;
    ReportWork("looking for the steady motion",
               static_cast<double>(search_.steps) / static_cast<double>(most_steps_));
    return step;
  }
  Eigen::VectorXd ScaleOf(const PeriodPoint& point) const { return map_.ScaleOf(point); }
  double error() const { return map_.error(); }
  bool heats() const { return map_.heats(); }

 private:
  const PeriodMap& map_;
  std::int64_t most_steps_;
  PeriodicSearch& search_;
};

// How far two states are apart, over the scale; without the coil's temperature.
double Apart(const CountedMap& map, const PeriodPoint& a, const PeriodPoint& b,
             const Eigen::VectorXd& scale) {
  // coordinates of different modes do not compare
  if (a.mode != b.mode) return std::numeric_limits<double>::infinity();
  const Eigen::Index n = a.x.size() - (map.heats() ? 1 : 0);
  return Size((a.x - b.x).cwiseQuotient(scale).head(n));
}

// The fixed points of P^k near a point.
class Shooting {
 public:
  Shooting(CountedMap& map, int periods, Eigen::VectorXd scale)
      : map_(map), periods_(periods), scale_(std::move(scale)) {}

  struct End {
    PeriodPoint point;
    Eigen::MatrixXd jacobian;
    double residual = 0;
    double error = 0;
  };

  // after Newton's steps; nothing if they do not converge. They end where the step is small, not
  // where the residual is: a slowly decaying state moves little in a period
  std::optional<End> From(PeriodPoint point, int newton_steps) {
    std::optional<Eigen::VectorXd> residual = Residual(point);
    if (!residual) return {};
    std::optional<Eigen::MatrixXd> jacobian = Jacobian(point);
    for (int i = 0; i < newton_steps && jacobian; ++i) {
      if (!TakeStep(*jacobian, point, *residual)) break;
      jacobian = Jacobian(point);
    }
    if (!jacobian || !(Size(*residual) <= kFixed * map_.error())) return {};
    return End{.point = point,
               .jacobian = *jacobian,
               .residual = Size(*residual),
               .error = LeftOf(*jacobian, *residual)};
  }

  // dP^k/dx in units of the scale, one period after the other
  std::optional<Eigen::MatrixXd> Jacobian(const PeriodPoint& point, double larger = 1) {
    // the orbit's points at phase 0 of the drive, one per period
    std::vector<PeriodPoint> points{point};
    if (!map_.After(point, periods_, false, [&](const PeriodPoint& p) { points.push_back(p); })) {
      return {};
    }
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(point.x.size(), point.x.size());
    Eigen::VectorXd scale = scale_;
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      // a closed orbit ends in the scale in which it began, so that M has true eigenvalues
      const bool closes = k + 2 == points.size() && points[k + 1].mode == point.mode;
      const Eigen::VectorXd next = closes ? scale_ : map_.ScaleOf(points[k + 1]);
      const auto one = JacobianOfOne(points[k], points[k + 1], scale, next, larger);
      if (!one) return {};
      // chain rule along the orbit: M = M_k ... M_2 M_1
      jacobian = (*one * jacobian).eval();
      scale = next;
    }
    return jacobian;
  }

  // how far a point is from where it returns to after other periods
  std::optional<double> ReturnsWithin(const PeriodPoint& point, int periods) {
    const std::optional<PeriodPoint> end = After(point, periods);
    if (!end || end->mode != point.mode) return {};
    return Size((end->x - point.x).cwiseQuotient(scale_));
  }

 private:
  // by central differences; shorter ones where the ends lie in other modes
  std::optional<Eigen::MatrixXd> JacobianOfOne(const PeriodPoint& from, const PeriodPoint& to,
                                               const Eigen::VectorXd& scale,
                                               const Eigen::VectorXd& scale_after, double larger) {
    constexpr int kMostTries = 3;
    // the cube root balances the truncation, step^2, and the map's error over the step
    double step = larger * Cbrt(map_.error());
    for (int i = 0; i < kMostTries; ++i, step /= 8) {
      Eigen::MatrixXd jacobian(to.x.size(), from.x.size());
      Eigen::Index k = 0;
      for (; k < from.x.size(); ++k) {
        std::array<PeriodPoint, 2> moved{from, from};
        moved[0].x(k) -= step * scale(k);
        moved[1].x(k) += step * scale(k);
        const std::optional<PeriodPoint> below = After(moved[0], 1), above = After(moved[1], 1);
        // a difference across two modes is no derivative: try again with an eighth of the step
        if (!below || !above || below->mode != to.mode || above->mode != to.mode) break;
        jacobian.col(k) = (above->x - below->x).cwiseQuotient(scale_after) / (2 * step);
      }
      if (k == from.x.size()) return jacobian;
    }
    return {};
  }

  std::optional<PeriodPoint> After(const PeriodPoint& point, int periods) {
    auto step = map_.After(point, periods);
    if (!step || !step->point.x.allFinite()) return {};
    return std::move(step->point);
  }

  // P^k(x) - x in units of the scale
  std::optional<Eigen::VectorXd> Residual(const PeriodPoint& point) {
    const std::optional<PeriodPoint> end = After(point, periods_);
    if (!end || end->mode != point.mode) return {};
    return (end->x - point.x).cwiseQuotient(scale_);
  }

  // bound of the distance to the fixed point, abs((I - M)^-1) abs(residual)
  static double LeftOf(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual) {
    const Eigen::Index n = jacobian.rows();
    const Eigen::MatrixXd inverse = (Eigen::MatrixXd::Identity(n, n) - jacobian).inverse();
    return (inverse.cwiseAbs() * residual.cwiseAbs()).maxCoeff();
  }

  // Takes the largest halved part of Newton's step for which the next step by the same Jacobian is
  // clearly smaller (Deuflhard's natural test: residuals of slow and fast states do not compare);
  // false if there is none, or if the step is within the map's error.
  bool TakeStep(const Eigen::MatrixXd& jacobian, PeriodPoint& point, Eigen::VectorXd& residual) {
    const Eigen::Index n = point.x.size();
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(n, n) - jacobian);
    // (I - M) step = P^k(x) - x
    const Eigen::VectorXd step = lu.solve(residual);
    if (!(Size(step) > kDone * map_.error())) return false;
    double part = 1;
    for (int i = 0; i < kMostHalvings; ++i, part /= 2) {
      PeriodPoint moved = point;
      moved.x += part * step.cwiseProduct(scale_);
      const std::optional<Eigen::VectorXd> left = Residual(moved);
      // a part p of the step must reduce the next one at least to 1 - p/2
      if (!left || !(Size(lu.solve(*left)) < (1 - part / 2) * Size(step))) continue;
      point = std::move(moved);
      residual = *left;
      return true;
    }
    return false;
  }

  CountedMap& map_;
  int periods_;
  Eigen::VectorXd scale_;
};

Eigen::VectorXcd LargestFirst(Eigen::VectorXcd values) {
  std::ranges::sort(values, [](const auto& a, const auto& b) { return Abs(a) > Abs(b); });
  return values;
}

// largest magnitude of a Floquet multiplier
double Largest(const Eigen::MatrixXd& jacobian) {
  return Magnitudes(jacobian.eigenvalues()).maxCoeff();
}

// Whether deviations decay beyond doubt: the error of the differences is about their step's square,
// map_error^(2/3); nearer to 1 it is measured by differences of three times the step.
bool IsStable(Shooting& shooting, const Shooting::End& end, double map_error) {
  const double largest = Largest(end.jacobian);
  if (largest < 1 - 10 * Pow(map_error, 2.0 / 3)) return true;
  if (!(largest < 1)) return false;
  const std::optional<Eigen::MatrixXd> again = shooting.Jacobian(end.point, 3);
  return again && largest < 1 - 10 * std::abs(Largest(*again) - largest);
}

// A periodic motion with the Jacobian and the scale that its stability was determined from.
struct Shot {
  PeriodicMotion motion;
  Eigen::MatrixXd jacobian;  // empty: none
  Eigen::VectorXd scale;
};

Shot ShotOf(const Shooting::End& end, int periods, bool stable, const Eigen::VectorXd& scale) {
  return Shot{.motion = {.drive_periods = periods,
                         .point = end.point,
                         .multipliers = LargestFirst(end.jacobian.eigenvalues()),
                         .stable = stable,
                         .residual = end.residual,
                         .error = end.error},
              .jacobian = end.jacobian,
              .scale = scale};
}

// The stable motion of a shorter period of which a motion is a repetition. With a multiplier near
// -1 its point may differ from the longer motion's by more than the residual.
std::optional<Shot> ShortestOf(CountedMap& map, const Shooting::End& end, int periods,
                               const Eigen::VectorXd& scale, int newton_steps) {
  for (int part = 1; part < periods; ++part) {
    if (periods % part != 0) continue;
    Shooting shooting(map, part, scale);
    const std::optional<double> apart = shooting.ReturnsWithin(end.point, part);
    if (!apart || *apart > kSame) continue;
    const std::optional<Shooting::End> shorter = shooting.From(end.point, newton_steps);
    // it must be the same motion, and not another fixed point nearby
    if (!shorter || Apart(map, shorter->point, end.point, scale) > kSame) continue;
    if (IsStable(shooting, *shorter, map.error())) return ShotOf(*shorter, part, true, scale);
  }
  return {};
}

std::optional<Shot> Shoot(CountedMap& map, const PeriodPoint& from, int periods, int newton_steps) {
  const Eigen::VectorXd scale = map.ScaleOf(from);
  Shooting shooting(map, periods, scale);
  const std::optional<Shooting::End> end = shooting.From(from, newton_steps);
  if (!end) return {};
  if (auto shorter = ShortestOf(map, *end, periods, scale, newton_steps)) return shorter;
  return ShotOf(*end, periods, IsStable(shooting, *end, map.error()), scale);
}

// Runs the search.
class Search {
 public:
  Search(const PeriodMap& map, const PeriodicSettings& settings)
      : settings_(settings), map_(map, settings.most_steps, search_) {}

  PeriodicSearch From(const PeriodPoint& start) {
    Remember(start);
    // the transient's length is doubled until a motion is found or a limit is reached
    for (int until = settings_.transient_periods;; until *= 2) {
      if (!Advance(until - transient_)) break;
      if (Look() || stall_) break;
      if (2 * until > settings_.most_periods || map_.IsSpent()) break;
    }
    // no repetition seen: chaos, quasi-periodic motion or a longer period
    if (!search_.found && !stall_ && !map_.IsSpent()) JudgeWhatIsLeft();
    if (!search_.found && !search_.chaotic) search_.refusal = Refusal();
    return std::move(search_);
  }

 private:
  [[nodiscard]] const PeriodPoint& Now() const { return points_.back(); }

  void Remember(const PeriodPoint& point) {
    points_.push_back(point);
    if (points_.size() > kMostDrivePeriods + 1) points_.pop_front();
  }

  // continues the transient; false: it stalls or the work is spent
  bool Advance(int periods) {
    constexpr int kPeriodsAtOnce = 64;
    for (int left = periods; left > 0; left -= kPeriodsAtOnce) {
      const int now = std::min(left, kPeriodsAtOnce);
      const PeriodPoint from = Now();
      const auto step = map_.After(from, now, false, [&](const PeriodPoint& p) { Remember(p); });
      transient_ += now;
      if (step) continue;
      if (!map_.IsSpent()) stall_ = step.error();
      return false;
    }
    return true;
  }

  // the periods after which the state seems to recur, the most probable first
  std::vector<int> Recurrences() {
    const Eigen::VectorXd scale = map_.ScaleOf(Now());
    // distance of the present point from that k periods earlier, k = 1 to 32
    std::vector<double> apart;
    for (std::size_t k = 1; k < points_.size(); ++k) {
      apart.push_back(Apart(map_, Now(), points_[points_.size() - 1 - k], scale));
    }
    nearest_ =
        apart.empty() ? std::numeric_limits<double>::infinity() : *std::ranges::min_element(apart);
    std::vector<int> periods;
    // the smallest k within 3 times the least distance, then the smallest within 30 times
    for (const double within : {3.0, 30.0}) {
      const auto first = std::ranges::find_if(apart, [&](double a) {
        return a <= kNear && a <= within * std::max(nearest_, kFixed * map_.error());
      });
      if (first == apart.end()) continue;
      const int k = static_cast<int>(first - apart.begin()) + 1;
      if (std::ranges::find(periods, k) == periods.end()) periods.push_back(k);
    }
    return periods;
  }

  // Searches for a periodic motion near the transient's last point; true: found.
  bool Look() {
    for (const int periods : Recurrences()) {
      std::optional<Shot> shot = Shoot(map_, Now(), periods, settings_.newton_steps);
      // a repetition to the map's error counts even without a derivative (graze, change of mode)
      if (!shot && nearest_ <= kFixed * map_.error()) shot = AsItRecurs(periods);
      if (!shot || !shot->motion.stable) continue;
      // a stable motion that the transient does not reach is no answer
      if (!Settles(*shot)) return false;
      return Take(std::move(*shot));
    }
    return false;
  }

  // the transient's own end, where the map has no derivative that Newton could use
  Shot AsItRecurs(int periods) {
    return {.motion = {.drive_periods = periods,
                       .point = Now(),
                       .multipliers = {},
                       .stable = true,
                       .residual = nearest_,
                       .error = kFixed * nearest_},
            .jacobian = {},
            .scale = map_.ScaleOf(Now())};
  }

  bool Take(Shot shot) {
    // once more over the whole period, for the means
    auto whole = map_.After(shot.motion.point, shot.motion.drive_periods, true);
    if (!whole) return false;
    shot.motion.means = std::move(*whole->means);
    search_.found = std::move(shot.motion);
    return true;
  }

  // Whether the transient reaches the motion.
  bool Settles(Shot& shot) {
    constexpr int kPeriodsBetween = 64;
    const int k = shot.motion.drive_periods;
    // the temperature is led to its value, the other states must reach theirs
    if (map_.heats() && !Warm(shot.motion)) return false;
    double apart = Apart(map_, Now(), shot.motion.point, shot.scale);
    for (int setbacks = 0; transient_ < 2 * settings_.most_periods;) {
      if (apart <= std::max(kThere, kFixed * map_.error())) return true;
      const double before = apart;
      if (!Advance(k * std::max(1, kPeriodsBetween / k))) return false;
      apart = Apart(map_, Now(), shot.motion.point, shot.scale);
      // slow decay: the rest of it is known from the linear map
      if (apart > before / 2 && IsForetold(shot, apart)) return true;
      // two increases of the distance are allowed, the third is a divergence
      if (!(apart < before) && ++setbacks > 2) return false;
    }
    return false;
  }

  // leads the coil's temperature to the motion's in equal steps, each with periods to decay
  bool Warm(const PeriodicMotion& motion) {
    const Eigen::Index theta = motion.point.x.size() - 1;
    const int k = motion.drive_periods;
    const double begin_k = Now().x(Now().x.size() - 1), end_k = motion.point.x(theta);
    for (int step = 1; step <= kWarmingSteps; ++step) {
      PeriodPoint warmer = Now();
      warmer.x(warmer.x.size() - 1) = begin_k + (end_k - begin_k) * step / kWarmingSteps;
      Remember(warmer);
      if (!Advance(k * std::max(1, kPeriodsPerWarmingStep / k))) return false;
    }
    return true;
  }

  // whether the linear map predicts the deviation after the next periods, with an error far below
  // the decay in them
  bool IsForetold(const Shot& shot, double apart) {
    if (shot.jacobian.size() == 0 || Now().mode != shot.motion.point.mode) return false;
    const auto after = map_.After(Now(), shot.motion.drive_periods);
    if (!after || after->point.mode != shot.motion.point.mode) return false;
    const auto deviation = [&](const PeriodPoint& point) -> Eigen::VectorXd {
      return (point.x - shot.motion.point.x).cwiseQuotient(shot.scale);
    };
    // d(n + 1) - M d(n), zero for a linear map; d is the deviation from the motion over the scale
    const double missed = Size(deviation(after->point) - shot.jacobian * deviation(Now()));
    // the decay by the slowest multiplier
    const double taken = (1 - Abs(shot.motion.multipliers(0))) * apart;
    return missed <= kForetold * taken + kFixed * map_.error();
  }

  // --------------------------------------------------------------------------------- no repetition

  // the exponent, a last search, and averages where the exponent is positive
  void JudgeWhatIsLeft() {
    if (!MeasureExponent()) return;
    // the exponent has prolonged the transient by 1024 periods, so a motion may now recur
    if (Look() || map_.IsSpent()) return;
    if (exponent_ > kSure * exponent_uncertainty_) Average();
  }

  // Benettin's pair of motions, batch by batch: mean of ln(growth of their distance) per period
  bool MeasureExponent() {
    const double apart = std::sqrt(map_.error());
    std::vector<double> batches;
    Eigen::VectorXd way = Eigen::VectorXd::Constant(Now().x.size(), apart);
    for (int batch = 0; batch < kBatches; ++batch) {
      double sum = 0;
      int counted = 0;
      for (int i = 0; i < kPairPeriodsPerBatch; ++i) {
        const Eigen::VectorXd scale = map_.ScaleOf(Now());
        if (way.size() != scale.size()) way = Eigen::VectorXd::Constant(scale.size(), apart);
        PeriodPoint beside = Now();
        // the neighbour is set back to the initial distance before each period
        beside.x += way.normalized().cwiseProduct(scale) * apart;
        const auto other = map_.After(beside, 1);
        if (!other || !Advance(1)) return false;
        // in different modes the pair has no distance: the period does not count
        if (other->point.mode != Now().mode) continue;
        way = (other->point.x - Now().x).cwiseQuotient(map_.ScaleOf(Now()));
        sum += Log(way.norm() / apart);
        ++counted;
      }
      if (counted > 0) batches.push_back(sum / counted);
    }
    if (batches.size() < kBatches / 2) return true;
    const auto [mean, uncertainty] = MeanOf(batches);
    exponent_ = mean;
    exponent_uncertainty_ = uncertainty;
    is_measured_ = true;
    return true;
  }

  // mean and its standard uncertainty
  static std::pair<double, double> MeanOf(const std::vector<double>& batches) {
    const auto count = static_cast<double>(batches.size());
    double mean = 0, square = 0;
    for (const double value : batches) mean += value / count;
    for (const double value : batches) square += (value - mean) * (value - mean);
    // s / sqrt(n), s the standard deviation of the batches
    return {mean, std::sqrt(square / (count - 1) / count)};
  }

  // Whether batches are alike. If one holds most of their variance, it contains something rare that
  // the others lack: then neither the mean nor its uncertainty is known. (Of 32 normal ones the
  // largest holds about a fifth; more than half once in 1e5.)
  static bool AreAlike(const std::vector<double>& batches, double mean) {
    constexpr double kMostOfOne = 0.5;
    double sum = 0, largest = 0;
    for (const double value : batches) {
      const double square = (value - mean) * (value - mean);
      sum += square;
      largest = std::max(largest, square);
    }
    return largest <= kMostOfOne * sum;
  }

  void Average() {
    std::vector<PeriodMeans> batches;
    ChaoticMotion chaotic{.point = Now(),
                          .exponent = exponent_,
                          .exponent_standard_uncertainty = exponent_uncertainty_,
                          .periods = kBatches * kMeanPeriodsPerBatch,
                          .means = {},
                          .standard_uncertainties = {}};
    // means over each batch, along one continued motion
    for (int batch = 0; batch < kBatches; ++batch) {
      const auto step = map_.After(Now(), kMeanPeriodsPerBatch, true);
      if (!step) return;
      Remember(step->point);
      batches.push_back(*step->means);
    }
    bool are_alike = true;
    // mean of one quantity over the batches, with its standard uncertainty
    const auto fill = [&](auto&& field) {
      std::vector<double> values;
      values.reserve(batches.size());
      for (PeriodMeans& batch : batches) values.push_back(field(batch));
      const auto [mean, uncertainty] = MeanOf(values);
      are_alike = are_alike && AreAlike(values, mean);
      field(chaotic.means) = mean;
      field(chaotic.standard_uncertainties) = uncertainty;
    };
    // for their size; fill() replaces the values
    chaotic.means.mean_squares = batches[0].mean_squares;
    chaotic.standard_uncertainties.mean_squares = batches[0].mean_squares;
    for (Eigen::Index k = 0; k < batches[0].mean_squares.size(); ++k) {
      fill([k](PeriodMeans& means) -> double& { return means.mean_squares(k); });
    }
    fill([](PeriodMeans& means) -> double& { return means.travel_mean_square; });
    fill([](PeriodMeans& means) -> double& { return means.power_w; });
    fill([](PeriodMeans& means) -> double& { return means.coil_w; });
    is_rare_ = !are_alike;
    if (are_alike) search_.chaotic = std::move(chaotic);
  }

  Finding Refusal() const {
    if (stall_) return {Severity::kRefusal, *stall_, {{"periods", transient_}}};
    // what was observed and the work it took, for the message
    Finding none{Severity::kRefusal,
                 FindingKind::kNoPeriodicMotion,
                 {{"most_periods", kMostDrivePeriods},
                  {"transient_periods", transient_},
                  {"periods", search_.periods_played},
                  {"steps", search_.steps}}};
    if (is_measured_) {
      none.numbers.emplace_back("growth", exponent_);
      none.numbers.emplace_back("growth_uncertainty", exponent_uncertainty_);
    }
    if (is_rare_) none.numbers.emplace_back("averaged_periods", kBatches * kMeanPeriodsPerBatch);
    if (std::isfinite(nearest_)) none.numbers.emplace_back("nearest_recurrence", nearest_);
    if (map_.IsSpent()) none.numbers.emplace_back("most_steps", settings_.most_steps);
    return none;
  }

  PeriodicSettings settings_;
  PeriodicSearch search_;
  CountedMap map_;
  std::deque<PeriodPoint> points_;  // of the last 33 periods
  int transient_ = 0;
  std::optional<FindingKind> stall_;
  double nearest_ = std::numeric_limits<double>::infinity();
  double exponent_ = 0, exponent_uncertainty_ = 0;
  bool is_measured_ = false;
  bool is_rare_ = false;
};

}  // namespace

PeriodicSearch FindPeriodicMotion(const PeriodMap& map, const PeriodPoint& start,
                                  const PeriodicSettings& settings) {
  return Search(map, settings).From(start);
}

std::optional<PeriodicMotion> RefinePeriodicMotion(const PeriodMap& map,
                                                   const PeriodicMotion& motion,
                                                   const PeriodicSettings& settings,
                                                   PeriodicSearch& search) {
  CountedMap counted(map, settings.most_steps, search);
  std::optional<Shot> shot =
      Shoot(counted, motion.point, motion.drive_periods, settings.newton_steps);
  // a shorter period or lost stability is another motion
  if (!shot || !shot->motion.stable || shot->motion.drive_periods != motion.drive_periods)
    return {};
  auto whole = counted.After(shot->motion.point, motion.drive_periods, true);
  if (!whole) return {};
  shot->motion.means = std::move(*whole->means);
  return std::move(shot->motion);
}

}  // namespace haptometer::sim
