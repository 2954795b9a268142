/// @file
/// Files that the programs of examples/ write and read: what fails is an Error that names the file and the
/// system's reason, at once.
#ifndef MYOGROWTH_EXAMPLES_FILES_HPP
#define MYOGROWTH_EXAMPLES_FILES_HPP

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <utility>

namespace common {

/// What the user has to put right; the message names place, value and what is allowed.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "out/history.csv: cannot be written: No space left on device"
[[noreturn]] inline void cannot_be(const std::string& path, const char* what, int reason = errno) {
  throw Error(path + ": cannot be " + what + ": " + std::strerror(reason));
}

/// A file to write to. Opening, every write and flush, and close() throw an Error if they fail. Who has
/// written all calls close(); without it the file counts as unfinished, as after an exception.
class Output : public std::ostream {
 public:
  /// mode as of fopen: "w" cuts the file, "a" appends to it.
  explicit Output(const std::string& path, const char* mode = "w")
      : Output(std::fopen(path.c_str(), mode), path) {}
  /// Standard output, which close() flushes.
  static Output standard() {
    return Output(fcntl(STDOUT_FILENO, F_GETFD) < 0 ? nullptr : stdout, "standard output");
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() override {
    if (buffer_.file && buffer_.file != stdout) std::fclose(buffer_.file);
  }

  void close() {
    flush();
    std::FILE* file = std::exchange(buffer_.file, nullptr);
    if (file != stdout && std::fclose(file) != 0) cannot_be(buffer_.path, "written");
  }

 private:
  struct Buffer : std::streambuf {
    std::FILE* file = nullptr;
    std::string path;

    std::streamsize xsputn(const char* text, std::streamsize n) override {
      if (!file) throw Error(path + ": cannot be written: it has been closed");
      const auto size = static_cast<std::size_t>(n);
      if (std::fwrite(text, 1, size, file) != size) cannot_be(path, "written");
      return n;
    }
    int_type overflow(int_type c) override {
      const char character = traits_type::to_char_type(c);
      xsputn(&character, 1);
      return c;
    }
    int sync() override {
      if (!file) throw Error(path + ": cannot be written: it has been closed");
      if (std::fflush(file) != 0) cannot_be(path, "written");
      return 0;
    }
  };

  Output(std::FILE* file, const std::string& path) : std::ostream(nullptr) {
    if (!file) cannot_be(path, "written");
    buffer_.file = file;
    buffer_.path = path;
    rdbuf(&buffer_);
    exceptions(badbit | failbit);  // what the buffer throws comes through
  }

  Buffer buffer_;
};

/// To be called first of all: a file would take the place of a standard stream that is closed, and get what
/// is printed. Throws Error if standard output is closed; what is written to a closed standard error is
/// dropped.
inline void check_standard_streams() {
  Output::standard();
  int place;
  while ((place = open("/dev/null", O_RDWR)) >= 0 && place <= STDERR_FILENO) {
  }
  if (place > STDERR_FILENO) ::close(place);
}

/// Writes a whole file.
inline void write_file(const std::string& path, const std::string& text) {
  Output out(path);
  out << text;
  out.close();
}

/// Writes to standard output, and has it written.
inline void print(const std::string& text) {
  Output out = Output::standard();
  out << text;
  out.close();
}

/// Makes a folder with those above it, and makes sure that files can be written there.
inline void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw Error(path + ": cannot be made a folder: " + error.message());
  std::string probe = path + "/.write_test_XXXXXX";
  const int file = mkstemp(probe.data());
  if (file < 0) cannot_be(path, "written in");
  int reason = ::write(file, "x", 1) == 1 ? 0 : errno;
  if (::close(file) != 0 && reason == 0) reason = errno;
  unlink(probe.c_str());
  if (reason != 0) cannot_be(path, "written in", reason);
}

/// A file to read from; not a folder.
class Input {
 public:
  explicit Input(std::string path) : path_(std::move(path)), file_(std::fopen(path_.c_str(), "rb")) {
    if (!file_) cannot_be(path_, "read");
    std::error_code ignored;
    if (std::filesystem::is_directory(path_, ignored)) {
      std::fclose(file_);
      cannot_be(path_, "read", EISDIR);
    }
  }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  ~Input() { std::fclose(file_); }

  const std::string& path() const { return path_; }
  /// The next byte, or -1 at the end.
  int get() {
    const int c = getc_unlocked(file_);
    if (c == EOF && std::ferror(file_)) cannot_be(path_, "read");
    return c;
  }
  /// As if `c`, the byte read last, had not been read.
  void put_back(int c) { std::ungetc(c, file_); }

 private:
  std::string path_;
  std::FILE* file_;
};

}  // namespace common

#endif
