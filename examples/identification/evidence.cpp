// What ./run fit cannot do, held against what is published: muscle and tendon in series, doses of stretch,
// growth across the fibre. examples/identification/evidence.py runs it with the fits and makes the table of
// docs/evidence.md.
#include <ceres/ceres.h>
#if __has_include(<glog/logging.h>)
#include <glog/logging.h>
#endif

#include <functional>
#include <myogrowth/more/cross_fibre_growth.hpp>
#include <myogrowth/more/sensed_stretch.hpp>

#include "../common/cycles.hpp"
#include "../common/study.hpp"

namespace {

using study::format;
using study::json;

const char* const help = R"(usage: study_evidence [FILE.csv] [OPTIONS]

  FILE.csv           a study with a tendon: time constants are fitted to some of its measurements, the others predicted
  --dose DAYS        without a file: maps of G after DAYS of stretch, over hours a day and stretch
  --area FILE.csv    growth across the fibre: fitted to these areas
  --predict FILE.csv areas that are predicted with it (may be given more than once)
  --extensions FILE.csv   with more files: extensions of the law, each fitted to all these studies together; FILE.csv
                     sets the parameters that are not fitted
  --set NAME=VALUE   a parameter of FILE.csv
  --out DIR          folder of report.json; default out/evidence
)";

/// Least squares over the logarithms of positive numbers, by Ceres with numeric derivatives.
using Residuals = std::function<std::vector<double>(const std::vector<double>&)>;
struct Functor {
  const Residuals& residuals;
  std::size_t n;
  bool operator()(double const* const* x, double* r) const {
    std::vector<double> values(n);
    for (std::size_t i = 0; i < n; ++i) values[i] = std::exp(x[0][i]);
    const auto found = residuals(values);
    std::copy(found.begin(), found.end(), r);
    return std::all_of(found.begin(), found.end(), [](double y) { return std::isfinite(y); });
  }
};
struct Between {
  double lower, upper;
};
struct Fitted {
  std::vector<double> x;
  double chi2;
};
Fitted fit(const Residuals& residuals, const std::vector<std::vector<double>>& starts,
           const std::vector<Between>& bounds) {
  Fitted best{{}, std::numeric_limits<double>::infinity()};
  for (const auto& start : starts) {
    std::vector<double> x;
    for (double s : start) x.push_back(std::log(s));
    auto* cost = new ceres::DynamicNumericDiffCostFunction<Functor>(new Functor{residuals, x.size()});
    cost->AddParameterBlock(static_cast<int>(x.size()));
    cost->SetNumResiduals(static_cast<int>(residuals(start).size()));
    ceres::Problem problem;
    problem.AddResidualBlock(cost, nullptr, x.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      problem.SetParameterLowerBound(x.data(), static_cast<int>(i), std::log(bounds[i].lower));
      problem.SetParameterUpperBound(x.data(), static_cast<int>(i), std::log(bounds[i].upper));
    }
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 100;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable() || !(2 * summary.final_cost < best.chi2)) continue;
    best.chi2 = 2 * summary.final_cost;
    best.x.clear();
    for (double s : x) best.x.push_back(std::exp(s));
  }
  if (best.x.empty()) throw study::Error("no fit: no start led to a finite result");
  return best;
}

// ---- Muscle and tendon

/// What the model gives for the measurements of a study, with these time constants.
std::vector<double> computed(study::Study s, double tau, double viscosity) {
  // Removal keeps its ratio to growth.
  if (s.muscle.removal.tau_rev > 0) s.muscle.removal.tau_rev *= tau / s.muscle.growth.tau;
  s.muscle.growth.tau = tau;
  s.tendon.viscosity = viscosity;
  std::vector<double> stops, result;
  for (const auto& m : s.measurements) stops.push_back(m.time);
  const auto run = study::pull(s.muscle, s.tendon, study::cut(s.knots, stops, 0.005, 0.03, s.name), s.name);
  for (const auto& m : s.measurements) {
    std::size_t i = run.size();
    while (run[i - 1].time > m.time + 1e-9) --i;
    const study::Point& p = run[i - 1];
    result.push_back(m.of == study::Quantity::G        ? p.G
                     : m.of == study::Quantity::tendon ? p.tendon
                                                       : p.lambda_e);
  }
  return result;
}

int tendon(const study::Options& options) {
  const study::Study s = study::read(options.files[0], options);
  if (!(s.tendon.length > 0)) throw study::Error(options.files[0] + ": expected a row 'tendon'");
  if (s.measurements.size() < 2 || s.knots.size() < 2)
    throw study::Error(options.files[0] + ": expected a history and two rows 'measure' or more");
  const study::Folder out(options.text("out", "out/evidence"), {"report.json"}, options.files);
  double first_day = study::most_days, last_day = 0;
  for (const auto& m : s.measurements) {
    first_day = std::min(first_day, m.time);
    last_day = std::max(last_day, m.time);
  }
  struct Case {
    const char* name;
    std::function<bool(const study::Measurement&)> fitted;
  };
  const std::vector<Case> cases{
      {"fitted to the first day", [&](const auto& m) { return m.time == first_day; }},
      {"fitted to the last day", [&](const auto& m) { return m.time == last_day; }},
      {"fitted to all", [](const auto&) { return true; }},
  };
  std::vector<std::string> items;
  std::string text = "| case | tau [d] | viscosity [kPa d] |";
  for (const auto& m : s.measurements)
    text += format(" %s, day %g: %.3f |", study::text(m.of), m.time, m.value);
  text += "\n|---|---|---|" + [&] {
    std::string rule;
    for (std::size_t i = 0; i < s.measurements.size(); ++i) rule += "---|";
    return rule;
  }() + "\n";
  for (const Case& c : cases) {
    // On the first day there is no measurement of creep: the tendon is then rigid.
    const bool creeps = c.fitted(s.measurements.back()) || s.measurements.back().time == first_day;
    const auto all = [&](const std::vector<double>& x) { return computed(s, x[0], creeps ? x[1] : 0); };
    const Residuals residuals = [&](const std::vector<double>& x) {
      std::vector<double> r;
      const auto y = all(x);
      for (std::size_t i = 0; i < y.size(); ++i) {
        const auto& m = s.measurements[i];
        if (c.fitted(m)) r.push_back((y[i] - m.value) / m.sd);
      }
      return r;
    };
    std::vector<std::vector<double>> starts;
    for (double tau : {0.3, 2.0, 10.0}) {
      for (double eta : {10.0, 100.0})
        starts.push_back(creeps ? std::vector<double>{tau, eta} : std::vector<double>{tau});
    }
    const Fitted f = fit(residuals, starts, {{1e-2, 1e6}, {1e-2, 1e6}});
    const auto y = all(f.x);
    text += format("| %s | %.3g | %s |", c.name, f.x[0], creeps ? format("%.3g", f.x[1]).c_str() : "rigid");
    for (double value : y) text += format(" %.3f |", value);
    text += "\n";
    items.push_back(study::json_object({{"name", json(std::string(c.name))},
                                        {"tau", json(f.x[0])},
                                        {"viscosity", json(creeps ? f.x[1] : NAN)},
                                        {"chi2", json(f.chi2)},
                                        {"computed", json(y)},
                                        {"fitted", study::json_array(s.measurements, [&](const auto& m) {
                                           return c.fitted(m) ? 1.0 : 0.0;
                                         })}}));
  }
  out.write(
      "report.json",
      study::json_object(
          {{"cases", study::json_array(items)},
           {"day", study::json_array(s.measurements, [](const auto& m) { return m.time; })},
           {"quantity",
            study::json_array(s.measurements, [](const auto& m) { return std::string(study::text(m.of)); })},
           {"value", study::json_array(s.measurements, [](const auto& m) { return m.value; })},
           {"sd", study::json_array(s.measurements, [](const auto& m) { return m.sd; })}}));
  common::print(text + out.last_line());
  return 0;
}

// ---- Growth across the fibre

struct Areas {
  std::string name;
  std::vector<double> day, value, sd;  // relative to the first
};
Areas read_areas(const std::string& path) {
  Areas a{std::filesystem::path(path).stem().string(), {}, {}, {}};
  common::Rows rows(path, common::Separator::comma);
  double first = 0;
  while (rows.next()) {
    if (rows.text(0, "the keyword 'area'") != "area") rows.unexpected(0, "the keyword 'area'");
    const double day = rows.number(1, "a time in days", 0, study::most_days);
    const double area = rows.number(2, "an area", 0), sd = rows.number(3, "a standard deviation", 0);
    rows.ends_after(4);
    if (first == 0 && day != 0) rows.fail(1, "expected day 0 first, found " + study::text_of(day));
    if (!a.day.empty() && !(day > a.day.back()))
      rows.unexpected(1, "a later day than that of the row before");
    if (first == 0) first = area;
    a.day.push_back(day);
    a.value.push_back(area / first);
    a.sd.push_back(sd / first);
  }
  if (a.day.size() < 2) throw study::Error(path + ": expected two rows 'area, DAY, AREA, SD' or more");
  return a;
}

double area(double tau, double overload, double day) {
  myogrowth::CrossFibreGrowth law;
  law.capacity.tau = tau;
  return law.at_constant_load(1, overload, day);
}

int areas(const study::Options& options) {
  const std::string file = options.text("area", "");
  const Areas fitted = read_areas(file);
  std::vector<std::string> inputs = options.all("predict");
  std::vector<Areas> all{fitted};
  for (const std::string& path : inputs) all.push_back(read_areas(path));
  inputs.push_back(file);
  const study::Folder out(options.text("out", "out/evidence"), {"report.json"}, inputs);
  const Residuals residuals = [&](const std::vector<double>& x) {
    std::vector<double> r;
    for (std::size_t i = 1; i < fitted.day.size(); ++i)
      r.push_back((area(x[0], 1 + x[1], fitted.day[i]) - fitted.value[i]) / fitted.sd[i]);
    return r;
  };
  const Fitted f = fit(residuals, {{3, 0.1}, {10, 0.1}, {30, 0.3}, {60, 0.3}}, {{1e-3, 1e4}, {1e-3, 1e4}});
  std::string text = format(
      "tau = %.3g d, overload %.3f, chi2 = %.2f for %zu areas\n\n| study | day | published | law | off by |\n"
      "|---|---|---|---|---|\n",
      f.x[0], 1 + f.x[1], f.chi2, fitted.day.size() - 1);
  std::vector<std::string> items;
  for (const Areas& a : all) {
    std::vector<double> y;
    for (std::size_t i = 0; i < a.day.size(); ++i) {
      y.push_back(area(f.x[0], 1 + f.x[1], a.day[i]));
      if (i > 0)
        text += format("| %s | %g | %.4f | %.4f | %+.2f %% |\n", a.name.c_str(), a.day[i], a.value[i], y[i],
                       100 * (y[i] / a.value[i] - 1));
    }
    items.push_back(study::json_object({{"name", json(a.name)},
                                        {"day", json(a.day)},
                                        {"value", json(a.value)},
                                        {"sd", json(a.sd)},
                                        {"computed", json(y)}}));
  }
  out.write("report.json", study::json_object({{"tau", json(f.x[0])},
                                               {"overload", json(1 + f.x[1])},
                                               {"chi2", json(f.chi2)},
                                               {"studies", study::json_array(items)}}));
  common::print(text + out.last_line());
  return 0;
}

// ---- Extensions of the law

/// What the law gives for the measurements of a study whose history is `points`. From whole and half steps
/// what vanishing ones would give, as in study::grow.
std::vector<double> computed(const myogrowth::SensedStretch<>& law, const study::Study& s,
                             const std::vector<study::Knot>& points) {
  std::vector<double> G{1}, result;
  myogrowth::SensedState<> whole, halves;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dt = points[i].time - points[i - 1].time, end = points[i].stretch;
    whole = solve_growth(law, whole, end, dt).state;
    halves = solve_growth(law, halves, (end + points[i - 1].stretch) / 2, dt / 2).state;
    halves = solve_growth(law, halves, end, dt / 2).state;
    G.push_back(2 * halves.G - whole.G);
  }
  for (const auto& m : s.measurements) {
    std::size_t i = points.size();
    while (points[i - 1].time > m.time + 1e-9) --i;
    result.push_back(m.of == study::Quantity::G ? G[i - 1] : points[i - 1].stretch / G[i - 1]);
  }
  return result;
}

// ---- Dose

int dose(const study::Options& options) {
  const long days = options.count("dose", 42, 1, 100000);
  const study::Folder out(options.text("out", "out/evidence"), {"report.json"}, {});
  constexpr int n = 48;
  std::vector<double> hours, stretch;
  for (int i = 0; i <= n; ++i) {
    hours.push_back(0.01 * std::pow(23.9 / 0.01, static_cast<double>(i) / n));
    stretch.push_back(1 + 0.3 * i / n);
  }
  struct Map {
    const char* name;
    myogrowth::GrowthRate<> growth;
    myogrowth::RemovalRate<> removal;
    double rest;
  };
  const myogrowth::GrowthRate<> table{0.5, 2, 1.6, 1.01};
  const std::vector<Map> maps{
      {"no removal, at rest 1", table, {}, 1},
      {"equal rates, at rest 1", table, {0.5, 0, 0.4, 1}, 1},
      {"equal rates, in a cast at 0.8", table, {0.5, 0, 0.4, 1}, 0.8},
      {"removal 50 times slower, in a cast at 0.8", table, {25, 0, 0.4, 1}, 0.8},
      {"tau 0.02 d, tau_rev 2 d, in a cast at 0.8", {0.02, 1, 3, 1.01}, {2, 0, 0.4, 1}, 0.8},
      {"tau 0.02 d, tau_rev 2 d, at rest 1", {0.02, 1, 3, 1.01}, {2, 0, 0.4, 1}, 1},
  };
  long evaluated = 0;
  std::vector<std::string> items;
  const auto add = [&](const char* name, const auto& G_at) {
    std::vector<std::string> rows;
    for (double h : hours) {
      std::vector<double> row;
      for (double x : stretch) row.push_back(G_at(h, x));
      rows.push_back(json(row));
    }
    items.push_back(study::json_object({{"name", json(std::string(name))}, {"G", study::json_array(rows)}}));
  };
  for (const Map& m : maps) {
    add(m.name, [&](double h, double x) {
      const auto c = study::many_cycles(m.growth, m.removal, {x, h, m.rest, 1}, 1, days, 1e-3);
      evaluated += c.evaluated;
      return c.G;
    });
  }
  // Every cycle in steps: a cycle of this law does not only depend on G.
  const myogrowth::SensedStretch<> sensed{{0.5, 1, 3, 1.01}, {0.5, 0, 0.4, 1}, 0.006, 1.05, 0};
  for (double rest : {0.8, 1.0}) {
    add(rest < 1 ? "sensed stretch, one rate, in a cast at 0.8" : "sensed stretch, one rate, at rest 1",
        [&](double h, double x) {
          study::Study s;
          s.measurements = {{static_cast<double>(days), study::Quantity::G, 1, 1}};
          s.knots = {{0, rest}};
          for (double day = 0; day < static_cast<double>(days); ++day) {
            for (const study::Knot& k :
                 {study::Knot{day, x}, {day + h / 24, x}, {day + h / 24, rest}, {day + 1, rest}})
              s.knots.push_back(k);
          }
          return computed(sensed, s, study::cut(s.knots, {}, 0.004, 0.5, ""))[0];
        });
  }
  // What the tolerance of the jumps is worth: 3000 cycles, against all of them computed.
  std::vector<std::string> control;
  for (const Map& m : {maps[0], maps[3]}) {
    const study::Cycle c{1.1, 0.5, m.rest, 1};
    double exact = 1;
    for (int i = 0; i < 3000; ++i) exact = study::one_cycle(m.growth, m.removal, c, exact);
    for (double tolerance : {1e-3, 1e-5, 1e-7}) {
      const auto jumped = study::many_cycles(m.growth, m.removal, c, 1, 3000, tolerance);
      control.push_back(study::json_object({{"name", json(std::string(m.name))},
                                            {"tolerance", json(tolerance)},
                                            {"evaluated", std::to_string(jumped.evaluated)},
                                            {"G", json(exact)},
                                            {"error", json(std::abs(jumped.G - exact))}}));
    }
  }
  out.write("report.json", study::json_object({{"days", std::to_string(days)},
                                               {"hours", json(hours)},
                                               {"stretch", json(stretch)},
                                               {"evaluated", std::to_string(evaluated)},
                                               {"control", study::json_array(control)},
                                               {"maps", study::json_array(items)}}));
  common::print(format("%zu maps of %d x %d points, %ld days each; by jumps: %ld cycles computed of %ld\n",
                       items.size(), n + 1, n + 1, days, evaluated,
                       static_cast<long>(maps.size()) * (n + 1) * (n + 1) * days) +
                out.last_line());
  return 0;
}

/// A parameter that a law may fit, where that starts, and at which value it does not matter.
struct Parameter {
  const char* name;
  std::vector<double> starts;
  Between bounds;
  double none;
};
enum Index { tau, tau_rev, lambda_crit_rev, tau_fall, tau_rise, x_half };
const Parameter fittable[] = {
    {"tau", {0.01, 0.5}, {0.002, 50}, 0.5},      {"tau_rev", {2, 20}, {0.05, 500}, 0.5},
    {"lambda_crit_rev", {0.99}, {0.9, 1.01}, 1}, {"tau_fall", {0.5, 3}, {0.01, 30}, 0.01},
    {"tau_rise", {0.01}, {0.001, 30}, 0.001},    {"x_half", {0.05}, {0.001, 100}, 100}};

/// One of the laws that are compared. What is not fitted is as it is set.
struct Candidate {
  const char* name;
  std::vector<Index> fitted;
  bool removes = true;
  enum { one_time, at_once } rise = at_once;  ///< where tau_rise is not fitted: as tau_fall, or 0
};
using Values = std::map<Index, double>;

myogrowth::SensedStretch<> law_of(const Candidate& c, const study::Study& base, const Values& v) {
  const auto given = [&](Index i, double otherwise) { return v.count(i) ? v.at(i) : otherwise; };
  myogrowth::SensedStretch<> law{base.muscle.growth, base.muscle.removal, 0, 0, 0};
  law.growth.tau = given(tau, law.growth.tau);
  law.removal.tau_rev = c.removes ? given(tau_rev, law.growth.tau) : 0;
  law.removal.lambda_crit_rev = given(lambda_crit_rev, law.removal.lambda_crit_rev);
  law.tau_fall = given(tau_fall, 0);
  law.tau_rise = given(tau_rise, c.rise == Candidate::one_time ? law.tau_fall : 0);
  law.per_x_half = v.count(x_half) ? 1 / v.at(x_half) : 0;
  return law;
}

int extensions(const study::Options& options) {
  const std::string base_file = options.text("extensions", "");
  const study::Study base = study::read(base_file, options);
  if (!(base.muscle.removal.tau_rev > 0))
    throw study::Error(base_file + ": expected removal to be set: tau_rev > 0");
  if (options.files.empty()) throw study::Error("--extensions: expected studies, FILE.csv ...");
  std::vector<study::Study> studies;
  std::vector<std::vector<study::Knot>> points;
  std::vector<std::string> figures;
  for (const std::string& file : options.files) {
    studies.push_back(study::read(file, options));
    const study::Study& s = studies.back();
    if (s.measurements.empty() || s.knots.size() < 2 || s.tendon.length > 0)
      throw study::Error(file + ": expected a history, rows 'measure' and no tendon");
    std::vector<double> stops;
    for (const auto& m : s.measurements) {
      stops.push_back(m.time);
      figures.push_back(study::json_object({{"title", json(s.title)},
                                            {"day", json(m.time)},
                                            {"quantity", json(std::string(study::text(m.of)))},
                                            {"value", json(m.value)},
                                            {"sd", json(m.sd)}}));
    }
    points.push_back(study::cut(s.knots, stops, 0.004, 0.25, file));
  }
  std::vector<std::string> inputs = options.files;
  inputs.push_back(base_file);
  const study::Folder out(options.text("out", "out/evidence"), {"report.json"}, inputs);
  const std::vector<Candidate> candidates{
      {"growth only", {tau}, false},
      {"growth and removal, one rate", {tau}},
      {"one rate, which saturates", {tau, x_half}},
      {"one rate, sensed stretch with one time constant", {tau, tau_fall}, true, Candidate::one_time},
      {"one rate, sensed stretch that rises at once", {tau, tau_fall}},
      {"one rate, sensed stretch with two time constants", {tau, tau_fall, tau_rise}},
      {"two rates", {tau, tau_rev}},
      {"two rates and lambda_crit_rev", {tau, tau_rev, lambda_crit_rev}},
      {"two rates, which saturate", {tau, tau_rev, x_half}},
      {"two rates, sensed stretch that rises at once", {tau, tau_rev, tau_fall}},
      {"tau as set, two rates", {tau_rev}},
      {"tau as set, two rates and lambda_crit_rev", {tau_rev, lambda_crit_rev}},
      {"tau as set, two rates, which saturate", {tau_rev, x_half}},
      {"tau as set, one rate, sensed stretch that rises at once", {tau_fall}},
      {"tau as set, one rate, sensed stretch with two time constants", {tau_fall, tau_rise}},
  };
  std::string text;
  std::vector<std::string> items;
  std::vector<std::pair<Candidate, std::vector<double>>> found;
  for (const Candidate& c : candidates) {
    const auto all = [&](const std::vector<double>& x) {
      Values v;
      for (std::size_t i = 0; i < x.size(); ++i) v[c.fitted[i]] = x[i];
      const auto law = law_of(c, base, v);
      std::vector<double> y;
      for (std::size_t i = 0; i < studies.size(); ++i) {
        for (double found : computed(law, studies[i], points[i])) y.push_back(found);
      }
      return y;
    };
    const Residuals residuals = [&](const std::vector<double>& x) {
      std::vector<double> r = all(x);
      std::size_t i = 0;
      for (const auto& s : studies) {
        for (const auto& m : s.measurements) {
          r[i] = (r[i] - m.value) / m.sd;
          ++i;
        }
      }
      return r;
    };
    std::vector<std::vector<double>> starts{{}};
    std::vector<Between> bounds;
    for (Index p : c.fitted) {
      std::vector<std::vector<double>> more;
      for (const auto& s : starts) {
        for (double x : fittable[p].starts) {
          more.push_back(s);
          more.back().push_back(x);
        }
      }
      starts = more;
      bounds.push_back(fittable[p].bounds);
    }
    // And from every law before that it includes, so that it is no worse.
    for (const auto& [other, values] : found) {
      Values v{{tau_rev, other.fitted[0] == tau ? values[0] : base.muscle.growth.tau}};
      for (std::size_t i = 0; i < values.size(); ++i) v[other.fitted[i]] = values[i];
      const auto has = [&](Index p) { return std::count(c.fitted.begin(), c.fitted.end(), p) > 0; };
      if (other.removes != c.removes || other.rise != c.rise ||
          !std::all_of(other.fitted.begin(), other.fitted.end(), has))
        continue;
      starts.push_back({});
      for (Index p : c.fitted)
        starts.back().push_back(std::clamp(v.count(p) ? v.at(p) : fittable[p].none, fittable[p].bounds.lower,
                                           fittable[p].bounds.upper));
    }
    const Fitted f = fit(residuals, starts, bounds);
    found.push_back({c, f.x});
    text += format("%-62s chi2 %7.2f", c.name, f.chi2);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < f.x.size(); ++i) {
      const Parameter& p = fittable[c.fitted[i]];
      names.push_back(json(std::string(p.name)));
      text += format("  %s = %.3g", p.name, f.x[i]);
    }
    text += "\n";
    items.push_back(study::json_object({{"name", json(std::string(c.name))},
                                        {"parameters", study::json_array(names)},
                                        {"values", json(f.x)},
                                        {"chi2", json(f.chi2)},
                                        {"computed", json(all(f.x))}}));
  }
  out.write("report.json", study::json_object({{"tau", json(base.muscle.growth.tau)},
                                               {"figures", study::json_array(figures)},
                                               {"laws", study::json_array(items)}}));
  common::print(text + out.last_line());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
#if __has_include(<glog/logging.h>)
  FLAGS_minloglevel = google::GLOG_FATAL;
#endif
  return study::run([&] {
    const study::Options options(argc, argv, help, {"dose", "area", "extensions", "out"}, {"set", "predict"});
    const bool extended = options.has("extensions");
    const int files = extended ? 0 : static_cast<int>(options.files.size());
    if (files + extended + options.has("dose") + options.has("area") != 1)
      throw study::Error("expected one of FILE.csv, --dose, --area and --extensions (--help says more)");
    if (options.has("predict") && !options.has("area"))
      throw study::Error("--predict: expected only with --area");
    if (options.has("set") && options.files.empty()) throw study::Error("--set: expected only with FILE.csv");
    if (extended) return extensions(options);
    return options.has("dose") ? dose(options) : options.has("area") ? areas(options) : tendon(options);
  });
}
