#include "tools/cli/options.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>

#include "base/input_file.h"
#include "base/text.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

constexpr const char* kMoreOptions = "More options";

// carries one of our errors out of CLI11's parser
struct Refused {
  Error error;
};

// a whole number, all of the text
std::optional<std::int64_t> WholeNumber(const std::string& text) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, value);
  if (failure != std::errc{} || stop != end) return std::nullopt;
  return value;
}

std::string Joined(const std::vector<std::string>& words, std::string_view separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

}  // namespace

struct Options::State {
  std::string verb;
  CLI::App app;
  std::vector<CLI::Option*> hidden;         // shown by --help-all only
  std::vector<const CLI::Option*> files;    // options whose words name files to read
  std::vector<const CLI::Option*> outputs;  // options whose words name files to write
  bool help = false;
  bool help_all = false;
  bool version = false;
  bool json = false;

  void Show(CLI::Option* option, Shown shown) {
    if (shown == Shown::kHelp) return;
    option->group("");
    hidden.push_back(option);
  }
  // an option whose text is read by `read`, which may throw Refused
  CLI::Option* Add(std::string_view name, std::string_view placeholder, std::string_view help_text,
                   const std::function<void(const std::string&)>& read) {
    return app.add_option_function<std::string>(std::string(name), read, std::string(help_text))
        ->type_name(std::string(placeholder));
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    return names;
  }
  bool IsOutput(const CLI::Option* option) const {
    return std::ranges::find(outputs, option) != outputs.end();
  }
  void NoteInputs() const;
  std::optional<Error> TwiceWritten() const;
  // the first word that an option other than of files takes and that is not printable
  std::optional<Error> NotPrintable() const;
  // our own sentence for what CLI11 found wrong
  Error Explain(const CLI::ParseError& error, int argc, const char* const* argv) const;
};

void Options::State::NoteInputs() const {
  ForgetInputs();
  for (const CLI::Option* option : app.get_options()) {
    if (IsOutput(option)) continue;
    for (const std::string& word : option->results()) NoteInput(word);
  }
}

// two options that name one file
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
    if (option->get_positional() || std::ranges::find(files, option) != files.end()) continue;
    for (const std::string& word : option->results()) {
      if (auto printable = CheckPrintable(option->get_name(), word); !printable) {
        return printable.error();
      }
    }
  }
  return std::nullopt;
}

Error Options::State::Explain(const CLI::ParseError& error, int argc,
                              const char* const* argv) const {
  const std::string help_remedy = fmt::format("see haptometer {} --help", verb);
  const std::vector<std::string> names = Names();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    for (int i = 1; i < argc; ++i) {
      const std::string word(argv[i], std::strcspn(argv[i], "="));
      if (word.starts_with("-") && std::ranges::find(names, word) == names.end()) {
        const std::string nearest = Nearest(word, names);
        return {Cause::kUsage, word, "is not an option",
                nearest.empty() ? help_remedy : fmt::format("did you mean {}?", nearest)};
      }
    }
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && argc <= 1) {
    return {Cause::kUsage, {}, "nothing is given to work on", help_remedy};
  }
  std::string what = error.what();
  std::ranges::replace(what, '\n', ' ');
  return {Cause::kUsage, {}, what, help_remedy};
}

Options::Options(const VerbText& text) : state_(std::make_unique<State>()) {
  state_->verb = text.name;
  CLI::App& app = state_->app;
  app.name("haptometer " + std::string(text.name));
  app.description(std::string(text.summary));
  std::string footer = "Examples:";
  for (const std::string_view example : text.examples) footer += fmt::format("\n  {}", example);
  app.footer(footer);
  app.set_help_flag();
  app.add_flag("-h,--help", state_->help, "Show this help");
  app.add_flag("--help-all", state_->help_all, "Show every option");
  app.add_flag("--version", state_->version, "Show the version");
  app.add_flag("--json", state_->json, "Print one JSON document (docs/reference/)");
}

Options::~Options() = default;

void Options::Positional(std::string_view name, std::string* value, std::string_view help) {
  state_->app.add_option(std::string(name), *value, std::string(help))->required()->type_name("");
}

void Options::Positionals(std::string_view name, std::vector<std::string>* values,
                          std::string_view help, std::size_t at_least) {
  auto* option = state_->app.add_option(std::string(name), *values, std::string(help));
  option->type_name("");
  if (at_least > 0) option->required()->expected(static_cast<int>(at_least), -1);
}

void Options::Flag(std::string_view name, bool* value, std::string_view help, Shown shown) {
  state_->Show(state_->app.add_flag(std::string(name), *value, std::string(help)), shown);
}

void Options::Text(std::string_view name, std::string* value, std::string_view placeholder,
                   std::string_view help, Shown shown) {
  state_->Show(
      state_->Add(name, placeholder, help, [value](const std::string& text) { *value = text; }),
      shown);
}

void Options::Output(std::string_view name, std::string* value, std::string_view placeholder,
                     std::string_view help, Shown shown) {
  auto* option =
      state_->Add(name, placeholder, help, [value](const std::string& text) { *value = text; });
  state_->outputs.push_back(option);
  state_->Show(option, shown);
}

void Options::OptionalText(std::string_view name, bool* given, std::string* value,
                           std::string_view placeholder, std::string_view help, Shown shown) {
  auto* option = state_->Add(name, placeholder, help, [given, value](const std::string& text) {
    *given = true;
    *value = text;
  });
  state_->Show(option->expected(0, 1), shown);
}

void Options::Choice(std::string_view name, std::string* value,
                     const std::vector<std::string>& choices, std::string_view help, Shown shown) {
  const std::string placeholder = Joined(choices, "|");
  const auto read = [name = std::string(name), value, choices](const std::string& text) {
    if (std::ranges::find(choices, text) == choices.end()) {
      throw Refused{{Cause::kUsage, name, fmt::format("'{}' is not known", text),
                     "use one of " + Joined(choices, ", ")}};
    }
    *value = text;
  };
  state_->Show(state_->Add(name, placeholder, help, read), shown);
}

void Options::Count(std::string_view name, std::optional<std::int64_t>* value, std::int64_t least,
                    std::int64_t most, std::string_view help, Shown shown) {
  const auto read = [name = std::string(name), value, least, most](const std::string& text) {
    const auto number = WholeNumber(text);
    if (!number || *number < least || *number > most) {
      throw Refused{{Cause::kUsage, name,
                     fmt::format("'{}' is not a whole number from {} to {}", text, least, most),
                     "write one within"}};
    }
    *value = number;
  };
  state_->Show(state_->Add(name, "N", help, read), shown);
}

void Options::Number(std::string_view name, std::optional<Quantity>* value, Dimension dimension,
                     std::string_view help, Shown shown) {
  const auto read = [name = std::string(name), value, dimension](const std::string& text) {
    auto quantity = ParseQuantity(text, dimension, name);
    if (!quantity) throw Refused{quantity.error()};
    *value = *quantity;
  };
  const std::string_view unit = SiUnit(dimension);
  state_->Show(state_->Add(name, unit.empty() ? "NUMBER" : unit, help, read), shown);
}

void Options::Repeated(std::string_view name, std::vector<std::string>* values,
                       std::string_view placeholder, std::string_view help, Shown shown) {
  auto* option = state_->app.add_option(std::string(name), *values, std::string(help));
  option->type_name(std::string(placeholder))->expected(1)->take_all()->allow_extra_args(false);
  state_->Show(option, shown);
}

void Options::Groups(std::string_view name, std::vector<std::vector<std::string>>* groups,
                     std::string_view placeholder, std::string_view help, Shown shown) {
  auto* option = state_->app.add_option(std::string(name), *groups, std::string(help));
  option->type_name(std::string(placeholder));
  state_->files.push_back(option);
  state_->Show(option, shown);
}

std::optional<int> Options::Parse(int argc, const char* const* argv) {
  std::optional<Error> error;
  try {
    state_->app.parse(argc, argv);
  } catch (const Refused& refused) {
    error = refused.error;
  } catch (const CLI::ParseError& parse_error) {
    error = state_->Explain(parse_error, argc, argv);
  }
  if (state_->version) {
    fmt::print("haptometer {}\n", HAPTOMETER_VERSION);
    return 0;
  }
  if (state_->help || state_->help_all) {
    if (state_->help_all) {
      for (CLI::Option* option : state_->hidden) option->group(kMoreOptions);
    }
    cli::Print(state_->app.help());
    return 0;
  }
  if (!error) error = state_->NotPrintable();
  if (!error) error = state_->TwiceWritten();
  if (error) return ReportError(state_->verb, *error);
  state_->NoteInputs();
  return std::nullopt;
}

bool Options::json() const { return state_->json; }

}  // namespace haptometer::cli
