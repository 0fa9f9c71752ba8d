#include "sim/tuning/latency_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "sim/effective_scene.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/travel_limit.h"
#include "sim/waveforms.h"

namespace haptometer::sim {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// outputs of a run, 0.1 s of work
constexpr double kMostLatencyOutputs = 1e6;

// the adapter from rest under the problem's sine
Scene SceneOf(const TuningProblem& problem, const AdapterPoint& point) {
  Scene scene;
  scene.actuator = problem.actuator;
  scene.adapter = point.adapter;
  scene.skin = SkinOf(problem, point.contact_area_m2);
  scene.drive.amplitude_v = problem.drive.amplitude_v;
  scene.drive.frequency_hz = problem.drive.frequency_hz;
  scene.duration_s = LatencyRunS(problem);
  return scene;
}

EffectiveScene RunOf(const TuningProblem& problem, const AdapterPoint& point) {
  return {.scene = SceneOf(problem, point), .piecewise = {}};
}

bool HasTooManyOutputs(const EffectiveScene& run) {
  return !(*run.scene.duration_s * run.RateHz() <= kMostLatencyOutputs);
}

// an adapter that was run
struct Tried {
  CubePlace place = CubePlace::Zero();
  double cost = kNever;
  double latency_s = kNever;  // at most, with its uncertainty
};

// where a climb in steps of that length ended
struct Summit {
  Tried top;
  double step = 0;
};

class LatencySearch {
 public:
  LatencySearch(const TuningProblem& problem, const MotorSource& source, double limit_s)
      : problem_(problem),
        source_(source),
        climb_(Objective::kSkinRms, problem, source, {}),
        limit_s_(limit_s),
        upper_(UpperEndOf(problem)) {}

  // the adapter at a place by its own run, which is remembered
  [[nodiscard]] Tried Run(const CubePlace& place);
  [[nodiscard]] bool Prompt(const Tried& tried) const { return tried.latency_s <= limit_s_; }
  [[nodiscard]] std::size_t runs() const { return tried_.size(); }
  [[nodiscard]] double least_uncertainty_s() const { return least_uncertainty_s_; }

  std::vector<Tried> Starts();
  // slopes are differences over `step`; 20 of it are trusted at first
  Tried ClimbFrom(Tried here, double step);

 private:
  [[nodiscard]] std::vector<CubePlace> Places() const;
  [[nodiscard]] CubePlace ScaleAt(const CubePlace& place) const;
  [[nodiscard]] CubePlace SlopesAt(const Tried& here, double width);
  [[nodiscard]] CubePlace Step(const Tried& here, const CubePlace& slopes, double offset_s,
                               double radius) const;
  [[nodiscard]] std::optional<Tried> Better(const Tried& here, const CubePlace& slopes,
                                            double& radius);

  const TuningProblem& problem_;
  const MotorSource& source_;
  LimitedClimb climb_;
  double limit_s_;
  CubePlace upper_;
  std::map<std::array<double, kCubeAxes>, Tried> tried_;
  std::vector<Summit> summits_;
  double least_uncertainty_s_ = kNever;
};

Tried LatencySearch::Run(const CubePlace& place) {
  // climbs return to the same places: each is run once
  std::array<double, kCubeAxes> key{};
  std::ranges::copy(place, key.begin());
  const auto known = tried_.find(key);
  if (known != tried_.end()) return known->second;
  const auto rise = RiseWith(problem_, PointOf(problem_.bounds, place));
  if (rise) least_uncertainty_s_ = std::min(least_uncertainty_s_, rise->uncertainty_s);
  const Tried tried{.place = place,
                    // ln |Fc / Xs|^2 of the steady motion, without a limit of travel
                    .cost = climb_.At(place).cost,
                    .latency_s = rise ? rise->LatencyAtMostS() : kNever};
  tried_.emplace(key, tried);
  return tried;
}

// a lattice of Ma1, Ka, Ba and the area, with Ma2 at and around that of the largest RMS
std::vector<CubePlace> LatencySearch::Places() const {
  const std::vector<double> springs = EqualSteps({.lower = 0, .upper = 1}, 9);
  const Range& mass_kg = problem_.bounds.skin_side_mass_kg;
  std::vector<CubePlace> places;
  for (CubePlace place : Lattice(upper_, {{{0, 0.5, 1}, springs, {0, 1}, {0, 1}}})) {
    const AdapterPoint point = PointOf(problem_.bounds, place);
    const double wanted_kg = WantedSkinSideMass(problem_, source_, point);
    for (const double part : {1.0, 0.6, 1.6}) {
      place[4] = PartOf(mass_kg, std::clamp(part * wanted_kg, mass_kg.lower, mass_kg.upper));
      places.push_back(place);
    }
  }
  return places;
}

// The first places within the limit by rising cost, apart from each other; without any, the one
// with the least latency.
std::vector<Tried> LatencySearch::Starts() {
  constexpr std::size_t kMostStarts = 3;
  constexpr double kApart = 0.2;
  std::vector<CubePlace> places = Places();
  std::ranges::sort(places, {}, [&](const CubePlace& place) { return climb_.At(place).cost; });
  std::vector<Tried> starts;
  Tried promptest;
  for (const CubePlace& place : places) {
    const bool near = std::ranges::any_of(
        starts, [&](const Tried& start) { return (start.place - place).norm() < kApart; });
    if (near) continue;
    const Tried tried = Run(place);
    if (tried.latency_s < promptest.latency_s) promptest = tried;
    if (Prompt(tried)) starts.push_back(tried);
    if (starts.size() == kMostStarts) break;
  }
  if (starts.empty() && promptest.latency_s < kNever) starts.push_back(promptest);
  return starts;
}

// Over how much of each axis the latency is assumed linear, as a part of its range: small numbers
// matter by their own size, 0.1 g to a mass of 0.5 g.
CubePlace LatencySearch::ScaleAt(const CubePlace& place) const {
  const AdapterBounds& bounds = problem_.bounds;
  const Adapter adapter = PointOf(bounds, place).adapter;
  const auto scale = [](double value, const Range& range) {
    return range.lower < range.upper ? std::min(1.0, 4 * value / (range.upper - range.lower)) : 1;
  };
  return {scale(adapter.motor_side_mass_kg, bounds.motor_side_mass_kg),
          scale(adapter.stiffness_n_per_m, bounds.stiffness_n_per_m),
          scale(adapter.damping_n_s_per_m, bounds.damping_n_s_per_m), 1,
          scale(adapter.skin_side_mass_kg, bounds.skin_side_mass_kg)};
}

// slopes of the latency by differences over a width of each range, backwards at its upper end
CubePlace LatencySearch::SlopesAt(const Tried& here, double width) {
  const CubePlace widths = width * ScaleAt(here.place).cwiseMax(1e-3);
  CubePlace slopes = CubePlace::Zero();
  for (int axis = 0; axis < kCubeAxes; ++axis) {
    if (upper_[axis] == 0) continue;
    const double step = here.place[axis] + widths[axis] <= 1 ? widths[axis] : -widths[axis];
    const Tried beside = Run(here.place + step * CubePlace::Unit(axis));
    if (beside.latency_s < kNever) slopes[axis] = (beside.latency_s - here.latency_s) / step;
  }
  return slopes;
}

// the largest RMS within the radius for which the linear latency plus an offset is in the limit
CubePlace LatencySearch::Step(const Tried& here, const CubePlace& slopes, double offset_s,
                              double radius) const {
  const auto view = [&](const CubePlace& place) {
    LimitedView at = climb_.At(place);
    const double line_s = here.latency_s + offset_s + slopes.dot(place - here.place);
    // relative excess of the linear latency over the limit
    at.excess = line_s / limit_s_ - 1;
    at.excess_slopes = slopes / limit_s_;
    return at;
  };
  const CubePlace reach = radius * ScaleAt(here.place).cwiseMax(1e-3);
  return ClimbWithinBounds(view, (here.place - reach).cwiseMax(0.0),
                           (here.place + reach).cwiseMin(upper_), here.place)
      .place;
}

// A better adapter within the radius of trust, which shrinks where there is none and doubles where
// there is.
std::optional<Tried> LatencySearch::Better(const Tried& here, const CubePlace& slopes,
                                           double& radius) {
  constexpr double kLeastRadius = 1e-4, kMostRadius = 0.5;
  constexpr int kCorrections = 3;
  constexpr double kMarginS = 1e-8;  // so that a correction ends on the limit's better side
  while (radius > kLeastRadius) {
    double offset_s = 0;
    for (int count = 0; count < kCorrections; ++count) {
      Tried next = Run(Step(here, slopes, offset_s, radius));
      // better is a larger RMS within the limit, or less latency outside of it
      const bool better = Prompt(next) ? !Prompt(here) || next.cost < here.cost - 1e-9
                                       : !Prompt(here) && next.latency_s < here.latency_s;
      if (better) {
        radius = std::min(kMostRadius, 2 * radius);
        return next;
      }
      if (Prompt(next) || next.latency_s == kNever) break;
      // the error of the straight line, added to the next one
      offset_s = next.latency_s - here.latency_s - slopes.dot(next.place - here.place) + kMarginS;
    }
    radius /= 4;
  }
  return std::nullopt;
}

Tried LatencySearch::ClimbFrom(Tried here, double step) {
  constexpr int kMostSteps = 25;
  constexpr double kSameHill = 1e-3;
  double radius = 20 * step;
  for (int count = 0; count < kMostSteps; ++count) {
    const auto next = Better(here, SlopesAt(here, step), radius);
    if (!next) break;
    // a gain below 1e-7 of the cost's logarithm ends the climb
    const bool settled = Prompt(here) && here.cost - next->cost < 1e-7;
    here = *next;
    if (settled) break;
    // a climb that reaches a known summit would repeat its runs
    const auto known = std::ranges::find_if(summits_, [&](const Summit& summit) {
      return summit.step <= step && (summit.top.place - here.place).norm() < kSameHill;
    });
    if (known != summits_.end()) return known->top;
  }
  summits_.push_back({.top = here, .step = step});
  return here;
}

}  // namespace

double LatencyRunS(const TuningProblem& problem) {
  // 0.5 s or 40 periods, whichever is longer, in whole milliseconds
  return std::ceil(1e3 * std::max(0.5, 40 / problem.drive.frequency_hz)) / 1e3;
}

bool RunIsTooLong(const TuningProblem& problem, const AdapterPoint& point) {
  return HasTooManyOutputs(RunOf(problem, point));
}

std::optional<SkinRise> RiseWith(const TuningProblem& problem, const AdapterPoint& point) {
  const EffectiveScene scene = RunOf(problem, point);
  if (HasTooManyOutputs(scene)) return std::nullopt;
  const double duration_s = *scene.scene.duration_s;
  const Waveforms played = PlayWaveforms(scene, BeginningOf(scene), duration_s, scene.RateHz());
  const double end_s = static_cast<double>(played.rows() - 1) / played.rate_hz;
  return RiseOf({played.skin_m.data(), static_cast<std::size_t>(played.rows())}, played.rate_hz,
                problem.drive.frequency_hz, {.end_s = end_s});
}

PromptBest BestWithinLatency(const TuningProblem& problem, double limit_s,
                             const AdapterPoint& unlimited) {
  HAPTOMETER_CHECK(!Fault(problem) && problem.skin_variation == 0 && limit_s > 0 &&
                       std::isinf(problem.mover_limit_m),
                   "limit {} s, variation {}", limit_s, problem.skin_variation);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const auto value = [&](const AdapterPoint& point) {
    return ValueOf(Objective::kSkinRms, problem, source, {}, point);
  };
  // the best adapter without a limit may be within it already
  const auto rise = RiseWith(problem, unlimited);
  if (rise && rise->LatencyAtMostS() <= limit_s) {
    return {.point = unlimited,
            .value = value(unlimited),
            .rise = *rise,
            .runs = 1,
            .least_limit_s = rise->uncertainty_s,
            .is_unlimited = true};
  }
  PromptBest answer{.runs = 1, .least_limit_s = rise ? rise->uncertainty_s : 0};
  // a limit below the uncertainty of the latency cannot be decided
  if (limit_s < answer.least_limit_s) return answer;
  LatencySearch search(problem, source, limit_s);
  Tried best;
  const auto climb = [&](const Tried& start, double step) {
    if (start.latency_s == kNever) return;
    const Tried found = search.ClimbFrom(start, step);
    if (search.Prompt(found) && found.cost < best.cost) best = found;
  };
  for (const Tried& start : search.Starts()) climb(start, 0.01);
  // from the unlimited optimum in long steps and in short ones, which stay on its hill
  const Tried from = search.Run(PlaceOf(problem.bounds, unlimited));
  for (const double step : {0.01, 1e-3}) climb(from, step);
  // the best of all climbs again, with slopes over shorter and shorter steps
  for (const double step : {2e-3, 4e-4}) {
    if (best.cost < kNever) best = search.ClimbFrom(best, step);
  }
  answer.runs = search.runs();
  if (search.least_uncertainty_s() < kNever) answer.least_limit_s = search.least_uncertainty_s();
  if (best.cost == kNever) return answer;
  answer.point = PointOf(problem.bounds, best.place);
  answer.value = value(answer.point);
  answer.rise = *RiseWith(problem, answer.point);
  return answer;
}

}  // namespace haptometer::sim
