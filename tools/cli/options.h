#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"

namespace CLI {
class Option;
}

namespace haptometer::cli {

/// What a verb's --help begins with.
struct VerbText {
  std::string_view name;     ///< "analyze"
  std::string_view summary;  ///< one sentence
  std::array<std::string_view, 3> examples;
};

/// The ends of what an option takes, in its SI unit.
struct Bounds {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool is_above = false;  ///< `least` itself is refused
  bool is_below = false;  ///< `most` itself is refused
};

[[nodiscard]] constexpr Bounds Above(double least) { return {.least = least, .is_above = true}; }
[[nodiscard]] constexpr Bounds AtLeast(double least) { return {.least = least}; }
[[nodiscard]] constexpr Bounds Within(double least, double most) {
  return {.least = least, .most = most};
}

/// Where an option is shown: in --help, or only in --help-all.
enum class Shown : std::uint8_t { kHelp, kHelpAll };

/// An option as it was declared: all that help, the manual and the tests say of it.
struct Option {
  enum class Kind : std::uint8_t { kFlag, kText, kChoice, kCount, kNumber, kRange };

  std::string name;  ///< "--drop-height", "-o,--output"; of a positional argument "scene"
  Kind kind = Kind::kText;
  std::string placeholder{};  ///< "LOW:HIGH"; of a number its unit
  std::string text{};
  Dimension dimension = Dimension::kNone;
  Bounds bounds{};
  std::vector<std::string> choices{};
  std::vector<std::string> known{};  ///< values among others: names, or keys before a '='
  std::string default_text{};        ///< what holds without it; empty: nothing
  bool is_rare = false;              ///< shown by --help-all alone
  bool is_repeated = false;          ///< may be given several times; of a positional: several words
  bool takes_several = false;        ///< several values at a time
  bool may_lack_value = false;       ///< its value may be left out
  bool is_required = false;          ///< a positional without which the verb does not start
  CLI::Option* parsed = nullptr;

  /// Shown by --help-all alone.
  Option& Rare() {
    is_rare = true;
    return *this;
  }
  /// Values that it takes among others, for the completion of a shell.
  Option& Known(std::vector<std::string> values) {
    known = std::move(values);
    return *this;
  }
  /// What holds without it, where the variable does not say so itself.
  Option& Default(std::string text_of) {
    default_text = std::move(text_of);
    return *this;
  }
};

/// `number` of an option within its bounds. Errors (Cause::kUsage): outside; `text` as it was
/// typed.
[[nodiscard]] Result<void> CheckBounds(const Option& option, double number,
                                       const std::string& text);

/// The command line of one verb. Declare every option with the variable that takes it, then
/// Parse().
///
/// --help, --help-all, --version, --json and --describe-options are declared here, so they are
/// alike in all verbs. Names carry their dashes ("--drop-height"). A variable keeps its value when
/// its option is absent; the value that it has when it is declared is the default that help states.
/// Bounds are stated by help, and what lies outside is refused. CLI11 does the work and is included
/// only in options.cc.
class Options {
 public:
  explicit Options(const VerbText& text);
  ~Options();
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;

  /// A required positional argument.
  Option& Positional(std::string_view name, std::string* value, std::string_view help);
  /// Any number of positional arguments, at least `at_least`.
  Option& Positionals(std::string_view name, std::vector<std::string>* values,
                      std::string_view help, std::size_t at_least = 1);
  Option& Flag(std::string_view name, bool* value, std::string_view help,
               Shown shown = Shown::kHelp);
  Option& Text(std::string_view name, std::string* value, std::string_view placeholder,
               std::string_view help, Shown shown = Shown::kHelp);
  /// A text that `read` takes apart; its error is that of the command line.
  Option& Parsed(std::string_view name, std::string_view placeholder,
                 std::function<Result<void>(const std::string&)> read, std::string_view help);
  /// A file or folder that the verb writes: no input, and none that another such option names.
  Option& Output(std::string_view name, std::string* value, std::string_view placeholder,
                 std::string_view help, Shown shown = Shown::kHelp);
  /// An option whose value may be left out; `given` says whether it is there.
  Option& OptionalText(std::string_view name, bool* given, std::string* value,
                       std::string_view placeholder, std::string_view help,
                       Shown shown = Shown::kHelp);
  /// One of `choices`; anything else is refused with the list.
  Option& Choice(std::string_view name, std::string* value, const std::vector<std::string>& choices,
                 std::string_view help, Shown shown = Shown::kHelp);
  /// A whole number from `least` to `most`.
  Option& Count(std::string_view name, std::optional<std::int64_t>* value, std::int64_t least,
                std::int64_t most, std::string_view help, Shown shown = Shown::kHelp);
  template <std::integral T>
  Option& Count(std::string_view name, T* value, std::int64_t least, std::int64_t most,
                std::string_view help) {
    const auto keep = [value](std::int64_t number) { *value = static_cast<T>(number); };
    return AddCount(name, keep, least, most, help).Default(std::to_string(*value));
  }
  /// A number with its unit (base/quantity.h), and its uncertainty.
  Option& Number(std::string_view name, std::optional<Quantity>* value, Dimension dimension,
                 Bounds bounds, std::string_view help);
  /// A number with its unit, which is exact: one with an uncertainty is refused.
  Option& Number(std::string_view name, std::optional<double>* value, Dimension dimension,
                 Bounds bounds, std::string_view help, Shown shown = Shown::kHelp);
  /// The same; a default that is not finite is none.
  Option& Number(std::string_view name, double* value, Dimension dimension, Bounds bounds,
                 std::string_view help);
  /// "LOW:HIGH", or one number for both. Each within the bounds, and LOW not above HIGH.
  Option& Range(std::string_view name, double* low, double* high, Dimension dimension,
                Bounds bounds, std::string_view help);
  /// May be given several times, one value each: --label subject=3 --label condition=stock.
  Option& Repeated(std::string_view name, std::vector<std::string>* values,
                   std::string_view placeholder, std::string_view help, Shown shown = Shown::kHelp);
  /// May be given several times, several values each: --load 33ohm a.csv b.csv --load 50ohm c.csv.
  Option& Groups(std::string_view name, std::vector<std::vector<std::string>>* groups,
                 std::string_view placeholder, std::string_view help, Shown shown = Shown::kHelp);

  /// `name` is refused beside any of `others`, all with their dashes; `why` says why not.
  void Exclude(std::string_view name, std::initializer_list<std::string_view> others,
               std::string_view why);

  /// Reads the command line. Returns the exit status to leave with (0 after --help or --version, 2
  /// after a wrong option, which is reported on stderr in one line), or nothing to go on. What an
  /// option takes is refused where it is not printable (base/text.h), because it may become a
  /// label, a name or a path of a new file; names of files that are read are not, in Positionals()
  /// and Groups(). Files that other words than those of Output() name are noted as inputs
  /// (base/input_file.h); those that the verb finds in folders, scenes and manifests are noted when
  /// they are opened.
  ///
  /// Beside --describe-options the options are printed as a JSON object where nothing else is
  /// wrong than what is missing: name, summary and examples of the verb; `positionals` in their
  /// order, each with name, text, repeatable (several words), required and known; `options`, each
  /// with name, kind, placeholder, unit, least, most, above and below (whether `least` and `most`
  /// themselves are refused), bounds (the same in words), choices, known (values among others, or
  /// keys before a '='), default, rare (shown by --help-all alone), repeatable (given again),
  /// several (values at a time), optional (its value) and text; `common`, the options of all verbs,
  /// each with name and text.
  [[nodiscard]] std::optional<int> Parse(int argc, const char* const* argv);

  [[nodiscard]] bool json() const;  ///< one JSON document on stdout instead of text

 private:
  struct State;

  Option& AddCount(std::string_view name, std::function<void(std::int64_t)> keep,
                   std::int64_t least, std::int64_t most, std::string_view help);
  Option& AddNumber(std::string_view name, std::function<Result<void>(const Quantity&)> keep,
                    Dimension dimension, Bounds bounds, std::string_view help);

  std::unique_ptr<State> state_;
};

/// A rule of a command line.
struct Rule {
  bool is_broken = false;
  std::string_view where;  ///< the option that breaks it
  std::string_view what;
  std::string_view remedy;
};

/// The first rule that is broken, as an error (Cause::kUsage).
[[nodiscard]] Result<void> CheckRules(std::initializer_list<Rule> rules);

}  // namespace haptometer::cli
