#include "tools/emulate/analog_output.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <random>
#include <utility>

#include "acquire/emulator/dl_unit.h"
#include "acquire/transport/descriptor.h"

namespace haptometer::tools {
namespace {

namespace emulator = acquire::emulator;

constexpr MonotonicNs kSampleNs = 1'000'000;  // 1 / kAnalogRateHz
constexpr MonotonicNs kWriteNs = 10'000'000;  // samples are handed over in blocks of 10
constexpr std::size_t kMostInBlock = 4096;    // PIPE_BUF: a block is written whole or not at all

class AnalogTap final : public emulator::Device {
 public:
  AnalogTap(std::unique_ptr<emulator::Device> device, emulator::MovingHead head,
            AnalogSampling sampling, bool is_made)
      : device_(std::move(device)),
        head_(std::move(head)),
        sampling_(std::move(sampling)),
        is_made_(is_made),
        engine_(sampling_.seed) {}
  AnalogTap(const AnalogTap&) = delete;
  AnalogTap& operator=(const AnalogTap&) = delete;
  ~AnalogTap() override {
    if (is_made_) unlink(sampling_.path.c_str());
  }

  void Receive(std::string_view bytes, MonotonicNs now) override { device_->Receive(bytes, now); }
  void Advance(MonotonicNs now, std::string& out) override {
    device_->Advance(now, out);
    while (now >= next_write_) {
      Append(next_write_);
      WriteBlock();
      next_write_ += kWriteNs;
    }
  }
  [[nodiscard]] std::optional<MonotonicNs> NextDue() const override {
    return std::min(device_->NextDue().value_or(next_write_), next_write_);
  }
  [[nodiscard]] bool TakeHangUp() override { return device_->TakeHangUp(); }
  [[nodiscard]] char line_end() const override { return device_->line_end(); }

 private:
  // the samples due before `until`
  void Append(MonotonicNs until) {
    for (; next_sample_ < until; next_sample_ += kSampleNs) {
      const double displacement_m = head_.displacement(SecondsFromNs(next_sample_));
      const double volts = emulator::AnalogVolts(head_.head, displacement_m) +
                           sampling_.noise_rms_v * normal_(engine_);
      block_ += fmt::format("{:.6f}\n", volts);
    }
  }

  // without a reader, or with one that is behind, the block is lost
  void WriteBlock() {
    if (pipe_.get() < 0) {
      pipe_ =
          acquire::OwnedDescriptor(open(sampling_.path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    }
    if (pipe_.get() >= 0 && block_.size() <= kMostInBlock &&
        write(pipe_.get(), block_.data(), block_.size()) < 0 && errno == EPIPE) {
      pipe_ = acquire::OwnedDescriptor(-1);
    }
    block_.clear();
  }

  std::unique_ptr<emulator::Device> device_;
  emulator::MovingHead head_;
  AnalogSampling sampling_;
  bool is_made_;  // the pipe
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  acquire::OwnedDescriptor pipe_{-1};
  std::string block_;
  MonotonicNs next_sample_ = 0;
  MonotonicNs next_write_ = kWriteNs;
};

}  // namespace

Result<std::unique_ptr<emulator::Device>> WithAnalogOutput(std::unique_ptr<emulator::Device> device,
                                                           emulator::MovingHead head,
                                                           AnalogSampling sampling) {
  struct stat status{};
  const bool is_made = mkfifo(sampling.path.c_str(), 0600) == 0;
  if (!is_made) {
    if (errno != EEXIST) {
      return Failed(sampling.path, fmt::format("cannot be made: {}", std::strerror(errno)),
                    "name a place where a pipe can be made");
    }
    if (stat(sampling.path.c_str(), &status) != 0 || !S_ISFIFO(status.st_mode)) {
      return Usage(sampling.path, "is there and is no named pipe", "give another name");
    }
  }
  return std::make_unique<AnalogTap>(std::move(device), std::move(head), std::move(sampling),
                                     is_made);
}

}  // namespace haptometer::tools
