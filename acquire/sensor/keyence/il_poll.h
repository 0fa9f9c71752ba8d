#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquire/protocol/keyence/dl_line.h"
#include "acquire/sensor/polled_line.h"

namespace haptometer::acquire {

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
