#include "fit/drop_test/drop_test_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "fit/drop_test/drop_test_model.h"
#include "fit/drop_test/drop_test_solution.h"
#include "fit/residuals.h"

namespace haptometer::fit {
namespace {

using Kind = DropTestInput::Kind;

// the better of the two roads to Km
DropTestRoad Choose(std::optional<DropTestRoad> by_heights, DropTestRoad by_loads,
                    const DropTestModel& model, std::vector<std::string>& assumptions) {
  if (!by_heights) return by_loads;
  const auto heights = EvaluateForceConstant(*by_heights, model);
  const auto loads = EvaluateForceConstant(by_loads, model);
  const bool prefer_loads =
      loads.determined && (!heights.determined || loads.combined_standard_uncertainty <
                                                      heights.combined_standard_uncertainty);
  if (prefer_loads) {
    assumptions.push_back(fmt::format(
        "Km rests on the loads' damping; with the drop height it would be {:.4g} +- {:.2g} N/A",
        heights.value, kCoverage95 * heights.combined_standard_uncertainty));
    return by_loads;
  }
  if (loads.determined) {
    assumptions.push_back(fmt::format(
        "Km rests on the drop height and the loads; by the loads alone it is {:.4g} +- {:.2g} N/A",
        loads.value, kCoverage95 * loads.combined_standard_uncertainty));
  }
  return std::move(*by_heights);
}

// what the contact may take of a drop's amplitude
std::string DescribeContact(const PreparedRecord& prepared, const DropTestInput* input) {
  const RingStart& start = prepared.start;
  const std::string& name = prepared.record.name;
  if (input == nullptr) {
    const double angle =
        std::sqrt(prepared.part.poles.stiffness_per_s2) * 0.5e-3;  // of a contact of 0.5 ms
    return fmt::format(
        "{}: the blow is short, since nothing quiet before it shows how long it lasts: a contact "
        "of "
        "0.5 ms makes Km by the height {:.2g} % too small",
        name, 100 * (0.125 - 1 / std::pow(std::numbers::pi, 2)) * angle * angle);
  }
  if (start.shortest_contact_s == 0) {
    return fmt::format(
        "{}: the blow may last up to {:.2g} ms, which makes Km by the height up to {:.2g} % too "
        "small; its interval holds that",
        name, 1e3 * start.longest_contact_s, 200 * input->quantity.standard_uncertainty);
  }
  return fmt::format(
      "{}: the blow lasts {:.2g} to {:.2g} ms, as a half sine of force; Km by the height is "
      "corrected for it, by {:.2g} %",
      name, 1e3 * start.shortest_contact_s, 1e3 * start.longest_contact_s,
      100 * (1 / input->quantity.value - 1));
}

void DescribeHeights(const DropTestModel& model, std::vector<std::string>& assumptions) {
  for (std::size_t r = 0; r < model.records.size(); ++r) {
    const auto& record = model.records[r].record;
    if (!record.drop_height_m || record.signal == RecordedSignal::kDisplacement) continue;
    const auto input = std::ranges::find_if(model.inputs, [r](const DropTestInput& one) {
      return one.kind == Kind::kContact && std::ranges::count(one.records, r) > 0;
    });
    assumptions.push_back(
        DescribeContact(model.records[r], input == model.inputs.end() ? nullptr : &*input));
  }
  for (const auto& input : model.inputs) {
    if (input.kind != Kind::kRebound) continue;
    assumptions.push_back(
        input.quantity.exact()
            ? fmt::format("impact speed (1 + e) sqrt(2 g h) with rebound e = {:g} and g = {} m/s2",
                          input.quantity.value, kGravityMPerS2)
            : fmt::format("impact speed (1 + e) sqrt(2 g h) with g = {} m/s2 and rebound e = {:g}"
                          " +- {:.2g}{}",
                          kGravityMPerS2, input.quantity.value, input.quantity.standard_uncertainty,
                          input.name == "rebound" ? "" : " (not stated: 0 to 0.3)"));
  }
  const bool knows_scale = std::ranges::any_of(
      model.inputs, [](const DropTestInput& input) { return input.kind == Kind::kVoltageScale; });
  if (knows_scale) return;
  assumptions.emplace_back(
      "the recorder's voltage scale is exact (--voltage-scale states it): 1 % of it moves Km by 1 "
      "%");
}

// what is not determined, what is instead, and what would help
void DescribeUndetermined(const DropTestRoad& road, const DropTestModel& model, DropTestFit& fit) {
  if (!fit.stiffness.determined && fit.stiffness_over_mass.determined && !model.knows_mass) {
    fit.undetermined.push_back(
        fmt::format("Kv and Bv are determined per kilogram only: state the {}",
                    model.all_free ? "moving mass and the case mass" : "moving mass"));
  }
  const bool some_loaded = std::any_of(fit.records.begin(), fit.records.end(),
                                       [](const auto& r) { return std::isfinite(r.load_ohm); });
  if (!some_loaded && !fit.damping_over_mass.determined) {
    fit.undetermined.emplace_back(
        "Bv and Q: the record shows no decay beyond its uncertainty; record at least three decay"
        " times of one free ring-down");
  }
  if (some_loaded && !fit.damping_over_mass.determined) {
    std::string missing = model.knows_resistance ? "" : " or state the coil's resistance";
    if (!model.knows_heights) missing = " or state the drop height and the coil's resistance";
    fit.undetermined.push_back(
        fmt::format("Bv and Km: only (Bv + Km^2/(R+RL))/M = {:.6g} 1/s is determined ({}); record "
                    "an open circuit"
                    " too{}",
                    2 * fit.records[0].decay_per_s, fit.records[0].name, missing));
  }
  if (fit.force_constant.determined || fit.force_constant.at_most) return;
  const auto& samples = road.problem.records();
  const auto voltage =
      std::ranges::find(samples, RingingSignal::kBlowVoltage, &RingDownSamples::signal);
  const bool shows_motion_alone = std::ranges::all_of(samples, [](const RingDownSamples& record) {
    return record.signal == RingingSignal::kBlowDisplacement;
  });
  if (shows_motion_alone) {
    fit.undetermined.emplace_back(
        "Km: a displacement shows none; record the voltage, with and without a load");
  } else if (voltage == samples.end()) {
    fit.undetermined.emplace_back(
        "Km: a voltage after a released current shows only Km^2/M; state the moving mass");
  } else if (!some_loaded) {
    const auto r = static_cast<std::size_t>(voltage - samples.begin());
    fit.undetermined.push_back(
        fmt::format("Km: an open circuit shows only Km x impact speed = {:.6g} V ({}); state the "
                    "drop height, or"
                    " record again with 27 to 50 ohm across the terminals",
                    std::exp(road.point.own[r][Index(Own::kAmplitude)]), fit.records[r].name));
  } else if (fit.damping_over_mass.determined) {
    fit.undetermined.emplace_back(
        "Km: what these loads change in the damping is lost in its uncertainty, or lacks the mass "
        "or"
        " the coil's resistance; state those, or record with 27 to 50 ohm across the terminals");
  }
}

FittedRecord DescribeRecord(const PreparedRecord& prepared, const DropTestRoad& road,
                            const FittedValue& force_constant, const UncertainPole& pole,
                            std::size_t r) {
  const auto& [record, start, part] = prepared;
  const auto& samples = road.problem.records()[r];
  const auto& own = road.point.own[r];
  FittedRecord fitted;
  fitted.name = record.name;
  fitted.signal = record.signal;
  fitted.load_ohm = samples.load_ohm;
  fitted.impact_s = own[Index(Own::kImpact)];
  fitted.offset_v = own[Index(Own::kOffset)];
  fitted.pole = pole;
  fitted.decay_per_s = pole.decay_per_s;
  fitted.damped_frequency_hz = pole.frequency_hz;
  const double scale = samples.time_scale;  // shown over true seconds, of which the poles are
  fitted.start = {scale * start.poles.decay_per_s, scale * scale * start.poles.stiffness_per_s2};
  fitted.quiet_noise_v = start.quiet_noise_v;
  fitted.first_sample = part.first_sample;
  fitted.samples = samples.times_s.size();
  fitted.found = part.found;
  fitted.density = road.densities[r];
  fitted.drawn_samples = static_cast<std::size_t>(
      std::ranges::count_if(samples.root_weights, [](double root) { return root * root < 0.5; }));
  if (fitted.drawn_samples > 0) {
    fitted.found.push_back(fmt::format("{} of {} samples lie far off and weigh less than half",
                                       fitted.drawn_samples, fitted.samples));
  }

  fitted.speed_determined = samples.signal == RingingSignal::kBlowVoltage &&
                            (samples.speed_m_per_s > 0 || force_constant.determined);
  if (fitted.speed_determined) {
    fitted.impact_speed_m_per_s =
        samples.speed_m_per_s > 0 ? samples.speed_m_per_s
                                  : std::exp(own[Index(Own::kAmplitude)]) / force_constant.value;
  }

  // the model at every sample, measured or not; the residual at the measured ones
  std::vector<double> times;
  for (std::size_t n = part.first_sample; n < part.end_sample; ++n) {
    times.push_back(record.start_s + static_cast<double>(n) * record.step_s);
  }
  fitted.model_v = road.problem.Voltages(road.point, r, times);
  for (std::size_t n = 0; n < std::min(times.size(), part.linear_less_friction_v.size()); ++n) {
    fitted.model_v[n] -= part.linear_less_friction_v[n];
  }
  double square_sum = 0;
  fitted.residual_v.assign(times.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t n = 0; n < times.size(); ++n) {
    const double sample = record.voltage_v[part.first_sample + n];
    if (!std::isfinite(sample) || times[n] < samples.times_s.front()) continue;
    fitted.residual_v[n] = sample - fitted.model_v[n];
    square_sum += fitted.residual_v[n] * fitted.residual_v[n];
    fitted.peak_v = std::max(fitted.peak_v, std::abs(sample - fitted.offset_v));
  }
  fitted.residual_rms_v = std::sqrt(square_sum / static_cast<double>(fitted.samples));
  if (fitted.quiet_noise_v > 2 * fitted.residual_rms_v) {
    fitted.found.emplace_back("what precedes the blow is louder than the residual: not quiet");
    fitted.quiet_noise_v = 0;
  }
  return fitted;
}

void DescribeInfluences(const DropTestRoad& road, const DropTestModel& model, DropTestFit& fit) {
  // Km^2 may be 0, of which nothing has a relative change
  const double square = road.point.shared[Index(Shared::kForceConstantSquared)];
  const std::array share_per_change{1.0, 1.0, square > 0 ? 1 / (2 * square) : 0.0};
  constexpr std::array kOf{Shared::kStiffness, Shared::kDamping, Shared::kForceConstantSquared};
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const auto& input = model.inputs[k];
    if (!DependsOn(road, input)) continue;
    InputInfluence influence{
        .input = input.name,
        .value = input.quantity.value,
        .standard_uncertainty = input.quantity.standard_uncertainty,
        .relative_standard_uncertainty = input.quantity.standard_uncertainty / InputBase(input),
        .unit = input.unit};
    for (std::size_t p = 0; p < kOf.size(); ++p) {
      influence.percent_per_percent[p] = share_per_change[p] * road.input_changes[k][Index(kOf[p])];
    }
    fit.influences.push_back(influence);
  }
}

// of ln Kv, ln Bv, ln Km, where determined
void DescribeCovariance(const DropTestRoad& road, const DropTestModel& model, DropTestFit& fit) {
  const std::array<const FittedValue*, 3> values{&fit.stiffness, &fit.damping, &fit.force_constant};
  const std::array weights{Weights(road, {{Shared::kStiffness, 1}}),
                           Weights(road, {{Shared::kDamping, 1}}),
                           Weights(road, {{Shared::kForceConstantSquared, 0.5}})};
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t j = 0; j < values.size(); ++j) {
      if (!values[i]->determined || !values[j]->determined) continue;
      fit.relative_covariance[i][j] = CovarianceOf(road, model, weights[i], weights[j]);
    }
  }
}

// a load that slows the decay
void DoubtForceConstant(const DropTestRoad& road, const DropTestModel& model,
                        std::vector<std::string>& contradictions) {
  constexpr double kDeviations = 4;
  std::vector<double> weights(road.jacobian.columns, 0.0);
  weights[Index(Shared::kForceConstantSquared)] = 1;
  const double square = road.point.shared[Index(Shared::kForceConstantSquared)];
  if (square > -kDeviations * SpreadOf(road, model, weights).combined) return;
  contradictions.emplace_back(
      "the records with the smaller load decay more slowly, as no coil does: are files or loads "
      "exchanged? Do not use Bv and Km");
}

// a blow found away from where the motion, continued backwards, begins
void DoubtBeginning(const PreparedRecord& prepared, const FittedRecord& record,
                    std::vector<std::string>& contradictions) {
  const RingStart& start = prepared.start;
  // without a height or a current, nothing rests on how the motion began
  if (!prepared.record.drop_height_m && !prepared.record.release_current_a) return;
  if (start.quiet_samples == 0 || record.damped_frequency_hz == 0) return;
  const double periods = (start.blow_s - record.impact_s) * record.damped_frequency_hz;
  if (std::abs(periods) < 1.0 / 8) return;
  contradictions.push_back(fmt::format(
      "{}: the motion would begin {:.2g} ms {} the signal does: a long contact, or a blow for a "
      "released current or the reverse; do not use Km by height or current",
      record.name, 1e3 * std::abs(start.blow_s - record.impact_s),
      periods > 0 ? "before" : "after"));
}

// pooled over the records with a quiet stretch: residual power over noise power
double ChiSquare(const std::vector<FittedRecord>& records) {
  double sum = 0;
  double samples = 0;
  for (const auto& record : records) {
    if (record.quiet_noise_v <= 0) continue;
    const double ratio = record.residual_rms_v / record.quiet_noise_v;
    sum += ratio * ratio * static_cast<double>(record.samples);
    samples += static_cast<double>(record.samples);
  }
  return samples > 0 ? sum / samples : 0;
}

}  // namespace

namespace {

Result<DropTestFit> FitModel(Result<DropTestModel> model, Loss loss) {
  if (!model) return std::unexpected(model.error());
  model->loss = loss;
  RingDownProblem problem = MakeProblem(*model);
  if (!problem.IsDefined(StartPoint(*model, false, &problem))) {
    return CannotAnswer(model->records[0].record.name, "no ring-down fits these records",
                        "record three decay times of one free ring-down each");
  }
  DropTestFit fit;
  fit.assumptions = model->assumptions;
  std::optional<DropTestRoad> by_heights;
  if (model->knows_heights) by_heights = Travel(*model, true);
  const DropTestRoad road =
      Choose(std::move(by_heights), Travel(*model, false), *model, fit.assumptions);
  if (road.uses_heights) DescribeHeights(*model, fit.assumptions);
  if (loss == Loss::kHuber) {
    fit.assumptions.push_back(fmt::format(
        "robust: beyond {} of the residuals' scale a sample pulls with a fixed force (Huber)",
        kHuberBend));
  }

  fit.mass_symbol = model->all_free ? "Mv Mc/(Mv+Mc)" : "Mv";
  fit.stiffness = Evaluate(road, *model, {{Shared::kStiffness, 1}}, 1, "N/m");
  fit.damping = Evaluate(road, *model, {{Shared::kDamping, 1}}, 1, "N s/m");
  fit.force_constant = EvaluateForceConstant(road, *model);
  if (!model->knows_mass && !model->all_free) {
    fit.moving_mass = Evaluate(road, *model, {{Shared::kMass, 1}}, 1, "kg");
  }
  fit.stiffness_over_mass =
      Evaluate(road, *model, {{Shared::kStiffness, 1}, {Shared::kMass, -1}}, 1, "1/s^2");
  fit.damping_over_mass =
      Evaluate(road, *model, {{Shared::kDamping, 1}, {Shared::kMass, -1}}, 1, "1/s");
  fit.natural_frequency = Evaluate(road, *model, {{Shared::kStiffness, 0.5}, {Shared::kMass, -0.5}},
                                   0.5 / std::numbers::pi, "Hz");
  fit.quality_factor =
      Evaluate(road, *model,
               {{Shared::kStiffness, 0.5}, {Shared::kMass, 0.5}, {Shared::kDamping, -1}}, 1, "");
  for (std::size_t r = 0; r < model->records.size(); ++r) {
    fit.records.push_back(
        DescribeRecord(model->records[r], road, fit.force_constant, PoleOf(road, *model, r), r));
  }
  DescribeInfluences(road, *model, fit);
  DescribeCovariance(road, *model, fit);
  DescribeUndetermined(road, *model, fit);
  fit.frequency_birge_ratio = road.consistency.frequency_ratio;
  fit.decay_birge_ratio = road.consistency.decay_ratio;
  fit.doubts = road.consistency.doubts;
  fit.contradictions = road.consistency.contradictions;
  DoubtForceConstant(road, *model, fit.contradictions);
  for (std::size_t r = 0; r < model->records.size(); ++r) {
    DoubtBeginning(model->records[r], fit.records[r], fit.contradictions);
  }
  fit.converged = road.solver.converged;
  fit.termination = road.solver.termination;
  fit.iterations = road.solver.iterations;
  fit.chi_square_per_degree = ChiSquare(fit.records);
  return fit;
}

}  // namespace

Result<DropTestFit> FitDropTest(const std::vector<ImpulseRecord>& records,
                                const ActuatorKnowns& knowns, Loss loss) {
  return FitModel(MakeDropTestModel(records, knowns), loss);
}

Result<DropTestFit> FitDropTest(std::vector<PreparedRecord> records, const ActuatorKnowns& knowns,
                                Loss loss) {
  return FitModel(MakeDropTestModel(std::move(records), knowns), loss);
}

namespace {

// the usual values of one quantity, and what is usually wrong outside of them
struct Usual {
  std::string_view name;
  double least = 0;
  double most = 0;
  std::string_view unit;
  std::string_view mistake;
};

void Doubt(const Usual& usual, double value, const std::string& where,
           std::vector<std::string>& doubts) {
  if (value >= usual.least && value <= usual.most) return;
  doubts.push_back(fmt::format("{}{} of {:.4g} {} is unlike an actuator's: {}", where, usual.name,
                               value, usual.unit, usual.mistake));
}

void Doubt(const Usual& usual, const std::optional<Quantity>& value,
           std::vector<std::string>& doubts) {
  if (value) Doubt(usual, value->value, "", doubts);
}

void Doubt(const Usual& usual, const FittedValue& value, std::vector<std::string>& doubts) {
  if (value.determined) Doubt(usual, value.value, "", doubts);
}

}  // namespace

std::vector<std::string> FindDoubts(const DropTestFit& fit,
                                    const std::vector<ImpulseRecord>& records,
                                    const ActuatorKnowns& knowns) {
  constexpr Usual kResonance{"a resonance", 20, 2000, "Hz", "are the times in ms or us?"};
  constexpr Usual kQuality{"a quality factor", 0.05, 1000, "", "is it a ring-down?"};
  constexpr Usual kVoltage{"a largest voltage", 1e-5, 100, "V", "is the column in mV or uV?"};
  constexpr Usual kMovingMass{"a moving mass", 1e-5, 0.1, "kg", "was it meant in g or mg?"};
  constexpr Usual kCaseMass{"a case mass", 1e-5, 1, "kg", "was it meant in g or mg?"};
  constexpr Usual kResistance{"a coil", 0.1, 1e4, "ohm", "was it meant in ohm?"};
  constexpr Usual kHeight{"a drop height", 1e-4, 1, "m", "was it meant in mm?"};
  constexpr Usual kForce{"a force constant", 1e-3, 100, "N/A",
                         "check the voltage's unit and the drop height"};
  std::vector<std::string> doubts = fit.contradictions;
  doubts.insert(doubts.end(), fit.doubts.begin(), fit.doubts.end());
  Doubt(kResonance, fit.natural_frequency, doubts);
  Doubt(kQuality, fit.quality_factor, doubts);
  Doubt(kForce, fit.force_constant, doubts);
  Doubt(kMovingMass, knowns.moving_mass_kg, doubts);
  Doubt(kCaseMass, knowns.case_mass_kg, doubts);
  Doubt(kResistance, knowns.resistance_ohm, doubts);
  for (const auto& record : fit.records) {
    Doubt(kVoltage, record.peak_v, record.name + ": ", doubts);
  }
  for (const auto& record : records) {
    if (!record.drop_height_m) continue;
    Doubt(kHeight, record.drop_height_m->value, record.name + ": ", doubts);
  }
  return doubts;
}

}  // namespace haptometer::fit
