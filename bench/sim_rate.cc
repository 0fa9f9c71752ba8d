// Times the thesis's adapter scene from rest, 0.1 s and 1000 outputs, for tests/long/sim_rate.py.
// Standard input: lines `METHOD RELATIVE REPEATS FILE`, METHOD exact, bdf, adams or dopri5. Each is
// answered with the median of so many runs in seconds; then FILE holds the states at outputs 0, 1
// ... as doubles, seven of each.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "bench/sim_cost_ours.h"
#include "bench/sim_cost_peers.h"

namespace haptometer::sim {
namespace {

using Run = std::function<Answer(const Tolerance&)>;

std::map<std::string, Run> Methods(const Question& question) {
  const auto cvode = [question](Multistep method) -> Run {
    return [=](const Tolerance& tolerance) {
      return ByCvode(question, question.outputs, method, tolerance);
    };
  };
  return {{"exact", [=](const Tolerance&) { return ByExactSteps(question, question.outputs); }},
          {"bdf", cvode(Multistep::kBdf)},
          {"adams", cvode(Multistep::kAdams)},
          {"dopri5", [=](const Tolerance& tolerance) {
             return ByDopri5(question, question.outputs, tolerance);
           }}};
}

void Serve() {
  const Question question{.name = "linear"};
  const auto methods = Methods(question);
  Tolerance tolerance{
      .largest = ByExactSteps(question, question.outputs).samples.cwiseAbs().rowwise().maxCoeff()};
  std::string method, path;
  std::size_t repeats = 0;
  std::cout.precision(9);
  while (std::cin >> method >> tolerance.relative >> repeats >> path) {
    std::vector<double> times_s;
    Answer answer;
    for (std::size_t k = 0; k < repeats; ++k) {
      const auto start = std::chrono::steady_clock::now();
      answer = methods.at(method)(tolerance);
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      times_s.push_back(taken.count());
    }
    std::ranges::sort(times_s);
    const auto bytes = answer.samples.size() * static_cast<std::ptrdiff_t>(sizeof(double));
    std::ofstream(path, std::ios::binary)
        .write(static_cast<const char*>(static_cast<const void*>(answer.samples.data())), bytes);
    std::cout << times_s[times_s.size() / 2] << std::endl;
  }
}

}  // namespace
}  // namespace haptometer::sim

int main() { haptometer::sim::Serve(); }
