// What the programs of examples/ read and write with: the place and the words of everything that is wrong.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "../../examples/common/files.hpp"
#include "../../examples/common/rows.hpp"

namespace {

using common::Rows;
using common::Separator;

/// A folder that is gone after the test.
struct FilesTest : testing::Test {
  std::string folder = testing::TempDir() + "myogrowth_files_XXXXXX";
  void SetUp() override { ASSERT_NE(mkdtemp(folder.data()), nullptr); }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::string file(const std::string& bytes) const {
    const std::string path = folder + "/a.csv";
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  template <class Body>
  std::string message(const Body& body) const {
    try {
      body();
    } catch (const common::Error& e) {
      std::string text = e.what();
      if (text.rfind(folder + "/", 0) == 0) text.erase(0, folder.size() + 1);
      return text;
    }
    return "no error";
  }
  /// The message of a file whose rows are `number, NUMBER, NUMBER` or, without the word, three of
  /// coordinates.
  std::string fault(const std::string& bytes, Separator separator = Separator::comma) const {
    return message([&] {
      Rows rows(file(bytes), separator);
      while (rows.next()) {
        const std::size_t first = separator == Separator::comma ? 1 : 0;
        if (first == 1 && rows.text(0, "a word") != "number") rows.unexpected(0, "number");
        for (std::size_t i = first; i < 3; ++i) rows.number(i, "a value");
        rows.ends_after(3);
      }
    });
  }
};

using RowsTest = FilesTest;

TEST_F(RowsTest, ReadsWhatEditorsAndSpreadsheetsWrite) {
  for (const char* text :
       {"number, 1.5, -2e-3\nnumber,+3,4", "\xef\xbb\xbfnumber, 1.5, -2e-3\r\n \t\r\nnumber,+3,4\r\n",
        "# a comment\rnumber,\t1.5 ,-2e-3 # another\r\rnumber,3,4\r",
        "number,1.5,-2e-3,,, \n,,,,\nnumber,3,4,,,\n\n"}) {
    Rows rows(file(text), Separator::comma);
    std::vector<double> found;
    while (rows.next()) {
      EXPECT_EQ(rows.size(), 3u) << text;
      for (std::size_t i : {1u, 2u}) found.push_back(rows.number(i, "a value"));
    }
    EXPECT_EQ(found, (std::vector<double>{1.5, -2e-3, 3, 4})) << text;
  }
  Rows blanks(file("\xef\xbb\xbf 1\t2  3 \r\n\r\n4 5 6"), Separator::blanks);
  ASSERT_TRUE(blanks.next());
  EXPECT_EQ(blanks.number(2, "z"), 3);
  ASSERT_TRUE(blanks.next());
  EXPECT_EQ(blanks.line(), 3u);
  EXPECT_EQ(blanks.count(0, "n", 1, 9), 4u);
  EXPECT_FALSE(blanks.next());
}

TEST_F(RowsTest, HugeLinesAreRead) {
  Rows rows(
      file("number, 1, 2" + std::string(3000000, ' ') + "# " + std::string(3000000, 'x') + "\n1, 2, 3\n"),
      Separator::comma);
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.number(2, "a value"), 2);
  ASSERT_TRUE(rows.next());
}

TEST_F(RowsTest, NamesPlaceAndWhatStandsThere) {
  const std::string expected = "expected a value, a number, found ";
  EXPECT_EQ(fault("number, 1, 2\n\nnumber, 1, x\n"), "a.csv:3:12: " + expected + "'x'");
  EXPECT_EQ(fault("\xef\xbb\xbfnumber, 1, x\r\n"), "a.csv:1:12: " + expected + "'x'");
  EXPECT_EQ(fault("number, 1, 2\rnumber, 1\r"), "a.csv:2:10: " + expected + "nothing");
  EXPECT_EQ(fault("number, , 1\n"), "a.csv:1:9: " + expected + "nothing");
  EXPECT_EQ(fault("number,,,\n"), "a.csv:1:7: " + expected + "nothing");
  EXPECT_EQ(fault("number, 1, 2, 3\n"), "a.csv:1:15: expected the end of the row, found '3'");
  for (const char* text :
       {"nan", "NaN", "inf", "-inf", "0x1p3", "1.5kPa", "1e", "--1", "+-1", "1_000", "e5", "."})
    EXPECT_EQ(fault(std::string("number, 1, ") + text), "a.csv:1:12: " + expected + "'" + text + "'");
  EXPECT_EQ(fault("number, 1, 1e400\n"), "a.csv:1:12: " + expected + "'1e400': beyond the range of double");
  // A no-break space, a long text, a character that moves the columns.
  EXPECT_EQ(fault("number, 1\xc2\xa0, 2\n"), "a.csv:1:9: " + expected + "'1\\xc2\\xa0'");
  EXPECT_EQ(fault("number, 1, " + std::string(5000, 'x')),
            "a.csv:1:12: " + expected + "'" + std::string(60, 'x') + "... (5000 bytes)'");
  EXPECT_EQ(fault("z\xc3\xb6, 1, 2\n"), "a.csv:1:1: expected number, found 'z\\xc3\\xb6'");
  EXPECT_EQ(fault("number, 1\x1b[2J, 2\n"), "a.csv:1:9: " + expected + "'1\\x1b[2J'");
}

TEST_F(RowsTest, NamesDecimalCommasAndOtherSeparators) {
  EXPECT_EQ(fault("number, 0,5, 2\n"), "a.csv:1:9: two numbers or one? write '0, 5' or '0.5'");
  EXPECT_EQ(fault("number,1,0,5\n"),
            "a.csv:1:12: expected the end of the row, found '5': decimal comma? write 0.5");
  EXPECT_EQ(fault("number;1,5;2\n"),
            "a.csv:1:1: expected number, found 'number;1': semicolons do not separate fields; "
            "decimals need a point, as 0.5");
  EXPECT_EQ(fault("number\t1\t2\n"),
            "a.csv:1:1: expected number, found 'number\\t1\\t2': tabs do not separate fields");
  EXPECT_EQ(fault("number 1 2\n"),
            "a.csv:1:1: expected number, found 'number 1 2': blanks do not separate fields");
  EXPECT_EQ(fault("number, \"1\", 2\n"),
            "a.csv:1:9: expected a value, a number, found '\"1\"': write it without quotes");
  EXPECT_EQ(fault("0,5 1 2\n", Separator::blanks),
            "a.csv:1:1: expected a value, a number, found '0,5': decimal comma? write 0.5");
  EXPECT_EQ(fault("number,1,2\n"), "no error");
  EXPECT_EQ(fault("number, 1,2\n"), "a.csv:1:9: two numbers or one? write '1, 2' or '1.2'");
  // A number that is not allowed is no decimal comma.
  EXPECT_EQ(message([&] {
              Rows rows(file("number,3,1\n"), Separator::comma);
              rows.next();
              rows.number(2, "an upper bound", 3.0);
            }),
            "a.csv:1:10: expected an upper bound, a number > 3, found '1'");
}

TEST_F(RowsTest, NamesWhatIsNoText) {
  const std::string utf16("\xff\xfe\x31\x00\x0a\x00", 6), big_endian("\xfe\xff\x00\x31", 4),
      binary("number, \0", 9);
  for (const std::string& bytes : {utf16, big_endian})
    EXPECT_EQ(fault(bytes), "a.csv: is a file in UTF-16 or UTF-32; save it as UTF-8");
  EXPECT_EQ(fault(binary),
            "a.csv:1:9: a NUL byte: this is a binary file, or UTF-16; expected a text in UTF-8");
  EXPECT_EQ(fault(std::string("1\0", 2)).substr(0, 16), "a.csv:1:2: a NUL");
  EXPECT_EQ(fault(""), "no error");
}

TEST_F(RowsTest, CountsAreWholeNumbersWithinLimits) {
  for (const char* text : {"-1", "0", "1.5", "101", "999999999999999999999999", "+5", "x", ""}) {
    EXPECT_EQ(message([&] {
                Rows rows(file(std::string("nodes ") + text), Separator::blanks);
                rows.next();
                rows.count(1, "their number", 1, 100);
              }),
              std::string("a.csv:1:") + (*text ? "7" : "6") +
                  ": expected their number, a whole number from 1 to 100, found " +
                  (*text ? std::string("'") + text + "'" : "nothing"));
  }
}

TEST_F(FilesTest, InputSaysWhyNot) {
  EXPECT_EQ(message([&] { common::Input(folder + "/none"); }),
            "none: cannot be read: No such file or directory");
  EXPECT_EQ(message([&] { Rows(folder + "/.", Separator::comma); }), ".: cannot be read: Is a directory");
  const std::string longer = folder + "/" + std::string(300, 'a');
  EXPECT_EQ(message([&] { common::Input give(longer); }),
            std::string(300, 'a') + ": cannot be read: File name too long");
}

TEST_F(FilesTest, OutputSaysWhyNot) {
  const std::string full = "/dev/full: cannot be written: No space left on device";
  EXPECT_EQ(message([] { common::write_file("/dev/full", "a few bytes"); }), full);
  // At once, and not only when it is closed.
  EXPECT_EQ(message([] {
              common::Output out("/dev/full");
              for (int i = 0; i < 100000; ++i) out << 1.5 << "," << i << '\n';
              std::abort();
            }),
            full);
  EXPECT_EQ(message([&] { common::Output(folder + "/none/a"); }),
            "none/a: cannot be written: No such file or directory");
  EXPECT_EQ(message([&] { common::Output(folder + "/."); }), ".: cannot be written: Is a directory");
  common::write_file(folder + "/a", "one\n");
  common::Output more(folder + "/a", "a");
  more << "two " << 2 << '\n';
  more.close();
  std::ifstream in(folder + "/a");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "one\ntwo 2\n");
}

TEST_F(FilesTest, OutputMeetsTheEndOfItsDisk) {
  rlimit before, small;
  getrlimit(RLIMIT_FSIZE, &before);
  small = before;
  small.rlim_cur = 8192;
  std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string found = message([&] { common::write_file(folder + "/a", std::string(9000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(found, "a: cannot be written: File too large");
}

// A file would take the place of a closed stream, and get what is printed.
TEST_F(FilesTest, ClosedStreams) {
  const auto in_child = [&](int closed) {
    const pid_t child = fork();
    if (child == 0) {
      close(closed);
      const std::string found = message([] { common::check_standard_streams(); });
      const int next = open(folder.c_str(), O_RDONLY);
      const bool right = closed == STDOUT_FILENO
                             ? found == "standard output: cannot be written: Bad file descriptor"
                             : found == "no error" && next > STDERR_FILENO;
      _exit(right ? 0 : 1);
    }
    int status = 1;
    waitpid(child, &status, 0);
    return status;
  };
  for (int closed : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) EXPECT_EQ(in_child(closed), 0) << closed;
}

TEST_F(FilesTest, FoldersAreMadeAndTried) {
  std::string deep = folder;
  for (int i = 0; i < 9; ++i) deep += "/" + std::string(200, 'd');
  common::make_folder(deep);  // longer than 1024 characters
  common::make_folder(deep);
  EXPECT_TRUE(std::filesystem::is_empty(deep));
  file("x");
  EXPECT_EQ(message([&] { common::make_folder(folder + "/a.csv"); }),
            "a.csv: cannot be made a folder: Not a directory");
  EXPECT_EQ(message([&] { common::make_folder(folder + "/a.csv/b"); }),
            "a.csv/b: cannot be made a folder: Not a directory");
  EXPECT_EQ(message([] { common::make_folder("/proc/self"); }).substr(0, 32),
            "/proc/self: cannot be written in");
}

}  // namespace
