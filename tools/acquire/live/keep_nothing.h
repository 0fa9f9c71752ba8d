#pragma once

#include "acquire/recorder/row_sink.h"

namespace haptometer::tools {

/// Where rows go that are only looked at.
class KeepNothing final : public acquire::RowSink {
 public:
  [[nodiscard]] Result<void> Append(const trial::Row& /*row*/) override { return {}; }
  [[nodiscard]] Result<void> AddEvent(trial::Event /*event*/) override { return {}; }
  [[nodiscard]] Result<void> FlushIfDue() override { return {}; }
  [[nodiscard]] Result<void> Finish() override { return {}; }
};

}  // namespace haptometer::tools
