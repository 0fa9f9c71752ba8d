#pragma once

#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/cli/csv_cell.h"
#include "tools/sweep/sweep.h"
#include "tools/verbs.h"

namespace haptometer::tools {

inline const std::string kAdapter = HAPTOMETER_FIXTURES "/lra_adapter.toml";
inline const std::string kCone = HAPTOMETER_FIXTURES "/lra_cone.toml";
inline const std::vector<std::string> kGrid{kAdapter, "--vary", "drive.frequency_hz=200Hz:250Hz:11",
                                            "--vary", "skin.stiffness_n_per_m=600,1200,2000"};
inline const std::vector<std::string> kSampled{kAdapter,
                                               "--vary",
                                               "drive.frequency_hz=100Hz:400Hz",
                                               "--vary",
                                               "skin.damping_n_s_per_m=log:0.75:2.38",
                                               "--samples",
                                               "40",
                                               "--seed",
                                               "7"};

// a row of a table, by column
using Row = std::map<std::string, std::string>;

class SweepVerb : public tests::TemporaryFiles {
 protected:
  [[nodiscard]] std::string Path(const std::string& name) const { return directory_ / name; }

  [[nodiscard]] Outcome Sweep(std::vector<std::string> words, const std::string& table,
                              const std::vector<std::string>& more = {}) const {
    words.insert(words.end(), {"-o", Path(table)});
    words.insert(words.end(), more.begin(), more.end());
    return Captured(RunSweep, "sweep", words);
  }

  // without the provenance, the only part of a table that differs from command to command
  [[nodiscard]] std::string Content(const std::string& name) const {
    std::istringstream lines(TemporaryFiles::Content(name));
    std::string kept;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with(kProvenance)) continue;
      kept += line;
      if (!lines.eof()) kept += '\n';
    }
    return kept;
  }

  // what a sweep writes that must succeed
  [[nodiscard]] std::string Table(const std::vector<std::string>& words, const std::string& name,
                                  const std::vector<std::string>& more = {}) const {
    const Outcome outcome = Sweep(words, name, more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Content(name);
  }

  [[nodiscard]] static std::vector<Row> RowsOf(const std::string& table) {
    std::istringstream lines(table);
    std::vector<std::string> columns;
    std::vector<Row> rows;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with('#')) continue;
      const std::vector<std::string> cells = cli::CellsOf(line);
      if (columns.empty()) {
        columns = cells;
        continue;
      }
      EXPECT_EQ(cells.size(), columns.size()) << line;
      Row row;
      for (std::size_t k = 0; k < cells.size(); ++k) row[columns[k]] = cells[k];
      rows.push_back(std::move(row));
    }
    return rows;
  }
};

}  // namespace haptometer::tools
