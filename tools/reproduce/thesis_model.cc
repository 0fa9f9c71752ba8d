#include "tools/reproduce/thesis_model.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>

#include "base/mapped.h"
#include "sim/sensor_model.h"

namespace haptometer::tools {

// the skin at that area (m2) by the thesis's law, with the changes of its two ends
sim::Skin SkinOf(const ThesisModel& model, double contact_area_m2) {
  const auto law = [&](double area_m2) { return sim::SkinUnderArea(area_m2, model.skin_range); };
  const double least = law(sim::kSkinAreaMinM2).stiffness_n_per_m;
  const double largest = law(sim::kSkinAreaMaxM2).stiffness_n_per_m;
  sim::Skin skin = law(contact_area_m2);
  // position of this stiffness between the ends of the law, 0 to 1
  const double part = (skin.stiffness_n_per_m - least) / (largest - least);
  // changes of the ends are interpolated linearly in stiffness
  skin.stiffness_n_per_m +=
      (1 - part) * model.least_skin.stiffness_n_per_m + part * model.largest_skin.stiffness_n_per_m;
  skin.damping_n_s_per_m +=
      (1 - part) * model.least_skin.damping_n_s_per_m + part * model.largest_skin.damping_n_s_per_m;
  return skin;
}

sim::Scene WithoutAdapter(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene;
  scene.actuator = model.actuator;
  scene.skin = SkinOf(model, contact_area_m2);
  scene.drive = model.drive;
  return scene;
}

sim::Scene WithAdapter(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene = WithoutAdapter(model, contact_area_m2);
  scene.adapter = model.adapter;
  return scene;
}

// Ma2 of the prototype is the mass of its base as built, not the tuned one
sim::Scene Prototype(const ThesisModel& model, double contact_area_m2) {
  sim::Scene scene = WithAdapter(model, contact_area_m2);
  scene.adapter->skin_side_mass_kg = kBuiltBaseMassKg;
  return scene;
}

sim::TuningProblem SearchOf(const ThesisModel& model) {
  sim::TuningProblem problem = sim::ThesisProblem();
  problem.actuator = model.actuator;
  problem.drive = model.drive;
  problem.skin_range = model.skin_range;
  return problem;
}

namespace {

// a printed input of the simulation, and half of its last digit
struct RoundedInput {
  std::string_view symbol;
  ThesisUnit unit;
  double half_step;  // SI
  double& (*place)(ThesisModel& model);
  double skin_area_m2 = 0;  // of an end of the skin's law, whose place holds a difference
};

// units of the printed inputs, with their SI values
constexpr ThesisUnit kGram{"g", "kg", 1e-3};
constexpr ThesisUnit kNPerM{"N/m", "N/m", 1};
constexpr ThesisUnit kNsPerM{"N s/m", "N s/m", 1};

// half a unit in the last printed digit of each input: the true one lies within
constexpr auto kInputs = std::to_array<RoundedInput>({
    {"Mv", kGram, 0.05e-3, [](ThesisModel& m) -> double& { return m.actuator.moving_mass_kg; }},
    {"Mc", kGram, 0.05e-3, [](ThesisModel& m) -> double& { return m.actuator.case_mass_kg; }},
    {"Kv", kNPerM, 50, [](ThesisModel& m) -> double& { return m.actuator.stiffness_n_per_m; }},
    {"Bv", kNsPerM, 5e-5, [](ThesisModel& m) -> double& { return m.actuator.damping_n_s_per_m; }},
    {"Km",
     {"N/A", "N/A", 1},
     0.05,
     [](ThesisModel& m) -> double& { return m.actuator.force_constant_n_per_a; }},
    {"R",
     {"ohm", "ohm", 1},
     0.5,
     [](ThesisModel& m) -> double& { return m.actuator.resistance_ohm; }},
    {"L",
     {"uH", "H", 1e-6},
     5e-6,
     [](ThesisModel& m) -> double& { return m.actuator.inductance_h; }},
    {"Ma1", kGram, 5e-6, [](ThesisModel& m) -> double& { return m.adapter.motor_side_mass_kg; }},
    {"Ma2", kGram, 5e-6, [](ThesisModel& m) -> double& { return m.adapter.skin_side_mass_kg; }},
    {"Ka", kNPerM, 50, [](ThesisModel& m) -> double& { return m.adapter.stiffness_n_per_m; }},
    {"Ba", kNsPerM, 0.005, [](ThesisModel& m) -> double& { return m.adapter.damping_n_s_per_m; }},
    {"least Ks", kNPerM, 50,
     [](ThesisModel& m) -> double& { return m.least_skin.stiffness_n_per_m; }, sim::kSkinAreaMinM2},
    {"largest Ks", kNPerM, 50,
     [](ThesisModel& m) -> double& { return m.largest_skin.stiffness_n_per_m; },
     sim::kSkinAreaMaxM2},
    {"least Bs", kNsPerM, 0.005,
     [](ThesisModel& m) -> double& { return m.least_skin.damping_n_s_per_m; }, sim::kSkinAreaMinM2},
    {"largest Bs", kNsPerM, 0.005,
     [](ThesisModel& m) -> double& { return m.largest_skin.damping_n_s_per_m; },
     sim::kSkinAreaMaxM2},
});

using Place = std::array<double, kInputs.size()>;  // in half steps from the printed values

ThesisModel ModelAt(ThesisModel model, const Place& place) {
  for (std::size_t i = 0; i < kInputs.size(); ++i) {
    kInputs[i].place(model) += place[i] * kInputs[i].half_step;
  }
  return model;
}

// value of an input in its printed unit; an end of the skin's law with the law's own value added
double ShownOf(const RoundedInput& input, ThesisModel model) {
  double value = input.place(model);
  if (input.skin_area_m2 > 0) {
    const sim::Skin law = sim::SkinUnderArea(input.skin_area_m2, model.skin_range);
    value += input.unit.name == kNPerM.name ? law.stiffness_n_per_m : law.damping_n_s_per_m;
  }
  return value / input.unit.si;
}

// distance of a value from the middle four fifths of the rounding interval of the printed one, in
// half steps; of a bound relative to it
double DistanceOf(const ThesisNumber& number, double value) {
  // the inner 80 % of the rounding interval: a result on its edge would not round reliably
  constexpr double kInner = 0.8;
  const double printed = SiValue(number);
  if (number.relation == Relation::kEquals) {
    // equality: deviation from the printed value in half steps, 0 within the inner part
    const double off = (value - printed) / (number.half_step * number.unit.si);
    return off - std::clamp(off, -kInner, kInner);
  }
  // bound: relative deviation, 1e-3 beyond the bound at least
  const double off = value / printed - 1;
  return number.relation == Relation::kBelow ? std::max(off + 1e-3, 0.0)
                                             : std::min(off - 1e-3, 0.0);
}

// values of the rows with the inputs at that place
std::vector<double> ValuesAt(const ThesisModel& model, std::span<const ThesisRow> rows,
                             const Place& place) {
  const ThesisModel moved = ModelAt(model, place);
  return Mapped(rows, [&](const ThesisRow& row) { return row.measure(moved); });
}

std::vector<double> DistancesOf(std::span<const ThesisRow> rows,
                                const std::vector<double>& values) {
  std::vector<double> distances;
  distances.reserve(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    distances.push_back(DistanceOf(rows[k].number(), values[k]));
  }
  return distances;
}

double SquareOf(const std::vector<double>& distances) {
  double sum = 0;
  for (const double distance : distances) sum += distance * distance;
  return sum;
}

// derivatives d(value k)/d(input i) at `values` of the place, in the units of DistanceOf
std::vector<Place> SlopesAt(const ThesisModel& model, std::span<const ThesisRow> rows,
                            const Place& place, const std::vector<double>& values) {
  constexpr double kStep = 1e-3;
  std::vector<Place> slopes(rows.size());
  for (std::size_t i = 0; i < kInputs.size(); ++i) {
    Place moved = place;
    // one-sided difference, towards the middle, so that the place stays within the bounds
    moved[i] += moved[i] > 0 ? -kStep : kStep;
    const std::vector<double> there = ValuesAt(model, rows, moved);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const ThesisNumber& number = rows[k].number();
      const double scale = number.relation == Relation::kEquals ? number.half_step * number.unit.si
                                                                : SiValue(number);
      slopes[k][i] = (there[k] - values[k]) / (scale * (moved[i] - place[i]));
    }
  }
  return slopes;
}

// minimum of the linearised squared distances within the bounds by coordinate descent; a small
// weight on the place itself, so that inputs without influence stay at the printed values
Place LinearBest(const std::vector<double>& distances, const std::vector<Place>& slopes,
                 const Place& place) {
  constexpr int kSweeps = 300;
  constexpr double kWeight = 1e-4;
  Place best = place;
  std::vector<double> left = distances;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    // derivative and curvature of (weight x^2 + sum of left^2) / 2 along this input
    for (std::size_t i = 0; i < best.size(); ++i) {
      double gradient = kWeight * best[i];
      double curvature = kWeight;
      for (std::size_t k = 0; k < left.size(); ++k) {
        // rows within their rounding already have no weight
        if (distances[k] == 0) continue;
        gradient += slopes[k][i] * left[k];
        curvature += slopes[k][i] * slopes[k][i];
      }
      // Newton step of one coordinate, clamped to the box
      const double moved = std::clamp(best[i] - gradient / curvature, -1.0, 1.0);
      for (std::size_t k = 0; k < left.size(); ++k) left[k] += slopes[k][i] * (moved - best[i]);
      best[i] = moved;
    }
  }
  return best;
}

// a place and the sum of squared distances of its rows
struct SearchEnd {
  Place place{};
  double square = 0;
};

// The end of a search from a place: where every distance is 0, or where no step makes them smaller.
SearchEnd NearestFrom(Place place, const ThesisModel& model, std::span<const ThesisRow> rows) {
  constexpr int kMostSteps = 12;
  std::vector<double> values = ValuesAt(model, rows, place);
  std::vector<double> distances = DistancesOf(rows, values);
  for (int step = 0; step < kMostSteps && SquareOf(distances) > 0; ++step) {
    // Gauss-Newton direction within the box, then halving until the squared distance decreases
    const Place wanted = LinearBest(distances, SlopesAt(model, rows, place, values), place);
    bool is_nearer = false;
    for (double part = 1; part > 1e-3 && !is_nearer; part /= 2) {
      Place tried = place;
      for (std::size_t i = 0; i < place.size(); ++i) tried[i] += part * (wanted[i] - place[i]);
      std::vector<double> there = ValuesAt(model, rows, tried);
      is_nearer = SquareOf(DistancesOf(rows, there)) < SquareOf(distances);
      if (!is_nearer) continue;
      place = tried;
      values = std::move(there);
      distances = DistancesOf(rows, values);
    }
    if (!is_nearer) break;
  }
  return {place, SquareOf(distances)};
}

// uniformly spread over the box (a Kronecker sequence of square roots of primes); number 0 is the
// printed values
Place StartOf(int number) {
  constexpr std::array kPrimes{2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47};
  static_assert(kPrimes.size() == kInputs.size());
  Place place{};
  for (std::size_t i = 0; i < place.size() && number > 0; ++i) {
    // fractional part of number x sqrt(prime), mapped to -1 to 1
    const double turns = number * std::sqrt(kPrimes[i]);
    place[i] = 2 * (turns - std::floor(turns)) - 1;
  }
  return place;
}

// best of several searches, because each ends in a local minimum
Place Nearest(const ThesisModel& model, std::span<const ThesisRow> rows) {
  constexpr int kStarts = 8;
  SearchEnd best = NearestFrom(StartOf(0), model, rows);
  for (int number = 1; number < kStarts && best.square > 0; ++number) {
    const SearchEnd end = NearestFrom(StartOf(number), model, rows);
    if (end.square < best.square) best = end;
  }
  return best.place;
}

// "Mv 1.446 g, R 26.89 ohm": the inputs that moved by a twentieth of a half step and more
std::string TextOf(const ThesisModel& model, const Place& place) {
  constexpr double kMoved = 0.05;
  const ThesisModel moved = ModelAt(model, place);
  std::string text;
  for (std::size_t i = 0; i < kInputs.size(); ++i) {
    if (std::abs(place[i]) < kMoved) continue;
    text += fmt::format("{}{} {:.4g} {}", text.empty() ? "" : ", ", kInputs[i].symbol,
                        ShownOf(kInputs[i], moved), kInputs[i].unit.name);
  }
  return text.empty() ? "as printed" : text;
}

}  // namespace

std::vector<CandidateCause> FromRoundedInputs(const ThesisModel& model,
                                              std::span<const ThesisRow> rows) {
  const Place place = Nearest(model, rows);
  const ThesisModel moved = ModelAt(model, place);
  const std::string text =
      fmt::format("inputs that round to the printed ones{}: {}",
                  rows.size() > 1 ? fmt::format(", one set for {} rows", rows.size()) : "",
                  TextOf(model, place));
  return Mapped(rows, [&](const ThesisRow& row) {
    return CandidateCause{.text = text, .gives = row.measure(moved), .kind = CauseKind::kRounding};
  });
}

std::vector<ThesisRow> Joined(std::vector<std::vector<ThesisRow>> parts) {
  std::vector<ThesisRow> rows;
  for (auto& part : parts) std::ranges::move(part, std::back_inserter(rows));
  return rows;
}

void Measure(const ThesisModel& model, std::vector<ThesisRow>* rows) {
  for (ThesisRow& row : *rows) {
    if (row.measure) row.ours = row.measure(model);
  }
}

void ExplainByRounding(const ThesisModel& model, std::vector<ThesisRow>* rows) {
  for (ThesisRow& row : *rows) {
    if (!row.measure || VerdictOf(row) == RowVerdict::kReproduced) continue;
    row.candidates.push_back(FromRoundedInputs(model, {&row, 1}).front());
  }
}

namespace {

// steps of the first search over an interval
constexpr int kSteps = 1000;

double PlaceOf(int step, double low, double high) {
  const double part = static_cast<double>(step) / kSteps;
  return low + (high - low) * part;
}

}  // namespace

// position of the maximum: a scan, then golden section between the neighbours of the best
double LargestAt(const std::function<double(double)>& function, double low, double high) {
  int best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (int step = 0; step <= kSteps; ++step) {
    const double value = function(PlaceOf(step, low, high));
    if (value > most) {
      most = value;
      best = step;
    }
  }
  double a = PlaceOf(std::max(best - 1, 0), low, high);
  double b = PlaceOf(std::min(best + 1, kSteps), low, high);
  constexpr double kShorter = 1 / std::numbers::phi;
  while (b - a > 1e-9 * (high - low)) {
    const double left = b - kShorter * (b - a);
    const double right = a + kShorter * (b - a);
    if (function(left) > function(right)) {
      b = right;
    } else {
      a = left;
    }
  }
  return (a + b) / 2;
}

// the last change of sign below `high`: a scan downwards, then bisection to rounding
std::optional<double> CrossingOf(const std::function<double(double)>& function, double low,
                                 double high) {
  const bool sign = function(high) > 0;
  for (int step = kSteps - 1; step >= 0; --step) {
    double a = PlaceOf(step, low, high);
    if ((function(a) > 0) == sign) continue;
    double b = PlaceOf(step + 1, low, high);
    for (double middle = (a + b) / 2; middle > a && middle < b; middle = (a + b) / 2) {
      ((function(middle) > 0) == sign ? b : a) = middle;
    }
    return b;
  }
  return std::nullopt;
}

// first time in s at which abs(xs) reaches the level, in a run from rest of 1 s at most
std::optional<double> TimeToReach(sim::Scene scene, double level_m) {
  constexpr double kLongestS = 1;
  constexpr double kStepsPerPeriod = 100;
  scene.start = sim::Start::kRest;
  const trial::Displacement motion = sim::MotionOf(scene, sim::SensorTarget::kSkin);
  // 100 steps per period: a crest between two steps is missed by at most 5e-4 of its height
  const double rate_hz = kStepsPerPeriod * scene.drive.frequency_hz;
  for (int step = 1; step <= kLongestS * rate_hz; ++step) {
    double after_s = step / rate_hz;
    if (std::abs(motion(after_s)) < level_m) continue;
    double before_s = (step - 1) / rate_hz;
    for (double middle_s = (before_s + after_s) / 2; middle_s > before_s && middle_s < after_s;
         middle_s = (before_s + after_s) / 2) {
      (std::abs(motion(middle_s)) < level_m ? before_s : after_s) = middle_s;
    }
    return after_s;
  }
  return std::nullopt;
}

}  // namespace haptometer::tools
