#pragma once

#include <string>

namespace haptometer::hard_cases {

/// What is always known of a hard case, in words for the generated page.
struct HardCase {
  std::string room;   ///< acquire, trial, dsp, sim or fit
  std::string name;   ///< unique in its room
  std::string why;    ///< why it is hard
  std::string naive;  ///< the naive method or peer that the case itself runs
  double bar = 0;     ///< largest relative error that is accepted; 0: exact
};

/// One quantity by three ways, in one unit.
struct Answers {
  long double truth = 0;  ///< the oracle; relative errors are absolute ones where it is 0
  double ours = 0;        ///< the answer of the room
  double naive = 0;       ///< the answer of the naive method
};

/// |value - truth| / |truth|, or |value| where the truth is 0; infinite for a NaN.
[[nodiscard]] double RelativeError(double value, long double truth);

/// Fails the running test where our error is above the bar, or the naive method is as good.
///
/// With HAPTOMETER_HARD_CASES=FILE in the environment, adds one JSON row a case to FILE; numbers
/// that are not finite, and the digits of an exact answer, are null.
void Check(const HardCase& hard_case, const Answers& answers);

}  // namespace haptometer::hard_cases
