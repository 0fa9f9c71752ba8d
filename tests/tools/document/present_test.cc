#include "tools/document/present.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/input_file.h"
#include "tests/tools/captured.h"

namespace haptometer::document {
namespace {

using ::testing::HasSubstr;

// what a verb would ask for and answer with
struct Case {
  Outputs outputs;
  Document document;
} shown;

int Show(int argc, const char* const* argv) {
  return Present(shown.document, shown.outputs, argc, argv);
}

class PresentDocument : public ::testing::Test {
 protected:
  void SetUp() override {
    ForgetInputs();
    shown = {};
    shown.document = {.verb = "sample", .title = "a sample"};
    shown.document.root.Add({"rms_m", "vibration", kMetre}, 2e-6);
    shown.document.root.figures.push_back({"a ramp", {{"", "x", "y", {{"", {}, {0, 1}, {0, 1}}}}}});
  }
};

TEST_F(PresentDocument, PrintsTextOrJson) {
  EXPECT_EQ(tools::Captured(Show, "sample", {}).out, "a sample\n  vibration  2 um\n");
  shown.outputs.json = true;
  const auto json = nlohmann::json::parse(tools::Captured(Show, "sample", {"a b"}).out);
  EXPECT_EQ(json.at("rms_m"), 2e-6);
  EXPECT_EQ(json.at("provenance").at("command"), "haptometer sample 'a b'");
}

// "abc": FIPS 180-4, the example of SHA-256
TEST_F(PresentDocument, NamesTheInputsWithTheirHash) {
  const std::string path = ::testing::TempDir() + "present_input.txt";
  std::ofstream(path) << "abc";
  ASSERT_TRUE(ReadInputFile(path));
  NoteInput(path);
  const Provenance provenance = CollectProvenance({"haptometer", "sample"});
  ASSERT_EQ(provenance.inputs.size(), 1U) << "named once";
  EXPECT_EQ(provenance.inputs[0].path, path);
  EXPECT_EQ(provenance.inputs[0].bytes, 3U);
  EXPECT_EQ(provenance.inputs[0].sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  std::ofstream(path, std::ios::app) << "d";
  EXPECT_EQ(CollectProvenance({}).inputs[0].sha256, "") << "another content than was read";
}

TEST_F(PresentDocument, ARefusalIsStatus3AndADoubtIsNot) {
  EXPECT_EQ(tools::Captured(Show, "sample", {}).status, 0);
  Section inner;
  inner.findings.push_back(
      {.kind = "doubt", .severity = Severity::kDoubt, .text = "", .subject = "", .numbers = {}});
  shown.document.root.sections.push_back(inner);
  EXPECT_EQ(tools::Captured(Show, "sample", {}).status, 0);
  shown.document.root.sections[0].findings[0].severity = Severity::kRefusal;
  EXPECT_EQ(tools::Captured(Show, "sample", {}).status, 3);
}

// in parts

Section Part(std::string heading, double rms_m) {
  Section part{.heading = std::move(heading)};
  part.Add({"rms_m", "vibration", kMetre}, rms_m);
  return part;
}

int ShowParts(int argc, const char* const* argv) {
  shown.document.root = {};
  shown.document.root.sections = {{.name = "parts", .shape = Section::Shape::kArray}};
  Presenter presenter(shown.document, shown.outputs, argc, argv);
  Section error = Part("error", 0);
  error.detail = Detail::kAll;
  presenter.Add(error);
  if (!shown.outputs.json && !shown.outputs.all) std::printf("here\n");
  presenter.Add(Part("first", 1e-6));
  presenter.Add(Part("second", 2e-6));
  Section last;
  last.Add({"excludes", "excludes"}, "nothing");
  return presenter.Finish(last);
}

TEST_F(PresentDocument, ShowsPartsAsTheyCome) {
  EXPECT_EQ(tools::Captured(ShowParts, "sample", {}).out,
            "here\na sample\n  first\n    vibration  1 um\n  second\n    vibration  2 um\n"
            "  excludes  nothing\n");
  shown.outputs.all = true;
  const std::string all = tools::Captured(ShowParts, "sample", {}).out;
  EXPECT_TRUE(all.starts_with("a sample\n  error\n")) << all;
  EXPECT_THAT(all, HasSubstr("  command: haptometer sample\n"));
  shown.outputs.json = true;
  const auto json = nlohmann::json::parse(tools::Captured(ShowParts, "sample", {}).out);
  EXPECT_EQ(json.at("parts").size(), 3U);
  EXPECT_EQ(json.at("parts").at(2).at("rms_m"), 2e-6);
  EXPECT_EQ(json.at("excludes"), "nothing");
}

TEST_F(PresentDocument, WritesThePictureAndThePage) {
  shown.outputs.plot = ::testing::TempDir() + "present.svg";
  shown.outputs.report = ::testing::TempDir() + "present.html";
  ASSERT_TRUE(CheckOutputs(shown.outputs));
  EXPECT_EQ(tools::Captured(Show, "sample", {}).status, 0);
  for (const std::string& path : {shown.outputs.plot, shown.outputs.report}) {
    std::ifstream file(path);
    const std::string content{std::istreambuf_iterator<char>(file), {}};
    EXPECT_THAT(content, HasSubstr("<svg")) << path;
  }
  shown.outputs.plot = "/no/such/folder/present.svg";
  EXPECT_FALSE(CheckOutputs(shown.outputs));
  for (const char* page : {"report.pdf", "/no/such/directory/report.html"}) {
    EXPECT_FALSE(CheckOutputs({.plot = {}, .report = page})) << page;
  }
  const tools::Outcome failed = tools::Captured(Show, "sample", {});
  EXPECT_EQ(failed.status, 2);
  EXPECT_THAT(failed.err, HasSubstr("haptometer sample: /no/such/folder"));
  EXPECT_THAT(failed.out, HasSubstr("vibration")) << "the answer is there all the same";
}

}  // namespace
}  // namespace haptometer::document
