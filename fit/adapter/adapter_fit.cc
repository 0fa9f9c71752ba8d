#include "fit/adapter/adapter_fit.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "base/mapped.h"
#include "fit/consensus_mean.h"
#include "fit/drop_test/prepared_record.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/uncertainty.h"

namespace haptometer::fit {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kLeastSamples = 32;
// more samples than this are averaged to blocks, which loses 0.3 % of their weight
constexpr std::size_t kManySamples = 20000;
constexpr double kBlocksPerPeriod = 32;

// logarithms of d and of q with their variances
struct Logarithms {
  std::array<double, 2> values{};  // ln d, ln q
  std::array<double, 2> variances{};
};

// one ring-down's fit over some samples of a record
struct Part {
  RingFit fit;
  Logarithms logarithms;
  ResidualDensity density;
  double residual_rms = 0;
  std::size_t samples = 0;
};

// sqrt(q)/(2 pi)
double Hertz(double stiffness_per_s2) {
  return std::sqrt(stiffness_per_s2) / (2 * std::numbers::pi);
}

// diagonal of (J'J)^-1 of the two poles
std::array<double, 2> UnitVariances(const Jacobian& jacobian) {
  const Eigen::Map<const RowMajor> whole(jacobian.values.data(),
                                         static_cast<Eigen::Index>(jacobian.rows),
                                         static_cast<Eigen::Index>(jacobian.columns));
  // columns of unit length, because their units differ
  Eigen::VectorXd lengths = whole.colwise().norm();
  lengths = (lengths.array() > 0).select(lengths, 1.0);
  const Eigen::MatrixXd scaled = whole * lengths.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::MatrixXd triangle =
      qr.matrixQR().topRows(whole.cols()).template triangularView<Eigen::Upper>();
  const Eigen::MatrixXd inverse = triangle.template triangularView<Eigen::Upper>().solve(
      Eigen::MatrixXd::Identity(whole.cols(), whole.cols()));
  // variance of parameter k: squared length of row k of the triangle's inverse
  return {inverse.row(0).squaredNorm() / (lengths[0] * lengths[0]),
          inverse.row(1).squaredNorm() / (lengths[1] * lengths[1])};
}

// nothing where too few samples are measured or the fit does not converge
std::optional<Part> FitPart(const ImpulseRecord& record, std::size_t first, std::size_t end,
                            const PolePair& start, const RingBackground& background) {
  const double period = 1 / (Hertz(start.stiffness_per_s2) * record.step_s);
  const bool many = end - first > kManySamples;
  const auto block = static_cast<std::size_t>(many ? std::max(period / kBlocksPerPeriod, 1.0) : 1);
  const RingSamples samples = BlocksOf(record, first, end, block);
  if (samples.values_v.size() < kLeastSamples) return {};
  Part part;
  part.fit = FitRing(samples, start, background);
  if (!part.fit.converged) return {};
  part.samples = samples.values_v.size();
  const auto& residuals = part.fit.jacobian.residuals;
  const Eigen::Map<const Eigen::VectorXd> view(residuals.data(),
                                               static_cast<Eigen::Index>(residuals.size()));
  const double square = view.squaredNorm();
  part.residual_rms = std::sqrt(square / static_cast<double>(part.samples));
  part.density = DensityAt(OnGrid(residuals, samples.times_s, samples.step_s), samples.step_s,
                           Hertz(part.fit.poles.stiffness_per_s2));
  // variance per degree of freedom, for the noise's density at the resonance
  const double noise =
      square / static_cast<double>(part.samples - part.fit.jacobian.columns) * part.density.ratio;
  const auto variances = UnitVariances(part.fit.jacobian);
  part.logarithms = {
      {std::log(part.fit.poles.decay_per_s), std::log(part.fit.poles.stiffness_per_s2)},
      {variances[0] * noise, variances[1] * noise}};
  return part;
}

// Doubts where the fit from half a decay time later has another result. The later part is contained
// in the whole: the variance of the difference is the difference of the variances.
void CompareWithLater(const PreparedRecord& prepared, const Part& whole, Findings* findings) {
  const double wanted_s = 0.5 / whole.fit.poles.decay_per_s;
  const double length_s =
      static_cast<double>(prepared.part.end_sample - prepared.part.first_sample) *
      prepared.record.step_s;
  // at least two thirds of the samples remain
  const double skipped_s = std::min(wanted_s, length_s / 3);
  const std::size_t first =
      prepared.part.first_sample + static_cast<std::size_t>(skipped_s / prepared.record.step_s);
  const auto later = FitPart(prepared.record, first, prepared.part.end_sample, whole.fit.poles,
                             prepared.part.background);
  if (!later) return;
  constexpr double kSurelyOther = 4;  // deviations
  // least changes of ln d and ln q that are reported
  constexpr std::array<double, 2> kNoticed{0.02, 1e-4};
  constexpr std::array kKinds{FindingKind::kDampingChangesLater,
                              FindingKind::kStiffnessChangesLater};
  for (std::size_t k = 0; k < 2; ++k) {
    const double change = later->logarithms.values[k] - whole.logarithms.values[k];
    const double variance =
        std::max(later->logarithms.variances[k] - whole.logarithms.variances[k], 0.0);
    if (std::abs(change) < kNoticed[k] || std::abs(change) < kSurelyOther * std::sqrt(variance)) {
      continue;
    }
    findings->Add(About(prepared.record.name, Severity::kDoubt, kKinds[k],
                        {{"share", change}, {"skipped_s", skipped_s}}));
  }
}

FittedTap Told(const PreparedRecord& prepared, const Part& part) {
  const auto time = [&](std::size_t sample) {
    return prepared.record.start_s + static_cast<double>(sample) * prepared.record.step_s;
  };
  return {.name = prepared.record.name,
          .first_s = time(prepared.part.first_sample),
          .end_s = time(prepared.part.end_sample),
          .samples = part.samples,
          .natural_frequency_hz = Hertz(part.fit.poles.stiffness_per_s2),
          .decay_per_s = part.fit.poles.decay_per_s,
          .amplitude = part.fit.Envelope(0),
          .residual_rms = part.residual_rms,
          .unit = prepared.record.unit,
          .density = part.density,
          .found = prepared.part.found};
}

// common value of one logarithm over the taps
ConsensusMean MeanOf(const std::vector<Logarithms>& taps, std::size_t which) {
  return ConsensusOf(Mapped<Estimate>(taps, [which](const Logarithms& tap) {
    return Estimate{tap.values[which], tap.variances[which]};
  }));
}

// what the record's time scale leaves open: d goes with the rate, q with its square
void AddTimeScale(const ImpulseRecord& record, Logarithms* tap) {
  if (!record.time_scale) return;
  const double share = record.time_scale->standard_uncertainty;
  tap->variances[0] += share * share;
  tap->variances[1] += 4 * share * share;
}

void Conclude(const std::vector<Logarithms>& taps, AdapterFit* fit) {
  const ConsensusMean decay = MeanOf(taps, 0);
  const ConsensusMean stiffness = MeanOf(taps, 1);
  const double ln_mass = std::log(fit->mass_kg.value);
  const double share = fit->mass_kg.standard_uncertainty / fit->mass_kg.value;
  const double ln_two = std::numbers::ln2;
  const auto degrees = static_cast<double>(std::max<std::size_t>(taps.size(), 2) - 1);
  // exp of a logarithm that goes with the powers of q and d; the two are uncorrelated but for
  // rounding
  const auto constant = [&](double logarithm, double power_of_q, double power_of_d, double given,
                            const char* unit) {
    const double q = power_of_q * power_of_q;
    const double d = power_of_d * power_of_d;
    const double variance = q * stiffness.variance + d * decay.variance;
    const double scatter = std::hypot(q * stiffness.scatter_variance, d * decay.scatter_variance);
    FittedValue value = FromLogarithm(logarithm, variance, given, unit);
    SetIntervals(ScatterCoverage(variance + given, scatter, degrees), {&value});
    return value;
  };
  // Ka = M q, Ba = 2 M d; type B: the mass
  fit->stiffness = constant(ln_mass + stiffness.value, 1, 0, share * share, "N/m");
  fit->damping = constant(ln_mass + ln_two + decay.value, 0, 1, share * share, "N s/m");
  fit->stiffness_over_mass = constant(stiffness.value, 1, 0, 0, "1/s^2");
  fit->damping_over_mass = constant(ln_two + decay.value, 0, 1, 0, "1/s");
  // sqrt(q) / (2 pi), sqrt(q) / 2d
  fit->natural_frequency =
      constant(stiffness.value / 2 - std::log(2 * std::numbers::pi), 0.5, 0, 0, "Hz");
  fit->quality_factor = constant(stiffness.value / 2 - ln_two - decay.value, 0.5, -1, 0, "");
  fit->stiffness_birge_ratio = stiffness.birge_ratio;
  fit->damping_birge_ratio = decay.birge_ratio;
  // upper limit of 95 % of a damping that is not determined
  const double damping = 2 * fit->mass_kg.value * std::exp(decay.value);
  const double variance = decay.variance + share * share;
  const double coverage = ScatterCoverage(variance, decay.scatter_variance, degrees);
  if (!fit->damping.determined) {
    fit->damping.at_most = damping * (1 + coverage * std::sqrt(variance));
  }
}

// A pair of poles cannot follow a frequency that falls with the amplitude; the residual resembles a
// series of small impacts.
void DoubtManyImpacts(const FittedTap& tap, Findings& findings) {
  constexpr auto kMany = 3;
  const auto impacts =
      std::ranges::count(tap.found.list(), FindingKind::kLaterImpact, &Finding::kind);
  if (impacts < kMany) return;
  findings.Add(
      About(tap.name, Severity::kDoubt, FindingKind::kManyImpacts, {{"impacts", impacts}}));
}

void Explain(AdapterFit* fit) {
  using enum FindingKind;
  Findings& findings = fit->findings;
  findings.Note(kOneSideHeld);
  findings.Note(kTimeBaseExact);
  if (!fit->stiffness.determined) findings.Refuse(kKaNotDetermined);
  if (!fit->damping.determined) {
    findings.Refuse(kBaBelow, {{"at_most_n_s_per_m", *fit->damping.at_most}});
  }
  const double degrees = static_cast<double>(fit->taps.size()) - 1;
  for (const auto& [constant, ratio] :
       {std::pair{"Ka", fit->stiffness_birge_ratio}, {"Ba", fit->damping_birge_ratio}}) {
    if (degrees < 1 || !Scatters(ratio, degrees)) continue;
    findings.Doubt(kTapsScatter, {{"constant", std::string(constant)},
                                  {"birge_ratio", ratio},
                                  {"degrees_of_freedom", std::lround(degrees)}});
  }
  DoubtUnusual(kUnusualFrequency, "natural_frequency_hz", fit->natural_frequency.value,
               sim::kPlausibleResonanceHz, findings);
  DoubtUnusual(kUnusualAdapterMass, "mass_kg", fit->mass_kg.value, sim::kPlausibleAdapterMassKg,
               findings);
  DoubtUnusual(kUnusualQuality, "quality_factor", fit->quality_factor, {1, 2000}, findings);
  for (const auto& tap : fit->taps) {
    DoubtManyImpacts(tap, findings);
    if (tap.unit != "m") {
      findings.Add({Severity::kDoubt, kNoDisplacement, {{"unit", tap.unit}}, tap.name});
      continue;
    }
    DoubtUnusual(kUnusualAmplitude, "amplitude_m", tap.amplitude, {1e-8, 0.02}, findings, tap.name);
  }
}

}  // namespace

Result<ImpulseRecord> TapFromRecord(const trial::Record& record, const std::string& name) {
  std::vector<const trial::Channel*> meant;
  for (const auto& channel : record.channels) {
    if (channel.role == trial::ChannelRole::kDisplacement) meant.push_back(&channel);
  }
  // a table's single column, regardless of its name
  if (meant.empty() && record.channels.size() == 1) meant.push_back(record.channels.data());
  if (meant.size() != 1) {
    return CannotAnswer(name, meant.empty() ? "has no displacement" : "has several displacements",
                        meant.empty() ? "give a trial or a CSV with time_s,displacement_m"
                                      : "name the adapter's channel");
  }
  if (record.stretches.size() != 1 ||
      (record.timing != trial::Timing::kUniform && record.stretches[0].time_uncertainty_s > 0)) {
    return CannotAnswer(name, "has gaps or a non-uniform time base",
                        "record the tap with a clocked source, without lost rows");
  }
  ImpulseRecord tap;
  tap.name = name;
  tap.start_s = record.stretches[0].start_s;
  tap.step_s = 1 / record.stretches[0].rate_hz;
  tap.time_scale = TimeScaleOf(record.stretches[0]);
  tap.voltage_v = meant[0]->values;
  tap.unit = meant[0]->unit;
  if (tap.unit == "m") tap.signal = RecordedSignal::kDisplacement;
  // samples whose status is no measurement are missing
  for (std::size_t n = 0; n < meant[0]->statuses.size(); ++n) {
    if (!trial::IsMeasurement(meant[0]->statuses[n])) tap.voltage_v[n] = std::nan("");
  }
  return tap;
}

Result<AdapterFit> FitAdapter(const std::vector<ImpulseRecord>& records, const Quantity& mass_kg) {
  AdapterFit fit;
  fit.mass_kg = mass_kg;
  std::vector<Logarithms> taps;
  for (const auto& record : records) {
    const auto prepared = PrepareRecord(record);
    if (!prepared) {
      fit.left_out.push_back(prepared.error());
      continue;
    }
    const auto part =
        FitPart(prepared->record, prepared->part.first_sample, prepared->part.end_sample,
                prepared->start.poles, prepared->part.background);
    if (!part) {
      fit.left_out.push_back(CannotAnswer(record.name, "holds too few clean samples of a ring-down",
                                          "record a tap and three decay times")
                                 .error());
      continue;
    }
    taps.push_back(part->logarithms);
    AddTimeScale(record, &taps.back());
    fit.taps.push_back(Told(*prepared, *part));
    CompareWithLater(*prepared, *part, &fit.findings);
  }
  if (taps.empty()) {
    if (!fit.left_out.empty()) return std::unexpected(fit.left_out.front());
    return CannotAnswer("", "no record of a tap is given", "give a recording of a tap");
  }
  Conclude(taps, &fit);
  Explain(&fit);
  return fit;
}

}  // namespace haptometer::fit
