#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// The most numbers of one object that is read, whatever size a file states: 2 GiB of doubles.
inline constexpr std::size_t kMostNumbers = std::size_t{1} << 28;

/// The objects of one exported trial by their names (trial/export/object_names.h), whatever kind
/// of file they lie in. Each is asked for once at most.
class ExportedObjects {
 public:
  /// `where`: the file and the trial in it, for messages.
  explicit ExportedObjects(std::string where) : where_(std::move(where)) {}
  virtual ~ExportedObjects() = default;

  [[nodiscard]] virtual bool Has(const std::string& object) = 0;
  /// Numbers of a table whose rows are `width` wide, row by row.
  /// Errors (Cause::kCannotAnswer), by Wrong(): missing, of another type or shape.
  [[nodiscard]] virtual Result<std::vector<double>> Doubles(const std::string& object,
                                                            std::size_t width) = 0;
  /// Numbers of a byte each. Errors: as Doubles.
  [[nodiscard]] virtual Result<std::vector<std::uint8_t>> Bytes(const std::string& object) = 0;
  /// Errors: as Doubles.
  [[nodiscard]] virtual Result<std::string> Text(const std::string& object) = 0;
  /// Whether `object` is there and not 0.
  [[nodiscard]] virtual bool Flag(const std::string& object) = 0;

  /// The error that names the file and the object in it.
  [[nodiscard]] std::unexpected<Error> Wrong(const std::string& object,
                                             const std::string& what) const;

 protected:
  ExportedObjects(ExportedObjects&&) = default;
  ExportedObjects& operator=(ExportedObjects&&) = default;

 private:
  std::string where_;
};

/// The trial that `objects` hold, bit for bit as it was exported to a file of `kind`: record,
/// events, whether it was closed; the losses stated at the export come as remarks.
/// Errors (Cause::kCannotAnswer): an object is missing or of another shape or type, statuses that
/// are none, stretches that do not describe the rows. Memory: the record.
[[nodiscard]] Result<Recording> ReadExportedTrial(ExportedObjects& objects, FileKind kind);

/// Objects that were read into memory; each is moved out where it is asked for.
class ObjectsInMemory final : public ExportedObjects {
 public:
  using ExportedObjects::ExportedObjects;

  [[nodiscard]] bool Has(const std::string& object) override;
  [[nodiscard]] Result<std::vector<double>> Doubles(const std::string& object,
                                                    std::size_t width) override;
  [[nodiscard]] Result<std::vector<std::uint8_t>> Bytes(const std::string& object) override;
  [[nodiscard]] Result<std::string> Text(const std::string& object) override;
  [[nodiscard]] bool Flag(const std::string& object) override;

  std::map<std::string, std::vector<double>> numbers{};
  std::map<std::string, std::vector<std::uint8_t>> bytes{};
  std::map<std::string, std::string> texts{};
};

/// Adds what the JSON document of an NPY or a WAV (trial/export/description.h) holds to `objects`,
/// its sample_offsets too (ObjectsInMemory::numbers), empty where it holds none.
/// Errors (Cause::kCannotAnswer): no such document.
[[nodiscard]] Result<void> AddDescription(std::string_view json, ObjectsInMemory* objects);

inline constexpr const char* kSampleOffsets = "sample_offsets";

}  // namespace haptometer::trial
