#include "sim/linear/window_rms.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

#include "base/error.h"

namespace haptometer::sim {
namespace {

// what rounding of the result leaves, relative
constexpr double kWindowRounding = 2e-15;
// what n times less rounding leaves of the error is less than this over n
constexpr double kWindowLeftOver = 64;
// an error at which the other way is tried as well
constexpr double kWellKnown = 1e-12;

// how z goes on: as the free motion beside the drive, or under it
enum class WindowWay : std::uint8_t { kFree, kDriven };

// The motion in arithmetic of either length, in balanced units.
template <typename Scalar>
class ScalarMotion {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  explicit ScalarMotion(const LinearMotion& motion)
      : frequency_hz_(motion.frequency_hz),
        omega_(2 * std::numbers::pi_v<Scalar> * static_cast<Scalar>(motion.frequency_hz)),
        a_(motion.a.template cast<Scalar>()),
        push_(static_cast<Scalar>(motion.amplitude_v) * motion.b.template cast<Scalar>()) {
    SolvePhasors();
    const Eigen::Index n = a_.rows();
    free_ = motion.initial ? (motion.initial->template cast<Scalar>() - phasors_.col(1)).eval()
                           : Vector::Zero(n);
    initial_ =
        motion.initial ? motion.initial->template cast<Scalar>().eval() : phasors_.col(1).eval();
  }

  // the RMS of a state over the window
  Scalar Rms(WindowWay way, Eigen::Index state, long double begin_s, long double end_s) const {
    const Eigen::Index n = a_.rows();
    // c'z: the state, and beside a free motion its phasor
    Vector output = Vector::Zero(n + 2);
    output(state) = 1;
    if (way == WindowWay::kFree) output.tail(2) = phasors_.row(state).transpose();
    const BalancedMatrix balanced = Balance(Generator(way).template cast<double>());
    const Vector scale = balanced.scale.template cast<Scalar>();
    const Matrix generator =
        scale.cwiseInverse().asDiagonal() * Generator(way) * scale.asDiagonal();
    Vector z(n + 2);
    z << (way == WindowWay::kFree ? free_ : initial_), 0, 1;
    if (begin_s > 0) z = (Exponential(Generator(way), static_cast<Scalar>(begin_s)) * z).eval();
    // the drive's phase is that of the window's begin, from whole cycles on
    z.tail(2) = DriveAt(frequency_hz_, begin_s).template cast<Scalar>();
    z = z.cwiseQuotient(scale).eval();
    const auto length_s = static_cast<Scalar>(end_s - begin_s);
    const Matrix gramian = Gramian(generator, output.cwiseProduct(scale), length_s);
    return std::sqrt(std::max(Scalar{0}, z.dot(gramian * z)) / length_s);
  }

 private:
  // X = (j w - A)^-1 B V, its real and imaginary part as columns
  void SolvePhasors() {
    const Eigen::Index n = a_.rows();
    const Vector scale = Balance(a_.template cast<double>()).scale.template cast<Scalar>();
    const Matrix a = scale.cwiseInverse().asDiagonal() * a_ * scale.asDiagonal();
    // -A Xr - w Xi = B V and w Xr - A Xi = 0
    Matrix equations(2 * n, 2 * n);
    equations << -a, -omega_ * Matrix::Identity(n, n), omega_ * Matrix::Identity(n, n), -a;
    Vector right = Vector::Zero(2 * n);
    right.head(n) = push_.cwiseQuotient(scale);
    const Eigen::PartialPivLU<Matrix> factors(equations);
    Vector x = factors.solve(right);
    x += factors.solve((right - equations * x).eval());
    phasors_.resize(n, 2);
    phasors_ << scale.cwiseProduct(x.head(n)), scale.cwiseProduct(x.tail(n));
  }

  // of z = [x, sin w t, cos w t]
  Matrix Generator(WindowWay way) const {
    const Eigen::Index n = a_.rows();
    Matrix generator = Matrix::Zero(n + 2, n + 2);
    generator.topLeftCorner(n, n) = a_;
    if (way == WindowWay::kDriven) generator.col(n).head(n) = push_;
    generator(n, n + 1) = omega_;
    generator(n + 1, n) = -omega_;
    return generator;
  }

  static Matrix Exponential(const Matrix& generator, Scalar t_s) {
    if constexpr (std::is_same_v<Scalar, double>) {
      return MatrixExponential(t_s * generator);
    } else {
      return LongMatrixExponential(generator, t_s);
    }
  }

  // S(length) of a balanced generator
  static Matrix Gramian(const Matrix& g, const Vector& c, Scalar length_s) {
    constexpr int kTerms = 20;
    // an interval so short that the series below converge at once, 2^-doublings of the window:
    // |G| h <= 1/4
    const Scalar norm = g.cwiseAbs().colwise().sum().maxCoeff() * length_s;
    const int doublings = std::max(0, 2 + std::ilogb(static_cast<double>(norm)) + 1);
    const auto h = static_cast<Scalar>(std::ldexp(1.0, -doublings)) * length_s;
    // S(h) and exp(G h) as Taylor series: h^(k+1) / (k+1)! M_k with M_0 = c c',
    // M_(k+1) = G' M_k + M_k G
    Matrix term = h * c * c.transpose();
    Matrix gramian = term;
    Matrix power = Matrix::Identity(g.rows(), g.rows());
    Matrix e = power;
    for (int k = 1; k <= kTerms; ++k) {
      term = (h / static_cast<Scalar>(k + 1)) * (g.transpose() * term + term * g).eval();
      gramian += term;
      power = ((h / static_cast<Scalar>(k)) * (power * g)).eval();
      e += power;
    }
    for (int k = 0; k < doublings; ++k) {
      gramian += (e.transpose() * gramian * e).eval();
      e = (e * e).eval();
    }
    return gramian;
  }

  double frequency_hz_;
  Scalar omega_;  // rad/s
  Matrix a_;
  Vector push_;     // B V
  Matrix phasors_;  // (n, 2): the steady motion is the first column's sine, the second's cosine
  Vector free_;     // the free motion at t = 0
  Vector initial_;  // the whole motion there
};

double RelativeApart(double value, double reference) {
  return value == reference ? 0 : std::abs(value / reference - 1);
}

}  // namespace

LinearMotion LinearMotionOf(const Scene& scene) {
  HAPTOMETER_CHECK(scene.drive.kind == DriveKind::kSine, "a drive of kind {}",
                   Name(scene.drive.kind));
  LongModel rows = AssembleLongModel(scene);
  LinearMotion motion{.a = std::move(rows.a),
                      .b = std::move(rows.b),
                      .amplitude_v = scene.drive.amplitude_v,
                      .frequency_hz = scene.drive.frequency_hz,
                      .initial = {}};
  if (StartOf(scene) == Start::kSteady) return motion;
  const LinearModel model = AssembleModel(scene);
  LongVector& x = motion.initial.emplace(StatedStart(scene.initial, model).cast<long double>());
  // under an offset i = V/R, and the mover rests where Kv xv = -Km i
  const Actuator& actuator = scene.actuator;
  const auto offset_v = static_cast<long double>(scene.drive.offset_v);
  const long double current_a =
      offset_v / (static_cast<long double>(actuator.resistance_ohm) +
                  static_cast<long double>(scene.drive.source_resistance_ohm));
  x(LinearModel::kMover) += static_cast<long double>(actuator.force_constant_n_per_a) * current_a /
                            static_cast<long double>(actuator.stiffness_n_per_m);
  if (model.current_per_volt == 0) x(model.states() - 1) -= current_a;
  return motion;
}

WindowRms WindowRmsOf(const LinearMotion& motion, Eigen::Index state, long double begin_s,
                      long double end_s) {
  HAPTOMETER_CHECK(begin_s >= 0 && end_s > begin_s, "[{}, {}] s", begin_s, end_s);
  constexpr auto kFiner =
      static_cast<double>(static_cast<long double>(std::numeric_limits<double>::epsilon()) /
                          std::numeric_limits<long double>::epsilon());
  // the rounding of the window's begin, over its length
  const auto of_time =
      static_cast<double>(std::numeric_limits<long double>::epsilon() * end_s / (end_s - begin_s));
  const ScalarMotion<long double> fine(motion);
  const ScalarMotion<double> coarse(motion);
  const auto by = [&](WindowWay way) {
    const auto rms = static_cast<double>(fine.Rms(way, state, begin_s, end_s));
    const double apart = RelativeApart(coarse.Rms(way, state, begin_s, end_s), rms);
    const double error = kWindowLeftOver / kFiner * apart + kWindowRounding + of_time;
    return WindowRms{.rms = rms, .error_estimate = std::isfinite(error) ? error : HUGE_VAL};
  };
  const WindowRms free = by(WindowWay::kFree);
  if (free.error_estimate <= kWellKnown) return free;
  const WindowRms driven = by(WindowWay::kDriven);
  return driven.error_estimate < free.error_estimate ? driven : free;
}

}  // namespace haptometer::sim
