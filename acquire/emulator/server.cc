#include "acquire/emulator/server.h"

#include <sys/prctl.h>

#include <algorithm>

namespace haptometer::acquire::emulator {
namespace {

// a line that was begun is kept to its end, up to this many bytes
constexpr std::size_t kMostKept = 256;

}  // namespace

void LineWriter::Write(std::string_view bytes) {
  // the rest of a line whose beginning was dropped
  if (dropping_) {
    const std::size_t end = bytes.find(line_end_);
    dropping_ = end == std::string_view::npos;
    bytes.remove_prefix(dropping_ ? bytes.size() : end + 1);
  }

  // what was kept goes first
  kept_ += bytes;
  if (kept_.empty()) return;
  // the sink takes as many bytes as the host's buffer has room for
  const std::size_t taken = sink_(kept_);
  // a line is begun where the last byte taken is no line end
  if (taken > 0) mid_line_ = kept_[taken - 1] != line_end_;
  kept_.erase(0, taken);
  if (kept_.size() <= room_) return;

  // whole lines are kept as far as there is room, and one that was begun to its end
  std::size_t keep = 0;
  // the rest of the begun line has priority over the room
  if (mid_line_) keep = std::min({kept_.find(line_end_), kept_.size() - 1, kMostKept - 1}) + 1;
  if (room_ > keep) {
    // then whole lines, as many as fit
    const std::size_t last_end = kept_.rfind(line_end_, room_ - 1);
    if (last_end != std::string::npos) keep = std::max(keep, last_end + 1);
  }
  Drop(std::string_view(kept_).substr(keep));
  kept_.resize(keep);
}

void LineWriter::Drop(std::string_view lines) {
  if (lines.empty()) return;
  dropping_ = lines.back() != line_end_;
  dropped_lines_ += static_cast<std::uint64_t>(std::ranges::count(lines, line_end_));
  // the line whose beginning is dropped counts too
  if (dropping_) ++dropped_lines_;
}

// a new host gets no bytes of the old one
void LineWriter::Abandon() {
  kept_.clear();
  mid_line_ = false;
  dropping_ = false;
}

namespace {

// longest sleep, so that a stop is noticed
constexpr MonotonicNs kStopPollNs = 50'000'000;

}  // namespace

Result<ServeReport> Serve(Device& device, Endpoint& endpoint, const std::atomic<bool>& stop,
                          std::optional<MonotonicNs> duration_ns,
                          const std::function<void(const std::string&)>& announce) {
  // the system may not round this thread's wake-ups to 50 us, its default
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  ServeReport report;
  // counts what the host accepted; the rest is kept or dropped in whole lines
  LineWriter writer(device.line_end(), LineWriter::kPortRoom, [&](std::string_view bytes) {
    const std::size_t taken = endpoint.Write(bytes);
    report.bytes += taken;
    return taken;
  });
  SystemClock clock;
  std::string incoming;
  std::string outgoing;
  std::string name = endpoint.name();
  const MonotonicNs start = clock.Now();
  announce(name);

  MonotonicNs now = 0;
  // all times are relative to `start`
  bool had_host = false;
  while (!stop.load() && (!duration_ns || now < *duration_ns)) {
    // sleep until something is due or comes in
    MonotonicNs wake = now + kStopPollNs;
    if (const auto due = device.NextDue()) wake = std::min(wake, *due);
    if (duration_ns) wake = std::min(wake, *duration_ns);
    bool has_host = endpoint.Wait(wake - (clock.Now() - start));

    // bytes are stamped after they are read, never before they were written
    incoming.clear();
    if (has_host) has_host = endpoint.Read(incoming);
    now = clock.Now() - start;
    if (!incoming.empty()) device.Receive(incoming, now);

    // what has crossed the wire goes to the host, if there is one
    outgoing.clear();
    device.Advance(now, outgoing);
    if (had_host && !has_host) writer.Abandon();
    if (has_host) writer.Write(outgoing);
    had_host = has_host;

    // a device that drops off the line may come back under another name
    if (device.TakeHangUp() && has_host) {
      HAPTOMETER_TRY(endpoint.Unplug());
      ++report.hang_ups;
      writer.Abandon();
      if (endpoint.name() != name) announce(name = endpoint.name());
    }
  }
  report.dropped_lines = writer.dropped_lines();
  return report;
}

}  // namespace haptometer::acquire::emulator
