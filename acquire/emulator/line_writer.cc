#include "acquire/emulator/line_writer.h"

#include <algorithm>

namespace haptometer::acquire::emulator {
namespace {

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
  const std::size_t taken = sink_(kept_);
  if (taken > 0) mid_line_ = kept_[taken - 1] != line_end_;
  kept_.erase(0, taken);
  if (kept_.size() <= room_) return;

  // whole lines are kept as far as there is room, and one that was begun to its end
  std::size_t keep = 0;
  if (mid_line_) keep = std::min({kept_.find(line_end_), kept_.size() - 1, kMostKept - 1}) + 1;
  if (room_ > keep) {
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
  if (dropping_) ++dropped_lines_;
}

void LineWriter::Abandon() {
  kept_.clear();
  mid_line_ = false;
  dropping_ = false;
}

}  // namespace haptometer::acquire::emulator
