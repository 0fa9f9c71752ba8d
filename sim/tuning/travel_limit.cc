#include "sim/tuning/travel_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/error.h"
#include "sim/tuning/adapter_cost.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/interval.h"

namespace haptometer::sim {
namespace {

using Complex = std::complex<double>;

// Re(conj(a) b)
double Dot(Complex a, Complex b) { return a.real() * b.real() + a.imag() * b.imag(); }

// a y^2 + 2 b y + c with y = Ma2 w^2 in N/m; at most 0 where the travel is within the limit
struct Excess {
  double a = 0, b = 0, c = 0;
  [[nodiscard]] double At(double y) const { return (a * y + 2 * b) * y + c; }
};

// |p - Q y|^2 - T^2 |d - U y|^2 with the letters of the header
Excess ExcessOf(const TuningProblem& problem, const MotorSource& source,
                const AdapterPoint& point) {
  const double w = source.omega_rad_per_s, T = problem.mover_limit_m;
  const Skin skin = SkinOf(problem, point.contact_area_m2);
  // Ks + Bs s and Ka + Ba s at s = j w, N/m
  const Complex contact(skin.stiffness_n_per_m, skin.damping_n_s_per_m * w);
  const Complex ka(point.adapter.stiffness_n_per_m, point.adapter.damping_n_s_per_m * w);
  const double Mc1 = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  // kc - (Mc + Ma1) w^2, N/m
  const Complex D1 = source.stiffness_n_per_m - Mc1 * w * w;
  const Complex U = 1.0 + D1 / ka;
  const Complex pushed = source.travel_per_case * source.force_n;
  const Complex Q = pushed / ka + source.free_travel_m * U;
  const Complex p = pushed + source.free_travel_m * D1 + Q * contact;
  const Complex d = D1 + U * contact;
  return {.a = std::norm(Q) - T * T * std::norm(U),
          .b = T * T * Dot(d, U) - Dot(p, Q),
          .c = std::norm(p) - T * T * std::norm(d)};
}

// real roots; b and the square root are added with the same sign, so that nothing cancels
std::vector<double> RootsOf(const Excess& excess) {
  const double square = excess.b * excess.b - excess.a * excess.c;
  if (square < 0) return {};
  const double sum = -(excess.b + std::copysign(std::sqrt(square), excess.b));
  std::vector<double> roots;
  if (excess.a != 0) roots.push_back(sum / excess.a);
  if (sum != 0) roots.push_back(excess.c / sum);
  return roots;
}

}  // namespace

double WantedSkinSideMass(const TuningProblem& problem, const MotorSource& source,
                          const AdapterPoint& point) {
  const double w = source.omega_rad_per_s;
  const double Mc1 = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  const std::complex<double> D1 = source.stiffness_n_per_m - Mc1 * w * w;
  const std::complex<double> ka(point.adapter.stiffness_n_per_m,
                                point.adapter.damping_n_s_per_m * w);
  // (Ks + Re Z) / w^2: the real part of the stiffness at the skin vanishes
  const double Ks = SkinOf(problem, point.contact_area_m2).stiffness_n_per_m;
  return (Ks + (D1 * ka / (D1 + ka)).real()) / (w * w);
}

std::optional<double> NearestWithinTravel(const TuningProblem& problem, const MotorSource& source,
                                          const AdapterPoint& point, double wanted_kg) {
  const double w = source.omega_rad_per_s;
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  // |Xs| falls with the distance from the wanted mass: the nearest one within the limit is the best
  const double within_kg = std::clamp(wanted_kg, mass_kg.lower, mass_kg.upper);
  if (std::isinf(problem.mover_limit_m)) return within_kg;
  const Excess excess = ExcessOf(problem, source, point);
  if (excess.At(within_kg * w * w) <= 0) return within_kg;
  std::optional<double> nearest;
  const auto offer = [&](double kg) {
    if (!nearest || std::abs(kg - wanted_kg) < std::abs(*nearest - wanted_kg)) nearest = kg;
  };
  // outside of the limit the candidates are the ends of the bounds and the roots
  for (const double end_kg : {mass_kg.lower, mass_kg.upper}) {
    if (excess.At(end_kg * w * w) <= 0) offer(end_kg);
  }
  // at a root the limit is met, to rounding
  for (const double root : RootsOf(excess)) {
    const double kg = root / (w * w);
    if (kg >= mass_kg.lower && kg <= mass_kg.upper) offer(kg);
  }
  return nearest;
}

double LimitedTravelBound(Objective objective, const TuningProblem& problem,
                          const MotorSource& source, const ReceptorField& receptors) {
  HAPTOMETER_CHECK(objective != Objective::kRmsPerWatt, "{}", Name(objective));
  const double w = source.omega_rad_per_s, q = source.coupling_damping_n_per_m;
  const double F = Abs(source.coil_force_n);
  // F T - q T^2 is largest at T = F / (2 q): a longer travel adds nothing
  const double T = std::min(problem.mover_limit_m, F / (2 * q));
  const double Bs = SkinOf(problem, problem.bounds.contact_area_m2.lower).damping_n_s_per_m;
  // work of the coil's force less that of the mover's own damping, per radian, N m
  const double work_n_m = (F * T - q * T * T) * (1 + source.rounding_allowance + kKeptLimit);
  if (objective == Objective::kSkinPower) return w * work_n_m / 2;
  // |Xs|^2 <= work / (w Bs), and the RMS is |Xs| / sqrt(2)
  const double rms_m = std::sqrt(work_n_m / (w * Bs) / 2);
  if (objective == Objective::kSkinRms) return rms_m;
  return rms_m *
         StimulatedReceptors(receptors, ContactRadius(problem.bounds.contact_area_m2.upper));
}

namespace {

// places per axis
constexpr std::size_t kLattice = 9;

// parts of Ma1's range; uniform in ln(Mc + Ma1) where that range is wide
std::vector<double> MassParts(const Range& mass_kg, double case_mass_kg) {
  const Range moved{.lower = mass_kg.lower + case_mass_kg, .upper = mass_kg.upper + case_mass_kg};
  std::vector<double> parts = EqualSteps({.lower = 0, .upper = 1}, kLattice);
  if (!IsWide(moved)) return parts;
  for (double& part : parts) part = std::min(1.0, PartOf(moved, ScaledAt(moved, part)));
  return parts;
}

// parts of Ba's range; if it begins at 0, in steps of 8 down from the upper end
std::vector<double> DampingParts(const Range& damping) {
  std::vector<double> parts = EqualSteps({.lower = 0, .upper = 1}, kLattice);
  if (damping.lower > 0) return parts;
  for (std::size_t k = 1; k < kLattice; ++k) {
    parts[k] = std::ldexp(1, -3 * static_cast<int>(kLattice - 1 - k));
  }
  return parts;
}

// the x with a x^2 + 2 b x + c = 0, or where the square is nearest to 0
std::array<double, 2> RootsOf(double a, double b, double c) {
  const double square = b * b - a * c;
  if (square <= 0) return {-b / a, -b / a};
  const double sum = -(b + std::copysign(std::sqrt(square), b));
  return {sum / a, c / sum};
}

// the terms of the ridge's equation at one place, all in N/m
struct Ridge {
  double p, Ka, e, b, q;

  // b ((Ka + p)^2 + (e + q)^2) = q (Ka^2 + e^2) + e (p^2 + q^2) solved for Ka
  [[nodiscard]] std::array<double, 2> Springs() const {
    return RootsOf(b - q, b * p, b * (p * p + (e + q) * (e + q)) - q * e * e - e * (p * p + q * q));
  }
  // the same equation solved for p
  [[nodiscard]] std::array<double, 2> Loads() const {
    return RootsOf(b - e, b * Ka,
                   b * (Ka * Ka + (e + q) * (e + q)) - q * (Ka * Ka + e * e) - e * q * q);
  }
};

Ridge RidgeAt(const TuningProblem& problem, const MotorSource& source, const CubePlace& place) {
  const AdapterPoint point = PointOf(problem.bounds, place);
  const double w = source.omega_rad_per_s;
  const double moved_kg = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  return {.p = source.stiffness_n_per_m.real() - moved_kg * w * w,
          .Ka = point.adapter.stiffness_n_per_m,
          .e = point.adapter.damping_n_s_per_m * w,
          .b = SkinOf(problem, point.contact_area_m2).damping_n_s_per_m * w,
          .q = source.stiffness_n_per_m.imag()};
}

// the value within the range; the lower end where the value is not finite
double Within(const Range& range, double value) {
  return std::isfinite(value) ? std::clamp(value, range.lower, range.upper) : range.lower;
}

}  // namespace

std::vector<CubePlace> StartPlaces(const TuningProblem& problem, const MotorSource& source) {
  const AdapterBounds& bounds = problem.bounds;
  const CubePlace upper = UpperEndOf(problem);
  const double square = source.omega_rad_per_s * source.omega_rad_per_s;
  const std::vector<double> even = EqualSteps({.lower = 0, .upper = 1}, kLattice);
  const std::vector<double> lowest{0};
  const std::vector<double> masses = MassParts(bounds.motor_side_mass_kg, source.case_mass_kg);
  const std::vector<double> dampings = DampingParts(bounds.damping_n_s_per_m);

  // the lattice without Ma2, which takes its best value later
  std::vector<CubePlace> places = Lattice(upper, {masses, even, dampings, even});
  // the ridge in Ka, with the other axes on the lattice
  if (upper[1] > 0) {
    for (CubePlace place : Lattice(upper, {masses, lowest, dampings, even})) {
      for (const double Ka : RidgeAt(problem, source, place).Springs()) {
        const Range& range = bounds.stiffness_n_per_m;
        place[1] = std::clamp(ScaledPartOf(range, Within(range, Ka)), 0.0, 1.0);
        places.push_back(place);
      }
    }
  }
  // the ridge in Ma1, from p = Re kc - (Mc + Ma1) w^2
  if (upper[0] > 0) {
    for (CubePlace place : Lattice(upper, {lowest, even, dampings, even})) {
      for (const double p : RidgeAt(problem, source, place).Loads()) {
        const double kg = (source.stiffness_n_per_m.real() - p) / square - source.case_mass_kg;
        const Range& range = bounds.motor_side_mass_kg;
        place[0] = std::clamp(PartOf(range, Within(range, kg)), 0.0, 1.0);
        places.push_back(place);
      }
    }
  }
  return places;
}

namespace {

// a number with its slopes along the five axes of the cube
using CubeNumber = Slope<double, kCubeAxes>;

struct CubePhasor {
  CubeNumber re, im;
};
CubePhasor operator+(const CubePhasor& a, const CubePhasor& b) {
  return {a.re + b.re, a.im + b.im};
}
CubePhasor operator*(const CubePhasor& a, const CubePhasor& b) {
  return {a.re * b.re + a.im * b.im * -1.0, a.re * b.im + a.im * b.re};
}
CubePhasor operator*(const CubePhasor& a, std::complex<double> b) {
  return {a.re * b.real() + a.im * -b.imag(), a.im * b.real() + a.re * b.imag()};
}
// |z|^2
CubeNumber Norm(const CubePhasor& z) { return z.re * z.re + z.im * z.im; }

// linear from the lower to the upper end, with its slope
CubeNumber On(const Range& range, const CubePlace& place, int axis) {
  return Variable<double, kCubeAxes>(place[axis], static_cast<std::size_t>(axis), 1.0) *
             (range.upper - range.lower) +
         range.lower;
}

// Ka or Ba, as ScaledAt() has them
CubeNumber ScaledOn(const Range& range, const CubePlace& place, int axis) {
  if (!IsWide(range)) return On(range, place, axis);
  const double decades = Log(range.upper / range.lower);
  const double value = range.lower * Exp(place[axis] * decades);
  return Variable<double, kCubeAxes>(0.0, static_cast<std::size_t>(axis), value * decades) + value;
}

// slopes of the logarithm, f' / f
CubePlace SlopesOf(const CubeNumber& number) {
  return CubePlace::Map(number.by.data()) / number.value;  // of the logarithm
}

}  // namespace

LimitedClimb::LimitedClimb(Objective objective, const TuningProblem& problem,
                           const MotorSource& source, const ReceptorField& receptors, int hardest)
    : objective_(objective),
      problem_(problem),
      source_(source),
      receptors_(receptors),
      hardest_(hardest),
      upper_(UpperEndOf(problem)),
      first_(SkinOf(problem, problem.bounds.contact_area_m2.lower)),
      last_(SkinOf(problem, problem.bounds.contact_area_m2.upper)) {}

// ln Nr^2 at a part of the area's range
double LimitedClimb::LogWeight(double part) const {
  const double area_m2 = AreaAt(problem_.bounds.contact_area_m2, part);
  return 2 * Log(StimulatedReceptors(receptors_, ContactRadius(area_m2)));
}

LimitedView LimitedClimb::At(const CubePlace& place) const {
  LimitedView view = ViewOf(place, hardest_);
  if (hardest_ == 0) return view;
  // by how much the skin at the other end of Ks moves less than this one
  const LimitedView other = ViewOf(place, -hardest_);
  view.excess = other.cost - view.cost;
  view.excess_slopes = other.cost_slopes - view.cost_slopes;
  return view;
}

// with the skin at the lower (-1) or upper (1) end of what its stiffness varies by, and with the
// largest damping; 0: the skin itself
LimitedView LimitedClimb::ViewOf(const CubePlace& place, int side) const {
  const AdapterBounds& bounds = problem_.bounds;
  const double w = source_.omega_rad_per_s;
  const double stiffer = 1 + side * problem_.skin_variation;
  const double damped = 1 + std::abs(side) * problem_.skin_variation;
  // p = Re D1, D1, ka, b = w Bs and D2 (docs/explanation/notation.md), N/m, with their slopes
  const CubeNumber p = (On(bounds.motor_side_mass_kg, place, 0) + source_.case_mass_kg) * (-w * w) +
                       source_.stiffness_n_per_m.real();
  const CubePhasor D1{p, {.value = source_.stiffness_n_per_m.imag()}};
  const CubePhasor ka{ScaledOn(bounds.stiffness_n_per_m, place, 1),
                      ScaledOn(bounds.damping_n_s_per_m, place, 2) * w};
  const CubeNumber b =
      On({first_.damping_n_s_per_m, last_.damping_n_s_per_m}, place, 3) * (w * damped);
  const CubePhasor D2{On({first_.stiffness_n_per_m, last_.stiffness_n_per_m}, place, 3) * stiffer +
                          On(bounds.skin_side_mass_kg, place, 4) * (-w * w),
                      b};

  // Xs = Fc ka / N, travel = (G (D2 + ka) + f N) / N
  const CubePhasor N = D1 * D2 + ka * (D1 + D2);
  const CubePhasor M =
      (D2 + ka) * (source_.travel_per_case * source_.force_n) + N * source_.free_travel_m;
  const CubeNumber N2 = Norm(N), M2 = Norm(M), k2 = Norm(ka);
  // cost ln |Fc / Xs|^2, excess ln(|travel|^2 / T^2); below zero the limit is kept
  LimitedView view{.cost = Log(N2.value / k2.value),
                   .excess = Log(M2.value / N2.value) - 2 * Log(problem_.mover_limit_m),
                   .cost_slopes = SlopesOf(N2) - SlopesOf(k2),
                   .excess_slopes = SlopesOf(M2) - SlopesOf(N2)};
  // less the logarithm of the objective's weight, 1 for the skin's RMS
  if (objective_ == Objective::kSkinPower) {
    view.cost -= Log(b.value);
    view.cost_slopes -= SlopesOf(b);
  } else if (objective_ == Objective::kRmsPerWatt) {
    // P |N|^2 = P0 |N|^2 + Re(beta Fc (ka + D2) conj N)
    const CubePhasor moved = (D2 + ka) * (source_.power_slope_w_per_m * source_.force_n);
    const CubeNumber power = N2 * source_.blocked_power_w + moved.re * N.re + moved.im * N.im;
    view.cost += 2 * Log(power.value / N2.value);
    view.cost_slopes += 2 * (SlopesOf(power) - SlopesOf(N2));
  } else if (objective_ == Objective::kStimulus) {
    constexpr double kStep = 1e-5;
    // Nr by a central difference, one-sided at the ends of the range
    const double before = std::clamp(place[3] - kStep, 0.0, 1.0);
    const double after = std::clamp(place[3] + kStep, 0.0, 1.0);
    view.cost -= LogWeight(place[3]);
    if (after > before)
      view.cost_slopes[3] -= (LogWeight(after) - LogWeight(before)) / (after - before);
  }
  return view;
}

LimitedSummit LimitedClimb::From(const CubePlace& start) const {
  return ClimbWithinBounds([this](const CubePlace& place) { return At(place); }, CubePlace::Zero(),
                           upper_, start);
}

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

// a place to begin at and its rank: the smaller, the better
struct Start {
  CubePlace place = CubePlace::Zero();
  double rank = kNone;
  void Offer(const CubePlace& other, double other_rank) {
    if (other_rank < rank) *this = {.place = other, .rank = other_rank};
  }
};

// the best starts for each third of Ma1 and of Ka (RMS per watt: of all axes), those within the
// limit and those beyond it
struct Starts {
  std::array<Start, std::size_t{3} * kCubeAxes> kept, beyond;
};

// sets Ma2 to that of the skin's largest motion within its bounds
void ServeBest(const TuningProblem& problem, const MotorSource& source, AdapterPoint& point) {
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  point.adapter.skin_side_mass_kg =
      std::clamp(WantedSkinSideMass(problem, source, point), mass_kg.lower, mass_kg.upper);
}

// Ma2 to begin with: that of the largest |Xs|, for RMS per watt also others around it
std::vector<double> MassesToTry(const AreaPiece& piece, const MotorSource& source,
                                const AdapterPoint& point) {
  const double wanted_kg = WantedSkinSideMass(piece.problem, source, point);
  if (piece.objective != Objective::kRmsPerWatt) return {wanted_kg};
  const double w = source.omega_rad_per_s;
  const double Bs = SkinOf(piece.problem, point.contact_area_m2).damping_n_s_per_m;
  const Range& mass_kg = piece.problem.bounds.skin_side_mass_kg;
  return {wanted_kg, wanted_kg - Bs / w, wanted_kg + Bs / w, mass_kg.lower, mass_kg.upper};
}

Starts StartsOf(const AreaPiece& piece, const MotorSource& source, const LimitedClimb& climb) {
  const TuningProblem& problem = piece.problem;
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  const auto third = [](double part) {
    return std::min<std::size_t>(2, static_cast<std::size_t>(part * 3));
  };
  const int axes = piece.objective == Objective::kRmsPerWatt ? kCubeAxes : 2;
  Starts starts;
  for (CubePlace place : StartPlaces(problem, source)) {
    const AdapterPoint point = PointOf(problem.bounds, place);
    for (const double wanted_kg : MassesToTry(piece, source, point)) {
      // the limit decides on Ma2; where no mass keeps to it, the wanted one within its bounds
      const auto found_kg = NearestWithinTravel(problem, source, point, wanted_kg);
      const double kg = found_kg.value_or(std::clamp(wanted_kg, mass_kg.lower, mass_kg.upper));
      place[4] = PartOf(mass_kg, kg);
      const LimitedView view = climb.At(place);
      auto& kind = found_kg ? starts.kept : starts.beyond;
      // within the limit the cost ranks, beyond it the travel
      const double rank = found_kg ? view.cost : view.excess;
      for (int axis = 0; axis < axes; ++axis) {
        kind[static_cast<std::size_t>(3 * axis) + third(place[axis])].Offer(place, rank);
      }
    }
  }
  return starts;
}

// the best over a piece of areas, with the price of travel there
LimitedBest BestOfPiece(const AreaPiece& piece, const MotorSource& source,
                        const ReceptorField& receptors) {
  const TuningProblem& problem = piece.problem;
  std::optional<LimitedSummit> best;
  // of skins that vary either end of Ks may be the hardest
  const bool varies = problem.skin_variation > 0;
  for (const int hardest : varies ? std::vector{-1, 1} : std::vector{0}) {
    const LimitedClimb climb(piece.objective, problem, source, receptors, hardest);
    const Starts starts = StartsOf(piece, source, climb);
    // starts beyond the limit are used only where none is within it
    const bool any =
        std::ranges::any_of(starts.kept, [](const Start& s) { return s.rank < kNone; });
    for (const Start& start : any ? starts.kept : starts.beyond) {
      if (start.rank == kNone) continue;
      const LimitedSummit summit = climb.From(start.place);
      if (summit.kept && (!best || summit.cost < best->cost)) best = summit;
    }
  }
  if (!best) return {.prices = {0}};
  AdapterPoint point = PointOf(problem.bounds, best->place);
  // there the limit is met to rounding only, and the best Ma2 is known
  if (varies) ServeBest(problem, source, point);
  return {.point = point,
          .value = piece.weight * ValueOf(piece.objective, problem, source, receptors, point),
          .prices = {best->price}};
}

// bound for a piece of areas from the coil's work alone
double RoughBound(const AreaPiece& piece, const MotorSource& source,
                  const ReceptorField& receptors) {
  if (piece.objective == Objective::kRmsPerWatt) return kNone;
  return piece.weight * LimitedTravelBound(piece.objective, piece.problem, source, receptors);
}

// Offers the adapter in the box's middle, and where it is better also the summit above it.
void TryMiddle(const AreaPiece& piece, const MotorSource& source, const ReceptorField& receptors,
               const AdapterBox& box, LimitedBest& best) {
  const AdapterBounds& bounds = piece.problem.bounds;
  const auto offer = [&](const AdapterPoint& point) {
    const double value =
        piece.weight * ValueOf(piece.objective, piece.problem, source, receptors, point);
    if (!(value > best.value)) return false;
    best.point = point;
    best.value = value;
    return true;
  };
  AdapterPoint middle{
      .adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(box[0].middle()),
                  .stiffness_n_per_m = bounds.stiffness_n_per_m.At(box[1].middle()),
                  .damping_n_s_per_m = bounds.damping_n_s_per_m.At(box[2].middle())},
      .contact_area_m2 = AreaAt(bounds.contact_area_m2, box[3].middle())};
  ServeBest(piece.problem, source, middle);
  if (!offer(middle) || piece.problem.skin_variation > 0) return;
  const LimitedClimb climb(piece.objective, piece.problem, source, receptors);
  offer(PointOf(bounds, climb.From(PlaceOf(bounds, middle)).place));
}

}  // namespace

LimitedBest BestWithinTravel(Objective objective, const TuningProblem& problem,
                             const ReceptorField& receptors) {
  HAPTOMETER_CHECK(!Fault(problem), "limit {}, variation {}", problem.mover_limit_m,
                   problem.skin_variation);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  LimitedBest best;
  for (const AreaPiece& piece : PiecesOf(objective, problem, receptors)) {
    best.prices.push_back(-1);
    // a piece that cannot exceed the best so far is not searched
    if (!(RoughBound(piece, source, receptors) > best.value)) continue;
    const LimitedBest found = BestOfPiece(piece, source, receptors);
    best.prices.back() = found.prices[0];
    if (!(found.value > best.value)) continue;
    best.point = found.point;
    best.value = found.value;
  }
  return best;
}

TravelBound BoundWithinTravel(Objective objective, const TuningProblem& problem,
                              const ReceptorField& receptors, double relative_gap,
                              std::size_t most_boxes, LimitedBest& best) {
  const bool steps = HasSteps(objective, receptors);
  const bool limited = std::isfinite(problem.mover_limit_m);
  // a stimulus with soft edges has no bound
  const bool provable = objective == Objective::kSkinRms || objective == Objective::kSkinPower;
  if (!provable && !steps) return {.value = kNone};
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const std::vector<AreaPiece> pieces = PiecesOf(objective, problem, receptors);
  HAPTOMETER_CHECK(pieces.size() == best.prices.size() && best.value > 0, "{} pieces, value {}",
                   pieces.size(), best.value);
  TravelBound bound;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const AreaPiece& piece = pieces[k];
    if (!(piece.weight > 0)) continue;
    const double rough = limited ? RoughBound(piece, source, receptors) : kNone;
    // the bound by the coil's work is already below the best value
    if (!(rough > best.value)) {
      bound.value = std::max(bound.value, rough);
      continue;
    }
    // any price below 1 gives a bound (weak duality, sim/tuning/adapter_cost.h)
    const double price = limited ? std::clamp(best.prices[k], 0.0, 1 - 1e-6) : 0;
    const AdapterCost cost(piece.problem, source, piece.objective == Objective::kSkinPower, price);
    // below this cost an adapter would exceed the value by more than the gap
    const double enough = CostOfValue(piece, source, best.value * (1 + relative_gap));
    const LeastOfBoxes least =
        LeastCost([&](const AdapterBox& box) { return cost.Over(box); }, enough, most_boxes);
    bound.boxes += least.boxes;
    if (!limited) TryMiddle(piece, source, receptors, least.reached, best);
    // both bounds hold, so the smaller one does
    bound.value = std::max(bound.value, std::min(rough, ValueOfCost(piece, source, least.cost)));
  }
  // allowance for the rounding of source and limit: the travel is a difference of two terms; the
  // price is 1 at most, so that the value changes by no more than the limit's square
  const double squares = objective == Objective::kSkinPower ? 2 : 1;  // of an RMS
  const double travel = 1 + Abs(source.free_travel_m) / problem.mover_limit_m;
  bound.value *= 1 + squares * source.rounding_allowance * travel + (limited ? kKeptLimit : 0) +
                 (steps ? kStepAllowance : 0);
  return bound;
}

}  // namespace haptometer::sim
