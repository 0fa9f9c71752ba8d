#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "acquire/emulator/device.h"
#include "base/clock.h"

namespace haptometer::acquire::emulator {

/// A byte and the moment at which it had crossed the wire.
struct TimedByte {
  char byte;
  MonotonicNs time;
};

/// Runs `device` from one due time to the next until `until`; a byte's time is its due time.
inline std::vector<TimedByte> RunUntil(Device& device, ManualClock& clock, MonotonicNs until) {
  std::vector<TimedByte> bytes;
  while (true) {
    const auto due = device.NextDue();
    if (!due || *due > until) break;
    const MonotonicNs before = clock.Now();
    clock.SleepUntil(*due);
    std::string out;
    device.Advance(clock.Now(), out);
    for (const char byte : out) bytes.push_back({byte, clock.Now()});
    if (clock.Now() == before && out.empty() && device.NextDue() == due) {
      ADD_FAILURE() << "the device asks to be woken at " << *due << " again and does nothing";
      break;
    }
  }
  clock.SleepUntil(until);
  return bytes;
}

inline std::string TextOf(const std::vector<TimedByte>& bytes) {
  std::string text;
  for (const TimedByte& timed : bytes) text += timed.byte;
  return text;
}

}  // namespace haptometer::acquire::emulator
