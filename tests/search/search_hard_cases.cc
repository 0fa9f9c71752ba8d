// Searches for cases in which a room's answer differs from an independent reference:
//
//   search_hard_cases [--seconds 60] [--seed N] [--only scenes|filters|records|drops|wires]
//
// The properties take turns, a round of some cases each, until the time is over; the first turn is
// always whole. Round k of a property draws from seed N + k, so a failure is repeated by the
// command that is printed with it, whatever the machine's speed. Status 1: a property failed.
#include <fmt/core.h>
#include <rapidcheck.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <string_view>

#include "tests/search/draws.h"

namespace haptometer::search {
namespace {

struct Property {
  std::string_view name;
  bool (*run)();
  int cases_of_round = 0;  ///< so that rounds take about as long
  std::uint64_t cases = 0;
  std::uint64_t compared = 0;  // of them
  std::uint64_t failures = 0;  // rounds
};

struct Options {
  double seconds = 60;
  std::uint64_t seed = std::random_device{}();
  std::string_view only;
};

template <typename Number>
bool Read(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

// nothing: not as the usage says
std::optional<Options> ReadOptions(int count, char** arguments) {
  Options options;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string_view name = arguments[i];
    const std::string_view value = arguments[i + 1];
    if (name == "--only") {
      options.only = value;
    } else if (name == "--seconds" ? !Read(value, options.seconds)
                                   : name != "--seed" || !Read(value, options.seed)) {
      return std::nullopt;
    }
  }
  if (count % 2 == 0) return std::nullopt;
  return options;
}

// the command that repeats the round that runs
std::array<char, 128> command_of_round;

// a case that aborts the program: what it drew, as far as it came
void TellCase(int /*signal*/) {
  const auto tell = [](std::string_view text) {
    static_cast<void>(!write(STDOUT_FILENO, text.data(), text.size()));
  };
  tell("\nABORTED by\n");
  tell(DrawsOfCase());
  tell(command_of_round.data());
}

class CaseCounter : public rc::detail::TestListener {
 public:
  void onTestCaseFinished(const rc::detail::CaseDescription& /*description*/) override { ++cases_; }
  void onShrinkTried(const rc::detail::CaseDescription& /*shrink*/, bool /*accepted*/) override {}
  void onTestFinished(const rc::detail::TestMetadata& /*metadata*/,
                      const rc::detail::TestResult& /*result*/) override {}
  [[nodiscard]] std::uint64_t cases() const { return cases_; }

 private:
  std::uint64_t cases_ = 0;
};

// Runs cases of a property and keeps the last that failed, which is the smallest one found. From
// some seconds after the first failure on all cases hold, which ends the shrinking.
class Runner {
 public:
  explicit Runner(Property* property) : property_(property) {}

  void operator()() {
    constexpr std::chrono::seconds kShrinking{20};
    if (failed_ && std::chrono::steady_clock::now() - *failed_ > kShrinking) return;
    DrawsOfCase().clear();
    try {
      property_->compared += property_->run() ? 1 : 0;
    } catch (const rc::detail::CaseResult& result) {
      if (!failed_) failed_ = std::chrono::steady_clock::now();
      smallest_ = fmt::format("{}\n{}", result.description, DrawsOfCase());
      throw;
    }
  }

  [[nodiscard]] const std::string& smallest() const { return smallest_; }

 private:
  Property* property_;
  std::optional<std::chrono::steady_clock::time_point> failed_{};
  std::string smallest_{};
};

void RunRound(std::uint64_t seed, Property& property) {
  const auto end = fmt::format_to_n(command_of_round.data(), command_of_round.size() - 1,
                                    "  repeat: search_hard_cases --only {} --seed {} --seconds 0\n",
                                    property.name, seed);
  *end.out = '\0';
  rc::detail::TestParams parameters;
  parameters.seed = seed;
  parameters.maxSuccess = property.cases_of_round;
  CaseCounter counter;
  Runner runner(&property);
  const auto result = rc::detail::checkTestable([&runner] { runner(); }, rc::detail::TestMetadata{},
                                                parameters, counter);
  property.cases += counter.cases();
  if (result.is<rc::detail::SuccessResult>()) return;
  ++property.failures;
  fmt::print("\nFAILED {}: {}{}", property.name, runner.smallest(), command_of_round.data());
}

int Search(const Options& options) {
  std::array<Property, 5> properties{{{"scenes", SceneCase, 20},
                                      {"filters", FilterCase, 40},
                                      {"records", RecordCase, 60},
                                      {"drops", DropCase, 60},
                                      {"wires", WireCase, 100}}};
  const auto begin = std::chrono::steady_clock::now();
  const auto is_over = [&] {
    const std::chrono::duration<double> run = std::chrono::steady_clock::now() - begin;
    return run.count() >= options.seconds;
  };
  for (std::uint64_t round = 0; round == 0 || !is_over(); ++round) {
    for (Property& property : properties) {
      if (!options.only.empty() && options.only != property.name) continue;
      if (round > 0 && is_over()) break;
      RunRound(options.seed + round, property);
      std::fflush(stdout);
    }
  }
  bool any_failed = false;
  for (const Property& property : properties) {
    fmt::print("{}: {} cases, {} compared, {} failures\n", property.name, property.cases,
               property.compared, property.failures);
    any_failed = any_failed || property.failures > 0;
  }
  return any_failed ? 1 : 0;
}

}  // namespace
}  // namespace haptometer::search

int main(int count, char** arguments) {
  const auto options = haptometer::search::ReadOptions(count, arguments);
  constexpr std::string_view kNames = " scenes filters records drops wires ";
  if (!options ||
      !kNames.contains(fmt::format(" {} ", options->only).substr(options->only.empty()))) {
    fmt::print(stderr,
               "usage: search_hard_cases [--seconds 60] [--seed N]"
               " [--only scenes|filters|records|drops|wires]\n");
    return 2;
  }
  fmt::print("seed {}\n", options->seed);
  std::fflush(stdout);
  // RapidCheck prints its own configuration once, though each round has its own
  setenv("RC_PARAMS", fmt::format("seed={}", options->seed).c_str(), 1);
  std::signal(SIGABRT, haptometer::search::TellCase);
  return haptometer::search::Search(*options);
}
