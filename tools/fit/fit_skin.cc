#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "fit/skin/skin_areas.h"
#include "fit/skin/skin_fit.h"
#include "sim/scene/actuator.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/fit/fit_skin_input.h"
#include "tools/fit/fit_skin_output.h"
#include "tools/plot/gnuplot.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "fit-skin";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit the skin's stiffness, damping and mass under a contact to a drive sweep.",
    .examples = {"haptometer fit-skin sweep.csv --actuator actuator.toml",
                 "haptometer fit-skin 1mm2.csv 20mm2.csv 80mm2.csv --actuator actuator.toml"
                 " --plot skin.svg",
                 "haptometer fit-skin sweep.csv --actuator thesis-c10-100 --json"}};

// the sweeps of all tables, and what could not be read
struct Sweeps {
  std::vector<fit::SkinSweep> list;
  std::vector<Error> left_out;
};

Result<Sweeps> ReadAll(const std::vector<std::string>& files) {
  Sweeps sweeps;
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (std::find(files.begin(), files.begin() + static_cast<std::ptrdiff_t>(k), files[k]) !=
        files.begin() + static_cast<std::ptrdiff_t>(k)) {
      return Usage(files[k], "is given twice", "name each table once");
    }
    auto read = ReadSkinSweeps(files[k]);
    if (!read) {
      sweeps.left_out.push_back(read.error());
      continue;
    }
    for (auto& sweep : *read) {
      if (!sweeps.list.empty() && sweep.drive != sweeps.list.front().drive) {
        return Usage(files[k], "has voltages and another table has currents",
                     "ask for them one after the other");
      }
      sweeps.list.push_back(std::move(sweep));
    }
  }
  return sweeps;
}

bool IsAnswered(const fit::SkinFit& contact) {
  return contact.stiffness.determined && contact.damping.determined;
}

Result<sim::StatedActuator> Actuator(const std::string& name) {
  if (name.empty()) {
    return Usage("--actuator", "is missing: the skin shows itself by how it loads a known actuator",
                 "add --actuator actuator.toml (with Kv, Bv, Km) or thesis-c10-100");
  }
  auto stated = sim::FindActuator(name);
  if (!stated) return std::unexpected(stated.error());
  if (auto complete = sim::Complete(*stated); !complete) return std::unexpected(complete.error());
  return stated;
}

}  // namespace

int RunFitSkin(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::vector<std::string> files;
  std::string actuator_name;
  std::string plot;
  options.Positionals("tables", &files,
                      "frequency_hz, displacement_amplitude_um, current_amplitude_ma and further "
                      "columns (docs/commands.md)");
  options.Text("--actuator", &actuator_name, "NAME|FILE",
               "The known actuator: a file with Kv, Bv and Km, or thesis-c10-100");
  options.Output("--plot", &plot, "FILE.svg|png|pdf", "Draw sweeps, fits and the area law");
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (!plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(plot); !drawable) {
      return cli::ReportError(kVerb, drawable.error());
    }
  }
  const auto actuator = Actuator(actuator_name);
  if (!actuator) return cli::ReportError(kVerb, actuator.error());
  auto sweeps = ReadAll(files);
  if (!sweeps) return cli::ReportError(kVerb, sweeps.error());

  // what cannot be used is reported, the rest is answered
  std::vector<fit::SkinFit> contacts;
  for (const auto& sweep : sweeps->list) {
    auto contact = fit::FitSkin(sweep, *actuator);
    if (contact) {
      contacts.push_back(std::move(*contact));
    } else {
      sweeps->left_out.push_back(contact.error());
    }
  }
  int status = 0;
  for (const auto& error : sweeps->left_out) {
    status = cli::WorseStatus(status, cli::ReportError(kVerb, error));
  }
  if (contacts.empty()) {
    if (options.json()) fmt::print("{}", FitSkinJson({}, {}, actuator->name, sweeps->left_out));
    return status;
  }
  const auto areas = fit::FitSkinAreas(contacts);
  cli::Print(options.json() ? FitSkinJson(contacts, areas, actuator->name, sweeps->left_out)
                            : FitSkinText(contacts, areas, actuator->name));
  if (!std::ranges::all_of(contacts, IsAnswered)) {
    status = cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
  }
  if (plot.empty()) return status;
  if (auto drawn = PlotFitSkin(plot, contacts, areas); !drawn) {
    return cli::ReportError(kVerb, drawn.error());
  }
  return status;
}

}  // namespace haptometer::tools
