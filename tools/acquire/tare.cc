#include "tools/acquire/tare.h"

#include <fmt/core.h>

#include "tools/acquire/sample_value.h"
#include "trial/record.h"

namespace haptometer::tools {

using acquire::Outcome;

namespace {

constexpr double kTareS = 1;
constexpr MonotonicNs kPatienceNs = 3 * kNsPerS;

// the mean so far, and whether it is enough
class TareMean {
 public:
  TareMean(const trial::TrialHeader& header, std::size_t channel, MonotonicNs begin_ns)
      : header_(header),
        channel_(channel),
        begin_ns_(begin_ns),
        patient_until_ns_(Later(begin_ns)) {}

  void Add(const acquire::Reading& reading, MonotonicNs now_ns) {
    const trial::Sample& sample = reading.samples[channel_];
    const bool is_measurement = IsMeasurement(sample.status);
    if (is_measurement) {
      ++count_;
      const double value = ValueOf(header_.channels[channel_], sample);
      mean_ += (value - mean_) / static_cast<double>(count_);
    }
    if (is_uniform()) {
      // its rows come when they like, but each is a part of the second; nothing is asked for
      is_over_ = static_cast<double>(reading.index + 1) >= kTareS * header_.rate_hz;
      patient_until_ns_ = Later(now_ns);
    } else {
      // behind an answer nothing is outstanding that a new beginning could mistake for its own
      is_over_ = is_measurement && now_ns - begin_ns_ >= NsFromSeconds(kTareS);
    }
  }

  [[nodiscard]] bool is_over() const { return is_over_; }
  [[nodiscard]] bool IsPatient(MonotonicNs now_ns) const { return now_ns < patient_until_ns_; }

  [[nodiscard]] Result<double> Mean(const std::string& name) const {
    if (is_uniform() && !is_over_) {
      return CannotAnswer(name, "sent less than a second of readings and fell silent during --tare",
                          "check that the source goes on, or leave --tare out");
    }
    if (count_ > 0) return mean_;
    return CannotAnswer(name, "gave no measurement to tare by",
                        "check that the laser is on and meets its target within the range");
  }

 private:
  [[nodiscard]] bool is_uniform() const { return header_.timing == trial::Timing::kUniform; }
  static MonotonicNs Later(MonotonicNs now_ns) { return now_ns + kPatienceNs; }

  const trial::TrialHeader& header_;
  std::size_t channel_;
  MonotonicNs begin_ns_;
  MonotonicNs patient_until_ns_;
  std::size_t count_ = 0;
  double mean_ = 0;
  bool is_over_ = false;
};

}  // namespace

Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock, const std::atomic<bool>& stop,
                           const std::string& name) {
  const auto channel = trial::DisplacementChannel(sensor.header());
  if (!channel) return CannotAnswer(name, "has no displacement to tare", "leave --tare out");
  acquire::Reading reading;
  (void)sensor.Begin();
  TareMean tare(sensor.header(), *channel, clock.Now());
  while (!stop.load() && !tare.is_over() && tare.IsPatient(clock.Now())) {
    const Outcome outcome = sensor.Next(reading);
    if (outcome == Outcome::kGone || outcome == Outcome::kAway) {
      // the second before the recording cannot be made up for, so nothing is waited for
      return Failed(name, "the connection was lost during --tare",
                    "check cable and power, and start again");
    }
    if (outcome == Outcome::kEnd) {
      return CannotAnswer(name, "ended during --tare, which takes its first second",
                          "give it more than that, or leave --tare out");
    }
    if (outcome == Outcome::kReading) tare.Add(reading, clock.Now());
  }
  if (stop.load()) return Failed(name, "was not recorded: interrupted during --tare");
  return tare.Mean(name);
}

}  // namespace haptometer::tools
