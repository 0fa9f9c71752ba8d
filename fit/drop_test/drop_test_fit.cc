#include "fit/drop_test/drop_test_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fit/calibration/calibration_fit.h"
#include "fit/drop_test/drop_test_model.h"
#include "fit/drop_test/drop_test_solution.h"

namespace haptometer::fit {
namespace {

using Kind = DropTestInput::Kind;

// the solution with the better Km: by drop heights or by loads
DropTestRoad Choose(std::optional<DropTestRoad> by_heights, DropTestRoad by_loads,
                    const DropTestModel& model, Findings& findings) {
  if (!by_heights) return by_loads;
  const auto heights = EvaluateForceConstant(*by_heights, model);
  const auto loads = EvaluateForceConstant(by_loads, model);
  // a determined Km first, then the smaller combined uncertainty
  const bool prefer_loads =
      loads.determined && (!heights.determined || loads.combined_standard_uncertainty <
                                                      heights.combined_standard_uncertainty);
  // two determined values that differ by more than both uncertainties explain contradict each other
  const auto normalized_error =
      heights.determined && loads.determined
          ? NormalizedError(heights.value, heights.combined_standard_uncertainty, loads.value,
                            loads.combined_standard_uncertainty)
          : std::nullopt;
  const bool is_contradicted = normalized_error && std::abs(*normalized_error) > 1;
  const auto note = [&](FindingKind kind, const FittedValue& other) {
    std::vector<FindingNumber> numbers{
        {"other_n_per_a", other.value},
        {"half_interval_n_per_a", kCoverage95 * other.combined_standard_uncertainty}};
    if (is_contradicted) numbers.emplace_back("normalized_error", std::abs(*normalized_error));
    findings.Add({is_contradicted ? Severity::kDoubt : Severity::kNote, kind, std::move(numbers)});
  };
  if (prefer_loads) {
    note(FindingKind::kKmByLoads, heights);
    return by_loads;
  }
  if (loads.determined) note(FindingKind::kKmByHeight, loads);
  return std::move(*by_heights);
}

// the finding on the share of a drop's amplitude that the contact removes
Finding ContactOf(const PreparedRecord& prepared, const DropTestInput* input) {
  const RingStart& start = prepared.start;
  const auto note = [&](FindingKind kind, std::vector<FindingNumber> numbers) {
    return About(prepared.record.name, Severity::kNote, kind, std::move(numbers));
  };
  if (input == nullptr) {
    // cos(x/2)/(1 - (x/pi)^2) = 1 - (1/8 - 1/pi^2) x^2 for small x = w T
    const double angle =
        std::sqrt(prepared.part.poles.stiffness_per_s2) * 0.5e-3;  // of a contact of 0.5 ms
    return note(FindingKind::kContactUnseen,
                {{"share", (0.125 - 1 / std::pow(std::numbers::pi, 2)) * angle * angle}});
  }
  if (start.shortest_contact_s == 0) {
    return note(FindingKind::kContactAtMost, {{"longest_s", start.longest_contact_s},
                                              {"share", 2 * input->quantity.standard_uncertainty}});
  }
  return note(FindingKind::kContactCorrected, {{"shortest_s", start.shortest_contact_s},
                                               {"longest_s", start.longest_contact_s},
                                               {"share", 1 / input->quantity.value - 1}});
}

void DescribeHeights(const DropTestModel& model, Findings& findings) {
  for (std::size_t r = 0; r < model.records.size(); ++r) {
    const auto& record = model.records[r].record;
    // a height matters only for records of an impact's voltage
    if (!record.drop_height_m || record.signal == RecordedSignal::kDisplacement) continue;
    const auto input = std::ranges::find_if(model.inputs, [r](const DropTestInput& one) {
      return one.kind == Kind::kContact && std::ranges::count(one.records, r) > 0;
    });
    findings.Add(ContactOf(model.records[r], input == model.inputs.end() ? nullptr : &*input));
  }
  for (const auto& input : model.inputs) {
    if (input.kind != Kind::kRebound) continue;
    const FindingNumber rebound{"rebound", input.quantity.value};
    if (input.quantity.exact()) {
      findings.Note(FindingKind::kReboundStated, {rebound});
      continue;
    }
    findings.Note(
        input.name == "rebound" ? FindingKind::kReboundStated : FindingKind::kReboundAssumed,
        {rebound, {"standard_uncertainty", input.quantity.standard_uncertainty}});
  }
  // a voltage scale that is not stated has no uncertainty
  const bool knows_scale = std::ranges::any_of(
      model.inputs, [](const DropTestInput& input) { return input.kind == Kind::kVoltageScale; });
  if (!knows_scale) findings.Note(FindingKind::kVoltageScaleExact);
}

// heights that are stated and not used
constexpr std::array kUnusedHeights{FindingKind::kHeightWithoutImpact,
                                    FindingKind::kHeightOfFirstImpact,
                                    FindingKind::kHeightOfLongImpact};

bool HasUnusedHeight(const Findings& findings) {
  return std::ranges::any_of(kUnusedHeights, [&](FindingKind kind) { return findings.Has(kind); });
}

// What is stated of a record and not used, taken out of what was found in it: it explains the
// answer of all.
Findings TakeUnused(Findings* found) {
  Findings unused;
  Findings others;
  for (const Finding& finding : found->list()) {
    const bool is_unused = finding.kind == FindingKind::kCurrentWithoutRelease ||
                           std::ranges::count(kUnusedHeights, finding.kind) > 0;
    (is_unused ? unused : others).Add(finding);
  }
  *found = std::move(others);
  return unused;
}

// the damping, where it is not determined
void DescribeDamping(const DropTestModel& model, bool some_loaded, DropTestFit& fit) {
  if (fit.damping_over_mass.determined) return;
  if (!some_loaded) return fit.findings.Note(FindingKind::kNoDecay);
  const bool states_heights = model.knows_heights || HasUnusedHeight(fit.findings);
  const FindingKind kind = !states_heights           ? FindingKind::kDampingsWithoutHeight
                           : !model.knows_resistance ? FindingKind::kDampingsWithoutResistance
                                                     : FindingKind::kDampingsTogether;
  fit.findings.Add(About(fit.records[0].name, Severity::kNote, kind,
                         {{"sum_per_s", 2 * fit.records[0].decay_per_s}}));
}

// what is not determined, what is instead, and what would help
void DescribeUndetermined(const DropTestRoad& road, const DropTestModel& model, DropTestFit& fit) {
  if (!fit.stiffness.determined && fit.stiffness_over_mass.determined && !model.knows_mass) {
    fit.findings.Note(model.all_free ? FindingKind::kMassesMissing : FindingKind::kMassMissing);
  }
  const bool some_loaded = std::any_of(fit.records.begin(), fit.records.end(),
                                       [](const auto& r) { return std::isfinite(r.load_ohm); });
  DescribeDamping(model, some_loaded, fit);
  if (fit.force_constant.determined || fit.force_constant.at_most) return;
  const auto& samples = road.problem.records();
  const auto voltage =
      std::ranges::find(samples, RingingSignal::kBlowVoltage, &RingDownSamples::signal);
  const bool shows_motion_alone = std::ranges::all_of(samples, [](const RingDownSamples& record) {
    return record.signal == RingingSignal::kBlowDisplacement;
  });
  if (shows_motion_alone) {
    fit.findings.Note(FindingKind::kKmOfDisplacement);
  } else if (voltage == samples.end()) {
    fit.findings.Note(FindingKind::kKmOfReleaseWithoutMass);
  } else if (!some_loaded) {
    // open records without a height: only the product Km v0 is determined
    const auto r = static_cast<std::size_t>(voltage - samples.begin());
    fit.findings.Add(About(fit.records[r].name, Severity::kNote,
                           HasUnusedHeight(fit.findings) ? FindingKind::kKmTimesUnusedSpeed
                                                         : FindingKind::kKmTimesSpeedOnly,
                           {{"product_v", std::exp(road.point.own[r][Index(Own::kAmplitude)])}}));
  } else if (fit.damping_over_mass.determined) {
    fit.findings.Note(FindingKind::kKmLostInDamping);
  }
}

FittedRecord DescribeRecord(const PreparedRecord& prepared, const DropTestRoad& road,
                            const FittedValue& force_constant, const UncertainPole& pole,
                            std::size_t r) {
  const ImpulseRecord& record = prepared.record;
  const RingStart& start = prepared.start;
  const Disturbances& part = prepared.part;
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
  // samples that Huber's loss gives less than half of their weight
  fitted.drawn_samples = static_cast<std::size_t>(
      std::ranges::count_if(samples.root_weights, [](double root) { return root * root < 0.5; }));
  if (fitted.drawn_samples > 0) {
    fitted.found.Add(About(record.name, Severity::kNote, FindingKind::kDownweighted,
                           {{"samples", fitted.drawn_samples}, {"of", fitted.samples}}));
  }

  // v0 as stated, else the amplitude Km v0 over the fitted Km
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
  // the samples contain dry friction, the fitted model does not
  for (std::size_t n = 0; n < std::min(times.size(), part.linear_less_friction_v.size()); ++n) {
    fitted.model_v[n] -= part.linear_less_friction_v[n];
  }
  double square_sum = 0;
  fitted.residual_v.assign(times.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t n = 0; n < times.size(); ++n) {
    const double sample = record.voltage_v[part.first_sample + n];
    // no residual at missing samples and before the fitted impact
    if (!std::isfinite(sample) || times[n] < samples.times_s.front()) continue;
    fitted.residual_v[n] = sample - fitted.model_v[n];
    square_sum += fitted.residual_v[n] * fitted.residual_v[n];
    fitted.peak_v = std::max(fitted.peak_v, std::abs(sample - fitted.offset_v));
  }
  fitted.residual_rms_v = std::sqrt(square_sum / static_cast<double>(fitted.samples));
  // more noise before the impact than in the fit: what precedes is not quiet
  if (fitted.quiet_noise_v > 2 * fitted.residual_rms_v) {
    fitted.found.Add(About(record.name, Severity::kNote, FindingKind::kNotQuietBefore));
    fitted.quiet_noise_v = 0;
  }
  return fitted;
}

void DescribeInfluences(const DropTestRoad& road, const DropTestModel& model, DropTestFit& fit) {
  // Km^2 may be 0, of which nothing has a relative change
  const double square = road.point.shared[Index(Shared::kForceConstantSquared)];
  // d ln Km = d(Km^2)/(2 Km^2)
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
    if (values[i]->determined) {
      fit.by_rounding[i] = std::sqrt(CovarianceBy(road.rounding_changes, weights[i], weights[i]));
    }
    for (std::size_t j = 0; j < values.size(); ++j) {
      if (!values[i]->determined || !values[j]->determined) continue;
      fit.relative_covariance[i][j] = CovarianceOf(road, model, weights[i], weights[j]);
    }
  }
}

// refuses a Km^2 below 0 by more than 4 uncertainties: a load that slows the decay
void DoubtForceConstant(const DropTestRoad& road, const DropTestModel& model, Findings& findings) {
  constexpr double kDeviations = 4;
  std::vector<double> weights(road.jacobian.columns, 0.0);
  weights[Index(Shared::kForceConstantSquared)] = 1;
  const double square = road.point.shared[Index(Shared::kForceConstantSquared)];
  if (square > -kDeviations * SpreadOf(road, model, weights).combined) return;
  findings.Refuse(FindingKind::kSmallerLoadDecaysSlower);
}

// an impact found away from where the motion, continued backwards, begins
void DoubtBeginning(const PreparedRecord& prepared, const FittedRecord& record,
                    Findings& findings) {
  const RingStart& start = prepared.start;
  // without a height or a current, nothing rests on how the motion began
  if (!prepared.record.drop_height_m && !prepared.record.release_current_a) return;
  if (start.quiet_samples == 0 || record.damped_frequency_hz == 0) return;
  const double periods = (start.blow_s - record.impact_s) * record.damped_frequency_hz;
  // within an eighth of a period both agree
  if (std::abs(periods) < 1.0 / 8) return;
  findings.Add(
      About(record.name, Severity::kRefusal,
            periods > 0 ? FindingKind::kMotionBeginsBefore : FindingKind::kMotionBeginsAfter,
            {{"apart_s", std::abs(start.blow_s - record.impact_s)}}));
}

// residual power over noise power, of all records with a quiet part
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
  // the start values must give finite voltages
  if (!problem.IsDefined(StartPoint(*model, false, &problem))) {
    return CannotAnswer(model->records[0].record.name, "no ring-down fits these records",
                        "record three decay times of one free ring-down each");
  }
  DropTestFit fit;
  fit.findings = model->findings;
  for (PreparedRecord& record : model->records) {
    fit.findings.AddAll(TakeUnused(&record.part.found));
  }
  // two ways to Km: by heights, if any is stated, and by loads
  std::optional<DropTestRoad> by_heights;
  if (model->knows_heights) by_heights = Travel(*model, true);
  const DropTestRoad road =
      Choose(std::move(by_heights), Travel(*model, false), *model, fit.findings);
  if (road.uses_heights) DescribeHeights(*model, fit.findings);
  if (loss == Loss::kHuber) fit.findings.Note(FindingKind::kRobustLoss, {{"bend", kHuberBend}});

  // each constant is a product of powers of Kv, Bv, Km^2 and M
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
  // doubts: scatter between drops, then contradictions within each
  fit.frequency_birge_ratio = road.consistency.frequency.birge_ratio;
  fit.decay_birge_ratio = road.consistency.decay.birge_ratio;
  fit.findings.AddAll(road.consistency.findings);
  DoubtForceConstant(road, *model, fit.findings);
  for (std::size_t r = 0; r < model->records.size(); ++r) {
    DoubtBeginning(model->records[r], fit.records[r], fit.findings);
  }
  fit.converged = road.solver.converged;
  fit.termination = road.solver.termination;
  fit.iterations = road.solver.iterations;
  fit.chi_square_per_degree = ChiSquare(fit.records);
  return fit;
}

}  // namespace

Result<DropTestFit> FitDropTest(std::vector<PreparedRecord> records, const ActuatorKnowns& knowns,
                                Loss loss) {
  return FitModel(MakeDropTestModel(std::move(records), knowns), loss);
}

void DoubtUnusual(FindingKind kind, std::string_view name, double value,
                  sim::PlausibleRange plausible, Findings& findings, const std::string& subject) {
  if (plausible.Holds(value)) return;
  findings.Add(About(subject, Severity::kDoubt, kind, {{name, value}}));
}

void DoubtUnusual(FindingKind kind, std::string_view name, const FittedValue& value,
                  sim::PlausibleRange plausible, Findings& findings) {
  if (value.determined) DoubtUnusual(kind, name, value.value, plausible, findings);
}

void DoubtUnusual(FindingKind kind, std::string_view name, const std::optional<Quantity>& value,
                  sim::PlausibleRange plausible, Findings& findings, const std::string& subject) {
  if (value) DoubtUnusual(kind, name, value->value, plausible, findings, subject);
}

Findings FindDoubts(const DropTestFit& fit, const std::vector<ImpulseRecord>& records,
                    const ActuatorKnowns& knowns) {
  using enum FindingKind;
  // ranges of actuators; values outside of them usually have another unit
  Findings findings;
  DoubtUnusual(kUnusualFrequency, "natural_frequency_hz", fit.natural_frequency,
               sim::kPlausibleResonanceHz, findings);
  DoubtUnusual(kUnusualQuality, "quality_factor", fit.quality_factor, {0.05, 1000}, findings);
  DoubtUnusual(kUnusualForceConstant, "force_constant_n_per_a", fit.force_constant,
               sim::kPlausibleForceConstantNPerA, findings);
  DoubtUnusual(kUnusualMovingMass, "moving_mass_kg", knowns.moving_mass_kg,
               sim::kPlausibleMovingMassKg, findings);
  DoubtUnusual(kUnusualCaseMass, "case_mass_kg", knowns.case_mass_kg, sim::kPlausibleCaseMassKg,
               findings);
  DoubtUnusual(kUnusualResistance, "resistance_ohm", knowns.resistance_ohm,
               sim::kPlausibleResistanceOhm, findings);
  for (const auto& record : fit.records) {
    DoubtUnusual(kUnusualVoltage, "peak_v", record.peak_v, {1e-5, 100}, findings, record.name);
  }
  for (const auto& record : records) {
    DoubtUnusual(kUnusualHeight, "drop_height_m", record.drop_height_m, {1e-4, 1}, findings,
                 record.name);
  }
  return findings;
}

}  // namespace haptometer::fit
