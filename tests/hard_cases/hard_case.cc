#include "tests/hard_cases/hard_case.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

namespace haptometer::hard_cases {

double RelativeError(double value, long double truth) {
  if (!std::isfinite(value)) return std::numeric_limits<double>::infinity();
  const long double difference = std::fabs(static_cast<long double>(value) - truth);
  return static_cast<double>(truth == 0 ? difference : difference / std::fabs(truth));
}

void Check(const HardCase& hard_case, const Answers& answers) {
  const double error = RelativeError(answers.ours, answers.truth);
  const double naive_error = RelativeError(answers.naive, answers.truth);
  EXPECT_LE(error, hard_case.bar) << hard_case.name;
  EXPECT_GT(naive_error, hard_case.bar) << hard_case.name << ": " << hard_case.naive;

  // an exact answer has no number of digits
  const char* file = std::getenv("HAPTOMETER_HARD_CASES");
  if (file == nullptr) return;
  nlohmann::json row = {{"room", hard_case.room},
                        {"name", hard_case.name},
                        {"why", hard_case.why},
                        {"naive", hard_case.naive},
                        {"naive_value", answers.naive},
                        {"naive_error", naive_error},
                        {"bar", hard_case.bar},
                        {"error", error},
                        {"digits", nullptr}};
  if (error > 0) row["digits"] = -std::log10(error);
  std::ofstream(file, std::ios::app) << row.dump() << '\n';
}

}  // namespace haptometer::hard_cases
