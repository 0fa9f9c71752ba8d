#include "sim/linear/excitation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/error.h"
#include "sim/linear/driven_step.h"

namespace haptometer::sim {
namespace {

using Kind = ExcitationTerm::Kind;

// number of signals: sin and cos, with a ramp also tau sin and tau cos, or derivatives 0 to degree
Eigen::Index SizeOf(const ExcitationTerm& term) {
  switch (term.kind) {
    case Kind::kTone:
      return 2;
    case Kind::kRampedTone:
      return 4;
    case Kind::kPolynomial:
      return term.degree + 1;
  }
  return 0;
}

Eigen::Index SizeOf(const ExcitationPiece& piece) {
  Eigen::Index size = 0;
  for (const ExcitationTerm& term : piece.terms) size += SizeOf(term);
  return size;
}

// a term's block of S in w' = S w, and its row of u = rows w
void FillShape(const ExcitationTerm& term, Eigen::Index at, ExcitationShape& shape) {
  Eigen::MatrixXd& s = shape.generator;
  if (term.kind == Kind::kPolynomial) {
    // each derivative is the rate of the one before
    for (Eigen::Index k = 0; k < term.degree; ++k) s(at + k, at + k + 1) = 1;
    shape.rows(term.input, at) = 1;
    return;
  }
  const double omega = 2 * std::numbers::pi * term.frequency_hz;
  // sin' = w cos, cos' = -w sin
  for (Eigen::Index pair = at; pair < at + SizeOf(term); pair += 2) {
    s(pair, pair + 1) = omega;
    s(pair + 1, pair) = -omega;
    shape.pairs.push_back(pair);
  }
  shape.rows(term.input, at) = term.amplitude;
  if (term.kind == Kind::kTone) return;
  // (tau sin)' = sin + w tau cos
  s(at + 2, at) = 1;
  s(at + 3, at + 1) = 1;
  shape.rows(term.input, at + 2) = term.amplitude_per_s;
}

// sin and cos of a tone's phase 2 pi f (t - origin) + phase_rad
Eigen::Vector2d TurnOf(const ExcitationTerm& term, long double t_s) {
  Eigen::Vector2d turn = DriveAt(term.frequency_hz, t_s - static_cast<long double>(term.origin_s));
  if (term.phase_rad == 0) return turn;
  // addition theorems, so that the phase of the frequency alone is reduced exactly
  const auto [s, c] = SinCos(term.phase_rad);
  return {turn[0] * c + turn[1] * s, turn[1] * c - turn[0] * s};
}

ExcitationTerm Silence() { return {.kind = Kind::kPolynomial}; }

// a bound of |v''''| / A of a chirp: v'''' = A ((w^4 - 3 a^2) sin - 6 a w^2 cos)
double FourthOfChirp(const Drive& drive) {
  const double w0 = 2 * std::numbers::pi * drive.frequency_hz;
  const double w1 = 2 * std::numbers::pi * drive.end_frequency_hz;
  const double w = std::max(w0, w1), a = std::abs(w1 - w0) / drive.duration_s;
  return w * w * w * w + 6 * a * w * w + 3 * a * a;
}

}  // namespace

double CubicsOf(const Drive& chirp) {
  // error h^4 / 384 max abs(v'''') of cubics h apart, set equal to hold_tolerance x amplitude
  const double step_s = Pow(384 * chirp.hold_tolerance / FourthOfChirp(chirp), 0.25);
  const double cubics = std::ceil(chirp.duration_s / step_s);
  // whole milliseconds: as many in each, so that knots and outputs meet
  const double milliseconds = std::round(1000 * chirp.duration_s);
  const bool is_whole =
      milliseconds >= 1 && std::abs(1000 * chirp.duration_s - milliseconds) <= 1e-12 * milliseconds;
  return is_whole ? milliseconds * std::ceil(cubics / milliseconds) : cubics;
}

ExcitationShape ShapeOf(const ExcitationPiece& piece) {
  const Eigen::Index m = SizeOf(piece);
  HAPTOMETER_CHECK(m > 0, "a piece without terms");
  ExcitationShape shape{.generator = Eigen::MatrixXd::Zero(m, m),
                        .rows = Eigen::MatrixXd::Zero(kInputs, m),
                        .pairs = {}};
  Eigen::Index at = 0;
  for (const ExcitationTerm& term : piece.terms) {
    FillShape(term, at, shape);
    at += SizeOf(term);
  }
  // the finger's rate is the derivative of its position
  shape.rows.row(kFingerRate) = shape.rows.row(kFinger) * shape.generator;
  return shape;
}

bool SameShape(const ExcitationPiece& one, const ExcitationPiece& other) {
  return std::ranges::equal(one.terms, other.terms, [](const auto& a, const auto& b) {
    if (a.kind != b.kind || a.input != b.input) return false;
    if (a.kind == Kind::kPolynomial) return a.degree == b.degree;
    return a.frequency_hz == b.frequency_hz && a.amplitude == b.amplitude &&
           a.amplitude_per_s == b.amplitude_per_s;
  });
}

void FillSignals(const ExcitationPiece& piece, long double t_s, Eigen::VectorXd& w) {
  w.resize(SizeOf(piece));
  const auto tau = static_cast<double>(t_s - piece.begin_s);
  Eigen::Index at = 0;
  for (const ExcitationTerm& term : piece.terms) {
    if (term.kind == Kind::kPolynomial) {
      // Horner, for each derivative
      for (int k = 0; k <= term.degree; ++k) {
        double value = 0;
        for (int j = term.degree; j >= k; --j) {
          value = value * tau / (j - k + 1) + term.derivatives[static_cast<std::size_t>(j)];
        }
        w[at++] = value;
      }
      continue;
    }
    const Eigen::Vector2d turn = TurnOf(term, t_s);
    w.segment<2>(at) = turn;
    if (term.kind == Kind::kRampedTone) w.segment<2>(at + 2) = tau * turn;
    at += SizeOf(term);
  }
}

// bounds of each signal over a piece: 1 for sin, its length in s for tau sin
Eigen::VectorXd LargestSignals(const ExcitationPiece& piece) {
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(SizeOf(piece));
  const auto length_s = static_cast<double>(piece.end_s - piece.begin_s);
  Eigen::Index at = 0;
  for (const ExcitationTerm& term : piece.terms) {
    if (term.kind == Kind::kPolynomial) {
      for (int k = 0; k <= term.degree; ++k) {
        // sum of abs(derivative j) T^(j - k) / (j - k)! by Horner's rule
        double bound = 0;
        for (int j = term.degree; j >= k; --j) {
          const double part = std::abs(term.derivatives[static_cast<std::size_t>(j)]);
          bound = (j == term.degree ? 0 : bound * length_s / (j - k + 1)) + part;
        }
        largest[at++] = bound;
      }
      continue;
    }
    largest[at] = 1;
    if (term.kind == Kind::kRampedTone) largest[at + 2] = length_s;
    at += SizeOf(term);
  }
  return largest;
}

Excitation::Excitation(const SineDrive& drive) {
  before_.push_back(
      {.terms = {{.amplitude = drive.amplitude_v, .frequency_hz = drive.frequency_hz}}});
  AddOffset(drive.offset_v);
}

Excitation::Excitation(const Drive& drive, const std::vector<Tone>& finger) {
  switch (drive.kind) {
    case DriveKind::kSine:
      before_ = Excitation(SineDrive(drive)).before_;
      break;
    case DriveKind::kTones:
      AddTones(drive.tones, kVoltage, before_.emplace_back());
      break;
    case DriveKind::kBurst:
      AddBurst(drive);
      break;
    case DriveKind::kChirp:
      HoldChirp(drive);
      break;
    case DriveKind::kPulse:
      AddPulse(drive);
      break;
    case DriveKind::kSamples:
      HoldSamples(drive);
      break;
  }
  AddOffset(drive.offset_v);
  ExcitationPiece moving;
  AddTones(finger, kFinger, moving);
  lasting_.insert(lasting_.end(), moving.terms.begin(), moving.terms.end());
}

// without an offset no term: a sine alone takes fewer operations
void Excitation::AddOffset(double offset_v) {
  if (offset_v == 0) return;
  ExcitationTerm constant = Silence();
  constant.derivatives[0] = offset_v;
  lasting_.push_back(constant);
}

ExcitationPiece Excitation::Piece(std::size_t place) const {
  HAPTOMETER_CHECK(place < size(), "piece {} of {}", place, size());
  ExcitationPiece piece;
  if (place < before_.size()) {
    piece = before_[place];
  } else {
    // a piece between each two knots: samples are joined by straight lines, a chirp's by cubics
    const std::size_t k = place - before_.size();
    const auto time_of = [&](std::size_t knot) {
      return static_cast<long double>(held_from_s_) +
             static_cast<long double>(knot) / static_cast<long double>(held_rate_hz_);
    };
    piece.begin_s = time_of(k);
    ExcitationTerm term = Silence();
    // after the last knot the drive is 0, apart from its offset
    if (k + 1 < knots_) {
      piece.end_s = time_of(k + 1);
      const auto [v0, d0] = knot_(k);
      const auto [v1, d1] = knot_(k + 1);
      const double rate = held_rate_hz_, rise = (v1 - v0) * rate;
      term.degree = held_degree_;
      term.derivatives = {v0, rise, 0, 0};
      // Hermite's cubic through the values v0, v1 and the slopes d0, d1
      if (held_degree_ == 3) {
        term.derivatives = {v0, d0, (6 * rise - 4 * d0 - 2 * d1) * rate,
                            (6 * (d0 + d1) - 12 * rise) * rate * rate};
      }
    }
    piece.terms = {term};
  }
  piece.terms.insert(piece.terms.end(), lasting_.begin(), lasting_.end());
  return piece;
}

void Excitation::AddTones(const std::vector<Tone>& tones, Eigen::Index input,
                          ExcitationPiece& piece) const {
  piece.terms.reserve(tones.size());
  for (const Tone& tone : tones) {
    piece.terms.push_back({.input = input,
                           .amplitude = tone.amplitude,
                           .frequency_hz = tone.frequency_hz,
                           .phase_rad = tone.phase_rad});
  }
}

void Excitation::AddSilence(long double begin_s, long double end_s) {
  if (begin_s < end_s) before_.push_back({begin_s, end_s, {Silence()}});
}

void Excitation::AddBurst(const Drive& drive) {
  const auto start_s = static_cast<long double>(drive.start_s);
  const long double risen_s = start_s + static_cast<long double>(drive.rise_s);
  const long double falls_s = risen_s + static_cast<long double>(drive.hold_s);
  const long double end_s = falls_s + static_cast<long double>(drive.fall_s);
  const ExcitationTerm tone{.amplitude = drive.amplitude_v,
                            .frequency_hz = drive.frequency_hz,
                            .origin_s = drive.start_s};
  AddSilence(0, start_s);
  // A tau / rise_s, then A, then A (1 - tau / fall_s): one phase over all three
  if (drive.rise_s > 0) {
    ExcitationTerm rising = tone;
    rising.kind = Kind::kRampedTone;
    rising.amplitude = 0;
    rising.amplitude_per_s = drive.amplitude_v / drive.rise_s;
    before_.push_back({start_s, risen_s, {rising}});
  }
  if (drive.hold_s > 0) before_.push_back({risen_s, falls_s, {tone}});
  if (drive.fall_s > 0) {
    ExcitationTerm falling = tone;
    falling.kind = Kind::kRampedTone;
    falling.amplitude_per_s = -drive.amplitude_v / drive.fall_s;
    before_.push_back({falls_s, end_s, {falling}});
  }
  before_.push_back({.begin_s = end_s, .terms = {Silence()}});
}

void Excitation::AddPulse(const Drive& drive) {
  const auto start_s = static_cast<long double>(drive.start_s);
  const long double end_s = start_s + static_cast<long double>(drive.hold_s);
  ExcitationTerm on = Silence();
  on.derivatives[0] = drive.amplitude_v;
  AddSilence(0, start_s);
  if (drive.hold_s > 0) before_.push_back({start_s, end_s, {on}});
  before_.push_back({.begin_s = end_s, .terms = {Silence()}});
}

// a linear chirp as Hermite cubics at knots 1 / held_rate_hz_ apart
void Excitation::HoldChirp(const Drive& drive) {
  AddSilence(0, static_cast<long double>(drive.start_s));
  const double tau = 2 * std::numbers::pi;
  const double w0 = tau * drive.frequency_hz, w1 = tau * drive.end_frequency_hz;
  // rad/s^2
  const double acceleration = (w1 - w0) / drive.duration_s;
  const double intervals = CubicsOf(drive);
  HAPTOMETER_CHECK(intervals < 1e9, "{} cubics", intervals);
  knots_ = static_cast<std::size_t>(intervals) + 1;
  held_degree_ = 3;
  held_from_s_ = drive.start_s;
  held_rate_hz_ = intervals / drive.duration_s;
  // V, at most A hold_tolerance
  voltage_error_v_ =
      std::abs(drive.amplitude_v) * FourthOfChirp(drive) * Pow(held_rate_hz_, -4) / 384;
  knot_ = [drive, acceleration, w0, rate = held_rate_hz_](std::size_t k) {
    const long double s = static_cast<long double>(k) / static_cast<long double>(rate);
    // phase in cycles f0 s + (f1 - f0) s^2 / (2 T), in long double for its fraction
    const long double cycles =
        s * (static_cast<long double>(drive.frequency_hz) +
             static_cast<long double>(drive.end_frequency_hz - drive.frequency_hz) * s /
                 (2 * static_cast<long double>(drive.duration_s)));
    const Eigen::Vector2d turn = DriveAt(1, cycles);
    // slope at the knot, V/s
    const double omega = w0 + acceleration * static_cast<double>(s);
    return Knot{drive.amplitude_v * turn[0], drive.amplitude_v * omega * turn[1]};
  };
}

void Excitation::HoldSamples(const Drive& drive) {
  HAPTOMETER_CHECK(drive.samples && drive.samples->rate_hz > 0, "no samples");
  const std::shared_ptr<const VoltageSamples> samples = drive.samples;
  knots_ = std::max<std::size_t>(samples->voltages_v.size(), 1);
  held_rate_hz_ = samples->rate_hz;
  knot_ = [samples](std::size_t k) { return Knot{samples->voltages_v[k], 0}; };
}

}  // namespace haptometer::sim
