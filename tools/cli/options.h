#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/quantity.h"

namespace haptometer::cli {

/// What a verb's --help begins with.
struct VerbText {
  std::string_view name;     ///< "analyze"
  std::string_view summary;  ///< one sentence
  std::array<std::string_view, 3> examples;
};

/// Where an option is shown: in --help, or only in --help-all.
enum class Shown : std::uint8_t { kHelp, kHelpAll };

/// The command line of one verb. Declare every option with the variable that takes it, then
/// Parse().
///
/// --help, --help-all, --version and --json are declared here, so they are alike in all verbs.
/// Names carry their dashes ("--drop-height"). A variable keeps its value when its option is
/// absent. CLI11 does the work and is included only in options.cc.
class Options {
 public:
  explicit Options(const VerbText& text);
  ~Options();
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;

  /// A required positional argument.
  void Positional(std::string_view name, std::string* value, std::string_view help);
  /// Any number of positional arguments, at least `at_least`.
  void Positionals(std::string_view name, std::vector<std::string>* values, std::string_view help,
                   std::size_t at_least = 1);
  void Flag(std::string_view name, bool* value, std::string_view help, Shown shown = Shown::kHelp);
  void Text(std::string_view name, std::string* value, std::string_view placeholder,
            std::string_view help, Shown shown = Shown::kHelp);
  /// A file or folder that the verb writes: no input, and none that another such option names.
  void Output(std::string_view name, std::string* value, std::string_view placeholder,
              std::string_view help, Shown shown = Shown::kHelp);
  /// An option whose value may be left out; `given` says whether it is there.
  void OptionalText(std::string_view name, bool* given, std::string* value,
                    std::string_view placeholder, std::string_view help,
                    Shown shown = Shown::kHelp);
  /// One of `choices`; anything else is refused with the list.
  void Choice(std::string_view name, std::string* value, const std::vector<std::string>& choices,
              std::string_view help, Shown shown = Shown::kHelp);
  /// A whole number from `least` to `most`.
  void Count(std::string_view name, std::optional<std::int64_t>* value, std::int64_t least,
             std::int64_t most, std::string_view help, Shown shown = Shown::kHelp);
  /// A number with its unit (base/quantity.h).
  void Number(std::string_view name, std::optional<Quantity>* value, Dimension dimension,
              std::string_view help, Shown shown = Shown::kHelp);
  /// May be given several times, one value each: --label subject=3 --label condition=stock.
  void Repeated(std::string_view name, std::vector<std::string>* values,
                std::string_view placeholder, std::string_view help, Shown shown = Shown::kHelp);
  /// May be given several times, several values each: --load 33ohm a.csv b.csv --load 50ohm c.csv.
  void Groups(std::string_view name, std::vector<std::vector<std::string>>* groups,
              std::string_view placeholder, std::string_view help, Shown shown = Shown::kHelp);

  /// Reads the command line. Returns the exit status to leave with (0 after --help or --version, 2
  /// after a wrong option, which is reported on stderr in one line), or nothing to go on. What an
  /// option takes is refused where it is not printable (base/text.h), because it may become a
  /// label, a name or a path of a new file; names of files that are read are not, in Positionals()
  /// and Groups(). Files that other words than those of Output() name are noted as inputs
  /// (base/input_file.h); those that the verb finds in folders, scenes and manifests are noted when
  /// they are opened.
  [[nodiscard]] std::optional<int> Parse(int argc, const char* const* argv);

  [[nodiscard]] bool json() const;  ///< one JSON document on stdout instead of text

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace haptometer::cli
