#pragma once

#include <utility>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/drop_test_model.h"
#include "fit/drop_test/prepared_record.h"

namespace haptometer::fit {

inline Result<std::vector<PreparedRecord>> Prepared(const std::vector<ImpulseRecord>& records) {
  std::vector<PreparedRecord> prepared;
  for (const ImpulseRecord& record : records) {
    auto one = PrepareRecord(record);
    if (!one) return std::unexpected(one.error());
    prepared.push_back(*std::move(one));
  }
  return prepared;
}

inline Result<DropTestModel> MakeDropTestModel(const std::vector<ImpulseRecord>& records,
                                               const ActuatorKnowns& knowns) {
  auto prepared = Prepared(records);
  if (!prepared) return std::unexpected(prepared.error());
  return MakeDropTestModel(*std::move(prepared), knowns);
}

inline Result<DropTestFit> FitDropTest(const std::vector<ImpulseRecord>& records,
                                       const ActuatorKnowns& knowns, Loss loss = Loss::kSquares) {
  auto prepared = Prepared(records);
  if (!prepared) return std::unexpected(prepared.error());
  return FitDropTest(*std::move(prepared), knowns, loss);
}

}  // namespace haptometer::fit
