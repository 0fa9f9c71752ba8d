#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquire/protocol/keyence/dl_line.h"
#include "acquire/sensor/polled_line.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// The communication units that carry IL amplifiers.
enum class IlUnit : std::uint8_t {
  kDlRs1a,  ///< RS-232C
  kDlEn1,   ///< Ethernet
};

/// What differs between them for one who talks to them.
struct IlUnitTraits {
  std::string_view sensor;  ///< "keyence-il"
  std::string_view name;    ///< "DL-RS1A"
  const dl::Spelling& spelling;
  int first_unit;            ///< identification number of the first amplifier
  std::size_t longest_line;  ///< characters without the end
  std::string_view (*error_text)(int number);
  MonotonicNs (*refresh_ns)(std::size_t amplifiers);
  std::string (*format_number)(int number);  ///< as SW's data, where the width is not known
  int write_locked;                          ///< the error number of a write that is locked
  std::string_view write_remedy;             ///< what the user can do then
};

[[nodiscard]] const IlUnitTraits& TraitsOf(IlUnit unit);

/// Questions to a unit before a recording, one at a time.
class IlTalk {
 public:
  /// `line` and `stop` must outlive it.
  IlTalk(PolledLine& line, const IlUnitTraits& traits, const std::atomic<bool>& stop)
      : line_(line), traits_(traits), stop_(stop) {}

  /// The reply to `request`, or nothing when none came within the maker's second; its views are
  /// valid until the next question. A line that answers something else is passed over. Errors:
  /// PolledLine::Exchange.
  [[nodiscard]] Result<std::optional<dl::Reply>> Ask(const dl::Request& request);

  /// What data `number` of amplifier `unit` holds; nothing where it is refused or not answered.
  [[nodiscard]] Result<std::optional<std::string>> Read(int unit, int number);

  /// Writes `data`. Errors (Cause::kCannotAnswer): refused, with the number and what it means, or
  /// not answered.
  [[nodiscard]] Result<void> Write(int unit, int number, std::string_view data);

  [[nodiscard]] const IlUnitTraits& traits() const { return traits_; }
  [[nodiscard]] const std::string& name() const { return line_.name(); }
  /// Questions in a row that were not answered.
  [[nodiscard]] int silences() const { return silences_; }

 private:
  PolledLine& line_;
  const IlUnitTraits& traits_;
  const std::atomic<bool>& stop_;
  int silences_ = 0;
};

/// What the values of one amplifier look like for the whole of a recording.
struct IlChannel {
  int sent_decimals = 0;         ///< behind the point, as they stand in the line
  bool has_il_specials = false;  ///< 99999 and its kin are no measurements (dl_en1::WithIlSpecials)
};

/// Polls a DL-RS1A or DL-EN1 with M0 or MS and steps with the other.
///
/// Samples: the value of each amplifier; with MS then the outputs of each.
class IlPoll final : public LineDialect {
 public:
  /// `command`: kM0 or kMs; `spelling` must outlive the object.
  IlPoll(const dl::Spelling& spelling, dl::Command command);

  void SetChannels(std::vector<IlChannel> channels) { channels_ = std::move(channels); }
  /// Samples of a row.
  [[nodiscard]] std::size_t samples() const;

  [[nodiscard]] std::string_view PollRequest() const override { return poll_; }
  [[nodiscard]] std::string_view StepRequest() const override { return step_; }
  [[nodiscard]] bool AnswersStep(std::string_view line) const override;
  [[nodiscard]] LineMeaning Read(std::string_view line,
                                 std::span<trial::Sample> samples) const override;

 private:
  [[nodiscard]] bool Fits(const dl::Reply& reply) const;

  const dl::Spelling& spelling_;
  dl::Command command_;
  dl::Command step_command_;
  std::string poll_;
  std::string step_;
  std::vector<IlChannel> channels_;
};

}  // namespace haptometer::acquire
