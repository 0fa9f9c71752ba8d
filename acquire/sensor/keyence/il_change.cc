#include "acquire/sensor/keyence/il_change.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "acquire/protocol/keyence/dl_rs1a.h"

namespace haptometer::acquire {
namespace {

constexpr std::string_view kUnknown = "unknown";

// `code` as the data that were read look: a sign where they have one, and as many digits
std::string DataLike(const std::optional<std::string>& data, int code, const IlTalk& talk) {
  if (!data || data->empty()) return talk.traits().format_number(code);
  const bool is_signed = data->front() == '+' || data->front() == '-';
  const std::size_t digits = data->size() - (is_signed ? 1 : 0);
  return fmt::format("{}{:0{}}", is_signed ? "+" : "", code, digits);
}

std::string TextOf(int number, const std::optional<std::string>& data) {
  if (!data) return std::string(kUnknown);
  const auto code = dl::NumberOf(*data);
  return code ? il_setting::Describe(number, *code) : *data;
}

// one setting of one amplifier; nothing where it held the code already
Result<std::optional<IlChange>> WriteOne(IlTalk& talk, int unit, const il_setting::Write& write) {
  const auto before = talk.Read(unit, write.number);
  if (!before) return std::unexpected(before.error());
  const auto code = *before ? dl::NumberOf(**before) : std::nullopt;
  if (code == write.code || (write.only_where && code != write.only_where)) return std::nullopt;
  if (auto done = talk.Write(unit, write.number, DataLike(*before, write.code, talk)); !done) {
    return std::unexpected(done.error());
  }
  const auto after = talk.Read(unit, write.number);
  if (!after) return std::unexpected(after.error());
  if (!*after || dl::NumberOf(**after) != write.code) {
    return CannotAnswer(
        talk.name(),
        fmt::format("amplifier {:02} took {} = {} but says {}", unit, write.key,
                    il_setting::Describe(write.number, write.code), TextOf(write.number, *after)),
        "set it at the amplifier");
  }
  return IlChange{unit, write.key, TextOf(write.number, *before), TextOf(write.number, *after)};
}

// an error that says what had been changed before it
std::unexpected<Error> AfterChanges(Error error, const std::vector<IlChange>& changes) {
  for (const IlChange& change : changes) error.what += "; already changed: " + change.Text();
  return std::unexpected(std::move(error));
}

// data 054: 0 as long as the amplifier is at it; an amplifier that does not tell is believed
Result<void> WaitForShift(IlTalk& talk, int unit, Clock& clock) {
  constexpr int kFailed = 2;
  const MonotonicNs deadline = clock.Now() + kNsPerS;
  while (clock.Now() < deadline) {
    const auto result = talk.Read(unit, dl_rs1a::kZeroShiftResult);
    if (!result) return std::unexpected(result.error());
    const auto code = *result ? dl::NumberOf(**result) : std::nullopt;
    if (code == kFailed) {
      return CannotAnswer(talk.name(),
                          fmt::format("amplifier {:02} could not shift its zero", unit),
                          "bring the target into the range, and measure again");
    }
    if (code != 0) return {};
  }
  return {};
}

Result<IlChange> ShiftOne(IlTalk& talk, int unit, Clock& clock) {
  const auto before = talk.Read(unit, dl_rs1a::kPresentValue);
  if (!before) return std::unexpected(before.error());
  const std::string off = talk.traits().format_number(0);
  for (const std::string& data : {off, talk.traits().format_number(1), off}) {
    auto done = talk.Write(unit, dl_rs1a::kZeroShift, data);
    if (done) continue;
    // an amplifier that acts on the level must not be left shifting: an interruption ends the
    // waiting, and this request still goes out
    Error error = done.error();
    if (data != off && !talk.Write(unit, dl_rs1a::kZeroShift, off)) {
      error.what += fmt::format("; data 001 of amplifier {:02} may still be 1", unit);
    }
    return std::unexpected(std::move(error));
  }
  if (auto shifted = WaitForShift(talk, unit, clock); !shifted) {
    return std::unexpected(shifted.error());
  }
  const auto after = talk.Read(unit, dl_rs1a::kPresentValue);
  if (!after) return std::unexpected(after.error());
  return IlChange{unit, "zero", before->value_or(std::string(kUnknown)),
                  after->value_or(std::string(kUnknown))};
}

}  // namespace

std::string IlChange::Text() const {
  return fmt::format("amplifier {:02}: {} {} -> {}", unit, key, before, after);
}

Result<std::vector<IlChange>> WriteSettings(IlTalk& talk, std::span<const int> units,
                                            std::span<const il_setting::Write> writes) {
  std::vector<IlChange> changes;
  for (const int unit : units) {
    for (const il_setting::Write& write : writes) {
      auto change = WriteOne(talk, unit, write);
      if (!change) return AfterChanges(change.error(), changes);
      if (*change) changes.push_back(std::move(**change));
    }
  }
  return changes;
}

Result<std::vector<IlChange>> ShiftZeros(IlTalk& talk, std::span<const int> units, Clock& clock) {
  std::vector<IlChange> changes;
  for (const int unit : units) {
    auto change = ShiftOne(talk, unit, clock);
    if (!change) return AfterChanges(change.error(), changes);
    changes.push_back(std::move(*change));
  }
  return changes;
}

Result<bool> WaitUntilValid(IlTalk& talk, MonotonicNs refresh_ns, MonotonicNs longest_ns,
                            Clock& clock) {
  const MonotonicNs deadline = clock.Now() + longest_ns;
  clock.SleepUntil(clock.Now() + refresh_ns);  // until then the unit hands out the old value
  while (clock.Now() < deadline) {
    const auto reply = talk.Ask({});
    if (!reply) return std::unexpected(reply.error());
    if (!*reply || (*reply)->kind != dl::ReplyKind::kM0) continue;
    const auto values = std::span((*reply)->values).first((*reply)->units);
    if (std::ranges::find(values, trial::SampleStatus::kInvalid, &Value::status) == values.end()) {
      return true;
    }
  }
  return false;
}

}  // namespace haptometer::acquire
