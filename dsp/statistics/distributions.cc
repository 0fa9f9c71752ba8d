#include "dsp/statistics/distributions.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

namespace math = boost::math;
// numbers instead of exceptions; inside, doubles are worked on as long doubles (Boost's default),
// and quantiles are not rounded to the discrete
using Quiet =
    math::policies::policy<math::policies::domain_error<math::policies::ignore_error>,
                           math::policies::pole_error<math::policies::ignore_error>,
                           math::policies::overflow_error<math::policies::ignore_error>,
                           math::policies::evaluation_error<math::policies::ignore_error>>;
using Student = math::students_t_distribution<double, Quiet>;
using NoncentralStudent = math::non_central_t_distribution<double, Quiet>;
using Fisher = math::fisher_f_distribution<double, Quiet>;
using ChiSquare = math::chi_squared_distribution<double, Quiet>;

constexpr double kTail = (1 - kConfidence) / 2;
// beyond this |t| and |t| / sqrt(df) the noncentral distribution cannot be computed
constexpr double kLargestT = 1e3;

// root in [low, high] of `excess`, which is monotone; nothing without a change of sign
template <typename Excess>
std::optional<double> Root(const Excess& excess, double low, double high) {
  const double at_low = excess(low);
  const double at_high = excess(high);
  if (!(at_low * at_high < 0)) return std::nullopt;
  // to 1e-14, near the rounding of doubles
  const auto tight = [](double a, double b) {
    return std::abs(a - b) <= 1e-14 * std::max(1.0, std::abs(a));
  };
  std::uintmax_t steps = 200;
  const auto [a, b] =
      math::tools::toms748_solve(excess, low, high, at_low, at_high, tight, steps, Quiet());
  return a + (b - a) / 2;
}

}  // namespace

double StudentTwoSidedP(double t, double df) {
  HAPTOMETER_CHECK(df > 0, "{} degrees of freedom", df);
  if (std::isinf(t)) return 0;
  return 2 * math::cdf(math::complement(Student(df), std::abs(t)));
}

double StudentCritical(double df) {
  HAPTOMETER_CHECK(df > 0, "{} degrees of freedom", df);
  return math::quantile(math::complement(Student(df), kTail));
}

double FisherUpperP(double f, double df1, double df2) {
  HAPTOMETER_CHECK(f >= 0 && df1 > 0 && df2 > 0, "F({}, {}) = {}", df1, df2, f);
  if (std::isinf(f)) return 0;
  return math::cdf(math::complement(Fisher(df1, df2), f));
}

double FisherQuantile(double p, double df1, double df2) {
  HAPTOMETER_CHECK(p > 0 && p < 1 && df1 > 0 && df2 > 0, "F({}, {}), p = {}", df1, df2, p);
  return math::quantile(Fisher(df1, df2), p);
}

double ChiSquareQuantile(double p, double df) {
  HAPTOMETER_CHECK(p > 0 && p < 1 && df > 0, "chi-square({}), p = {}", df, p);
  return math::quantile(ChiSquare(df), p);
}

std::optional<Interval> NoncentralityInterval(double t, double df) {
  HAPTOMETER_CHECK(df > 0, "{} degrees of freedom", df);
  if (!(std::abs(t) <= kLargestT) || std::abs(t) > kLargestT * std::sqrt(df)) return std::nullopt;
  // the interval of -t mirrors that of t; for t >= 0 the required tails are not rounded beside 1
  const double size = std::abs(t);
  const auto upper_tail_excess = [&](double delta) {
    return math::cdf(math::complement(NoncentralStudent(df, delta), size)) - kTail;
  };
  const auto lower_tail_excess = [&](double delta) {
    return math::cdf(NoncentralStudent(df, delta), size) - kTail;
  };
  // noncentral t scatters by about sqrt(1 + t^2 / (2 df)) about delta: widely for df near 1
  const double reach = 8 + 8 * size / std::sqrt(df) + size;
  // P(T >= t) grows with delta, P(T <= t) falls: one root each
  const auto lower = Root(upper_tail_excess, -reach, size + 1);
  const auto upper = Root(lower_tail_excess, size - 1, size + reach);
  if (!lower || !upper) return std::nullopt;
  return t >= 0 ? Interval{*lower, *upper} : Interval{-*upper, -*lower};
}

std::optional<double> NoncentralityForPower(double df, double alpha, double power) {
  HAPTOMETER_CHECK(df > 0 && alpha > 0 && alpha < power && power < 1, "{}, {}, {}", df, alpha,
                   power);
  const double critical = math::quantile(math::complement(Student(df), alpha / 2));
  if (!(critical <= kLargestT) || critical > kLargestT * std::sqrt(df)) return std::nullopt;
  const auto excess = [&](double delta) {
    const NoncentralStudent t(df, delta);
    return math::cdf(math::complement(t, critical)) + math::cdf(t, -critical) - power;
  };
  // normal over chi: above 40 critical values every level is reached
  return Root(excess, 0, 40 * critical + 40);
}

}  // namespace haptometer::dsp
