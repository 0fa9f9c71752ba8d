#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "tools/cli/options.h"
#include "tools/document/document.h"

/// The thin face of every verb: what is shown where.
namespace haptometer::document {

/// What of an answer is asked for; a verb declares the options that it has.
struct Outputs {
  bool json = false;   ///< --json: JSON in the place of text on standard output
  bool all = false;    ///< --all: text with all details
  std::string plot;    ///< --plot: all figures in one picture; empty: none
  std::string report;  ///< --report: a page; empty: none

  /// Whether figures are drawn, which cost time to compute.
  [[nodiscard]] bool HasFigures() const;
};

/// While one lives, a document that is presented is kept here, too. One at a time.
class Receiver {
 public:
  /// `has_figures`: they are computed.
  explicit Receiver(bool has_figures);
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  [[nodiscard]] bool has_figures() const { return has_figures_; }
  void Take(const Document& document) { document_ = document; }
  /// The last one; nothing where none was presented.
  [[nodiscard]] std::optional<Document> document() && { return std::move(document_); }

 private:
  bool has_figures_;
  std::optional<Document> document_{};
};

/// What help says of --all, --plot and --report; an option is not declared where it is empty.
struct OutputHelp {
  std::string_view all = {};
  std::string_view plot = {};
  std::string_view report = "Write one page with all details and the figures";
};
void DeclareOutputs(cli::Options& options, Outputs& outputs, const OutputHelp& help);

/// Whether the picture and the page can be written; to be asked before long work. Errors: as
/// plot::CheckPlotPath and cli::CheckOutput; Cause::kUsage where the page does not end in .html.
[[nodiscard]] Result<void> CheckOutputs(const Outputs& outputs);

/// The provenance of what a verb answers now. `argv` is the verb's own: its first word is not
/// looked at.
[[nodiscard]] Provenance ProvenanceOf(std::string_view verb, int argc, const char* const* argv);

/// Prints the document and writes picture and page. Returns the exit status: 3 where a refusal is
/// among the findings, that of an error where one occurs, or else 0. The provenance is collected
/// where it is shown, so the document's own is overwritten.
[[nodiscard]] int Present(Document document, const Outputs& outputs, int argc,
                          const char* const* argv);

/// The frame of a verb: reads the command line, asks whether the outputs can be written, and leaves
/// with the exit status that `answer` gives. An error of either is reported.
[[nodiscard]] int RunVerb(std::string_view verb, cli::Options& options, Outputs& outputs, int argc,
                          const char* const* argv, const std::function<Result<int>()>& answer);

/// Present() for an answer that comes in parts, as of one file after the other: the text of each is
/// printed as soon as it is there. The title stands before the first part that has a text.
class Presenter {
 public:
  /// The parts become those of the last section of `document`. `argv` must outlive this.
  Presenter(Document document, Outputs outputs, int argc, const char* const* argv);

  /// Adds a part, and prints its text.
  void Add(Section part);
  /// Ends the document with a last section, and does what is left of Present().
  [[nodiscard]] int Finish(Section last);

 private:
  void PrintText(const Section& section);

  Document document_;
  Outputs outputs_;
  int argc_;
  const char* const* argv_;
  bool has_title_ = false;  // printed
};

}  // namespace haptometer::document
