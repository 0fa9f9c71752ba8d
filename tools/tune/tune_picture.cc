#include "tools/tune/tune_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

constexpr std::size_t kFactors = 121;
constexpr std::size_t kRidgeMasses = 41;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Number {
  const char* name;
  plot::Colour colour;
};
// apart in grey too (Okabe and Ito, 2008)
constexpr std::array<Number, 5> kNumbers{{{"motor side's mass", plot::kBlue},
                                          {"skin side's mass", plot::kOrange},
                                          {"spring", plot::kGreen},
                                          {"damper", plot::kPurple},
                                          {"contact's area", plot::kYellow}}};
constexpr std::size_t kSpring = 2, kArea = 4;

double& PartOf(sim::AdapterPoint& point, std::size_t number) {
  switch (number) {
    case 0:
      return point.adapter.motor_side_mass_kg;
    case 1:
      return point.adapter.skin_side_mass_kg;
    case kSpring:
      return point.adapter.stiffness_n_per_m;
    case 3:
      return point.adapter.damping_n_s_per_m;
    default:
      return point.contact_area_m2;
  }
}

std::vector<double> Factors() { return sim::EqualSteps({.lower = 0.7, .upper = 1.3}, kFactors); }

// a curve for each number; value(point) at the optimum with one number times a factor
template <typename Value>
std::vector<plot::Series> AroundOptimum(const TuneAnswer& answer, const Value& value) {
  std::vector<plot::Series> curves;
  for (std::size_t number = 0; number < kNumbers.size(); ++number) {
    if (number == kArea && answer.question.problem.fixed_skin) continue;
    plot::Series curve{.title = kNumbers[number].name,
                       .style = plot::Lines(kNumbers[number].colour, 1.5),
                       .x = Factors(),
                       .y = {}};
    for (const double factor : curve.x) {
      sim::AdapterPoint point = answer.optimum.point;
      PartOf(point, number) *= factor;
      // the skin's law holds for these areas
      const bool known = number != kArea || (point.contact_area_m2 >= sim::kSkinAreaMinM2 &&
                                             point.contact_area_m2 <= sim::kSkinAreaMaxM2);
      curve.y.push_back(known ? value(point) : kNaN);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

plot::Series Rebalanced(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  plot::Series curve{.title = "spring, the skin side's mass chosen anew",
                     .style = plot::Lines(kNumbers[kSpring].colour, 1.5, 2),
                     .x = Factors(),
                     .y = {}};
  for (const double factor : curve.x) {
    const sim::SpringCost cost = sim::CostOfSpring(
        question.objective, question.problem, question.receptors, answer.optimum.point, factor);
    curve.y.push_back(
        cost.rebalanced > 0 ? cost.rebalanced * SpokenUnitOf(question.objective).factor : kNaN);
  }
  return curve;
}

std::string ObjectiveLabel(const TuneQuestion& question) {
  return fmt::format("{} / {}", sim::Name(question.objective),
                     SpokenUnitOf(question.objective).unit);
}

plot::Panel ObjectivePanel(const TuneAnswer& answer, const sim::MotorSource& source) {
  const TuneQuestion& question = answer.question;
  plot::Panel panel{.title = fmt::format("{}: around the optimum", question.name),
                    .x_label = "one number / its best",
                    .y_label = ObjectiveLabel(question),
                    .series = AroundOptimum(answer, [&](const sim::AdapterPoint& point) {
                      return sim::ValueOf(question.objective, question.problem, source,
                                          question.receptors, point) *
                             SpokenUnitOf(question.objective).factor;
                    })};
  panel.series.push_back(Rebalanced(answer));
  return panel;
}

plot::Panel TravelPanel(const TuneAnswer& answer, const sim::MotorSource& source) {
  const sim::TuningProblem& problem = answer.question.problem;
  plot::Panel panel{.title = "",
                    .x_label = "one number / its best",
                    .y_label = "mover travel / um",
                    .series = AroundOptimum(answer, [&](const sim::AdapterPoint& point) {
                      const sim::Skin skin = sim::SkinOf(problem, point.contact_area_m2);
                      const sim::AdapterMotion motion = sim::MotionOf(source, point.adapter, skin);
                      return sim::MoverTravel(source, motion.case_m) * 1e6;
                    })};
  if (std::isinf(problem.mover_limit_m)) return panel;
  const double limit_um = problem.mover_limit_m * 1e6;
  panel.series.push_back({.title = "allowed",
                          .style = plot::Lines(plot::kGrey, 2),
                          .x = {0.7, 1.3},
                          .y = {limit_um, limit_um}});
  return panel;
}

plot::Panel RidgePanel(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  plot::Series ridge{
      .title = "the best with that mass", .style = plot::Lines(plot::kBlue, 1.5), .x = {}, .y = {}};
  for (const sim::RidgePoint& point :
       sim::RidgeOf(question.objective, question.problem, question.receptors, kRidgeMasses)) {
    ridge.x.push_back(point.point.adapter.motor_side_mass_kg * 1e3);
    ridge.y.push_back(point.value * SpokenUnitOf(question.objective).factor);
  }
  const auto [least, most] = std::ranges::minmax_element(ridge.y);
  const std::string title = ridge.y.empty()
                                ? "the ridge"
                                : fmt::format("the ridge: its best is {:.3g} % above its least",
                                              (*most / *least - 1) * 100);
  return {.title = title,
          .x_label = "mass on the motor's side / g",
          .y_label = ObjectiveLabel(question),
          .series = {std::move(ridge)}};
}

}  // namespace

Result<void> DrawTune(const std::string& path, const TuneAnswer& answer) {
  const sim::TuningProblem& problem = answer.question.problem;
  const sim::MotorSource source = sim::SourceOf(problem.actuator, problem.drive);
  std::vector<plot::Panel> panels{ObjectivePanel(answer, source), TravelPanel(answer, source)};
  if (!answer.ridge.empty()) panels.push_back(RidgePanel(answer));
  return plot::DrawPanels(path, panels);
}

}  // namespace haptometer::tools
