// What comes before the recording: the first answers, the header, the remarks.
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "acquire/sensor/modbus/modbus_reading.h"
#include "acquire/sensor/modbus/modbus_sensor.h"
#include "acquire/transport/latency_timer.h"

namespace haptometer::acquire {
namespace {

constexpr int kTries = 3;

}  // namespace

Result<ReadReply> ModbusSensor::Exchange(ReadRequest request, int tries,
                                         const std::atomic<bool>& stop) {
  ReadReply answer{.fault = ModbusFault::kTimeout};
  for (int attempt = 0; attempt < tries; ++attempt) {
    clock_.SleepUntil(free_from_ns_);
    if (!Send(request, Phase::kFree)) {
      return Failed(link_->name(), "the connection was lost", "check cable and power");
    }
    const MonotonicNs deadline = request_ns_ + profile_.longest_reply_ns;
    while (clock_.Now() < deadline) {
      if (stop.load()) {
        return Failed(link_->name(), "was not recorded: interrupted before the first reading");
      }
      const ModbusReply reply = Receive(std::min(deadline, clock_.Now() + kSliceNs));
      if (reply.arrival == ModbusArrival::kGone) {
        return Failed(link_->name(), "the connection was lost", "check cable and power");
      }
      if (reply.arrival == ModbusArrival::kNothing) continue;
      answer = Parse(reply);
      if (answer.fault == ModbusFault::kNone) return answer;
      discarded_bytes_ += reply.bytes.size();
    }
    start_was_silent_ = true;
  }
  return answer;
}

// the registers, or why there are none
Result<std::string> ModbusSensor::Ask(ReadRequest request, const std::atomic<bool>& stop) {
  const auto answer = Exchange(request, kTries, stop);
  if (!answer) return std::unexpected(answer.error());
  if (answer->fault == ModbusFault::kNone && answer->exception == 0) {
    return std::string(answer->registers);
  }
  const std::string asked =
      fmt::format("slave {}, function {:02}, {} registers from {}", request.unit, request.function,
                  request.count, request.address + profile_.address_base);
  if (answer->exception != 0) {
    return CannotAnswer(
        link_->name(),
        fmt::format("refuses {} with exception {:02} ({})", asked, answer->exception,
                    ModbusExceptionText(answer->exception)),
        profile_.advice.empty() ? "give the --profile of this sensor" : profile_.advice);
  }
  const std::string settings =
      fmt::format("{} baud, parity {}", profile_.wire.baud, Name(profile_.wire.parity));
  std::string remedy = fmt::format("check that the sensor is on, --slave{}",
                                   is_rtu() ? ", baud rate and parity in the profile, and A and B "
                                              "of the cable"
                                            : " and the --profile");
  if (!profile_.advice.empty()) remedy += "; " + profile_.advice;
  return CannotAnswer(
      link_->name(),
      answer->fault == ModbusFault::kTimeout
          ? fmt::format("nothing answers to {}{}", asked, is_rtu() ? " at " + settings : "")
          : fmt::format("answers to {} come damaged ({})", asked, Name(answer->fault)),
      remedy);
}

Result<void> ModbusSensor::Start(const std::atomic<bool>& stop) {
  double register_scale = 1;
  if (profile_.scale_address) {
    ReadRequest request = ReadingRequest(profile_);
    request.address = static_cast<std::uint16_t>(*profile_.scale_address - profile_.address_base);
    request.count = 1;
    const auto registers = Ask(request, stop);
    if (!registers) return std::unexpected(registers.error());
    register_scale = RegisterAt(*registers, 0);
    if (register_scale == 0) {
      return CannotAnswer(
          link_->name(),
          fmt::format("register {}, which scales its values, holds 0", *profile_.scale_address),
          profile_.advice.empty() ? "check the --profile" : profile_.advice);
    }
  }
  const auto registers = Ask(ReadingRequest(profile_), stop);
  if (!registers) return std::unexpected(registers.error());
  MakeHeader(register_scale);
  return LearnCheck(stop);
}

// TCP needs no checks: there replies are told apart by their identifiers
Result<void> ModbusSensor::LearnCheck(const std::atomic<bool>& stop) {
  if (!is_rtu()) return {};
  const bool was_silent = std::exchange(start_was_silent_, false);
  const auto answer = Exchange(CheckRequest(profile_), 1, stop);
  if (!answer) return std::unexpected(answer.error());
  has_checks_ = answer->fault == ModbusFault::kNone && answer->exception == 0;
  // registers of a check are behind everything older
  start_was_silent_ = !has_checks_ && (start_was_silent_ || was_silent);
  errors_ = {};
  return {};
}

void ModbusSensor::MakeHeader(double register_scale) {
  header_.timing = trial::Timing::kPolled;
  header_.channels = {ChannelOf(profile_, register_scale)};
  Describe(header_.metadata);
  if (!profile_.timestamp_address && profile_.fastest_rate_hz) {
    repeats_.emplace(NsFromSeconds(1.0 / *profile_.fastest_rate_hz));
  }
}

void ModbusSensor::Describe(trial::Metadata& metadata) const {
  metadata.sensor = "modbus";
  metadata.source = link_->Source();
  AddLatencyTimer(link_->LatencyTimer(), metadata);
  metadata.head = profile_.model.empty() ? profile_.name : profile_.maker + " " + profile_.model;
  double highest_hz = profile_.fastest_rate_hz.value_or(std::numeric_limits<double>::infinity());
  if (is_rtu()) highest_hz = HighestRateHz(profile_);
  highest_hz = std::min(highest_hz, rate_hz_.value_or(highest_hz));
  if (highest_hz < std::numeric_limits<double>::infinity()) metadata.nominal_rate_hz = highest_hz;
  const ReadRequest request = ReadingRequest(profile_);
  metadata.fields["modbus_profile"] = profile_.name;
  metadata.fields["modbus_slave"] = std::to_string(request.unit);
  metadata.fields["modbus_function"] = std::to_string(request.function);
  metadata.fields["modbus_address_on_the_wire"] = std::to_string(request.address);
  metadata.fields["modbus_count"] = std::to_string(request.count);
  metadata.fields["modbus_value"] =
      fmt::format("{} {} at {}", Name(profile_.type), Name(profile_.order), profile_.value_address);
}

std::vector<std::string> ModbusSensor::Remarks() const {
  std::vector<std::string> remarks{WireRemarks(profile_)};
  if (is_rtu() && profile_.transport == ModbusFraming::kTcp) {
    remarks.push_back(profile_.name + " speaks TCP by its profile, and the port is a serial one");
  }
  if (is_rtu() && !has_checks_) {
    remarks.push_back(fmt::format(
        "{} does not answer the check request of its profile with registers: replies later than "
        "{:g} s cannot be told from the next (longest_reply_s, check_address and check_count)",
        profile_.name, SecondsFromNs(profile_.longest_reply_ns)));
  }
  if (const std::string errors = InWords(errors_); !errors.empty()) {
    remarks.push_back("errors on the wire: " + errors);
  }
  for (std::string& remark : DoubtfulReplies(replies_, exchanges_.wire_ns())) {
    remarks.push_back(std::move(remark));
  }
  return remarks;
}

}  // namespace haptometer::acquire
