#include "dsp/spectrum/chi_squared.h"

#include <boost/math/distributions/chi_squared.hpp>

#include "base/check.h"

namespace haptometer::dsp {

double ChiSquaredQuantile(double probability, double degrees_of_freedom) {
  HAPTOMETER_CHECK(probability > 0 && probability < 1 && degrees_of_freedom > 0,
                   "probability = {}, degrees_of_freedom = {}", probability, degrees_of_freedom);
  return boost::math::quantile(boost::math::chi_squared(degrees_of_freedom), probability);
}

}  // namespace haptometer::dsp
