#include "fit/drop_test/drop_test_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace haptometer::fit {
namespace {

using Kind = DropTestInput::Kind;

constexpr double kOpen = std::numeric_limits<double>::infinity();
// uniform ignorance of the rebound between 0 and 0.3, as root mean square about 0
const double kUnknownReboundUncertainty = 0.3 / std::sqrt(3.0);

// adds an input, or the record to an equal one: the same resistor, the same ruler
void AddInput(std::vector<DropTestInput>& inputs, Kind kind, std::string name, std::string unit,
              const Quantity& quantity, std::size_t record) {
  for (DropTestInput& input : inputs) {
    if (input.kind == kind && input.quantity == quantity) {
      input.records.push_back(record);
      return;
    }
  }
  inputs.push_back({kind, std::move(name), std::move(unit), quantity, {record}});
}

// What a contact of half a sine, T long, leaves of the ringing's amplitude: cos(w T/2)/(1 - (w
// T/pi)^2)
double LeftByContact(double angle) {
  constexpr double kMostAngle = 2.8;  // 0.87 of a half period, of what RingStart looks for
  const double x = std::min(angle, kMostAngle);
  return std::cos(x / 2) / (1 - std::pow(x / std::numbers::pi, 2));
}

// What the contact leaves of the impact's speed, from the lengths that it may have. Dry friction
// brakes from its begin on, half of it before the middle, where the modelled ring-down begins.
Quantity ContactShare(const PreparedRecord& prepared) {
  const RingStart& start = prepared.start;
  const double angular = std::sqrt(prepared.part.poles.stiffness_per_s2);
  const double shortest = LeftByContact(angular * start.shortest_contact_s);
  const double longest = LeftByContact(angular * start.longest_contact_s);
  const bool is_seen = start.shortest_contact_s > 0;
  const double braked = prepared.part.friction_share * angular * start.longest_contact_s / 4;
  return {(is_seen ? (shortest + longest) / 2 : 1) - braked,
          std::hypot(is_seen ? (shortest - longest) / 4 : (1 - longest) / 2, braked / 2)};
}

// the given numbers of one record; equal numbers of several records are one input
void AddRecordInputs(const PreparedRecord& prepared, std::size_t index, DropTestModel& model) {
  const ImpulseRecord& record = prepared.record;
  const Quantity load = record.load_ohm.value_or(Quantity{kOpen, 0});
  if (!record.load_ohm) {
    model.findings.Add(About(record.name, Severity::kNote, FindingKind::kOpenAssumed));
  }
  AddInput(model.inputs, Kind::kLoad, "load", "ohm", load, index);
  if (record.time_scale) {
    AddInput(model.inputs, Kind::kTimeScale, "time scale", "", *record.time_scale, index);
  }
  if (record.voltage_scale) {
    AddInput(model.inputs, Kind::kVoltageScale, "voltage scale", "", *record.voltage_scale, index);
  }
  if (record.release_current_a) {
    AddInput(model.inputs, Kind::kReleaseCurrent, "released current", "A",
             *record.release_current_a, index);
  }
  if (record.added_mass_kg) {
    AddInput(model.inputs, Kind::kAddedMass, "added mass", "kg", *record.added_mass_kg, index);
  }
  // which share of a displacement is measured is not known: a height gives no Km
  if (!record.drop_height_m || record.signal == RecordedSignal::kDisplacement) return;
  model.knows_heights = true;
  AddInput(model.inputs, Kind::kHeight, "drop height", "m", *record.drop_height_m, index);
  const Quantity rebound = record.rebound.value_or(Quantity{0, kUnknownReboundUncertainty});
  AddInput(model.inputs, Kind::kRebound, record.rebound ? "rebound" : "rebound (not stated)", "",
           rebound, index);
  if (prepared.start.longest_contact_s > 0) {
    AddInput(model.inputs, Kind::kContact, "share of the speed that the contact leaves", "",
             ContactShare(prepared), index);
  }
}

// the actuator's given numbers; R and L have an influence only under a load
void AddKnowns(const ActuatorKnowns& knowns, bool some_loaded, DropTestModel& model) {
  const auto add = [&model](Kind kind, const char* name, const char* unit,
                            const std::optional<Quantity>& quantity) {
    if (quantity) model.inputs.push_back({kind, name, unit, *quantity, {}});
  };
  const bool all_held =
      std::count(model.conditions.begin(), model.conditions.end(), CaseCondition::kFree) == 0;
  if (model.knows_mass) {
    add(Kind::kMovingMass, "moving mass", "kg", knowns.moving_mass_kg);
    if (!all_held) add(Kind::kCaseMass, "case mass", "kg", knowns.case_mass_kg);
  }
  if (some_loaded) {
    add(Kind::kResistance, "coil resistance", "ohm", knowns.resistance_ohm);
    add(Kind::kInductance, "coil inductance", "H", knowns.inductance_h);
    if (!knowns.inductance_h) model.findings.Note(FindingKind::kInductanceAssumedZero);
  }
}

// what the case did, record by record; an unstated case counts as held
void AddConditions(const ActuatorKnowns& knowns, DropTestModel& model) {
  bool assumed = false;
  for (const PreparedRecord& prepared : model.records) {
    const ImpulseRecord& record = prepared.record;
    assumed = assumed || !record.condition;
    model.conditions.push_back(record.condition.value_or(CaseCondition::kHeld));
  }
  const auto free_count =
      std::count(model.conditions.begin(), model.conditions.end(), CaseCondition::kFree);
  model.all_free = free_count == std::ssize(model.records);
  // M is known by Mv if all cases are held, else by Mv and Mc
  const bool both = knowns.moving_mass_kg && knowns.case_mass_kg;
  model.knows_mass = knowns.moving_mass_kg && (free_count == 0 || both);
  if (!assumed) return;
  if (!both) return model.findings.Note(FindingKind::kHeldAssumed);
  // Mc/(Mv + Mc): M of a free case over that of a held one, a factor of Kv and Bv; Km has its root
  const double ratio =
      knowns.case_mass_kg->value / (knowns.moving_mass_kg->value + knowns.case_mass_kg->value);
  model.findings.Note(FindingKind::kHeldAssumed,
                      {{"ratio", ratio}, {"root_ratio", std::sqrt(ratio)}});
}

// the value of the first input of a kind
double ValueOf(const std::vector<DropTestInput>& inputs, Kind kind, double otherwise) {
  for (const auto& input : inputs) {
    if (input.kind == kind) return input.quantity.value;
  }
  return otherwise;
}

// 1/(R+RL) of a record at a point
double Conductance(const RingDownSamples& record, const RingDownPoint& point) {
  if (std::isinf(record.load_ohm)) return 0;
  return 1 / (std::exp(point.shared[Index(Shared::kResistance)]) + record.load_ohm);
}

// RL/(R + RL), terminal voltage over back EMF; 1 for open terminals
double Divider(const RingDownSamples& record, const RingDownPoint& point) {
  return std::isinf(record.load_ohm) ? 1.0 : record.load_ohm * Conductance(record, point);
}

// damping over mass against 1/(R+RL): a line whose slope is Km^2/M and whose foot is Bv/M
struct DampingLine {
  double slope = 0;
  double foot = 0;
  bool has_slope = false;
};

DampingLine FitDampingLine(const std::vector<double>& conductances,
                           const std::vector<double>& dampings) {
  const auto count = static_cast<double>(dampings.size());
  double mean_g = 0;
  double mean_d = 0;
  for (std::size_t r = 0; r < dampings.size(); ++r) {
    mean_g += conductances[r] / count;
    mean_d += dampings[r] / count;
  }
  double gg = 0;
  double gd = 0;
  for (std::size_t r = 0; r < dampings.size(); ++r) {
    gg += (conductances[r] - mean_g) * (conductances[r] - mean_g);
    gd += (conductances[r] - mean_g) * (dampings[r] - mean_d);
  }
  DampingLine line;
  line.has_slope = gg > 1e-12 * mean_g * mean_g;
  if (!line.has_slope) {
    // one load only: share the damping between the two causes
    line.slope = mean_g > 0 ? 0.3 * mean_d / mean_g : 0;
    line.foot = mean_d - line.slope * mean_g;
    return line;
  }
  // noise may reverse the slope; the start values stay positive
  const double least_d = *std::min_element(dampings.begin(), dampings.end());
  const double most_g = *std::max_element(conductances.begin(), conductances.end());
  line.slope = std::max(gd / gg, 0.01 * least_d / most_g);
  line.foot = std::max(mean_d - line.slope * mean_g, 0.02 * least_d);
  return line;
}

// poles and amplitudes of the records before any fit, referred to the problem's M
struct PoleSummary {
  double stiffness_over_mass = 0;  // mean of the records
  std::vector<double> conductances;
  std::vector<double> dampings;  // (Bv + Km^2/(R+RL))/M of each record
  // mean over the records with a known impact speed or released current
  std::optional<double> force_constant;
};

PoleSummary Summarise(const DropTestModel& model, const RingDownProblem& problem,
                      const RingDownPoint& point) {
  PoleSummary summary;
  const double mass = std::exp(point.shared[Index(Shared::kMass)]);
  double sum = 0;
  int known = 0;
  for (std::size_t r = 0; r < model.records.size(); ++r) {
    const RingStart& start = model.records[r].start;
    const RingDownSamples& record = problem.records()[r];
    summary.conductances.push_back(Conductance(record, point));
    // the record's own ringing mass over M
    const double ratio = RingingMass(record, mass) / mass;
    summary.dampings.push_back(2 * start.poles.decay_per_s * ratio);
    summary.stiffness_over_mass +=
        start.poles.stiffness_per_s2 * ratio / static_cast<double>(model.records.size());
    if (record.signal == RingingSignal::kReleaseVoltage) {
      // Km^2 I0/M, the slope at the release
      sum += std::sqrt(std::abs(start.release_slope_v_per_s) * RingingMass(record, mass) /
                       (record.release_current_a * Divider(record, point)));
      ++known;
    } else if (record.speed_m_per_s > 0) {
      // amplitude of the terminal voltage: Km v0 RL/(R + RL)
      sum += std::abs(start.impact_voltage_v) / (record.speed_m_per_s * Divider(record, point));
      ++known;
    }
  }
  if (known > 0) summary.force_constant = sum / known;
  return summary;
}

// signals and statements that do not go together
Result<void> CheckKind(const ImpulseRecord& record) {
  if (record.added_mass_kg && record.condition == CaseCondition::kFree) {
    return CannotAnswer(record.name, "has an added mass and a free case",
                        "hold the case while a mass is added to the mover");
  }
  if (record.release_current_a && record.drop_height_m) {
    return CannotAnswer(record.name, "states a drop height and a released current",
                        "state what began the motion: an impact or the current's end");
  }
  if (record.release_current_a && record.signal == RecordedSignal::kDisplacement) {
    return CannotAnswer(record.name, "is a displacement after a released current",
                        "record the voltage; of a laser's records, those of impacts are fitted");
  }
  return {};
}

RingingSignal SignalOf(const ImpulseRecord& record) {
  if (record.signal == RecordedSignal::kDisplacement) return RingingSignal::kBlowDisplacement;
  return record.release_current_a ? RingingSignal::kReleaseVoltage : RingingSignal::kBlowVoltage;
}

// M from 1/w^2 = (M + dM)/Kv, a line through the records with the least and the most added mass
std::optional<double> MassFromAddedOnes(const DropTestModel& model,
                                        const RingDownProblem& problem) {
  const auto& records = problem.records();
  const auto [least, most] =
      std::ranges::minmax_element(records, {}, &RingDownSamples::added_mass_kg);
  const auto square_of = [&](auto record) {
    const auto r = static_cast<std::size_t>(record - records.begin());
    return 1 / model.records[r].start.poles.stiffness_per_s2;
  };
  const double rise = square_of(most) - square_of(least);
  const double added_kg = most->added_mass_kg - least->added_mass_kg;
  if (!(rise > 0 && added_kg > 0)) return std::nullopt;
  const double mass_kg = square_of(least) / rise * added_kg - least->added_mass_kg;
  return mass_kg > 0 ? std::optional(mass_kg) : std::nullopt;
}

}  // namespace

Result<DropTestModel> MakeDropTestModel(std::vector<PreparedRecord> records,
                                        const ActuatorKnowns& knowns) {
  if (records.empty()) return CannotAnswer("", "no ring-down is given", "give an impulse.csv");
  DropTestModel model;
  model.records = std::move(records);
  bool some_loaded = false;
  for (std::size_t r = 0; r < model.records.size(); ++r) {
    const ImpulseRecord& record = model.records[r].record;
    HAPTOMETER_TRY(CheckKind(record));
    AddRecordInputs(model.records[r], r, model);
    some_loaded = some_loaded || (record.load_ohm && std::isfinite(record.load_ohm->value));
  }
  AddConditions(knowns, model);
  // held and free cases have a known ratio of ringing masses only by both masses
  const bool some_held =
      std::count(model.conditions.begin(), model.conditions.end(), CaseCondition::kHeld) > 0;
  if (some_held && model.conditions.size() > 1 && !model.all_free && !model.knows_mass &&
      std::count(model.conditions.begin(), model.conditions.end(), CaseCondition::kFree) > 0) {
    return CannotAnswer("", "held and free cases together need both masses",
                        "give the moving mass and the case mass");
  }
  model.knows_resistance = !some_loaded || knowns.resistance_ohm.has_value();
  AddKnowns(knowns, some_loaded, model);
  return model;
}

RingDownProblem MakeProblem(const DropTestModel& model) {
  std::vector<RingDownSamples> samples(model.records.size());
  for (std::size_t r = 0; r < samples.size(); ++r) {
    const ImpulseRecord& record = model.records[r].record;
    const RingStart& start = model.records[r].start;
    const Disturbances& part = model.records[r].part;
    // measured samples of the part, with the difference that removes dry friction
    for (std::size_t n = part.first_sample; n < part.end_sample; ++n) {
      if (!std::isfinite(record.voltage_v[n])) continue;
      samples[r].times_s.push_back(record.start_s + static_cast<double>(n) * record.step_s);
      const double more_v = part.linear_less_friction_v.empty()
                                ? 0
                                : part.linear_less_friction_v[n - part.first_sample];
      samples[r].voltages_v.push_back(record.voltage_v[n] + more_v);
    }
    samples[r].step_s = record.step_s;
    samples[r].signal = SignalOf(record);
    // the amplitude is positive: the record's sign is its polarity
    const bool begins_at_zero = samples[r].signal != RingingSignal::kBlowVoltage;
    samples[r].polarity =
        (begins_at_zero ? start.release_slope_v_per_s : start.impact_voltage_v) < 0 ? -1 : 1;
    // first weights: the residual of the record's own pole pair
    samples[r].noise_v = std::max(start.residual_rms_v, 1e-12 * std::abs(start.impact_voltage_v));
    samples[r].drifts = part.background.drifts;
    samples[r].hum_hz = part.background.hum_hz;
  }
  return {std::move(samples), 0};
}

void ApplyInputs(const std::vector<DropTestInput>& inputs, const DropTestModel& model,
                 bool use_heights, RingDownProblem* problem, RingDownPoint* point) {
  // Mc/(Mv + Mc), by which a free case reduces M
  const double moving = ValueOf(inputs, Kind::kMovingMass, 1);
  const double housing = ValueOf(inputs, Kind::kCaseMass, kOpen);
  const double reduction = std::isinf(housing) ? 1.0 : housing / (moving + housing);
  if (model.knows_mass) {
    point->shared[Index(Shared::kMass)] = std::log(model.all_free ? moving * reduction : moving);
  }
  problem->set_inductance_h(ValueOf(inputs, Kind::kInductance, 0));
  for (const auto& input : inputs) {
    if (input.kind == Kind::kResistance) {
      point->shared[Index(Shared::kResistance)] = std::log(input.quantity.value);
    }
    for (const std::size_t r : input.records) {
      if (input.kind == Kind::kLoad) problem->records()[r].load_ohm = input.quantity.value;
      if (input.kind == Kind::kTimeScale) problem->records()[r].time_scale = input.quantity.value;
      if (input.kind == Kind::kAddedMass) {
        problem->records()[r].added_mass_kg = input.quantity.value;
      }
      if (input.kind == Kind::kReleaseCurrent) {
        problem->records()[r].release_current_a = input.quantity.value;
      }
    }
  }
  // if held and free cases are mixed, the free ones have the reduced mass by their ratio
  for (std::size_t r = 0; r < model.conditions.size(); ++r) {
    const bool reduced = !model.all_free && model.conditions[r] == CaseCondition::kFree;
    problem->records()[r].mass_ratio = reduced ? reduction : 1.0;
  }
  // v0 = (1 + e) sqrt(2 g h)
  for (const auto& input : inputs) {
    for (const std::size_t r : input.records) {
      if (input.kind != Kind::kHeight || !use_heights) continue;
      problem->records()[r].speed_m_per_s = std::sqrt(2 * kGravityMPerS2 * input.quantity.value);
    }
  }
  // factors of the speed, after all heights
  for (const auto& input : inputs) {
    for (const std::size_t r : input.records) {
      auto& record = problem->records()[r];
      if (input.kind == Kind::kRebound) record.speed_m_per_s *= 1 + input.quantity.value;
      if (input.kind == Kind::kContact) record.speed_m_per_s *= input.quantity.value;
      if (input.kind != Kind::kVoltageScale) continue;
      // a larger voltage is shown where the scale is larger, as after a faster impact
      record.speed_m_per_s *= input.quantity.value;
      record.release_current_a *= input.quantity.value;
    }
  }
}

RingDownPoint StartPoint(const DropTestModel& model, bool use_heights, RingDownProblem* problem) {
  RingDownPoint point;
  point.own.resize(model.records.size());
  // an unknown coil resistance starts as large as a load
  for (const auto& input : model.inputs) {
    if (input.kind == Kind::kLoad && std::isfinite(input.quantity.value)) {
      point.shared[Index(Shared::kResistance)] = std::log(input.quantity.value);
    }
  }
  ApplyInputs(model.inputs, model, use_heights, problem, &point);
  // M unknown: from records with added masses, else 1 kg, which only ratios to M refer to
  if (!model.knows_mass) {
    const auto seen_kg = MassFromAddedOnes(model, *problem);
    point.shared[Index(Shared::kMass)] = std::log(seen_kg.value_or(1));
  }
  const double mass = std::exp(point.shared[Index(Shared::kMass)]);

  const PoleSummary poles = Summarise(model, *problem, point);
  // Km^2/M and Bv/M from the damping of different loads
  DampingLine line = FitDampingLine(poles.conductances, poles.dampings);
  double km = line.slope > 0 ? std::sqrt(line.slope * mass) : 1.0;
  double start_mass = mass;
  if (poles.force_constant) {
    km = *poles.force_constant;
    // Km by a height and Km^2/M by loads give M
    const bool weighs_by_loads = !model.knows_mass && mass == 1 && line.has_slope;
    if (weighs_by_loads) start_mass = km * km / line.slope;
  }
  point.shared[Index(Shared::kMass)] = std::log(start_mass);
  point.shared[Index(Shared::kStiffness)] = std::log(poles.stiffness_over_mass * start_mass);
  // with Km from a height, the load's share of a single damping follows
  if (!line.has_slope && poles.force_constant) {
    const double electric = km * km / start_mass * poles.conductances[0];
    line.foot = std::max(poles.dampings[0] - electric, 0.05 * poles.dampings[0]);
  }
  point.shared[Index(Shared::kDamping)] = std::log(line.foot * start_mass);
  point.shared[Index(Shared::kForceConstantSquared)] = km * km;
  // own parameters: offset, time of the impact and ln amplitude
  for (std::size_t r = 0; r < point.own.size(); ++r) {
    auto& own = point.own[r];
    const RingStart& start = model.records[r].start;
    const RingDownSamples& record = problem->records()[r];
    own[Index(Own::kOffset)] = start.offset_v;
    // signals that begin at 0 have their time at a zero, the voltage of an impact at its largest
    const bool begins_at_zero = record.signal != RingingSignal::kBlowVoltage;
    own[Index(Own::kImpact)] = begins_at_zero ? start.release_s : start.impact_s;
    own[Index(Own::kAmplitude)] =
        std::log(record.signal == RingingSignal::kBlowDisplacement
                     ? std::abs(start.release_slope_v_per_s)
                     : std::abs(start.impact_voltage_v) / Divider(record, point));
  }
  return point;
}

std::vector<bool> UnknownColumns(const DropTestModel& model, const RingDownProblem& problem) {
  std::vector<bool> unknown(kSharedCount + kOwnCount * problem.records().size(), true);
  unknown[Index(Shared::kMass)] = !model.knows_mass;
  unknown[Index(Shared::kResistance)] = !model.knows_resistance;
  for (std::size_t r = 0; r < problem.records().size(); ++r) {
    const RingDownSamples& record = problem.records()[r];
    unknown[Column(r, Own::kDrift)] = record.drifts;
    for (std::size_t k = 0; k < 2 * kMostHumLines; ++k) {
      unknown[Column(r, Own::kHumCosine) + k] = k < 2 * record.hum_hz.size();
    }
    unknown[Column(r, Own::kStiffness)] = record.stiffness_scatter > 0;
    unknown[Column(r, Own::kDamping)] = record.damping_scatter > 0;
    // an amplitude is unknown unless a speed or a released current gives it
    unknown[Column(r, Own::kAmplitude)] =
        record.speed_m_per_s == 0 && record.signal != RingingSignal::kReleaseVoltage;
  }
  return unknown;
}

}  // namespace haptometer::fit
