#include "fit/drop_test/ringing_model.h"

#include <ceres/jet.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

constexpr double kSeries = 1;  // |(d^2 - q) t^2| below which O's slope cancels

RingingMoment Computed(double decay_per_s, double stiffness_per_s2, double since_s) {
  const auto pair = sim::DampedFundamentals(decay_per_s, stiffness_per_s2, since_s);
  return {.since_s = since_s, .even = pair.even, .odd = pair.odd};
}

// (cosh x - sinh(x)/x) / (2 x^2) by x^2 = z: sum of z^(k-1) k/(2k+1)!, the tenth term below 1e-18
double OddSeries(double z) {
  double sum = 0;
  for (int k = 9; k >= 2; --k) {
    // term k over term k - 1
    const double ratio = k / ((k - 1.0) * 2 * k * (2 * k + 1));
    sum = (1 + sum) * z * ratio;
  }
  return (1 + sum) / 6;
}

}  // namespace

RingingMoments::RingingMoments(double decay_per_s, double stiffness_per_s2,
                               double electrical_rate_per_s, double step_s)
    : decay_per_s_(decay_per_s),
      discriminant_per_s2_(decay_per_s * decay_per_s - stiffness_per_s2),
      stiffness_per_s2_(stiffness_per_s2),
      electrical_rate_per_s_(electrical_rate_per_s),
      steps_per_s_(step_s > 0 ? 1 / step_s : 0) {
  if (!(step_s > 0)) return;
  for (std::size_t k = 0; k < kSteps; ++k) {
    table_[k] = Computed(decay_per_s, stiffness_per_s2, static_cast<double>(k) * step_s);
  }
}

RingingMoment RingingMoments::Begin(double since_s) {
  first_ = Computed(decay_per_s_, stiffness_per_s2_, since_s);
  return first_;
}

// D = dO/d(d^2 - q) = (t E - O)/(2 (d^2 - q)), by its series where the difference cancels
double RingingMoments::OddByDiscriminant(const RingingMoment& moment) const {
  const double t = moment.since_s;
  const double z = discriminant_per_s2_ * t * t;
  return std::abs(z) < kSeries ? std::exp(-decay_per_s_ * t) * t * t * t * OddSeries(z)
                               : (t * moment.even - moment.odd) / (2 * discriminant_per_s2_);
}

// E by d is t (d O - E), by q -t O/2; O by d is 2 d D - t O, by q -D
RingingSlopes RingingMoments::SlopesAt(const RingingMoment& moment) const {
  const auto [t, even, odd, electrical] = moment;
  const double by_discriminant = OddByDiscriminant(moment);
  return {.even_by_decay = t * (decay_per_s_ * odd - even),
          .even_by_stiffness = -0.5 * t * odd,
          .even_by_time = discriminant_per_s2_ * odd - decay_per_s_ * even,
          .odd_by_decay = 2 * decay_per_s_ * by_discriminant - t * odd,
          .odd_by_stiffness = -by_discriminant,
          .odd_by_time = even - decay_per_s_ * odd};
}

RecordingParts::RecordingParts(const RingDownSamples& record)
    : middle_s(0.5 * (record.times_s.front() + record.times_s.back())),
      lines(record.hum_hz.size()) {
  HAPTOMETER_CHECK(lines <= kMostHumLines, "{} lines of hum", lines);
  for (std::size_t k = 0; k < lines; ++k) {
    hum_rad_per_s[k] = 2 * std::numbers::pi * record.hum_hz[k];
  }
}

// drift about the record's middle (s), cosines and sines of the hum, in the record's own time
std::array<double, 1 + 2 * kMostHumLines> RecordingParts::At(double time_s) const {
  std::array<double, 1 + 2 * kMostHumLines> parts{time_s - middle_s};
  for (std::size_t k = 0; k < lines; ++k) {
    parts[1 + 2 * k] = std::cos(hum_rad_per_s[k] * time_s);
    parts[2 + 2 * k] = std::sin(hum_rad_per_s[k] * time_s);
  }
  return parts;
}

RingingParts::RingingParts(const RingDownSamples& record, const RingingRates& rates)
    : recording_(record),
      impact_s_(rates.impact_s),
      per_time_scale_(1 / record.time_scale),
      moments_(rates.decay_per_s, rates.stiffness_per_s2, rates.electrical_rate_per_s,
               record.step_s / record.time_scale) {}

PartNumbers RingingParts::At(double time_s) {
  // time since the impact in true seconds
  const RingingMoment moment = moments_.At((time_s - impact_s_) * per_time_scale_);
  const auto [t, even, odd, electrical] = moment;
  PartNumbers parts{
      even,           odd, t * even, t * odd, moments_.OddByDiscriminant(moment), electrical,
      t * electrical, 1};
  std::ranges::copy(recording_.At(time_s), parts.begin() + Index(Part::kDrift));
  return parts;
}

double RingingParts::SumAt(double time_s, const PartNumbers& coefficients) {
  const RingingMoment moment = moments_.At((time_s - impact_s_) * per_time_scale_);
  const auto recorded = recording_.At(time_s);
  const auto share = [&coefficients](Part part, double value) {
    return coefficients[Index(part)] * value;
  };
  double sum = share(Part::kConstant, 1) + share(Part::kEven, moment.even) +
               share(Part::kOdd, moment.odd) + share(Part::kElectrical, moment.electrical);
  for (std::size_t k = 0; k < 1 + 2 * recording_.lines; ++k) {
    sum += coefficients[Index(Part::kDrift) + k] * recorded[k];
  }
  return sum;
}

namespace {

// parameters with automatic derivatives (Ceres jets): those of the circuit's numbers
constexpr std::size_t kRingingCount = Index(Own::kDrift);
constexpr int kAutomatic = static_cast<int>(kSharedCount + kRingingCount);
using Jet = ceres::Jet<double, kAutomatic>;

// mass ratio times M, plus the added mass
Jet RingingMass(const RingDownSamples& record, const Jet* shared) {
  return record.mass_ratio * exp(shared[Index(Shared::kMass)]) + record.added_mass_kg;
}

// the circuit of one record from logarithmic parameters, and its own part of two of these
sim::RingDown<Jet> Circuit(const RingDownSamples& record, double inductance_h, const Jet* shared,
                           const double* own) {
  return sim::RingDown<Jet>(
      {.stiffness_n_per_m = exp(shared[Index(Shared::kStiffness)] + own[Index(Own::kStiffness)]),
       .damping_n_s_per_m = exp(shared[Index(Shared::kDamping)] + own[Index(Own::kDamping)]),
       .force_constant_squared_n2_per_a2 = shared[Index(Shared::kForceConstantSquared)],
       .mass_kg = RingingMass(record, shared),
       .coil_resistance_ohm = exp(shared[Index(Shared::kResistance)]),
       .inductance_h = inductance_h,
       .load_ohm = record.load_ohm});
}

// what the shape is multiplied by; not a number where a given speed meets an impossible Km^2
Jet Amplitude(const RingDownSamples& record, const Jet* shared, const Jet* own) {
  const Jet& square = shared[Index(Shared::kForceConstantSquared)];
  if (record.signal == RingingSignal::kReleaseVoltage) {
    return record.release_current_a * square / RingingMass(record, shared);
  }
  if (record.speed_m_per_s == 0) return exp(own[Index(Own::kAmplitude)]);
  return record.speed_m_per_s * sqrt(square);
}

// below 0 at first, as the thesis has it of the voltage (equation 2.1)
sim::RingingShape<Jet> Shape(RingingSignal signal, const sim::RingDown<Jet>& circuit) {
  if (signal == RingingSignal::kBlowVoltage) return circuit.voltage();
  if (signal == RingingSignal::kReleaseVoltage) return circuit.release();
  const auto& displacement = circuit.displacement();
  return {-displacement.even, -displacement.odd, -displacement.electrical};
}

struct Jets {
  std::array<Jet, kSharedCount> shared;
  std::array<Jet, kRingingCount> own;
};

// each parameter with a derivative of 1 by itself
Jets MakeJets(const double* shared, const double* own) {
  Jets jets;
  for (std::size_t k = 0; k < kSharedCount; ++k)
    jets.shared[k] = Jet(shared[k], static_cast<int>(k));
  for (std::size_t k = 0; k < kRingingCount; ++k) {
    jets.own[k] = Jet(own[k], static_cast<int>(kSharedCount + k));
  }
  return jets;
}

// even E + odd O + electrical e^(-p t), and its circuit
struct Circuitry {
  sim::RingDown<Jet> circuit;
  Jet even;
  Jet odd;
  Jet electrical;

  // slopes by a parameter whose derivatives are automatic
  void WriteAutomatic(std::size_t parameter, RingingSum& sum) const {
    const auto k = static_cast<int>(parameter);
    const double d = circuit.decay_per_s().a;
    const double by_d = circuit.decay_per_s().v[k];
    const double by_q = circuit.stiffness_per_s2().v[k];
    const auto slope = [&](Part part) -> double& { return sum.slopes[Index(part)][parameter]; };
    slope(Part::kEven) = even.v[k];
    slope(Part::kOdd) = odd.v[k];
    slope(Part::kElectrical) = electrical.v[k];
    // E by d is t (d O - E), by q -t O/2; O by d is 2 d D - t O, by q -D, D being kByDiscriminant
    slope(Part::kTimesEven) = -even.a * by_d;
    slope(Part::kTimesOdd) = (d * even.a - odd.a) * by_d - 0.5 * even.a * by_q;
    slope(Part::kByDiscriminant) = odd.a * (2 * d * by_d - by_q);
    slope(Part::kTimesElectrical) = -electrical.a * circuit.electrical_rate_per_s().v[k];
  }

  // by the time of the impact: E by t is (d^2 - q) O - d E, O by t is E - d O
  void WriteByImpact(double time_scale, RingingSum& sum) const {
    const double d = circuit.decay_per_s().a;
    const double discriminant = d * d - circuit.stiffness_per_s2().a;
    const auto slope = [&](Part part) -> double& {
      return sum.slopes[Index(part)][kSharedCount + Index(Own::kImpact)];
    };
    slope(Part::kEven) = (d * even.a - odd.a) / time_scale;
    slope(Part::kOdd) = (d * odd.a - discriminant * even.a) / time_scale;
    slope(Part::kElectrical) = circuit.electrical_rate_per_s().a * electrical.a / time_scale;
  }
};

Circuitry CircuitryOf(const RingDownSamples& record, double inductance_h, const Jets& jets,
                      const double* own) {
  const auto circuit = Circuit(record, inductance_h, jets.shared.data(), own);
  // the shapes begin below 0: a record of positive polarity has the opposite sign
  const Jet amplitude = -record.polarity * Amplitude(record, jets.shared.data(), jets.own.data());
  const auto shape = Shape(record.signal, circuit);
  return {circuit, amplitude * shape.even, amplitude * shape.odd, amplitude * shape.electrical};
}

RecordPoles PolesOf(const sim::RingDown<Jet>& circuit) {
  RecordPoles poles{{circuit.decay_per_s().a, circuit.stiffness_per_s2().a}};
  for (std::size_t k = 0; k < kSharedCount; ++k) {
    poles.decay_slopes[k] = circuit.decay_per_s().v[static_cast<int>(k)];
    poles.stiffness_slopes[k] = circuit.stiffness_per_s2().v[static_cast<int>(k)];
  }
  return poles;
}

}  // namespace

RingingSum SumOfParts(const RingDownSamples& record, double inductance_h, const double* shared,
                      const double* own) {
  const Circuitry ringing = CircuitryOf(record, inductance_h, MakeJets(shared, own), own);
  RingingSum sum;
  sum.poles = PolesOf(ringing.circuit);
  sum.rates = {.decay_per_s = sum.poles.poles.decay_per_s,
               .stiffness_per_s2 = sum.poles.poles.stiffness_per_s2,
               .electrical_rate_per_s = ringing.circuit.electrical_rate_per_s().a,
               .impact_s = own[Index(Own::kImpact)]};
  sum.voltage[Index(Part::kEven)] = ringing.even.a;
  sum.voltage[Index(Part::kOdd)] = ringing.odd.a;
  sum.voltage[Index(Part::kElectrical)] = ringing.electrical.a;
  for (std::size_t k = 0; k < kSharedCount; ++k) ringing.WriteAutomatic(k, sum);
  ringing.WriteAutomatic(kSharedCount + Index(Own::kAmplitude), sum);
  ringing.WriteByImpact(record.time_scale, sum);
  // its own stiffness and damping act as those of all
  for (auto& slopes : sum.slopes) {
    slopes[kSharedCount + Index(Own::kStiffness)] = slopes[Index(Shared::kStiffness)];
    slopes[kSharedCount + Index(Own::kDamping)] = slopes[Index(Shared::kDamping)];
  }
  // linear parameters, from the offset on: the part's coefficient, with a slope of 1
  for (std::size_t k = 0; Index(Own::kOffset) + k < Index(Own::kStiffness); ++k) {
    sum.voltage[Index(Part::kConstant) + k] = own[Index(Own::kOffset) + k];
    sum.slopes[Index(Part::kConstant) + k][kSharedCount + Index(Own::kOffset) + k] = 1;
  }
  return sum;
}

}  // namespace haptometer::fit
