#include "tools/calibrate/reference_points.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "acquire/protocol/sample_format.h"

namespace haptometer::tools {
namespace {

using trial::SampleStatus;

constexpr int kMostUnanswered = 5;
constexpr int kMostWithoutSamples = 10;
constexpr std::size_t kLeastReadings = 8;
constexpr double kLongestWindow = 10;  // times window_s, where readings are slow
constexpr double kStillInputV = 5e-3;

// running mean and variance (Welford)
struct Running {
  double count = 0;
  double mean = 0;
  double squares = 0;
  double least = 0;
  double most = 0;

  void Add(double value) {
    least = count > 0 ? std::min(least, value) : value;
    most = count > 0 ? std::max(most, value) : value;
    ++count;
    const double from_mean = value - mean;
    mean += from_mean / count;
    squares += from_mean * (value - mean);
  }
  [[nodiscard]] double StandardError() const {
    return count > 1 ? std::sqrt(squares / (count - 1) / count) : 0;
  }
};

// one quantity over a window: the whole and its two halves
struct Halves {
  Running whole;
  std::array<Running, 2> half;

  void Add(double value, bool is_second) {
    whole.Add(value);
    half[is_second ? 1 : 0].Add(value);
  }
  // whether the halves agree within `limit`, or `errors` standard errors of their difference
  [[nodiscard]] bool Agree(double limit, double errors) const {
    if (half[0].count == 0 || half[1].count == 0) return false;
    const double error = std::hypot(half[0].StandardError(), half[1].StandardError());
    return std::abs(half[1].mean - half[0].mean) <= std::max(limit, errors * error);
  }
  [[nodiscard]] MeanValue Value() const { return {whole.mean, whole.StandardError()}; }
};

struct Window {
  Halves displacement;
  Halves analog;
  Halves input;
  bool has_error = false;
  bool is_at_rail = false;
};

// what a window shows by itself; kSettling stands for still
WindowState StateOf(const Window& window, const StillQuestion& question) {
  if (window.has_error) return WindowState::kErrorLevel;
  if (window.is_at_rail) return WindowState::kAtRail;
  const Running& readings = window.displacement.whole;
  if (readings.count < 2 || window.input.whole.count < 2) return WindowState::kNoSamples;
  const double farthest = std::max(readings.most - readings.mean, readings.mean - readings.least);
  const bool is_still = farthest <= question.still_m &&
                        window.displacement.Agree(question.still_m / 4, 3) &&
                        window.input.Agree(kStillInputV, 5);
  return is_still ? WindowState::kSettling : WindowState::kMoving;
}

// lines of numbers from the DAQ's program
class Input {
 public:
  Input(acquire::Transport& transport, const trial::RawLimits& rails)
      : transport_(transport), parser_(acquire::SampleFormat::kText, {rails}) {}

  // takes what is there without waiting; nullptr drops it
  void Drain(Clock& clock, Window* window, bool is_second) {
    // a source that never pauses must not hold up the readings
    constexpr int kMostChunks = 64;
    for (int i = 0; i < kMostChunks && !has_ended_; ++i) {
      const acquire::ReadOutcome outcome = transport_.Read(chunk_, clock.Now());
      has_ended_ = outcome.state == acquire::ReadState::kGone;
      if (outcome.state != acquire::ReadState::kBytes) return;
      parser_.Feed({chunk_.data(), outcome.bytes});
      trial::Sample sample;
      for (auto row = parser_.Next({&sample, 1}); row != acquire::RowState::kNeedMore;
           row = parser_.Next({&sample, 1})) {
        if (window == nullptr || row == acquire::RowState::kBadRow) continue;
        if (sample.status == SampleStatus::kClipped) window->is_at_rail = true;
        if (sample.status == SampleStatus::kOk) {
          window->input.Add(sample.raw.Number(trial::Encoding::kF64), is_second);
        }
      }
    }
  }
  [[nodiscard]] bool has_ended() const { return has_ended_; }
  [[nodiscard]] const std::string& name() const { return transport_.name(); }

 private:
  acquire::Transport& transport_;
  acquire::SampleParser parser_;
  std::array<char, 65'536> chunk_{};
  bool has_ended_ = false;
};

// reads the amplifier and the DAQ by turns over one window
Result<Window> ReadWindow(acquire::KeyenceIl& reference, Input& input, Clock& clock,
                          const std::atomic<bool>& stop, const StillQuestion& question,
                          const std::string& name) {
  Window window;
  const MonotonicNs begin = clock.Now();
  const MonotonicNs length = NsFromSeconds(question.window_s);
  int unanswered = 0;
  while (!stop.load() && !input.has_ended()) {
    const MonotonicNs elapsed = clock.Now() - begin;
    if (elapsed >= NsFromSeconds(kLongestWindow * question.window_s)) break;
    if (elapsed >= length && window.displacement.whole.count >= kLeastReadings) break;
    if (elapsed >= length && window.has_error) break;
    const bool is_second = 2 * elapsed >= length;
    HAPTOMETER_LET(const auto read, reference.ReadAnalog(stop));
    unanswered = read.status == SampleStatus::kLate ? unanswered + 1 : 0;
    if (unanswered == kMostUnanswered) {
      return Failed(name, "does not answer the reading of data 038 and 042",
                    "check the cable; an amplifier without data 042 is calibrated from pairs");
    }
    if (read.status == SampleStatus::kOk) {
      window.displacement.Add(read.displacement_m, is_second);
      window.analog.Add(read.volts, is_second);
    } else if (read.status != SampleStatus::kLate && read.status != SampleStatus::kBadFrame) {
      window.has_error = true;
    }
    input.Drain(clock, &window, is_second);
  }
  return window;
}

// still: whether it is a point, by the window and the point before
WindowState PlaceOf(const Window& window, const std::optional<double>& before_m,
                    const ReferencePoints& found, const StillQuestion& question) {
  const double place_m = window.displacement.whole.mean;
  if (!found.points.empty() &&
      std::abs(place_m - found.points.back().displacement_m.mean) < question.apart_m) {
    return WindowState::kSamePlace;
  }
  const bool has_settled = before_m && std::abs(place_m - *before_m) <= question.still_m / 2;
  return has_settled ? WindowState::kPoint : WindowState::kSettling;
}

}  // namespace

Result<ReferencePoints> CollectPoints(
    acquire::KeyenceIl& reference, acquire::Transport& input_port, Clock& clock,
    const std::atomic<bool>& stop, const StillQuestion& question,
    const std::function<void(WindowState, const ReferencePoints&)>& tell) {
  ReferencePoints found;
  Input input(input_port, question.rails);
  // what waits in the pipe is older than the first reading
  input.Drain(clock, nullptr, false);
  const MonotonicNs deadline = clock.Now() + NsFromSeconds(question.timeout_s);
  std::optional<double> before_m;  // of the window before, where it was still
  int without_samples = 0;
  while (found.points.size() < question.points && clock.Now() < deadline && !stop.load() &&
         !input.has_ended()) {
    const auto window =
        ReadWindow(reference, input, clock, stop, question, reference.header().metadata.source);
    // an interruption ends an exchange with an error
    if (!window && stop.load()) break;
    if (!window) return std::unexpected(window.error());
    WindowState state = StateOf(*window, question);
    const bool is_still = state == WindowState::kSettling;
    if (is_still) state = PlaceOf(*window, before_m, found, question);
    before_m = is_still ? std::optional(window->displacement.whole.mean) : std::nullopt;
    if (state == WindowState::kPoint) {
      found.points.push_back({.displacement_m = window->displacement.Value(),
                              .analog_v = window->analog.Value(),
                              .input_v = window->input.Value()});
    }
    found.moving += state == WindowState::kMoving ? 1 : 0;
    found.error_level += state == WindowState::kErrorLevel ? 1 : 0;
    found.at_rail += state == WindowState::kAtRail ? 1 : 0;
    without_samples = state == WindowState::kNoSamples ? without_samples + 1 : 0;
    if (without_samples == kMostWithoutSamples) {
      return Failed(input.name(), "gives no numbers",
                    "check that it writes a line of volts for each sample");
    }
    tell(state, found);
  }
  found.input_ended = input.has_ended() && found.points.size() < question.points && !stop.load();
  return found;
}

}  // namespace haptometer::tools
