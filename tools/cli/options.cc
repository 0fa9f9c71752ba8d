#include "tools/cli/options.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/render.h"

namespace haptometer::cli {
namespace {

constexpr const char* kMoreOptions = "More options";

// carries an Error out of CLI11, whose callbacks report by exceptions
struct Refused {
  Error error;
};

void ThrowWhereWrong(const Result<void>& result) {
  if (!result) throw Refused{result.error()};
}

// options that exclude each other
struct Exclusion {
  std::string name;
  std::vector<std::string> others;
  std::string why;
};

// --- what the program says of the options of a verb ---

using document::Section;
using document::Value;

// unit of a bound, in the order of Dimension
constexpr std::array kUnits{document::kNone,
                            document::kMetre,
                            document::kKilogram,
                            document::kHenry,
                            document::kSecond,
                            document::kHertz,
                            document::kVolt,
                            document::kAmpere,
                            document::kOhm,
                            document::kNewtonPerMetre,
                            document::kNewtonSecondPerMetre,
                            document::kNewtonPerAmpere};

// a number in SI units as people say it: "15 mm"
std::string NumberText(double value, Dimension dimension) {
  // six digits, in the unit in which the value is written
  return document::QuantityText(value, kUnits.at(static_cast<std::size_t>(dimension)), 6);
}

// whole numbers beyond it have no double of their own: such a bound is as good as none
constexpr double kMostExact = 9007199254740992;  // 2^53

// an end as people say it
std::string InUsualUnit(const Option& option, double end) {
  if (end == 0) return "0";
  return option.kind == Option::Kind::kCount ? fmt::format("{:.0f}", end)
                                             : NumberText(end, option.dimension);
}

// an end in the SI unit
std::string InSiUnit(const Option& option, double end) {
  const std::string_view unit = SiUnit(option.dimension);
  if (end == 0 || unit.empty()) return InUsualUnit(option, end);
  return fmt::format("{:g} {}", end, unit);
}

// both ends in the usual unit (mm, ms), or in the SI unit where one would have a power of ten
std::array<std::string, 2> EndTexts(const Option& option) {
  const double least = option.bounds.least, most = option.bounds.most;
  std::array texts{InUsualUnit(option, least), InUsualUnit(option, most)};
  const auto has_power = [](const std::string& text) { return text.contains('e'); };
  if (std::ranges::any_of(texts, has_power))
    texts = {InSiUnit(option, least), InSiUnit(option, most)};
  return texts;
}

// "above 0", "from 1 to 60", "at most 1 V"; empty without bounds
std::string BoundsText(const Option& option) {
  const Bounds& bounds = option.bounds;
  const bool has_least = std::isfinite(bounds.least);
  const bool has_most =
      option.kind == Option::Kind::kCount ? bounds.most <= kMostExact : std::isfinite(bounds.most);
  const auto [least, most] = EndTexts(option);
  // a closed end is "from" or "to", an open one "above" or "below"
  if (has_least && has_most && bounds.is_above) {
    return fmt::format("above {} and {} {}", least, bounds.is_below ? "below" : "at most", most);
  }
  if (has_least && has_most) {
    return fmt::format("from {} to {}{}", least, bounds.is_below ? "below " : "", most);
  }
  if (has_least) return (bounds.is_above ? "above " : "at least ") + least;
  if (has_most) return (bounds.is_below ? "below " : "at most ") + most;
  return "";
}

std::string_view NameOf(Option::Kind kind) {
  constexpr std::array<std::string_view, 6> kNames{"flag",  "text",   "choice",
                                                   "count", "number", "range"};
  return kNames[static_cast<std::size_t>(kind)];
}

constexpr document::Key kKnown{"known"};
constexpr document::Key kRepeatable{"repeatable"};

// an option as JSON, for --describe-options
Section SectionOf(const Option& option) {
  const bool is_number =
      option.kind == Option::Kind::kNumber || option.kind == Option::Kind::kRange;
  Section section;
  section.Add(document::kName, option.name);
  section.Add(document::kKind, NameOf(option.kind));
  section.Add({"placeholder"}, document::TextOrNotKnown(option.placeholder));
  section.Add(document::kUnit,
              is_number ? document::TextOrNotKnown(SiUnit(option.dimension)) : Value());
  section.Add({"least"}, option.bounds.least);
  section.Add({"most"}, option.bounds.most);
  section.Add({"above"}, option.bounds.is_above);
  section.Add({"below"}, option.bounds.is_below);
  section.Add({"bounds"}, document::TextOrNotKnown(BoundsText(option)));
  section.Add({"choices"}, option.choices);
  section.Add(kKnown, option.known);
  section.Add({"default"}, document::TextOrNotKnown(option.default_text));
  section.Add({"rare"}, option.is_rare);
  section.Add(kRepeatable, option.is_repeated);
  section.Add({"several"}, option.takes_several);
  section.Add({"optional"}, option.may_lack_value);
  section.Add(document::kText, option.text);
  return section;
}

// a positional argument as JSON
Section SectionOfPositional(const Option& positional) {
  Section section;
  section.Add(document::kName, positional.name);
  section.Add(document::kText, positional.text);
  section.Add(kRepeatable, positional.is_repeated);
  section.Add({"required"}, positional.is_required);
  section.Add(kKnown, positional.known);
  return section;
}

// line of an option in --help: "Side of the fingerpad [above 0; default 15 mm]"
std::string HelpOf(const Option& option) {
  std::string added = BoundsText(option);
  if (!option.default_text.empty()) {
    added += fmt::format("{}default {}", added.empty() ? "" : "; ", option.default_text);
  }
  return added.empty() ? option.text : fmt::format("{} [{}]", option.text, added);
}

}  // namespace

// NaN satisfies no bound; without bounds both are infinite
Result<void> CheckBounds(const Option& option, double number, const std::string& text) {
  const Bounds& bounds = option.bounds;
  const bool is_above = bounds.is_above ? number > bounds.least : number >= bounds.least;
  const bool is_below = bounds.is_below ? number < bounds.most : number <= bounds.most;
  if (is_above && is_below) return {};
  return Usage(option.name, fmt::format("'{}' is not {}", text, BoundsText(option)),
               "write one within");
}

struct Options::State {
  VerbText verb;
  CLI::App app;
  std::deque<Option> declared;  // without those that all verbs have
  std::deque<Option> positionals;
  std::vector<const CLI::Option*> files;    // options whose words name files to read
  std::vector<const CLI::Option*> outputs;  // options whose words name files to write
  std::vector<Exclusion> exclusions;
  bool help = false;
  bool help_all = false;
  bool version = false;
  bool json = false;
  bool describe = false;

  // what all verbs have
  struct CommonFlag {
    const char* name;
    bool State::* value;
    const char* text;
  };
  static constexpr std::array<CommonFlag, 4> CommonFlags() {
    return {{{"-h,--help", &State::help, "Show this help"},
             {"--help-all", &State::help_all, "Show every option"},
             {"--version", &State::version, "Show the version"},
             {"--json", &State::json, "Print one JSON document (docs/reference/)"}}};
  }

  Option& Add(Option option, CLI::Option* parsed, Shown shown = Shown::kHelp) {
    option.parsed = parsed;
    option.is_rare = shown == Shown::kHelpAll;
    if (option.kind != Option::Kind::kFlag) parsed->type_name(option.placeholder);
    return declared.emplace_back(std::move(option));
  }
  // an option whose text is read by `read`, which may throw Refused
  Option& AddRead(Option option, const std::function<void(const std::string&)>& read,
                  Shown shown = Shown::kHelp) {
    auto* parsed = app.add_option_function<std::string>(option.name, read);
    return Add(std::move(option), parsed, shown);
  }
  // long names of all options, for the nearest one to an unknown word
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    return names;
  }
  // the option whose name `word` is, "--port" or "-o"; nullptr for any other word
  const CLI::Option* Named(std::string_view word) const {
    // without dashes it could be the name of a positional
    return word.starts_with("-") ? app.get_option_no_throw(std::string(word)) : nullptr;
  }
  bool IsGiven(const std::string& name) const { return app.count(name) > 0; }
  bool IsOutput(const CLI::Option* option) const {
    return std::ranges::find(outputs, option) != outputs.end();
  }
  // the options as JSON; what is not known is null
  std::string Description() const;
  // help text of each option, and the group in which it is listed
  void DescribeToParser() const;
  void NoteInputs() const;
  std::optional<Error> TwiceWritten() const;
  std::optional<Error> Excluded() const;
  // the first word of an option, other than of files, that is not printable
  std::optional<Error> NotPrintable() const;
  // the first option that is followed by another option, or by nothing, in place of its value
  std::optional<Error> MissingValue(int argc, const char* const* argv) const;
  // a message in the form of all errors for what CLI11 found wrong
  Error Explain(const CLI::ParseError& error, int argc) const;
};

std::string Options::State::Description() const {
  Section section;
  section.Add(document::kName, verb.name);
  section.Add({"summary"}, verb.summary);
  std::vector<std::string> examples(verb.examples.begin(), verb.examples.end());
  std::erase(examples, "");
  section.Add({"examples"}, examples);
  Section& of_words = section.sections.emplace_back(
      Section{.name = "positionals", .shape = Section::Shape::kArray});
  for (const Option& positional : positionals) {
    of_words.sections.push_back(SectionOfPositional(positional));
  }
  Section& of_options =
      section.sections.emplace_back(Section{.name = "options", .shape = Section::Shape::kArray});
  for (const Option& option : declared) of_options.sections.push_back(SectionOf(option));
  Section& of_all =
      section.sections.emplace_back(Section{.name = "common", .shape = Section::Shape::kArray});
  for (const CommonFlag& flag : CommonFlags()) {
    Section& one = of_all.sections.emplace_back();
    one.Add(document::kName, flag.name);
    one.Add(document::kText, flag.text);
  }
  return document::JsonOf(section);
}

void Options::State::DescribeToParser() const {
  for (const Option& option : declared) {
    option.parsed->description(HelpOf(option));
    if (!option.is_rare) continue;
    // an empty group leaves an option out of the help
    option.parsed->group(help_all ? kMoreOptions : "");
  }
  for (const Option& positional : positionals) {
    // shown as one word, though a verb refuses a second one in words of its own
    if (!positional.is_repeated) positional.parsed->expected(positional.is_required ? 1 : 0, 1);
  }
}

std::optional<Error> Options::State::Excluded() const {
  for (const Exclusion& exclusion : exclusions) {
    if (!IsGiven(exclusion.name)) continue;
    for (const std::string& other : exclusion.others) {
      if (!IsGiven(other)) continue;
      return Error{Cause::kUsage, exclusion.name,
                   fmt::format("cannot be combined with {}: {}", other, exclusion.why),
                   "leave out one of the two"};
    }
  }
  return std::nullopt;
}

// each word of an option that is no output may name an input: an output must not overwrite it
void Options::State::NoteInputs() const {
  // inputs of an earlier command in the same process
  ForgetInputs();
  for (const CLI::Option* option : app.get_options()) {
    if (IsOutput(option)) continue;
    for (const std::string& word : option->results()) NoteInput(word);
  }
}

// two output options that name one file, compared by device and inode
std::optional<Error> Options::State::TwiceWritten() const {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (outputs[i]->empty() || outputs[j]->empty()) continue;
      const std::string& path = outputs[i]->results().back();
      if (!AreOneOutput(path, outputs[j]->results().back())) continue;
      return Error{Cause::kUsage, path,
                   fmt::format("is named by --{} and by --{}", outputs[j]->get_lnames().front(),
                               outputs[i]->get_lnames().front()),
                   "give each a file of its own"};
    }
  }
  return std::nullopt;
}

std::optional<Error> Options::State::NotPrintable() const {
  for (const CLI::Option* option : app.get_options()) {
    // positionals and files name paths, which may hold any byte
    if (option->get_positional() || std::ranges::find(files, option) != files.end()) continue;
    for (const std::string& word : option->results()) {
      if (auto printable = CheckPrintable(option->get_name(), word); !printable) {
        return printable.error();
      }
    }
  }
  return std::nullopt;
}

// CLI11 takes any word behind an option as its value, the name of the next option too
std::optional<Error> Options::State::MissingValue(int argc, const char* const* argv) const {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    // words behind it are plain
    if (word == "--") return std::nullopt;
    const CLI::Option* option = Named(word);
    if (option == nullptr || option->get_items_expected_min() == 0) continue;
    // the next word is its value, other than the name of an option, perhaps with a value of its own
    const std::string_view next = ++i < argc ? argv[i] : "";
    if (i < argc && Named(next.substr(0, next.find('='))) == nullptr) continue;
    return Error{Cause::kUsage, std::string(word), "has no value",
                 fmt::format("write {} {}", word, option->get_type_name())};
  }
  return std::nullopt;
}

Error Options::State::Explain(const CLI::ParseError& error, int argc) const {
  const std::string help_remedy = fmt::format("see haptometer {} --help", verb.name);
  const std::vector<std::string> names = Names();
  // CLI11 reports an absent input first, and left-over words without the nearest name
  for (const std::string& left : app.remaining()) {
    const std::string word = left.substr(0, left.find('='));
    if (!word.starts_with("-") || Named(word) != nullptr) continue;
    const std::string nearest = Nearest(word, names);
    return {Cause::kUsage, word, "is not an option",
            nearest.empty() ? help_remedy : fmt::format("did you mean {}?", nearest)};
  }
  // no word at all: the name of the missing input alone would be of little use
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && argc <= 1) {
    return {Cause::kUsage, {}, "no input is given", help_remedy};
  }
  std::string what = error.what();
  std::ranges::replace(what, '\n', ' ');
  return {Cause::kUsage, {}, what, help_remedy};
}

Options::Options(const VerbText& text) : state_(std::make_unique<State>()) {
  state_->verb = text;
  CLI::App& app = state_->app;
  app.name("haptometer " + std::string(text.name));
  app.description(std::string(text.summary));
  std::string footer = "Examples:";
  for (const std::string_view example : text.examples) footer += fmt::format("\n  {}", example);
  app.footer(footer);
  // without CLI11's own help flag, which ends the parse: Parse() prints the help itself
  app.set_help_flag();
  for (const State::CommonFlag& flag : State::CommonFlags()) {
    app.add_flag(flag.name, (*state_).*flag.value, flag.text);
  }
  app.add_flag("--describe-options", state_->describe)->group("");
}

Options::~Options() = default;

Option& Options::Positional(std::string_view name, std::string* value, std::string_view help) {
  auto* parsed = state_->app.add_option(std::string(name), *value, std::string(help));
  parsed->required()->type_name("");
  return state_->positionals.emplace_back(Option{
      .name = std::string(name), .text = std::string(help), .is_required = true, .parsed = parsed});
}

Option& Options::Positionals(std::string_view name, std::vector<std::string>* values,
                             std::string_view help, std::size_t at_least) {
  auto* parsed = state_->app.add_option(std::string(name), *values, std::string(help));
  parsed->type_name("");
  // -1: no upper limit
  if (at_least > 0) parsed->required()->expected(static_cast<int>(at_least), -1);
  return state_->positionals.emplace_back(Option{.name = std::string(name),
                                                 .text = std::string(help),
                                                 .is_repeated = true,
                                                 .is_required = at_least > 0,
                                                 .parsed = parsed});
}

namespace {

Option Declared(std::string_view name, Option::Kind kind, std::string_view placeholder,
                std::string_view help) {
  return {.name = std::string(name),
          .kind = kind,
          .placeholder = std::string(placeholder),
          .text = std::string(help)};
}

// of a number or a range
Option DeclaredNumber(std::string_view name, Option::Kind kind, std::string_view placeholder,
                      Dimension dimension, Bounds bounds, std::string_view help) {
  Option option = Declared(name, kind, placeholder, help);
  option.dimension = dimension;
  option.bounds = bounds;
  return option;
}

std::string PlaceholderOf(Dimension dimension) {
  const std::string_view unit = SiUnit(dimension);
  return std::string(unit.empty() ? "NUMBER" : unit);
}

// within the bounds of the option
Quantity ReadNumber(const Option& option, const std::string& text) {
  auto quantity = ParseQuantity(text, option.dimension, option.name);
  if (!quantity) throw Refused{quantity.error()};
  ThrowWhereWrong(CheckBounds(option, quantity->value, text));
  return *quantity;
}

// a number with an uncertainty ("3 +- 1") where the verb has no use for it
Result<void> CheckExact(std::string_view name, const Quantity& quantity) {
  if (quantity.exact()) return {};
  return Usage(std::string(name), "has an uncertainty, which is not used here", "leave it out");
}

}  // namespace

Option& Options::Flag(std::string_view name, bool* value, std::string_view help, Shown shown) {
  auto* parsed = state_->app.add_flag(std::string(name), *value);
  return state_->Add(Declared(name, Option::Kind::kFlag, "", help), parsed, shown);
}

Option& Options::Text(std::string_view name, std::string* value, std::string_view placeholder,
                      std::string_view help, Shown shown) {
  Option option = Declared(name, Option::Kind::kText, placeholder, help);
  const auto keep = [value, name = option.name](const std::string& text) {
    // an empty text is often a variable of a script that has no value, and would mean the default
    if (text.empty()) throw Refused{{Cause::kUsage, name, "is empty", "write a value"}};
    *value = text;
  };
  return state_->AddRead(std::move(option), keep, shown).Default(*value);
}

Option& Options::Parsed(std::string_view name, std::string_view placeholder,
                        std::function<Result<void>(const std::string&)> read,
                        std::string_view help) {
  return state_->AddRead(
      Declared(name, Option::Kind::kText, placeholder, help),
      [read = std::move(read)](const std::string& text) { ThrowWhereWrong(read(text)); });
}

Option& Options::Output(std::string_view name, std::string* value, std::string_view placeholder,
                        std::string_view help, Shown shown) {
  Option& option = Text(name, value, placeholder, help, shown);
  // registered, so that NoteInputs() and TwiceWritten() treat its word as an output
  state_->outputs.push_back(option.parsed);
  return option;
}

// the option's value may be absent: `given` separates "--name" from no option
Option& Options::OptionalText(std::string_view name, bool* given, std::string* value,
                              std::string_view placeholder, std::string_view help, Shown shown) {
  const auto read = [given, value](const std::string& text) {
    *given = true;
    *value = text;
  };
  Option& option =
      state_->AddRead(Declared(name, Option::Kind::kText, placeholder, help), read, shown);
  option.parsed->expected(0, 1);
  option.may_lack_value = true;
  return option;
}

Option& Options::Choice(std::string_view name, std::string* value,
                        const std::vector<std::string>& choices, std::string_view help,
                        Shown shown) {
  Option option =
      Declared(name, Option::Kind::kChoice, fmt::format("{}", fmt::join(choices, "|")), help);
  option.choices = choices;
  const auto read = [name = option.name, value, choices](const std::string& text) {
    if (std::ranges::find(choices, text) == choices.end()) {
      throw Refused{{Cause::kUsage, name, fmt::format("'{}' is not known", text),
                     fmt::format("use one of {}", fmt::join(choices, ", "))}};
    }
    *value = text;
  };
  return state_->AddRead(std::move(option), read, shown).Default(*value);
}

Option& Options::AddCount(std::string_view name, std::function<void(std::int64_t)> keep,
                          std::int64_t least, std::int64_t most, std::string_view help) {
  Option option = Declared(name, Option::Kind::kCount, "N", help);
  // doubles hold the bounds for the help text; the comparison below is in integers
  option.bounds = Within(static_cast<double>(least), static_cast<double>(most));
  // read as 64-bit integer: a double would round counts above 2^53
  const auto read = [name = option.name, keep = std::move(keep), least,
                     most](const std::string& text) {
    const auto number = NumberFrom<std::int64_t>(text);
    if (!number || *number < least || *number > most) {
      throw Refused{{Cause::kUsage, name,
                     fmt::format("'{}' is not a whole number from {} to {}", text, least, most),
                     "write one within"}};
    }
    keep(*number);
  };
  return state_->AddRead(std::move(option), read);
}

Option& Options::Count(std::string_view name, std::optional<std::int64_t>* value,
                       std::int64_t least, std::int64_t most, std::string_view help, Shown shown) {
  Option& option =
      AddCount(name, [value](std::int64_t number) { *value = number; }, least, most, help);
  return shown == Shown::kHelpAll ? option.Rare() : option;
}

Option& Options::AddNumber(std::string_view name, std::function<Result<void>(const Quantity&)> keep,
                           Dimension dimension, Bounds bounds, std::string_view help) {
  const Option option = DeclaredNumber(name, Option::Kind::kNumber, PlaceholderOf(dimension),
                                       dimension, bounds, help);
  return state_->AddRead(option, [option, keep = std::move(keep)](const std::string& text) {
    ThrowWhereWrong(keep(ReadNumber(option, text)));
  });
}

Option& Options::Number(std::string_view name, std::optional<Quantity>* value, Dimension dimension,
                        Bounds bounds, std::string_view help) {
  const auto keep = [value](const Quantity& quantity) -> Result<void> {
    *value = quantity;
    return {};
  };
  return AddNumber(name, keep, dimension, bounds, help);
}

Option& Options::Number(std::string_view name, std::optional<double>* value, Dimension dimension,
                        Bounds bounds, std::string_view help, Shown shown) {
  const auto keep = [value, name = std::string(name)](const Quantity& quantity) {
    *value = quantity.value;
    return CheckExact(name, quantity);
  };
  Option& option = AddNumber(name, keep, dimension, bounds, help);
  return shown == Shown::kHelpAll ? option.Rare() : option;
}

Option& Options::Number(std::string_view name, double* value, Dimension dimension, Bounds bounds,
                        std::string_view help) {
  const auto keep = [value, name = std::string(name)](const Quantity& quantity) {
    *value = quantity.value;
    return CheckExact(name, quantity);
  };
  // a default that is not finite means none, and is not shown
  return AddNumber(name, keep, dimension, bounds, help)
      .Default(std::isfinite(*value) ? NumberText(*value, dimension) : "");
}

Option& Options::Range(std::string_view name, double* low, double* high, Dimension dimension,
                       Bounds bounds, std::string_view help) {
  const Option option =
      DeclaredNumber(name, Option::Kind::kRange, "LOW:HIGH", dimension, bounds, help);
  const auto read = [option, low, high](const std::string& text) {
    // LOW:HIGH, or one number for both
    const std::size_t colon = text.find(':');
    const auto end = [&](const std::string& word) {
      const Quantity quantity = ReadNumber(option, word);
      ThrowWhereWrong(CheckExact(option.name, quantity));
      return quantity.value;
    };
    *low = *high = end(text.substr(0, colon));
    if (colon != std::string::npos) *high = end(text.substr(colon + 1));
    if (*low <= *high) return;
    throw Refused{{Cause::kUsage, option.name,
                   fmt::format("the lower end of '{}' lies above the upper one", text),
                   "write it as LOW:HIGH"}};
  };
  // a default that is not finite means none, and is not shown
  const bool is_shown = std::isfinite(*low) && std::isfinite(*high);
  return state_->AddRead(option, read)
      .Default(is_shown
                   ? fmt::format("{}:{}", NumberText(*low, dimension), NumberText(*high, dimension))
                   : "");
}

// one value per occurrence, so that a word behind it is not taken as a further value
Option& Options::Repeated(std::string_view name, std::vector<std::string>* values,
                          std::string_view placeholder, std::string_view help, Shown shown) {
  auto* parsed = state_->app.add_option(std::string(name), *values);
  Option& option =
      state_->Add(Declared(name, Option::Kind::kText, placeholder, help), parsed, shown);
  parsed->expected(1)->take_all()->allow_extra_args(false);
  option.is_repeated = true;
  return option;
}

Option& Options::Groups(std::string_view name, std::vector<std::vector<std::string>>* groups,
                        std::string_view placeholder, std::string_view help, Shown shown) {
  auto* parsed = state_->app.add_option(std::string(name), *groups);
  state_->files.push_back(parsed);
  Option& option =
      state_->Add(Declared(name, Option::Kind::kText, placeholder, help), parsed, shown);
  // the help adds dots
  parsed->type_name(option.placeholder.substr(0, option.placeholder.find("...")));
  option.is_repeated = option.takes_several = true;
  return option;
}

void Options::Exclude(std::string_view name, std::initializer_list<std::string_view> others,
                      std::string_view why) {
  state_->exclusions.push_back(
      {std::string(name), {others.begin(), others.end()}, std::string(why)});
}

std::optional<int> Options::Parse(int argc, const char* const* argv) {
  std::optional<Error> error;
  bool is_incomplete = false;  // a required input is absent, otherwise valid
  try {
    state_->app.parse(argc, argv);
  } catch (const Refused& refused) {
    // errors are kept, since --version and --help take precedence over them
    error = refused.error;
  } catch (const CLI::ParseError& parse_error) {
    is_incomplete = dynamic_cast<const CLI::RequiredError*>(&parse_error) != nullptr;
    error = state_->Explain(parse_error, argc);
  }
  // the cause of other errors, as where the next option's value is left over
  if (auto missing = state_->MissingValue(argc, argv)) {
    error = std::move(missing);
    is_incomplete = false;
  }
  if (state_->version) {
    fmt::print("haptometer {}\n", HAPTOMETER_VERSION);
    return 0;
  }
  if (state_->help || state_->help_all) {
    state_->DescribeToParser();
    cli::Print(state_->app.help());
    return 0;
  }
  // a description needs no input, so an absent one is no error here
  if (state_->describe && (!error || is_incomplete)) {
    cli::Print(state_->Description());
    return 0;
  }
  // checks over several options, once each alone is valid
  if (!error) error = state_->Excluded();
  if (!error) error = state_->NotPrintable();
  if (!error) error = state_->TwiceWritten();
  if (error) return ReportError(state_->verb.name, *error);
  // before any output is checked against the inputs
  state_->NoteInputs();
  return std::nullopt;
}

bool Options::json() const { return state_->json; }

Result<void> CheckRules(std::initializer_list<Rule> rules) {
  const auto* const rule = std::ranges::find(rules, true, &Rule::is_broken);
  if (rule == rules.end()) return {};
  return Usage(std::string(rule->where), std::string(rule->what), std::string(rule->remedy));
}

}  // namespace haptometer::cli
