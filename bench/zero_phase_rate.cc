// Times one run at a time, as asked on standard input, for tests/long/zero_phase_rate.py:
//   filter SET THREADS   zero phase over the record, a line of seconds
//   memcpy               the record copied
//   loop THREADS         a bare loop of arithmetic without memory, in each of THREADS threads
// Arguments: samples, rate in Hz, order. The buffers are touched before anything is timed.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iostream>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "dsp/filter/zero_phase.h"

namespace haptometer::dsp {
namespace {

double SecondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void InThreads(int threads, const std::function<void()>& work) {
  std::vector<std::jthread> helpers;
  helpers.reserve(static_cast<std::size_t>(threads));
  for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
  work();
}

void BareLoop() {
  double sum = 0;
  // as long as a run of the filter: a longer one is disturbed more often
  for (int k = 0; k < 40'000'000; ++k) sum = sum * 0.999 + 1;
  // the result is used, so that the loop stays
  if (sum < 0) std::abort();
}

InstructionSet SetOf(const std::string& name) {
  for (const InstructionSet set : kInstructionSets) {
    if (name == Name(set) && IsSupported(set)) return set;
  }
  std::cerr << "no instruction set " << name << " here\n";
  std::exit(3);
}

class Record {
 public:
  Record(std::size_t samples, double rate_hz, int order)
      : design_(DesignBandPass({order, 20, 500, Corners::kEach}, rate_hz).value()),
        in_(samples),
        out_(samples) {
    for (std::size_t k = 0; k < samples; ++k) {
      in_[k] = 0.03 + 1e-6 * std::sin(0.063 * static_cast<double>(k));
    }
  }

  void Filter(InstructionSet set, int threads) {
    const ZeroPhaseBlocks blocks(design_, in_.size(), set);
    std::atomic<std::size_t> next = 0;
    // kept where fewer threads run in between: a larger one's memory counts as touched, too
    scratch_.resize(std::max(scratch_.size(), static_cast<std::size_t>(threads)));
    std::atomic<std::size_t> mine = 0;
    InThreads(threads, [&] {
      ZeroPhaseBlocks::Scratch& scratch = scratch_[mine++];
      for (std::size_t block = next++; block < blocks.blocks(); block = next++) {
        const SampleRange range = blocks.Range(block);
        blocks.Filter(block, in_, std::span(out_).subspan(range.first, range.count), scratch);
      }
    });
  }

  void Copy() { std::memcpy(out_.data(), in_.data(), in_.size() * sizeof(double)); }

 private:
  FilterDesign design_;
  std::vector<double> in_;
  std::vector<double> out_;
  std::vector<ZeroPhaseBlocks::Scratch> scratch_;
};

void Answer(Record& record) {
  std::string command;
  while (std::cin >> command) {
    double seconds = 0;
    if (command == "filter") {
      std::string set;
      int threads = 1;
      std::cin >> set >> threads;
      seconds = SecondsOf([&] { record.Filter(SetOf(set), threads); });
    } else if (command == "memcpy") {
      seconds = SecondsOf([&] { record.Copy(); });
    } else {
      int threads = 1;
      std::cin >> threads;
      seconds = SecondsOf([&] { InThreads(threads, BareLoop); });
    }
    std::cout << seconds << std::endl;
  }
}

}  // namespace
}  // namespace haptometer::dsp

int main(int count, char** arguments) {
  if (count != 4) {
    std::cerr << "give samples, rate and order\n";
    return 2;
  }
  haptometer::dsp::Record record(std::stoul(arguments[1]), std::stod(arguments[2]),
                                 std::stoi(arguments[3]));
  haptometer::dsp::Answer(record);
}
