/// @file
/// What the studies have in common: a study's file, a history of stretch cut into time steps, growth along
/// it, options, and what is written.
///
/// A study is a CSV file of rows that begin with a keyword; `#` begins a comment, blank lines are skipped.
///
///   title, TEXT
///   include, FILE                    the rows of another file, looked for beside this one
///   set, NAME, VALUE                 a parameter: c1 c2 tau gamma G_max lambda_crit, and for removal
///                                    tau_rev gamma_rev G_min lambda_crit_rev [kPa, days], all four; else the
///                                    paper's Table 1
///   fit, NAME, LOWER, UPPER          a parameter to be found between bounds: those of growth and removal,
///   and
///                                    `amplitude`, by which every stretch - 1 of the history is multiplied
///   rest_length, MM                  length at stretch 1, for `distract` and for schedules
///   step, STRETCH                    history: to this stretch at once
///   ramp, STRETCH, DAYS              to this stretch at a constant rate
///   hold, DAYS                       as it is
///   distract, MM_PER_DAY, DAYS       a constant rate of lengthening
///   cycle, STRETCH, HOURS, EVERY, DAYS   for so many days, at the beginning of every EVERY days, so many
///   HOURS
///                                    at this stretch; else as it is
///   tendon, LENGTH, STIFFNESS, CREEP a tendon in series: its length at rest [that of the fibres], its
///   stiffness
///                                    [kPa] and its viscosity [kPa days; 0: no creep], both over logarithmic
///                                    stretch, per reference area of the fibres. The stretch of the history
///                                    is then 1 + (lengthening of both)/ (length of the fibres at rest)
///   measure, DAY, QUANTITY, VALUE, SD   lambda_e (relative sarcomere length), G (relative number), or tendon
///                                    (relative length of the tendon)
///
/// The history starts with stretch 1 on day 0 and ends with its last row; the last stretch stays. The same
/// row twice is an error, but a row may replace one of a file that was included before it.
#ifndef MYOGROWTH_EXAMPLES_STUDY_HPP
#define MYOGROWTH_EXAMPLES_STUDY_HPP

#include <sys/file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <myogrowth/more/stress_states.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "../../abi/faults.hpp"
#include "files.hpp"
#include "muscle_tendon.hpp"
#include "rows.hpp"

namespace study {

namespace abi = myogrowth::abi;

using common::Error;
using common::text_of;
using common::visible;

// ---- Limits: what is beyond them is refused at once, with the limit.

constexpr double least_days = 1e-6, most_days = 1e6;  // of a row, and of a history
constexpr double least_stretch = 0.01, most_stretch = 100;
constexpr double least_length = 1e-3, most_length = 1e6;      // [mm]
constexpr double least_measured = 1e-6, most_measured = 1e3;  // value and standard deviation
constexpr double most_amplitude = 100;
constexpr double most_stiffness = 1e9;  // [kPa, kPa days]
constexpr std::size_t most_rows = 100000, most_includes = 100, most_steps = 1000000;

// ---- What a study is

/// A point of a history [day, -]. Two of the same time are a step.
struct Knot {
  double time, stretch;
};

enum class Quantity { lambda_e, G, tendon };
inline const char* text(Quantity q) {
  return q == Quantity::G ? "G" : q == Quantity::tendon ? "tendon" : "lambda_e";
}

struct Measurement {
  double time;  ///< [day]
  Quantity of;
  double value, sd;
};

/// What can be fitted: entries of abi/properties.hpp, and last the amplitude of the history.
constexpr std::size_t n_fit = 9, amplitude = n_fit - 1;
inline int entry_of(std::size_t index) {
  constexpr int first_growth = 2, n_growth = 4;
  const int i = static_cast<int>(index);
  return i < n_growth ? first_growth + i : abi::tau_rev_entry + i - n_growth;
}

/// A parameter to be fitted, and between what.
struct Bounds {
  std::size_t index;  ///< < n_fit
  double lower, upper;
  std::string place;  ///< where they are given

  const char* name() const {
    return index == amplitude ? "amplitude" : abi::property(entry_of(index)).symbol;
  }
  /// Wide bounds are divided by factors.
  bool wide() const { return lower > 0 && upper > 10 * lower; }
  /// From 0 at the lower bound to 1 at the upper one, and back.
  double part(double x) const {
    return wide() ? std::log(x / lower) / std::log(upper / lower) : (x - lower) / (upper - lower);
  }
  double at(double part) const {
    return wide() ? lower * std::pow(upper / lower, part) : lower + (upper - lower) * part;
  }
};

struct Study {
  std::string name, title;
  myogrowth::FibreGrowth<> muscle;
  std::map<std::string, std::string> given;  ///< the parameters that are set, by name, and where
  std::vector<Bounds> fitted;
  double rest_length = 0;  ///< [mm]; 0: not known
  std::vector<Knot> knots{{0, 1}};
  std::vector<Measurement> measurements;
  Tendon tendon;
  std::string tendon_place;  ///< where it is given

  /// What can be fitted, where its fit starts: at what is set, the amplitude at 1.
  std::array<double, n_fit> start() const {
    const auto& g = muscle.growth;
    const auto& r = muscle.removal;
    return {g.tau, g.gamma, g.G_max, g.lambda_crit, r.tau_rev, r.gamma_rev, r.G_min, r.lambda_crit_rev, 1};
  }
};

// ---- Parameters: the UMAT's table and checks (abi/properties.hpp)

/// Entry of the parameter of that name; -1 if there is none.
inline int find_parameter(const std::string& name) {
  myogrowth::FibreGrowth<> muscle;
  const int entry = abi::find_property(name.c_str());
  return abi::parameter(muscle, entry) ? entry : -1;
}

/// "c1, c2, tau, ..."
inline std::string parameter_names() {
  std::string names;
  for (int i = 0; i < abi::n_props; ++i) {
    if (find_parameter(abi::property(i).symbol) == i)
      names += (names.empty() ? "" : ", ") + std::string(abi::property(i).symbol);
  }
  return names;
}

/// Checks a parameter among the others of a muscle; throws what is wrong, after the place that it comes from.
inline void check(myogrowth::FibreGrowth<> muscle, const std::string& name, const std::string& place) {
  const int entry = find_parameter(name);
  abi::Text text;
  if (abi::find_value_fault(muscle, entry, *abi::parameter(muscle, entry), text))
    throw Error(place + ": " + text);
}

/// Checks the parameters together, once all are known, and at the bounds of those to be fitted.
inline void check_parameters(const Study& s) {
  for (const auto& [name, place] : s.given) check(s.muscle, name, place);
  const double tau_rev = s.muscle.removal.tau_rev;
  for (const char* name : {"gamma_rev", "G_min", "lambda_crit_rev"}) {
    if (tau_rev > 0 && !s.given.count(name))
      throw Error(s.given.at("tau_rev") + ": tau_rev = " + text_of(tau_rev) + ": expected " + name +
                  " to be set too, as all of removal's parameters");
    if (s.given.count(name) && !s.given.count("tau_rev"))
      throw Error(s.given.at(name) + ": expected tau_rev to be set too: without it nothing is removed, and " +
                  name + " is not used");
  }
  const Bounds *crit = nullptr, *crit_rev = nullptr;
  for (const Bounds& b : s.fitted) {
    if (b.name() == std::string("lambda_crit")) crit = &b;
    if (b.name() == std::string("lambda_crit_rev")) crit_rev = &b;
    if (b.index == amplitude) {
      if (!(b.lower >= 0) || b.upper > most_amplitude)
        throw Error(b.place + ": expected bounds of the amplitude from 0 to " + text_of(most_amplitude));
      for (const Knot& k : s.knots) {
        if (!(1 + b.upper * (k.stretch - 1) >= least_stretch))
          throw Error(b.place + ": with amplitude = " + text_of(b.upper) + " the stretch " +
                      text_of(k.stretch) + " becomes " + text_of(1 + b.upper * (k.stretch - 1)) +
                      ": expected at least " + text_of(least_stretch));
      }
      if (!(b.lower <= 1 && 1 <= b.upper))
        throw Error(b.place + ": expected bounds of the amplitude that include 1, where its fit starts");
      continue;
    }
    if (entry_of(b.index) >= abi::tau_rev_entry && !(tau_rev > 0))
      throw Error(b.place + ": expected tau_rev > 0 to be set, else nothing is removed and there is no " +
                  b.name() + " to be found");
    if (entry_of(b.index) == abi::tau_rev_entry && !(b.lower > 0))
      throw Error(b.place + ": expected a lower bound of tau_rev > 0: at 0 nothing is removed");
    for (double x : {b.lower, b.upper}) {
      myogrowth::FibreGrowth<> muscle = s.muscle;
      *abi::parameter(muscle, find_parameter(b.name())) = x;
      check(muscle, b.name(), b.place);
      if (tau_rev > 0) check(muscle, "lambda_crit_rev", b.place + ": with " + b.name() + " = " + text_of(x));
    }
    const double start = s.start()[b.index];
    if (s.given.count(b.name()) && !(b.lower <= start && start <= b.upper))
      throw Error(s.given.at(b.name()) + ": " + b.name() + " = " + text_of(start) +
                  ": expected a start within the bounds of its fit, " + text_of(b.lower) + " to " +
                  text_of(b.upper));
  }
  if (crit && crit_rev && crit_rev->upper > crit->lower)
    throw Error(crit_rev->place + ": expected an upper bound <= the lower bound of lambda_crit, " +
                text_of(crit->lower));
}

// ---- Reading

class Reader {
 public:
  /// Reads a file; its parameters are yet to be checked.
  static Study read(const std::string& path) {
    Study study;
    study.name = std::filesystem::path(path).stem().string();
    Reader reader(study);
    common::Rows rows(path, common::Separator::comma);
    reader.file(rows);
    if (reader.n_rows_ == 0) throw Error(path + ": has no rows");
    if (study.title.empty()) study.title = visible(study.name);
    return study;
  }

 private:
  using Rows = common::Rows;

  explicit Reader(Study& study) : study_(study) {}

  void file(Rows& rows) {
    chain_.push_back(rows.path());
    while (rows.next()) {
      if (++n_rows_ > most_rows)
        rows.fail(0, "more than " + std::to_string(most_rows) + " rows, with those of included files");
      row(rows);
    }
    chain_.pop_back();
  }

  void include(const Rows& rows) {
    const auto path = std::filesystem::path(rows.path()).parent_path() / rows.text(1, "the name of a file");
    rows.ends_after(2);
    std::string chain;
    bool circle = false;
    for (const std::string& above : chain_) {
      std::error_code none;
      circle = circle || std::filesystem::equivalent(above, path, none);
      chain += above + " -> ";
    }
    const auto refuse = [&](const std::string& why) {
      rows.fail(1, "expected the name of a file that can be read, found '" + visible(rows.text(1, "")) +
                       "': " + why);
    };
    if (circle) refuse("a circle, " + chain + path.string());
    if (chain_.size() > most_includes)
      refuse("more than " + std::to_string(most_includes) + " files, each included by the one before");
    std::optional<Rows> other;
    try {
      other.emplace(path.string(), common::Separator::comma);
    } catch (const Error& e) {
      refuse(e.what());
    }
    file(*other);
  }

  /// Fails if the same has already been given. A row may replace one of a file that its own file has
  /// included.
  void once(const Rows& rows, const std::string& what, bool may_replace = true) {
    const auto [before, first] = given_before_.insert({what, {rows.place(0), chain_.size()}});
    if (first) return;
    if (!may_replace || before->second.second <= chain_.size())
      rows.fail(0, what + " was already given, in " + before->second.first);
    before->second = {rows.place(0), chain_.size()};
  }

  void add(const Rows& rows, std::size_t stretch_field, double stretch, double days) {
    const Knot last = study_.knots.back();
    if (!(stretch >= least_stretch && stretch <= most_stretch))
      rows.fail(stretch_field, "leads to stretch " + text_of(stretch) + ": expected " +
                                   text_of(least_stretch) + " to " + text_of(most_stretch));
    if (last.time + days > most_days)
      rows.fail(rows.size() - 1,
                "leads to day " + text_of(last.time + days) + ": expected at most " + text_of(most_days));
    study_.knots.push_back({last.time + days, stretch});
  }

  void row(const Rows& rows) {
    const auto within = [&](std::size_t i, const std::string& what, double least, double most) {
      const double x = rows.number(i, what, 0);
      if (!(least <= x && x <= most))
        rows.out_of_range(i, what + " from " + text_of(least) + " to " + text_of(most));
      return x;
    };
    const auto days = [&](std::size_t i) { return within(i, "a time in days", least_days, most_days); };
    const auto stretch = [&] { return within(1, "a stretch", least_stretch, most_stretch); };
    const std::string key = rows.text(0, "a keyword");
    if (key == "title") {
      once(rows, "the title");
      study_.title = rows.text_from(1, "a text");
    } else if (key == "include") {
      include(rows);
    } else if (key == "set") {
      const std::string name = rows.text(1, "the name of a parameter");
      const int entry = find_parameter(name);
      if (entry < 0) rows.unexpected(1, "a parameter: " + parameter_names());
      *abi::parameter(study_.muscle, entry) = rows.number(2, "a value");
      rows.ends_after(3);
      once(rows, "set, " + name);
      study_.given[name] = rows.place(2);
    } else if (key == "fit") {
      const std::string name = rows.text(1, "the name of a parameter");
      std::size_t index = 0;
      std::string names;
      for (std::size_t i = 0; i < n_fit; ++i)
        names += (i == 0 ? "" : i == amplitude ? " or " : ", ") + std::string(Bounds{i, 0, 1, ""}.name());
      while (index < n_fit && name != Bounds{index, 0, 1, ""}.name()) ++index;
      if (index == n_fit) rows.unexpected(1, names);
      const double lower = rows.number(2, "a lower bound"), upper = rows.number(3, "an upper bound", lower);
      rows.ends_after(4);
      const Bounds bounds{index, lower, upper, rows.place(0)};
      once(rows, std::string("fit, ") + bounds.name());
      auto same = [&](const Bounds& b) { return b.index == bounds.index; };
      study_.fitted.erase(std::remove_if(study_.fitted.begin(), study_.fitted.end(), same),
                          study_.fitted.end());
      study_.fitted.push_back(bounds);
    } else if (key == "rest_length") {
      study_.rest_length = within(1, "a length in mm", least_length, most_length);
      rows.ends_after(2);
      once(rows, "rest_length");
    } else if (key == "step") {
      add(rows, 1, stretch(), 0);
      rows.ends_after(2);
    } else if (key == "ramp") {
      add(rows, 1, stretch(), days(2));
      rows.ends_after(3);
    } else if (key == "hold") {
      add(rows, 1, study_.knots.back().stretch, days(1));
      rows.ends_after(2);
    } else if (key == "distract") {
      if (!(study_.rest_length > 0)) rows.fail(0, "expected a row 'rest_length, MM' before 'distract'");
      const double rate = rows.number(1, "a rate in mm/day"), time = days(2);
      rows.ends_after(3);
      add(rows, 1, study_.knots.back().stretch + rate * time / study_.rest_length, time);
    } else if (key == "cycle") {
      const double there = stretch(), hours = rows.number(2, "a time in hours", 0);
      const double every = days(3), total = within(4, "a time in days", every, most_days);
      if (!(hours < 24 * every))
        rows.fail(2, "expected less than EVERY, " + text_of(24 * every) + " hours, found " + text_of(hours));
      rows.ends_after(5);
      const double cycles = std::round(total / every), rest = study_.knots.back().stretch;
      if (std::abs(cycles * every - total) > 1e-9 * total)
        rows.fail(4, "expected a multiple of EVERY, " + text_of(every) + " days, found " + text_of(total));
      if (cycles > static_cast<double>(most_steps) / 4)
        rows.fail(4,
                  "expected at most " + std::to_string(most_steps / 4) + " cycles, found " + text_of(cycles));
      for (double i = 0; i < cycles; ++i) {
        add(rows, 1, there, 0);
        add(rows, 1, there, hours / 24);
        add(rows, 1, rest, 0);
        add(rows, 1, rest, every - hours / 24);
      }
    } else if (key == "tendon") {
      study_.tendon.length = within(1, "a length at rest, that of the fibres being 1", 1e-6, 1e6);
      study_.tendon.stiffness = within(2, "a stiffness in kPa", 1e-6, most_stiffness);
      study_.tendon.viscosity = rows.number(3, "a viscosity in kPa days", 0, most_stiffness);
      study_.tendon_place = rows.place(0);
      rows.ends_after(4);
      once(rows, "the tendon");
    } else if (key == "measure") {
      Measurement m;
      m.time = rows.number(1, "a time in days", 0, most_days);
      const std::string quantity = rows.text(2, "lambda_e, G or tendon");
      if (quantity == "lambda_e") {
        m.of = Quantity::lambda_e;
      } else if (quantity == "G") {
        m.of = Quantity::G;
      } else if (quantity == "tendon") {
        m.of = Quantity::tendon;
      } else {
        rows.unexpected(2, "lambda_e, G or tendon");
      }
      m.value = within(3, "a value", least_measured, most_measured);
      m.sd = within(4, "a standard deviation", least_measured, most_measured);
      rows.ends_after(5);
      once(rows, "the measurement of " + quantity + " = " + text_of(m.value) + " on day " + text_of(m.time),
           false);
      study_.measurements.push_back(m);
    } else {
      rows.unexpected(
          0, "title, include, set, fit, rest_length, step, ramp, hold, distract, cycle, tendon or measure");
    }
  }

  Study& study_;
  std::vector<std::string> chain_;  // the files that are open, each included by the one before
  std::size_t n_rows_ = 0;
  std::map<std::string, std::pair<std::string, std::size_t>> given_before_;  // where, and how deep
};

// ---- Histories

/// The history with time steps between its knots, ending at the last knot or stop. After every knot the steps
/// begin with `first` [day] and lengthen by `ratio` of the time since; none takes more than 0.002 of stretch.
inline std::vector<Knot> cut(std::vector<Knot> knots, std::vector<double> stops, double first, double ratio,
                             const std::string& name) {
  std::sort(stops.begin(), stops.end());
  if (!stops.empty() && stops.back() > knots.back().time)
    knots.push_back({stops.back(), knots.back().stretch});
  std::vector<Knot> all{knots[0]};
  const auto push = [&](const Knot& next) {
    if (all.size() > most_steps)
      throw Error(name + ": the history takes more than " + std::to_string(most_steps) +
                  " time steps, by day " + text_of(next.time) +
                  ": expected fewer rows, or less change of stretch");
    all.push_back(next);
  };
  for (std::size_t k = 1; k < knots.size(); ++k) {
    const Knot a = knots[k - 1], b = knots[k];
    const double length = b.time - a.time, change = std::abs(b.stretch - a.stretch);
    if (!(length > 0)) {
      push(b);
      continue;
    }
    const double most = change > 0 ? 0.002 * length / change : length;
    for (double t = a.time; t < b.time;) {
      double next = t + std::min(first + ratio * (t - a.time), most);
      if (next > b.time - 1e-9 * length) next = b.time;
      const auto stop = std::upper_bound(stops.begin(), stops.end(), t);
      if (stop != stops.end() && *stop < next) next = *stop;
      t = next;
      push({t, t == b.time ? b.stretch : a.stretch + (b.stretch - a.stretch) * (t - a.time) / length});
    }
  }
  return all;
}

/// G at the points of a history that has been cut into steps. Backward Euler in whole and in half steps, and
/// from the two what vanishing steps would give: of second order, smooth in the parameters, and with
/// derivatives with respect to them if T carries any.
/// amplitude: what every stretch - 1 is multiplied by.
template <class T>
T scaled(double stretch, const T& amplitude) {
  return T(1.0) + amplitude * (stretch - 1);
}
template <class T>
std::vector<T> grow(const myogrowth::GrowthRate<T>& growth, const myogrowth::RemovalRate<T>& removal,
                    const T& amplitude, const std::vector<Knot>& points) {
  std::vector<T> G;
  T whole(1.0), halves(1.0);
  G.push_back(whole);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dt = points[i].time - points[i - 1].time;
    const T middle = scaled((points[i].stretch + points[i - 1].stretch) / 2, amplitude);
    const T end = scaled(points[i].stretch, amplitude);
    whole = solve_growth(growth, removal, whole, end, T(dt)).G;
    halves = solve_growth(growth, removal, halves, middle, T(dt / 2)).G;
    halves = solve_growth(growth, removal, halves, end, T(dt / 2)).G;
    G.push_back(2.0 * halves - whole);
  }
  return G;
}

/// A muscle at a point of time.
struct Point {
  double time, stretch, G, lambda_e;  ///< of the fibres
  double force;    ///< along the fibre, per reference area: first Piola-Kirchhoff stress [stress]
  double lateral;  ///< stretch across the fibre
  double tendon;   ///< relative length of the tendon; 1 without one
};

/// Pulls a strip of muscle with free sides, or one with a tendon in series, through a history that has been
/// cut into steps. The exact flow at the stretch of the middle of every step: exact where the stretch is
/// held.
inline std::vector<Point> pull(myogrowth::FibreGrowth<> muscle, const Tendon& tendon,
                               const std::vector<Knot>& points, const std::string& name) {
  muscle.integration = myogrowth::TimeIntegration::midpoint_flow;
  std::vector<Point> result;
  MuscleTendon now;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double dt = i > 0 ? points[i].time - points[i - 1].time : 0;
    const auto status = step_to_length(muscle, tendon, points[i].stretch, dt, now);
    if (status != myogrowth::UpdateStatus::ok)
      throw Error(name + ": no result at stretch " + text_of(points[i].stretch) + " on day " +
                  text_of(points[i].time) + ": " + abi::text(status));
    result.push_back({points[i].time, now.stretch, now.G, now.stretch / now.G, now.force, now.lateral,
                      now.tendon(tendon)});
  }
  return result;
}

// ---- Options: --name VALUE, and files

class Options {
 public:
  /// names: the options there are; all but --help take a value. repeated: those that may be given more than
  /// once.
  Options(int argc, char** argv, const char* help, const std::vector<std::string>& names,
          const std::vector<std::string>& repeated) {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--help" || word == "-h") {
        common::print(help);
        std::exit(0);
      }
      if (word.rfind('-', 0) != 0) {
        files.push_back(word);
        continue;
      }
      const auto is_in = [&](const std::vector<std::string>& some) {
        return word.rfind("--", 0) == 0 && std::find(some.begin(), some.end(), word.substr(2)) != some.end();
      };
      if (!is_in(names) && !is_in(repeated))
        throw Error("no option '" + visible(word) + "' (--help lists them)");
      const std::string value = i + 1 < argc ? argv[i + 1] : "";
      if (value.empty() || value.rfind("--", 0) == 0) throw Error(word + ": expected a value after it");
      if (has(word.substr(2)) && !is_in(repeated)) throw Error(word + ": expected only once");
      given_.push_back({word.substr(2), value});
      ++i;
    }
  }

  std::vector<std::string> files;

  bool has(const std::string& name) const { return !all(name).empty(); }
  std::string text(const std::string& name, const std::string& otherwise) const {
    return has(name) ? all(name)[0] : otherwise;
  }
  /// All values of an option that may be given more than once.
  std::vector<std::string> all(const std::string& name) const {
    std::vector<std::string> values;
    for (const auto& option : given_) {
      if (option.first == name) values.push_back(option.second);
    }
    return values;
  }
  double number(const std::string& name, double otherwise, double above) const {
    return number_if(name, otherwise, "a number > " + text_of(above), [&](double x) { return x > above; });
  }
  double number(const std::string& name, double otherwise, double least, double most) const {
    return number_if(name, otherwise, "a number from " + text_of(least) + " to " + text_of(most),
                     [&](double x) { return x >= least && x <= most; });
  }
  long count(const std::string& name, long otherwise, long least, long most) const {
    return static_cast<long>(number_if(
        name, static_cast<double>(otherwise),
        "a whole number from " + std::to_string(least) + " to " + std::to_string(most), [&](double x) {
          return x == std::floor(x) && x >= static_cast<double>(least) && x <= static_cast<double>(most);
        }));
  }
  /// --set NAME=VALUE, all of them, on a study.
  void set(Study& study) const {
    std::set<std::string> done;
    for (const std::string& option : all("set")) {
      const std::string place = "--set " + visible(option);
      const std::size_t equals = option.find('=');
      const std::string name = option.substr(0, equals);
      const int entry = find_parameter(name);
      double x;
      if (entry < 0 || equals == option.npos)
        throw Error(place + ": expected NAME=VALUE, NAME one of " + parameter_names());
      const std::string value = option.substr(equals + 1);
      if (!common::to_number(value, x))
        throw Error(place + ": expected a number, found '" + visible(value) + "'" + common::hint(value));
      if (!done.insert(name).second) throw Error(place + ": expected only once");
      *abi::parameter(study.muscle, entry) = x;
      study.given[name] = place;
    }
  }

 private:
  template <class Allowed>
  double number_if(const std::string& name, double otherwise, const std::string& what,
                   const Allowed& allowed) const {
    double x;
    if (!has(name)) return otherwise;
    const std::string value = text(name, "");
    if (!common::to_number(value, x) || !allowed(x))
      throw Error("--" + name + " = " + visible(value) + ": expected " + what + common::hint(value));
    return x;
  }

  std::vector<std::pair<std::string, std::string>> given_;
};

/// A study from a file, with what the options set, checked.
inline Study read(const std::string& path, const Options& options) {
  Study study = Reader::read(path);
  options.set(study);
  check_parameters(study);
  return study;
}

// ---- Results

/// printf into a text.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  const int length = std::snprintf(nullptr, 0, pattern, values...);
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  std::snprintf(text.data(), text.size(), pattern, values...);
  text.pop_back();
  return text;
}

/// Shows on a terminal how far a run is; printf's arguments.
template <class... Values>
void show_progress(const char* pattern, Values... values) {
  if (isatty(STDERR_FILENO)) std::fputs(format(pattern, values...).c_str(), stderr);
}

/// JSON, as texts.
inline std::string json(double x) { return std::isfinite(x) ? text_of(x) : "null"; }
inline std::string json(const std::string& text) {
  std::string quoted = "\"";
  for (char c : common::is_text(text) ? text : visible(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\t' ? ' ' : c;
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

/// A text as a cell of a table in Markdown.
inline std::string cell(const std::string& text) {
  std::string escaped;
  for (char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

/// The folder of a run's results. It is made and tried before the first step, and what a run before has left
/// of `names`, the files that this program writes, is removed: whatever is there later is of this run.
/// inputs: the files that it reads, which must not be among them.
class Folder {
 public:
  Folder(const std::string& path, const std::vector<std::string>& names,
         const std::vector<std::string>& inputs)
      : path_(path) {
    if (!common::is_text(path))
      throw Error("--out " + visible(path) + ": expected a name in UTF-8 without control characters");
    common::make_folder(path);
    // The lock lasts until the program ends.
    if (flock(open(path.c_str(), O_RDONLY | O_CLOEXEC), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      throw Error(path + ": another run is at work there");
    std::error_code error;
    for (const std::string& input : inputs) {
      for (const std::string& name : names) {
        if (std::filesystem::equivalent(input, path_ / name, error))
          throw Error(input + ": would be overwritten; expected another folder than --out " + path);
      }
    }
    for (const std::string& name : names) {
      std::filesystem::remove(path_ / name, error);
      if (error) throw Error((path_ / name).string() + ": cannot be removed: " + error.message());
    }
  }

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { common::write_file(path(name), text); }
  /// The last line of what a run prints; pictures.py looks for it.
  std::string last_line() const { return "\nresults in " + path_.string() + "\n"; }

 private:
  std::filesystem::path path_;
};

/// Runs a program's body; an Error becomes one line and status 2.
template <class Body>
int run(const Body& body) {
  try {
    common::check_standard_streams();
    return body();
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "error: there is not enough memory\n");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
  }
  return 2;
}

}  // namespace study

#endif
