/// @file
/// What the studies have in common: a study's file, a history of stretch cut into time steps, growth along
/// it, and what is written.
///
/// A study is a CSV file of rows that begin with a keyword; `#` begins a comment, blank lines are skipped.
///
///   title, TEXT
///   include, FILE                    the rows of another file, looked for beside this one
///   set, NAME, VALUE                 a parameter: c1 c2 tau gamma G_max lambda_crit, and for removal
///                                    tau_rev gamma_rev G_min lambda_rev [kPa, days]; else the paper's Table
///                                    1
///   fit, NAME, LOWER, UPPER          a parameter to be found between bounds: tau gamma G_max lambda_crit
///   rest_length, MM                  length at stretch 1, for `distract` and for schedules
///   step, STRETCH                    history: to this stretch at once
///   ramp, STRETCH, DAYS              to this stretch at a constant rate
///   hold, DAYS                       as it is
///   distract, MM_PER_DAY, DAYS       a constant rate of lengthening
///   measure, DAY, QUANTITY, VALUE, SD   lambda_e (relative sarcomere length) or G (relative number)
///
/// The history starts with stretch 1 on day 0 and ends with its last row; the last stretch stays.
#ifndef MYOGROWTH_EXAMPLES_STUDY_HPP
#define MYOGROWTH_EXAMPLES_STUDY_HPP

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <myogrowth/stress_states.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace study {

/// What the user has to put right; the message names place, value and what is allowed.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A point of a history [day, -]. Two of the same time are a step.
struct Knot {
  double time, stretch;
};

struct Measurement {
  double time;  ///< [day]
  bool of_G;    ///< of G, else of lambda_e
  double value, sd;
};

struct Bounds {
  std::string name;
  double lower, upper;
};

struct Study {
  std::string name, title;
  myogrowth::FibreGrowth<> muscle;
  std::vector<Bounds> fitted;
  double rest_length = 0;  ///< [mm]; 0: not known
  std::vector<Knot> knots{{0, 1}};
  std::vector<Measurement> measurements;
};

// ---- Parameters by name

struct Parameter {
  const char* name;
  double& (*of)(myogrowth::FibreGrowth<>&);
  double above, below;  ///< allowed: above < value < below
};

inline const std::vector<Parameter>& parameters() {
  using M = myogrowth::FibreGrowth<>;
  constexpr double inf = std::numeric_limits<double>::infinity(), tiny = 1e-300;
  static const std::vector<Parameter> all = {
      {"c1", [](M& m) -> double& { return m.c1; }, -inf, inf},
      {"c2", [](M& m) -> double& { return m.c2; }, 0, inf},
      {"tau", [](M& m) -> double& { return m.growth.growth_time; }, 0, inf},
      {"gamma", [](M& m) -> double& { return m.growth.gamma; }, -tiny, inf},
      {"G_max", [](M& m) -> double& { return m.growth.G_max; }, 1, inf},
      {"lambda_crit", [](M& m) -> double& { return m.growth.lambda_crit; }, 0, inf},
      {"tau_rev", [](M& m) -> double& { return m.removal.removal_time; }, -tiny, inf},
      {"gamma_rev", [](M& m) -> double& { return m.removal.gamma; }, -tiny, inf},
      {"G_min", [](M& m) -> double& { return m.removal.G_min; }, 0, 1},
      {"lambda_rev", [](M& m) -> double& { return m.removal.lambda_crit; }, 0, inf},
  };
  return all;
}

inline const Parameter* find_parameter(const std::string& name) {
  for (const Parameter& p : parameters()) {
    if (name == p.name) return &p;
  }
  return nullptr;
}

/// Those that can be fitted, in this order everywhere.
constexpr const char* growth_names[] = {"tau", "gamma", "G_max", "lambda_crit"};
constexpr int n_growth = 4;
inline int growth_index(const std::string& name) {
  for (int i = 0; i < n_growth; ++i) {
    if (name == growth_names[i]) return i;
  }
  return -1;
}

/// A whole text as a number; false if it is none.
inline bool to_number(const std::string& text, double& x) {
  char* end = nullptr;
  x = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(x);
}

inline std::string text_of(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", x);
  return text;
}

/// "> 0 and < 1": what a parameter may be.
inline std::string allowed(const Parameter& p) {
  std::string text = !std::isfinite(p.above) ? "finite" : p.above < 0 ? ">= 0" : "> " + text_of(p.above);
  if (std::isfinite(p.below)) text += " and < " + text_of(p.below);
  return text;
}

// ---- Reading

class Reader {
 public:
  static Study read(const std::string& path) {
    Study study;
    study.name = std::filesystem::path(path).stem().string();
    Reader(study).file(path, 0);
    if (study.title.empty()) study.title = study.name;
    check_removal(study.muscle, path);
    return study;
  }

  static void check_removal(const myogrowth::FibreGrowth<>& m, const std::string& where) {
    if (m.removal.removal_time > 0 && m.removal.lambda_crit > m.growth.lambda_crit)
      throw Error(where + ": lambda_rev = " + text_of(m.removal.lambda_crit) +
                  ": expected at most lambda_crit = " + text_of(m.growth.lambda_crit));
  }

 private:
  struct Field {
    std::string text;
    std::size_t column;  // of its first character, from 1
  };

  explicit Reader(Study& study) : study_(study) {}

  void file(const std::string& path, int depth) {
    std::ifstream in(path);
    if (!in || std::filesystem::is_directory(path)) throw Error(path + ": cannot be read");
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      path_ = path;
      line_ = number;
      split(line);
      if (!fields_.empty()) row(depth);
    }
  }

  void split(std::string line) {
    fields_.clear();
    line = line.substr(0, line.find('#'));
    const char* blank = " \t\r";
    if (line.find_first_not_of(blank) == std::string::npos) return;
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t comma = std::min(line.find(',', from), line.size());
      const std::size_t begin = std::min(line.find_first_not_of(blank, from), comma);
      const std::size_t end = begin < comma ? line.find_last_not_of(blank, comma - 1) + 1 : begin;
      fields_.push_back({line.substr(begin, end - begin), begin + 1});
      from = comma + 1;
    }
  }

  [[noreturn]] void fail(std::size_t column, const std::string& words) const {
    throw Error(path_ + ":" + std::to_string(line_) + ":" + std::to_string(column) + ": " + words);
  }
  /// Field i of the row, of which `what` is expected.
  const Field& field(std::size_t i, const std::string& what) const {
    if (i < fields_.size() && !fields_[i].text.empty()) return fields_[i];
    const Field& last = fields_.back();
    fail(i < fields_.size() ? fields_[i].column : last.column + last.text.size(),
         "expected " + what + ", found nothing");
  }
  [[noreturn]] void unexpected(const Field& f, const std::string& what) const {
    fail(f.column, "expected " + what + ", found '" + f.text + "'");
  }
  double number(std::size_t i, const std::string& what, double above) const {
    const std::string wanted =
        what + ", a number" + (std::isfinite(above) ? (above < 0 ? " >= 0" : " > " + text_of(above)) : "");
    const Field& f = field(i, wanted);
    double x;
    if (!to_number(f.text, x) || !(x > above)) unexpected(f, wanted);
    return x;
  }
  void ends_after(std::size_t n) const {
    if (fields_.size() > n)
      fail(fields_[n].column, "expected the end of the row, found '" + fields_[n].text + "'");
  }

  void add(double stretch, double days) {
    const Knot last = study_.knots.back();
    study_.knots.push_back({last.time + days, stretch});
  }

  void row(int depth) {
    constexpr double any = -std::numeric_limits<double>::infinity(), not_negative = -1e-300;
    const std::string key = fields_[0].text;
    if (key == "title") {
      study_.title = field(1, "a text").text;
      for (std::size_t i = 2; i < fields_.size(); ++i) study_.title += ", " + fields_[i].text;
    } else if (key == "include") {
      const Field name = field(1, "the name of a file");
      ends_after(2);
      const auto other = std::filesystem::path(path_).parent_path() / name.text;
      if (depth > 4 || !std::ifstream(other))
        unexpected(name, "the name of a file that can be read (and not in a circle)");
      const std::string here = path_;
      file(other.string(), depth + 1);
      path_ = here;
    } else if (key == "set") {
      const Field& name = field(1, "the name of a parameter");
      const Parameter* p = find_parameter(name.text);
      if (!p)
        unexpected(
            name,
            "a parameter: c1, c2, tau, gamma, G_max, lambda_crit, tau_rev, gamma_rev, G_min or lambda_rev");
      const double x = number(2, "a value", any);
      if (!(x > p->above && x < p->below)) unexpected(fields_[2], name.text + " " + allowed(*p));
      ends_after(3);
      p->of(study_.muscle) = x;
    } else if (key == "fit") {
      const Field& name = field(1, "the name of a parameter");
      if (growth_index(name.text) < 0) unexpected(name, "tau, gamma, G_max or lambda_crit");
      const Parameter& p = *find_parameter(name.text);
      const double lower = number(2, "a lower bound", p.above), upper = number(3, "an upper bound", lower);
      ends_after(4);
      auto same = [&](const Bounds& b) { return b.name == name.text; };
      study_.fitted.erase(std::remove_if(study_.fitted.begin(), study_.fitted.end(), same),
                          study_.fitted.end());
      study_.fitted.push_back({name.text, lower, upper});
    } else if (key == "rest_length") {
      study_.rest_length = number(1, "a length in mm", 0);
      ends_after(2);
    } else if (key == "step") {
      add(number(1, "a stretch", 0), 0);
      ends_after(2);
    } else if (key == "ramp") {
      add(number(1, "a stretch", 0), number(2, "a time in days", 0));
      ends_after(3);
    } else if (key == "hold") {
      add(study_.knots.back().stretch, number(1, "a time in days", 0));
      ends_after(2);
    } else if (key == "distract") {
      if (!(study_.rest_length > 0))
        fail(fields_[0].column, "expected a row 'rest_length, MM' before 'distract'");
      const double rate = number(1, "a rate in mm/day", any), days = number(2, "a time in days", 0);
      const double stretch = study_.knots.back().stretch + rate * days / study_.rest_length;
      if (!(stretch > 0)) unexpected(fields_[1], "a rate that leaves the length > 0");
      ends_after(3);
      add(stretch, days);
    } else if (key == "measure") {
      Measurement m;
      m.time = number(1, "a time in days", not_negative);
      const Field& quantity = field(2, "lambda_e or G");
      if (quantity.text != "lambda_e" && quantity.text != "G") unexpected(quantity, "lambda_e or G");
      m.of_G = quantity.text == "G";
      m.value = number(3, "a value", 0);
      m.sd = number(4, "a standard deviation", 0);
      ends_after(5);
      study_.measurements.push_back(m);
    } else {
      unexpected(fields_[0], "title, include, set, fit, rest_length, step, ramp, hold, distract or measure");
    }
  }

  Study& study_;
  std::string path_;
  int line_ = 0;
  std::vector<Field> fields_;
};

// ---- Histories

/// The history with time steps between its knots, ending at the last knot or stop. After every knot the steps
/// begin with `first` [day] and lengthen by `ratio` of the time since; none takes more than 0.002 of stretch.
inline std::vector<Knot> cut(std::vector<Knot> knots, std::vector<double> stops, double first, double ratio) {
  std::sort(stops.begin(), stops.end());
  if (!stops.empty() && stops.back() > knots.back().time)
    knots.push_back({stops.back(), knots.back().stretch});
  std::vector<Knot> all{knots[0]};
  for (std::size_t k = 1; k < knots.size(); ++k) {
    const Knot a = knots[k - 1], b = knots[k];
    const double length = b.time - a.time, change = std::abs(b.stretch - a.stretch);
    if (!(length > 0)) {
      all.push_back(b);
      continue;
    }
    const double most = change > 0 ? 0.002 * length / change : length;
    for (double t = a.time; t < b.time;) {
      double next = t + std::min(first + ratio * (t - a.time), most);
      const auto stop = std::upper_bound(stops.begin(), stops.end(), t);
      if (stop != stops.end() && *stop < next) next = *stop;
      if (next > b.time - 1e-9 * length) next = b.time;
      t = next;
      all.push_back(
          {t, t == b.time ? b.stretch : a.stretch + (b.stretch - a.stretch) * (t - a.time) / length});
    }
  }
  return all;
}

/// G at the points of a history that has been cut into steps. Backward Euler in whole and in half steps, and
/// from the two what vanishing steps would give: of second order, smooth in the parameters, and with
/// derivatives with respect to them if T carries any.
template <class T>
std::vector<T> grow(const myogrowth::GrowthRate<T>& growth, const myogrowth::RemovalRate<T>& removal,
                    const std::vector<Knot>& points) {
  std::vector<T> G;
  T whole(1.0), halves(1.0);
  G.push_back(whole);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dt = points[i].time - points[i - 1].time;
    const double middle = (points[i].stretch + points[i - 1].stretch) / 2;
    whole = solve_growth(growth, removal, whole, T(points[i].stretch), T(dt)).G;
    halves = solve_growth(growth, removal, halves, T(middle), T(dt / 2)).G;
    halves = solve_growth(growth, removal, halves, T(points[i].stretch), T(dt / 2)).G;
    G.push_back(2.0 * halves - whole);
  }
  return G;
}

/// A muscle at a point of time.
struct Point {
  double time, stretch, G, lambda_e;
  double force;    ///< along the fibre, per reference area: first Piola-Kirchhoff stress [stress]
  double lateral;  ///< stretch across the fibre
};

/// Pulls a strip of muscle with free sides through a history that has been cut into steps. The exact flow at
/// the stretch of the middle of every step: exact where the stretch is held.
inline std::vector<Point> pull(myogrowth::FibreGrowth<> muscle, const std::vector<Knot>& points) {
  muscle.integration = myogrowth::TimeIntegration::midpoint_flow;
  std::vector<Point> result;
  double G = 1, lateral = 1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Knot& last = points[i > 0 ? i - 1 : 0];
    myogrowth::PointUpdate<double> u;
    double slope;
    const auto status = uniaxial_stress(muscle, points[i].stretch, G, last.stretch,
                                        points[i].time - last.time, lateral, u, slope);
    if (status != myogrowth::Status::ok)
      throw Error("no result at stretch " + text_of(points[i].stretch) + " on day " +
                  text_of(points[i].time));
    G = u.G;
    result.push_back(
        {points[i].time, points[i].stretch, G, u.lambda_e, u.tau[0] / points[i].stretch, lateral});
  }
  return result;
}

// ---- Options: --name VALUE, and files

class Options {
 public:
  /// names: the options there are; all but --help take a value.
  Options(int argc, char** argv, const char* help, const std::vector<std::string>& names) {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--help" || word == "-h") {
        std::fputs(help, stdout);
        std::exit(0);
      }
      if (word.rfind("--", 0) != 0) {
        files.push_back(word);
        continue;
      }
      const std::string name = word.substr(2);
      if (std::find(names.begin(), names.end(), name) == names.end())
        throw Error("no option '" + word + "' (--help lists them)");
      if (i + 1 == argc) throw Error(word + ": expected a value after it");
      given_.push_back({name, argv[++i]});
    }
  }

  std::vector<std::string> files;

  bool has(const std::string& name) const { return !text(name, "").empty(); }
  std::string text(const std::string& name, const std::string& otherwise) const {
    std::string found = otherwise;
    for (const auto& option : given_) {
      if (option.first == name) found = option.second;
    }
    return found;
  }
  /// All values of an option that may come more than once.
  std::vector<std::string> all(const std::string& name) const {
    std::vector<std::string> values;
    for (const auto& option : given_) {
      if (option.first == name) values.push_back(option.second);
    }
    return values;
  }
  double number(const std::string& name, double otherwise, double above) const {
    if (!has(name)) return otherwise;
    double x;
    if (!to_number(text(name, ""), x) || !(x > above))
      throw Error("--" + name + " = " + text(name, "") + ": expected a number > " + text_of(above));
    return x;
  }
  long count(const std::string& name, long otherwise, long least) const {
    const double x = number(name, static_cast<double>(otherwise), static_cast<double>(least) - 0.5);
    if (x != std::floor(x)) throw Error("--" + name + " = " + text(name, "") + ": expected a whole number");
    return static_cast<long>(x);
  }
  /// --set NAME=VALUE, all of them, on a muscle.
  void set(myogrowth::FibreGrowth<>& muscle) const {
    for (const std::string& option : all("set")) {
      const std::size_t equals = option.find('=');
      const Parameter* p = find_parameter(option.substr(0, equals));
      double x;
      if (!p || equals == std::string::npos || !to_number(option.substr(equals + 1), x))
        throw Error("--set " + option + ": expected NAME=VALUE, the name of a parameter (--help lists them)");
      if (!(x > p->above && x < p->below))
        throw Error("--set " + option + ": expected " + p->name + " " + allowed(*p));
      p->of(muscle) = x;
    }
    Reader::check_removal(muscle, "--set");
  }

 private:
  std::vector<std::pair<std::string, std::string>> given_;
};

// ---- Results

/// JSON, as texts.
inline std::string json(double x) { return std::isfinite(x) ? text_of(x) : "null"; }
inline std::string json(const std::string& text) {
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= ' ') quoted += c;
  }
  return quoted + "\"";
}
inline std::string json_array(const std::vector<std::string>& items) {
  std::string text = "[";
  for (std::size_t i = 0; i < items.size(); ++i) text += (i ? ", " : "") + items[i];
  return text + "]";
}
template <class Range, class Get>
std::string json_array(const Range& range, const Get& get) {
  std::vector<std::string> items;
  for (const auto& x : range) items.push_back(json(get(x)));
  return json_array(items);
}
inline std::string json(const std::vector<double>& numbers) {
  return json_array(numbers, [](double x) { return x; });
}
inline std::string json_object(const std::vector<std::pair<std::string, std::string>>& members) {
  std::string text = "{";
  for (std::size_t i = 0; i < members.size(); ++i)
    text += (i ? ",\n " : "") + json(members[i].first) + ": " + members[i].second;
  return text + "}";
}

inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path);
  out << text;
  if (!out.flush()) throw Error(path.string() + ": cannot be written");
}

/// printf into a text.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[2000];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

/// Runs a program's body; an Error becomes one line and status 2.
template <class Body>
int run(const Body& body) {
  try {
    return body();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
    return 2;
  }
}

}  // namespace study

#endif
