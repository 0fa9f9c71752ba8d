#include "tools/cli/output_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <set>

#include "base/input_file.h"
#include "tests/temporary_files.h"
#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::string_view kSvg = "<?xml version=\"1.0\"?>\n<svg></svg>\n\n";

class OutputFileTest : public tests::TemporaryFiles {
 protected:
  void SetUp() override {
    TemporaryFiles::SetUp();
    ForgetInputs();
  }

  std::string Path(const std::string& name) const { return directory_ / name; }

  std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_)) {
      names.insert(entry.path().filename());
    }
    return names;
  }

  static std::string Wrong(const Result<void>& result) {
    return result ? "" : result.error().Text();
  }
};

// the longest file that this process may write; what is longer fails as on a full disk
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{.rlim_cur = bytes, .rlim_max = before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(OutputFileTest, IsNotThereBeforeItIsWhole) {
  auto file = OutputFile::Begin(Path("rows.csv"), kRowsOutput, false);
  ASSERT_TRUE(file.has_value());
  ASSERT_TRUE(file->Write("time_s,displacement_m\n").has_value());
  EXPECT_FALSE(fs::exists(Path("rows.csv")));
  ASSERT_TRUE(file->Write("0,1e-6\n").has_value());
  ASSERT_TRUE(file->Finish().has_value());
  EXPECT_EQ(Content("rows.csv"), "time_s,displacement_m\n0,1e-6\n");
  EXPECT_EQ(Names(), std::set<std::string>{"rows.csv"});
}

TEST_F(OutputFileTest, LeavesNothingWhereItIsGivenUp) {
  {
    auto file = OutputFile::Begin(Path("rows.csv"), kRowsOutput, false);
    ASSERT_TRUE(file.has_value());
    ASSERT_TRUE(file->Write("time_s,").has_value());
    EXPECT_EQ(Names().size(), 1U);
  }
  EXPECT_TRUE(Names().empty());
}

TEST_F(OutputFileTest, AFullDiskKeepsTheOlderFileAndLeavesNoPart) {
  const std::string older = "time_s,voltage_v\n0,1\n";
  const std::string path = File("rows.csv", older);
  const FileLimit limit(4096);
  const auto written =
      WriteOutput(path, kRowsOutput, true, "time_s,displacement_m\n" + std::string(9000, '1'));
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().cause, Cause::kFailed);
  EXPECT_THAT(Wrong(written), HasSubstr("rows.csv: cannot be written: File too large"));
  EXPECT_EQ(Content("rows.csv"), older);
  EXPECT_EQ(Names(), std::set<std::string>{"rows.csv"});
}

TEST_F(OutputFileTest, AnExistingFileNeedsToBeOfItsKindAndAskedFor) {
  const std::string path = File("s.csv", "# resolution_hz = 1\nfrequency_hz,density\n1,2\n");
  EXPECT_THAT(Wrong(WriteOutput(path, kSpectrumOutput, false, "x")), HasSubstr("already exists"));
  EXPECT_THAT(Wrong(WriteOutput(path, kRowsOutput, true, "x")),
              HasSubstr("exists and is not a table of time_s"));
  EXPECT_EQ(Wrong(WriteOutput(path, kSpectrumOutput, true, "frequency_hz,x\n")), "");
  EXPECT_EQ(Content("s.csv"), "frequency_hz,x\n");
  // an empty file holds nothing that could be lost
  const std::string empty = File("empty.csv", "");
  EXPECT_THAT(Wrong(WriteOutput(empty, kRowsOutput, false, "x")), HasSubstr("already exists"));
  EXPECT_EQ(Wrong(WriteOutput(empty, kRowsOutput, true, "time_s,y\n")), "");
}

TEST_F(OutputFileTest, WhatEachKindReplaces) {
  const std::string recording =
      "\x93"
      "haptrial\r\n....";
  const std::pair<const OutputKind*, std::string> kinds[] = {
      {&kTrialOutput, recording},
      {&kRowsOutput, "# source = x\n# rate = 1\ntime_s,displacement_m\n"},
      {&kSpectrumOutput, "# window = hann\nfrequency_hz,amplitude_m\n"},
      {&kSpectrogramOutput, "# window = hann\ntime_s,frequency_hz,density_m2_per_hz\n"},
      {&kSweepTableOutput, "# haptometer sweep 0.1.0\n# scene = s\npoint,a\n"},
      {&kStudyTableOutput, "subject,condition\n"},
      {&kMethodsOutput, "## Methods\n\nText"},
      {&kActuatorOutput, "# written by haptometer fit-lra; value\nmoving_mass_kg = 1\n"},
      {&kHdf5Output, "\x89HDF\r\n\x1a\n..."},
      {&kNpyOutput, "\x93NUMPY\x01"},
      {&kWavOutput, "RIFF1234WAVE"},
      {&kMatOutput, "MATLAB 5.0 MAT-file, written by haptometer   "}};
  for (const auto& [kind, own] : kinds) {
    for (const auto& [other, content] : kinds) {
      // a spectrogram is a table of time_s as well
      const bool is_own = other == kind || (kind == &kRowsOutput && other == &kSpectrogramOutput);
      EXPECT_EQ(IsOfKind(content, *kind), is_own) << kind->name << " over " << other->name;
    }
    for (const char* foreign : {"[actuator]\nmodel = \"x\"\n", "# a note\n", "a,b\n1,2\n",
                                "<?xml version=\"1.0\"?><svg></svg>", "%PDF-1.5\n%%EOF\n"}) {
      EXPECT_FALSE(IsOfKind(foreign, *kind)) << kind->name << " over " << foreign;
    }
  }
}

TEST_F(OutputFileTest, OnlyUnchangedPicturesOfOursAreReplaced) {
  const std::string own = Marked(std::string(kSvg));
  const std::string path = File("p.svg", own);
  EXPECT_EQ(Wrong(WriteOutput(path, kPictureOutput, false, own)), "");
  std::string edited = own;
  edited[edited.find("<svg>") + 1] = 'S';
  for (const std::string& other : {std::string(kSvg), edited, own + " ", std::string()}) {
    const std::string there = File("other.svg", other);
    EXPECT_THAT(Wrong(WriteOutput(there, kPictureOutput, true, own)),
                HasSubstr("is not a picture"));
    EXPECT_EQ(Content("other.svg"), other);
  }
  // a picture is no page
  EXPECT_FALSE(IsOfKind(own, kPageOutput));
  EXPECT_TRUE(IsOfKind(Marked("<!DOCTYPE html>\n<html></html>\n"), kPageOutput));
}

TEST_F(OutputFileTest, APngKeepsItsChunksAndAPdfItsEnd) {
  using std::string_literals::operator""s;
  const std::string png = "\x89PNG\r\n\x1a\n"s + "\0\0\0\0IEND\xae\x42\x60\x82"s;
  const std::string marked = Marked(png);
  EXPECT_TRUE(IsOfKind(marked, kPictureOutput));
  EXPECT_TRUE(IsWholePicture(marked));
  // the chunk between: length 36, tEXt, keyword Software; its CRC is of zlib (Python's binascii)
  EXPECT_EQ(marked.size(), png.size() + 12 + 36);
  EXPECT_EQ(marked.substr(8, 17), "\0\0\0\x24tEXtSoftware\0"s);
  EXPECT_EQ(marked.substr(25, 27), "made by haptometer 7a0709a4"s);
  const std::string pdf = Marked("%PDF-1.5\n%%EOF\n");
  EXPECT_THAT(pdf, ::testing::StartsWith("%PDF-1.5\n%%EOF\n% made by haptometer "));
  EXPECT_TRUE(IsOfKind(pdf, kPictureOutput));
}

TEST_F(OutputFileTest, ACutPictureIsNotWhole) {
  const std::string pictures[] = {std::string(kSvg), "%PDF-1.5\nx\n%%EOF\n"};
  for (const std::string& picture : pictures) {
    EXPECT_TRUE(IsWholePicture(picture));
    EXPECT_FALSE(IsWholePicture(picture.substr(0, picture.size() - 5)));
  }
  EXPECT_FALSE(IsWholePicture(""));
  EXPECT_FALSE(IsWholePicture("</svg>"));
}

TEST_F(OutputFileTest, NeverAnInputUnderWhateverName) {
  const std::string input = File("in.csv", "time_s,displacement_m\n0,1\n");
  fs::create_symlink(input, Path("link.csv"));
  fs::create_hard_link(input, Path("hard.csv"));
  ASSERT_TRUE(ReadInputFile(input).has_value());
  for (const char* name : {"in.csv", "link.csv", "hard.csv"}) {
    const auto written = WriteOutput(Path(name), kRowsOutput, true, "time_s,x\n");
    EXPECT_THAT(Wrong(written), HasSubstr("is an input of this command")) << name;
    EXPECT_EQ(written.error().cause, Cause::kUsage);
  }
  EXPECT_EQ(Content("in.csv"), "time_s,displacement_m\n0,1\n");
  // the next command reads something else
  ForgetInputs();
  EXPECT_EQ(Wrong(CheckOutput(input, kRowsOutput, true)), "");
}

TEST_F(OutputFileTest, ALinkStandsForItsFile) {
  const std::string file = File("file.csv", "time_s,x\n");
  fs::create_directory(Path("folder"));
  fs::create_symlink("../file.csv", Path("folder/link.csv"));
  EXPECT_EQ(Wrong(WriteOutput(Path("folder/link.csv"), kRowsOutput, true, "time_s,y\n")), "");
  EXPECT_TRUE(fs::is_symlink(Path("folder/link.csv")));
  EXPECT_EQ(Content("file.csv"), "time_s,y\n");
  fs::create_symlink("nowhere.csv", Path("dangling.csv"));
  EXPECT_THAT(Wrong(WriteOutput(Path("dangling.csv"), kRowsOutput, true, "time_s,y\n")),
              HasSubstr("is a link to nothing"));
  fs::create_symlink("loop.csv", Path("loop.csv"));
  EXPECT_THAT(Wrong(CheckOutput(Path("loop.csv"), kRowsOutput, true)),
              HasSubstr("Too many levels"));
}

TEST_F(OutputFileTest, DirectoriesDisksAndMissingPlacesAreRefused) {
  EXPECT_THAT(Wrong(CheckOutput(directory_, kRowsOutput, true)), HasSubstr("is a directory"));
  EXPECT_THAT(Wrong(CheckOutput("-", kRowsOutput, true)), HasSubstr("standard output"));
  EXPECT_THAT(Wrong(CheckOutput(Path("none/x.csv"), kRowsOutput, true)),
              HasSubstr("lies in a directory that does not exist"));
  const std::string file = File("file", "x");
  EXPECT_THAT(Wrong(CheckOutput(file + "/x.csv", kRowsOutput, true)),
              HasSubstr("lies in a directory that does not exist"));
}

TEST_F(OutputFileTest, WhatIsBeingWrittenIsRefused) {
  const std::string path = File("t.bin",
                                "\x93"
                                "haptrial\r\n");
  const int other = open(path.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(other, LOCK_EX), 0);
  EXPECT_THAT(Wrong(CheckOutput(path, kTrialOutput, true)),
              HasSubstr("is being written by another program"));
  close(other);
  EXPECT_EQ(Wrong(CheckOutput(path, kTrialOutput, true)), "");
}

TEST_F(OutputFileTest, PermissionsAreThoseOfOpenOrOfTheOlderFile) {
  const auto mode = [&](const std::string& name) {
    struct stat status{};
    EXPECT_EQ(stat(Path(name).c_str(), &status), 0);
    return status.st_mode & 0777U;
  };
  const mode_t mask = umask(027);
  EXPECT_EQ(Wrong(WriteOutput(Path("new.csv"), kRowsOutput, false, "time_s,x\n")), "");
  EXPECT_EQ(mode("new.csv"), 0640U);
  fs::permissions(File("old.csv", "time_s,x\n"), fs::perms(0604));
  EXPECT_EQ(Wrong(WriteOutput(Path("old.csv"), kRowsOutput, true, "time_s,y\n")), "");
  EXPECT_EQ(mode("old.csv"), 0604U);
  umask(mask);
}

TEST_F(OutputFileTest, AFileThatAppearsMeanwhileStays) {
  auto file = OutputFile::Begin(Path("rows.csv"), kRowsOutput, false);
  ASSERT_TRUE(file.has_value());
  ASSERT_TRUE(file->Write("time_s,x\n").has_value());
  ASSERT_FALSE(File("rows.csv", "precious").empty());
  const auto finished = file->Finish();
  EXPECT_THAT(Wrong(finished), HasSubstr("rows.csv: already exists"));
  EXPECT_EQ(Content("rows.csv"), "precious");
}

TEST_F(OutputFileTest, PipesAndDevicesAreWrittenAsTheyAre) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  EXPECT_THAT(Wrong(WriteOutput(Path("pipe"), kRowsOutput, false, "time_s,x\n")),
              HasSubstr("pipe: is a pipe that no program reads"));
  const int reader = open(Path("pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  EXPECT_EQ(Wrong(WriteOutput(Path("pipe"), kRowsOutput, false, "time_s,x\n")), "");
  char bytes[16] = {};
  EXPECT_EQ(read(reader, bytes, sizeof bytes), 9);
  close(reader);
  EXPECT_TRUE(fs::is_fifo(Path("pipe")));
  EXPECT_EQ(Wrong(WriteOutput("/dev/null", kRowsOutput, false, "time_s,x\n")), "");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THAT(Wrong(WriteOutput("/dev/full", kRowsOutput, false, "time_s,x\n")),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
  // a library that goes back cannot write to them
  auto pipe = OutputFile::Begin("/dev/null", kHdf5Output, false);
  ASSERT_TRUE(pipe.has_value());
  EXPECT_FALSE(pipe->PathForLibrary().has_value());
}

TEST_F(OutputFileTest, AnOpenFileGoesOnWhereItStands) {
  const int file = open(Path("out").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_EQ(write(file, "before\n", 7), 7);
  const std::string path = "/dev/fd/" + std::to_string(file);
  EXPECT_EQ(Wrong(WriteOutput(path, kRowsOutput, false, "time_s,x\n")), "");
  ASSERT_EQ(write(file, "after\n", 6), 6);
  close(file);
  EXPECT_EQ(Content("out"), "before\ntime_s,x\nafter\n");
}

TEST_F(OutputFileTest, TwoNamesOfOneFileAreKnown) {
  const std::string file = File("a.svg", "x");
  fs::create_hard_link(file, Path("b.svg"));
  EXPECT_TRUE(AreOneOutput(file, Path("b.svg")));
  EXPECT_TRUE(AreOneOutput(Path("new.svg"), Path("./new.svg")));
  EXPECT_TRUE(AreOneOutput("new.svg", "./new.svg"));
  EXPECT_FALSE(AreOneOutput(Path("new.svg"), Path("newer.svg")));
  EXPECT_FALSE(AreOneOutput("/dev/null", "/dev/null"));
}

}  // namespace
}  // namespace haptometer::cli
