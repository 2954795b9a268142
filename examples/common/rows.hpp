/// @file
/// Rows of fields in a text file: one reader for the studies' CSV files and for meshes and fibres between
/// blanks.
///
/// Lines end with LF, CRLF or CR; `#` begins a comment; lines without a field are skipped; a byte order mark
/// of UTF-8 and the empty fields that spreadsheets leave at the end of a row mean nothing. What is wrong is
/// an Error that begins with FILE:LINE:COLUMN and shows what stands there.
#ifndef MYOGROWTH_EXAMPLES_ROWS_HPP
#define MYOGROWTH_EXAMPLES_ROWS_HPP

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files.hpp"

namespace common {

/// A text as it can be seen in a message: everything but printable ASCII as \t, \xc3 ..., long texts cut.
inline std::string visible(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string seen;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i == longest) return seen + "... (" + std::to_string(text.size()) + " bytes)";
    const char c = text[i];
    if (c == '\t') {
      seen += "\\t";
    } else if (c >= ' ' && c <= '~') {
      seen += c;
    } else {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
      seen += escaped;
    }
  }
  return seen;
}

/// Whether a text is UTF-8 and has no control characters but tabs.
inline bool is_text(std::string_view text) {
  int following = 0;  // bytes of the character that are yet to come
  for (char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (following > 0) {
      if ((byte & 0xc0) != 0x80) return false;
      --following;
    } else if (byte >= 0x80) {
      if (byte < 0xc2 || byte > 0xf4) return false;
      following = byte < 0xe0 ? 1 : byte < 0xf0 ? 2 : 3;
    } else if ((byte < ' ' && byte != '\t') || byte == 0x7f) {
      return false;
    }
  }
  return following == 0;
}

/// A number in a message.
inline std::string text_of(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", x);
  return text;
}

/// A whole text as a finite decimal number; false if it is none.
inline bool to_number(std::string_view text, double& x) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(x);
}

/// What may be meant by a text that is no number, to be put after it; empty where nothing comes to mind.
inline std::string hint(std::string_view text) {
  const std::size_t comma = text.find(',');
  double x;
  if (comma != text.npos && text.find(',', comma + 1) == text.npos) {
    std::string point(text);
    point[comma] = '.';
    if (to_number(point, x)) return ": decimal comma? write " + point;
  }
  if (text.find(';') != text.npos)
    return ": semicolons do not separate fields; decimals need a point, as 0.5";
  if (text.find('\t') != text.npos) return ": tabs do not separate fields";
  if (text.find(' ') != text.npos) return ": blanks do not separate fields";
  if (text.find('"') != text.npos) return ": write it without quotes";
  if (std::from_chars(text.data(), text.data() + text.size(), x).ec == std::errc::result_out_of_range)
    return ": beyond the range of double";
  return "";
}

/// What is between the fields of a row.
enum class Separator { comma, blanks };

/// The rows of a file, one at a time.
class Rows {
 public:
  Rows(std::string path, Separator separator) : in_(std::move(path)), separator_(separator) {
    const int first = in_.get(), second = in_.get();
    if ((first == 0xfe && second == 0xff) || (first == 0xff && second == 0xfe))
      throw Error(in_.path() + ": is a file in UTF-16 or UTF-32; save it as UTF-8");
    if (first == 0xef && second == 0xbb) {
      if (in_.get() != 0xbf) throw Error(in_.path() + ":1:1: is no text in UTF-8; save it as such");
      return;
    }
    for (int c : {first, second}) {
      if (c >= 0) start_ += static_cast<char>(c);
    }
  }

  /// Goes to the next row that has fields; false if there is none.
  bool next() {
    while (read_line()) {
      split();
      if (!fields_.empty()) return true;
    }
    return false;
  }

  std::size_t size() const { return fields_.size(); }
  const std::string& path() const { return in_.path(); }
  std::size_t line() const { return number_; }

  /// FILE:LINE:COLUMN of field i, or of the row's end.
  std::string place(std::size_t i) const {
    const std::size_t at = i < fields_.size() ? offset(fields_[i]) : end_of_row();
    const auto starts_character = [](char c) { return (c & 0xc0) != 0x80; };
    const auto column =
        1 + std::count_if(line_.begin(), line_.begin() + static_cast<std::ptrdiff_t>(at), starts_character);
    return in_.path() + ":" + std::to_string(number_) + ":" + std::to_string(column);
  }
  [[noreturn]] void fail(std::size_t i, const std::string& words) const {
    throw Error(place(i) + ": " + words);
  }
  /// Says what should be in field i, and what is there.
  [[noreturn]] void unexpected(std::size_t i, const std::string& what) const {
    if (i >= size() || fields_[i].empty()) fail(i, "expected " + what + ", found nothing");
    const std::string comma = decimal_comma(i > 0 ? i - 1 : 0);
    fail(i, "expected " + what + ", found '" + visible(fields_[i]) + "'" +
                (comma.empty() ? hint(fields_[i]) : comma));
  }
  /// Says that field i, a number, is not one of those that are allowed.
  [[noreturn]] void out_of_range(std::size_t i, const std::string& what) const {
    fail(i, "expected " + what + ", found '" + visible(fields_[i]) + "'");
  }

  /// Field i; it has to be there.
  std::string text(std::size_t i, const std::string& what) const { return std::string(text_view(i, what)); }
  /// All from field i to the end of the row, a text for people.
  std::string text_from(std::size_t i, const std::string& what) const {
    const std::size_t begin = offset(text_view(i, what));
    const std::string whole = line_.substr(begin, end_of_row() - begin);
    if (!is_text(whole))
      fail(i, "expected " + what + " in UTF-8 without control characters, found '" + visible(whole) + "'");
    return whole;
  }
  /// Field i, a number > above.
  double number(std::size_t i, const std::string& what,
                double above = -std::numeric_limits<double>::infinity()) const {
    return number_if(i, what + ", a number" + (std::isfinite(above) ? " > " + text_of(above) : ""),
                     [&](double x) { return x > above; });
  }
  /// Field i, a number from `least` to `most`.
  double number(std::size_t i, const std::string& what, double least, double most) const {
    return number_if(i, what + ", a number from " + text_of(least) + " to " + text_of(most),
                     [&](double x) { return x >= least && x <= most; });
  }
  /// Field i, a whole number from `least` to `most`.
  std::size_t count(std::size_t i, const std::string& what, std::size_t least, std::size_t most) const {
    std::size_t n = 0;
    const std::string_view digits = i < size() ? fields_[i] : std::string_view();
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), n);
    if (digits.empty() || error != std::errc() || end != digits.data() + digits.size() || n < least ||
        n > most)
      unexpected(i, what + ", a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return n;
  }
  /// The row has n fields and no more.
  void ends_after(std::size_t n) const {
    if (size() > n) unexpected(n, "the end of the row");
  }

 private:
  std::string_view text_view(std::size_t i, const std::string& what) const {
    if (i >= size() || fields_[i].empty()) unexpected(i, what);
    return fields_[i];
  }

  template <class Allowed>
  double number_if(std::size_t i, const std::string& what, const Allowed& allowed) const {
    double x;
    if (i >= size() || !to_number(fields_[i], x)) unexpected(i, what);
    if (!allowed(x)) out_of_range(i, what);
    // `ramp, 1,1` would be read silently as two numbers.
    if (blank_after_comma_ && !decimal_comma(i).empty()) {
      const std::string whole(fields_[i]), part(fields_[i + 1]);
      fail(i, "two numbers or one? write '" + whole + ", " + part + "' or '" + whole + "." + part + "'");
    }
    return x;
  }

  int get() {
    if (start_.empty()) return in_.get();
    const unsigned char c = static_cast<unsigned char>(start_.front());
    start_.erase(0, 1);
    return c;
  }

  bool read_line() {
    constexpr std::size_t longest = std::size_t(1) << 26;
    ++number_;
    line_.clear();
    int c = get();
    if (c < 0) return false;
    for (; c >= 0 && c != '\n'; c = get()) {
      if (c == '\r') {
        const int after = get();
        if (after != '\n' && after >= 0) put_back(after);
        break;
      }
      line_ += static_cast<char>(c);
      if (c == 0)
        throw Error(in_.path() + ":" + std::to_string(number_) + ":" + std::to_string(line_.size()) +
                    ": a NUL byte: this is a binary file, or UTF-16; expected a text in UTF-8");
      if (line_.size() > longest)
        throw Error(in_.path() + ":" + std::to_string(number_) + ":1: a line of more than " +
                    std::to_string(longest) + " bytes");
    }
    return true;
  }
  void put_back(int c) {
    if (start_.empty()) {
      in_.put_back(c);
    } else {
      start_.insert(start_.begin(), static_cast<char>(c));
    }
  }

  void split() {
    fields_.clear();
    blank_after_comma_ = false;
    const std::string_view line = std::string_view(line_).substr(0, line_.find('#')), blank = " \t\v\f";
    const std::string_view ends = separator_ == Separator::comma ? "," : blank;
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t begin = std::min(line.find_first_not_of(blank, from), line.size());
      const std::size_t end = std::min(line.find_first_of(ends, begin), line.size());
      std::string_view field = line.substr(begin, end - begin);
      field = field.substr(0, field.find_last_not_of(blank) + 1);
      if (separator_ == Separator::comma || !field.empty()) fields_.push_back(field);
      if (from > 0 && begin > from && begin < end) blank_after_comma_ = true;
      from = end + 1;
    }
    while (!fields_.empty() && fields_.back().empty()) fields_.pop_back();
  }

  std::size_t offset(std::string_view field) const {
    return static_cast<std::size_t>(field.data() - line_.data());
  }
  std::size_t end_of_row() const {
    return fields_.empty() ? 0 : offset(fields_.back()) + fields_.back().size();
  }

  /// What to say of fields i and i + 1 if they look like one number with a decimal comma.
  std::string decimal_comma(std::size_t i) const {
    if (separator_ != Separator::comma || i + 1 >= size()) return "";
    const std::string_view whole = fields_[i], part = fields_[i + 1];
    const auto digits = [](std::string_view text) {
      return !text.empty() && text.find_first_not_of("0123456789") == text.npos;
    };
    if (!digits(whole.substr(std::min(whole.find_first_not_of("+-"), whole.size()))) || !digits(part) ||
        offset(part) != offset(whole) + whole.size() + 1)
      return "";
    return ": decimal comma? write " + std::string(whole) + "." + std::string(part);
  }

  Input in_;
  Separator separator_;
  std::string start_;  // bytes that were looked at and belong to the first line
  std::string line_;
  std::size_t number_ = 0;
  std::vector<std::string_view> fields_;  // of line_
  bool blank_after_comma_ = false;
};

}  // namespace common

#endif
