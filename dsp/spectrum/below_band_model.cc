#include "dsp/spectrum/below_band_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "dsp/spectrum/decimated.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// Legendre's P_0 .. P_3: a cubic drift
constexpr std::size_t kDriftTerms = 4;
// sines below the band that are modelled, and sines in the band that are fitted to find them
constexpr int kMostLow = 3;
constexpr int kMostInBand = 2;
constexpr int kMostSteps = 12;
// last change of a phase at the ends in rad
constexpr double kAtRestRad = 1e-11;
// steps that shrink by less than this are slow because of noise; what they leave, as a part of that
constexpr double kSlowRate = 0.1;
constexpr double kOfNoise = 0.1;
// rate over the band's upper corner, and fewest samples, that decimation leaves
constexpr double kRatePerUpper = 4;
constexpr std::size_t kLeastSize = 4096;
constexpr std::size_t kBlock = PhasorBlocks::kBlock;

using Sine = BelowBandModel::Sine;

struct Parts {
  std::array<double, kDriftTerms> drift{};
  std::vector<Sine> sines;
};

std::array<double, kDriftTerms> Legendre(double tau) {
  return {1, tau, 0.5 * (3 * tau * tau - 1), 0.5 * tau * (5 * tau * tau - 3)};
}

// places of samples: tau from -1 to 1 over the signal, angles from its middle
struct Frame {
  double middle = 0;
  double rate_hz = 0;

  [[nodiscard]] double Tau(std::size_t n) const {
    return (static_cast<double>(n) - middle) / middle;
  }
};

// adds `factor` times the parts to samples from `first` on
void AddParts(const Frame& frame, const Parts& parts, std::size_t first, double factor,
              std::span<double> samples) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto p = Legendre(frame.Tau(first + k));
    double value = 0;
    for (std::size_t term = 0; term < kDriftTerms; ++term) value += parts.drift[term] * p[term];
    samples[k] += factor * value;
  }
  for (const Sine& sine : parts.sines) {
    SubtractSine(kTwoPi * sine.frequency_hz / frame.rate_hz, -factor * sine.cosine,
                 -factor * sine.sine, static_cast<double>(first) - frame.middle, samples);
  }
}

// derivatives of the model at samples from `first` on: by the drift's terms, then by cosine, sine
// and w T/2 of each sine
void FillRows(const Frame& frame, const Parts& parts, std::span<const PhasorBlocks> phasors,
              std::size_t first, Eigen::Ref<Eigen::MatrixXd> rows) {
  const auto size = static_cast<std::size_t>(rows.rows());
  Eigen::ArrayXd tau(rows.rows());
  for (std::size_t k = 0; k < size; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    tau[row] = frame.Tau(first + k);
    const auto p = Legendre(tau[row]);
    for (std::size_t term = 0; term < kDriftTerms; ++term) {
      rows(row, static_cast<Eigen::Index>(term)) = p[term];
    }
  }
  const double first_from_middle = static_cast<double>(first) - frame.middle;
  Eigen::Index column = kDriftTerms;
  for (std::size_t k = 0; k < phasors.size(); ++k, column += 3) {
    const Sine& sine = parts.sines[k];
    auto c = rows.col(column);
    auto s = rows.col(column + 1);
    phasors[k].Fill(first_from_middle, std::span(c.data(), size), std::span(s.data(), size));
    rows.col(column + 2) = tau * (sine.sine * c.array() - sine.cosine * s.array());
  }
}

// m = sum of drift[k] P_k + sum of (cosine cos(w t) + sine sin(w t)), by the columns of FillRows
Eigen::VectorXd FactorsOf(const Parts& parts) {
  const auto columns = static_cast<Eigen::Index>(kDriftTerms + 3 * parts.sines.size());
  Eigen::VectorXd factors = Eigen::VectorXd::Zero(columns);
  Eigen::Index column = 0;
  for (const double term : parts.drift) factors[column++] = term;
  for (const Sine& sine : parts.sines) {
    factors[column] = sine.cosine;
    factors[column + 1] = sine.sine;
    column += 3;
  }
  return factors;
}

struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

// J'J and J' residual of one step, a block of rows at a time
Normal Linearise(const Frame& frame, const Parts& parts, std::span<const double> signal) {
  const Eigen::VectorXd factors = FactorsOf(parts);
  Normal normal{Eigen::MatrixXd::Zero(factors.size(), factors.size()),
                Eigen::VectorXd::Zero(factors.size())};
  std::vector<PhasorBlocks> phasors;
  phasors.reserve(parts.sines.size());
  for (const Sine& sine : parts.sines) {
    phasors.emplace_back(kTwoPi * sine.frequency_hz / frame.rate_hz);
  }
  Eigen::MatrixXd block(kBlock, factors.size());
  for (std::size_t begin = 0; begin < signal.size(); begin += kBlock) {
    const auto size = static_cast<Eigen::Index>(std::min(kBlock, signal.size() - begin));
    auto rows = block.topRows(size);
    FillRows(frame, parts, phasors, begin, rows);
    const Eigen::VectorXd left =
        Eigen::Map<const Eigen::VectorXd>(signal.data() + begin, size) - rows * factors;
    normal.matrix.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    normal.right.noalias() += rows.transpose() * left;
  }
  return normal;
}

// one Gauss-Newton step with columns scaled to one length; gives the largest change of a phase at
// the ends in rad, nothing where the parts are linearly dependent
std::optional<double> Step(const Frame& frame, std::span<const double> signal, Parts& parts) {
  Normal normal = Linearise(frame, parts, signal);
  const Eigen::VectorXd scale =
      normal.matrix.diagonal().unaryExpr([](double x) { return x > 0 ? 1 / std::sqrt(x) : 1.0; });
  normal.matrix = scale.asDiagonal() * normal.matrix * scale.asDiagonal();
  normal.right = scale.asDiagonal() * normal.right;
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal.matrix);
  if (solver.info() != Eigen::Success || !(solver.rcond() > 1e-12)) return std::nullopt;
  const Eigen::VectorXd change = scale.asDiagonal() * solver.solve(normal.right);
  if (!change.allFinite()) return std::nullopt;
  Eigen::Index column = 0;
  for (double& term : parts.drift) term += change[column++];
  double turn = 0;
  const double half_s = frame.middle / frame.rate_hz;
  for (Sine& sine : parts.sines) {
    sine.cosine += change[column++];
    sine.sine += change[column++];
    turn = std::max(turn, std::abs(change[column]));
    // w T/2 in rad to Hz
    sine.frequency_hz += change[column++] / (kTwoPi * half_s);
  }
  return turn;
}

// Whether what steps of `turn` rad, each `rate` times the one before, leave to go is a small part
// of the phase's own uncertainty. Steps of Gauss and Newton shrink at once where the model explains
// the signal; else by the rate of the motion that is not explained to the sine's amplitude, which
// is the uncertainty of its phase in rad.
bool IsWithinNoise(double turn, double rate) {
  return rate > kSlowRate && rate < 1 && turn * rate / (1 - rate) < kOfNoise * rate;
}

// Gauss-Newton steps until they converge; false where a frequency leaves its start by 1 / duration
bool Refine(const Frame& frame, std::span<const double> signal, Parts& parts) {
  const std::vector<Sine> start = parts.sines;
  const double most_hz = 0.5 * frame.rate_hz / frame.middle;  // 1 / duration
  double before = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const std::optional<double> turn = Step(frame, signal, parts);
    if (!turn) return false;
    for (std::size_t k = 0; k < start.size(); ++k) {
      const double moved = std::abs(parts.sines[k].frequency_hz - start[k].frequency_hz);
      if (!(moved <= most_hz) || !(parts.sines[k].frequency_hz > 0)) return false;
    }
    if (*turn < kAtRestRad || IsWithinNoise(*turn, before > 0 ? *turn / before : 0)) return true;
    before = *turn;
  }
  return true;  // noise keeps it moving by less than it matters
}

std::vector<double> Rest(const Frame& frame, std::span<const double> signal, const Parts& parts) {
  std::vector<double> rest(signal.begin(), signal.end());
  AddParts(frame, parts, 0, -1, rest);
  return rest;
}

// `fit` in the model's terms: its phase is at the first sample
Sine StartOf(const Frame& frame, const SineFit& fit) {
  const double phase = fit.phase_rad + kTwoPi * fit.frequency_hz * frame.middle / frame.rate_hz;
  return {fit.frequency_hz, fit.amplitude * std::cos(phase), -fit.amplitude * std::sin(phase)};
}

}  // namespace

double BelowBandModel::Sine::amplitude() const { return std::hypot(cosine, sine); }

std::optional<BelowBandModel> BelowBandModel::Fit(std::span<const double> signal, double rate_hz,
                                                  double lower_hz, double upper_hz) {
  // sines in the band are fitted too, to be let go: what folds onto them matters little
  const Decimator decimator(
      Decimator::FactorFor(signal.size(), rate_hz, kRatePerUpper * upper_hz, kLeastSize), rate_hz);
  if (decimator.factor() == 1) return FitAll(signal, rate_hz, lower_hz, upper_hz);
  const std::vector<double> slow = decimator.Decimate(signal);
  auto model = FitAll(slow, decimator.rate_hz(), lower_hz, upper_hz);
  if (model) model->Refer(decimator, signal.size());
  return model;
}

// From every n-th sample to all of them: sines without the decimator's gain, their phase from the
// middle of the longer signal, and the cubic as the same function of time.
void BelowBandModel::Refer(const Decimator& decimator, std::size_t size) {
  const auto every = static_cast<double>(decimator.factor());
  const double slow_half = 0.5 * static_cast<double>(size_ - 1);
  const double half = 0.5 * static_cast<double>(size - 1);
  // where the middle of the decimated samples lies in the longer signal
  const double middle = slow_half * every + 0.5 * static_cast<double>(decimator.taps() - 1);
  for (Sine& sine : sines_) {
    const double gain = decimator.GainAt(sine.frequency_hz);
    const double turn = kTwoPi * sine.frequency_hz * (middle - half) / (rate_hz_ * every);
    const double c = sine.cosine / gain;
    const double s = sine.sine / gain;
    sine.cosine = c * std::cos(turn) - s * std::sin(turn);
    sine.sine = c * std::sin(turn) + s * std::cos(turn);
  }
  // a cubic is determined by its values at four places
  Eigen::Matrix4d terms;
  Eigen::Vector4d values;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const double tau = -1 + 2.0 * static_cast<double>(k) / 3;
    const auto at_all = Legendre(tau);
    const auto at_slow = Legendre((half + tau * half - middle) / (slow_half * every));
    values[k] = 0;
    for (std::size_t term = 0; term < kDriftTerms; ++term) {
      terms(k, static_cast<Eigen::Index>(term)) = at_all[term];
      values[k] += drift_[term] * at_slow[term];
    }
  }
  const Eigen::Vector4d drift = terms.partialPivLu().solve(values);
  for (std::size_t term = 0; term < kDriftTerms; ++term) {
    drift_[term] = drift[static_cast<Eigen::Index>(term)];
  }
  rate_hz_ *= every;
  size_ = size;
}

std::optional<BelowBandModel> BelowBandModel::FitAll(std::span<const double> signal, double rate_hz,
                                                     double lower_hz, double upper_hz) {
  if (signal.size() < 8) return std::nullopt;
  const Frame frame{0.5 * static_cast<double>(signal.size() - 1), rate_hz};
  // two periods over the signal at least: less is drift
  const double least_hz = 2 * rate_hz / static_cast<double>(signal.size());
  if (!(least_hz < lower_hz)) return std::nullopt;
  std::vector<double> centred(signal.begin(), signal.end());
  const double mean = Mean(signal);
  for (double& x : centred) x -= mean;

  // drift alone first; then one sine after the other, each the strongest tone of the residual
  Parts parts;
  if (!Refine(frame, centred, parts)) return std::nullopt;
  int low = 0;
  for (int in_band = 0; low < kMostLow && in_band <= kMostInBand;) {
    const auto tone = StrongestTone(Rest(frame, centred, parts), {rate_hz, least_hz, upper_hz, 0});
    if (!tone) break;
    Parts more = parts;
    more.sines.push_back(StartOf(frame, *tone));
    if (!Refine(frame, centred, more)) break;
    parts = std::move(more);
    ++(tone->frequency_hz < lower_hz ? low : in_band);
  }
  // sines in the band were fitted only to find weaker ones below it
  std::erase_if(parts.sines, [&](const Sine& sine) { return sine.frequency_hz >= lower_hz; });
  if (parts.sines.empty()) return std::nullopt;
  std::ranges::sort(parts.sines, std::ranges::greater{}, [](const Sine& sine) {
    return std::pair(sine.amplitude(), sine.frequency_hz);
  });

  BelowBandModel model;
  model.drift_ = parts.drift;
  model.drift_[0] += mean;
  model.sines_ = std::move(parts.sines);
  model.rate_hz_ = rate_hz;
  model.size_ = signal.size();
  return model;
}

void BelowBandModel::Subtract(std::size_t first, std::span<double> samples) const {
  HAPTOMETER_CHECK(first + samples.size() <= size_, "{} + {} of {}", first, samples.size(), size_);
  const Frame frame{0.5 * static_cast<double>(size_ - 1), rate_hz_};
  const Parts parts{drift_, sines_};
  AddParts(frame, parts, first, -1, samples);
}

// a steady sine leaves both passes multiplied by |H|^2, the cubic as 0
void BelowBandModel::AddFiltered(const FilterDesign& design, std::size_t first,
                                 std::span<double> filtered) const {
  HAPTOMETER_CHECK(first + filtered.size() <= size_, "{} + {} of {}", first, filtered.size(),
                   size_);
  const Frame frame{0.5 * static_cast<double>(size_ - 1), rate_hz_};
  Parts parts{{}, sines_};
  for (Sine& sine : parts.sines) {
    const double gain = std::norm(Response(design, sine.frequency_hz));
    sine.cosine *= gain;
    sine.sine *= gain;
  }
  AddParts(frame, parts, first, 1, filtered);
}

}  // namespace haptometer::dsp
