// Which inputs determine how far a muscle is overstretched? Sensitivity of the elastic stretch and the force
// to the law's parameters and to the ramp: local, by dual numbers through whole histories; global, by Sobol's
// indices.
//
// Shows from the library: parameters as dual numbers, uniaxial stress included; and the batch kernel on
// a million histories whose parameters all differ. The batch takes one material a call (a SIMD pack cannot be
// the parameters' type: the local solve branches on them). But eq. 4 has similarity solutions: with s =
// G_max/2,
//
//   G = s G', lambda = lambda_crit s lambda', t = t' s tau/lambda_crit [(G_max - 1)/s]^gamma
//
// turn every history into one of the material with tau = 1, G_max = 2, lambda_crit = 1 and the same gamma.
// Each point has its own stretch, start and time step. Only gamma remains: it takes one of `levels` values,
// with one call each.
#include <array>
#include <chrono>
#include <ctime>
#include <future>
#include <myogrowth/many/batch.hpp>
#include <random>
#include <system_error>
#include <thread>

#include "../common/jet.hpp"
#include "../common/study.hpp"
#include "sobol.hpp"

namespace {

using study::format;
using study::json;

const char* const help = R"(usage: ./run sensitivity [OPTIONS]

Stretches a muscle in a ramp and holds it, and asks how its peak and final elastic stretch and its peak force depend
on the law's six parameters and the length of the ramp. Local: derivatives of the whole history at the middle.
Global: Sobol's indices of independent, uniform parameters, with 95 % bootstrap intervals.

  --histories N          about how many histories for the global part; default 1000000
  --stretch LAMBDA       stretch that is held; default 1.1
  --days DAYS            end; default 42
  --range NAME=LOW:HIGH  of tau gamma G_max lambda_crit ramp c1 c2 [kPa, days]; default: the table it prints
  --threads N            default: all cores
  --seed N               default 1
  --out DIR              default out/sensitivity
)";

constexpr std::size_t n_inputs = 7;
constexpr std::array<const char*, n_inputs> names = {"tau",  "gamma", "G_max", "lambda_crit",
                                                     "ramp", "c1",    "c2"};
constexpr std::size_t gamma_input = 1, ramp_input = 4;
constexpr int levels = 64;  // of gamma
template <class T>
using Inputs = std::array<T, n_inputs>;  // in the order of names

struct Case {
  double stretch, days;
  Inputs<double> low, high;

  double gamma(int level) const {
    return low[gamma_input] + (high[gamma_input] - low[gamma_input]) * (level + 0.5) / levels;
  }
};

/// Where along the rest of the time the steps after the ramp end, in (0, 1]: they lengthen evenly.
std::vector<double> hold_fractions(int n) {
  std::vector<double> ends;
  for (int i = 1; i <= n; ++i) ends.push_back((std::pow(2000.0, static_cast<double>(i) / n) - 1) / 1999);
  return ends;
}

// ---- One history, in any scalar

template <class T>
struct Row {
  double time;
  T lambda_e, force;
};

/// The history at times that do not depend on the inputs, but for the end of the ramp.
template <class T>
std::vector<Row<T>> history(const Inputs<T>& x, const Case& c) {
  using myogrowth::value;
  myogrowth::FibreGrowth<T> muscle;
  muscle.growth = {x[0], x[1], x[2], x[3]};
  muscle.c1 = x[5];
  muscle.c2 = x[6];
  const T ramp = x[4];
  constexpr int in_ramp = 100;
  std::vector<Row<T>> rows;
  T time(0.0), last_stretch(1.0), whole(1.0), halves(1.0), lateral(1.0);
  const auto step = [&](const T& t, const T& stretch) {
    const T dt = t - time, middle = (last_stretch + stretch) / 2.0;
    whole = solve_growth(muscle.growth, muscle.removal, whole, stretch, dt).G;
    halves = solve_growth(muscle.growth, muscle.removal, halves, middle, T(dt / 2.0)).G;
    halves = solve_growth(muscle.growth, muscle.removal, halves, stretch, T(dt / 2.0)).G;
    const T G = 2.0 * halves - whole;  // as in study::grow
    myogrowth::PointUpdate<T> u;
    T slope;
    uniaxial_stress(muscle, stretch, G, last_stretch, T(0.0), lateral, u, slope);  // no time passes: G stays
    rows.push_back({value(t), u.lambda_e, T(u.tau[0] / stretch)});
    time = t;
    last_stretch = stretch;
  };
  for (int i = 1; i < in_ramp; ++i) {
    const T t(value(ramp) * i / in_ramp);
    step(t, T(1.0 + (c.stretch - 1) * t / ramp));
  }
  step(ramp, T(c.stretch));
  const double start = value(ramp);
  for (double part : hold_fractions(200)) step(T(start + (c.days - start) * part), T(c.stretch));
  return rows;
}

template <class T>
std::array<T, 3> outputs(const std::vector<Row<T>>& rows) {
  using myogrowth::value;
  const Row<T>* peak = &rows[0];
  for (const Row<T>& r : rows) {
    if (value(r.lambda_e) > value(peak->lambda_e)) peak = &r;
  }
  return {peak->lambda_e, rows.back().lambda_e, peak->force};
}

// ---- Many histories

/// F of the points as the batch reads it: the stretch along the fibre, 1 across it. A view tells where
/// component c of the points from i on is stored.
struct AlongFibre {
  const double *stretch, *zeros, *ones;  // the last two as long as a pack
  struct Place {
    const double *stretch, *zeros, *ones;
    const double* operator()(int c) const { return c == 0 ? stretch : c % 4 == 0 ? ones : zeros; }
  };
  Place from(std::ptrdiff_t i) const { return {stretch + i, zeros, ones}; }
};

struct History {
  Inputs<double> x;  // but for gamma
  int level;         // of gamma
  std::array<double, 3> y;
};

/// Some histories with the same gamma, side by side.
void run_together(const Case& c, History* const* some, std::size_t n) {
  constexpr std::size_t most = 256;
  constexpr int in_ramp = 32;
  static const std::vector<double> hold = hold_fractions(48);
  double G[most], stretch[most], dt[most], rate[most], per_scale[most], peak[most], peak_stretch[most];
  myogrowth::FibreGrowth<> material;
  material.growth = {1, c.gamma(some[0]->level), 2, 1};
  const double fibre[3] = {1, 0, 0}, zeros[16] = {};
  double ones[16];
  std::fill_n(ones, 16, 1.0);
  std::ptrdiff_t failed = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Inputs<double>& x = some[i]->x;
    const double s = x[2] / 2;
    rate[i] = x[3] / (s * x[0]) * std::pow(s / (x[2] - 1), material.growth.gamma);
    per_scale[i] = 1 / (x[3] * s);
    G[i] = 1 / s;
    peak[i] = 0;
  }
  const auto points = static_cast<std::ptrdiff_t>(n);
  const myogrowth::batch::Input in{AlongFibre{stretch, zeros, ones}, myogrowth::batch::shared(fibre),
                                   myogrowth::batch::soa(G, points), myogrowth::batch::soa(dt, points)};
  const myogrowth::batch::Output out{myogrowth::batch::Absent{}, myogrowth::batch::soa(G, points)};
  const auto step = [&](double lambda) {
    failed += myogrowth::update_batch<myogrowth::Tangent::none>(material, points, in, out);
    for (std::size_t i = 0; i < n; ++i) {
      const double lambda_e = some[i]->x[3] * stretch[i] / G[i];
      if (lambda_e > peak[i]) {
        peak[i] = lambda_e;
        peak_stretch[i] = lambda;
      }
    }
  };
  for (int k = 1; k <= in_ramp; ++k) {
    const double lambda = 1 + (c.stretch - 1) * k / in_ramp;
    for (std::size_t i = 0; i < n; ++i) {
      stretch[i] = lambda * per_scale[i];
      dt[i] = rate[i] * some[i]->x[4] / in_ramp;
    }
    step(lambda);
  }
  double last = 0;
  for (double part : hold) {
    for (std::size_t i = 0; i < n; ++i) dt[i] = rate[i] * (c.days - some[i]->x[4]) * (part - last);
    step(c.stretch);
    last = part;
  }
  // The force is that of the elastic stretch, per reference area.
  myogrowth::FibreGrowth<> elastic;
  double lateral = 1, slope;
  myogrowth::PointUpdate<double> u;
  for (std::size_t i = 0; i < n; ++i) {
    const Inputs<double>& x = some[i]->x;
    elastic.c1 = x[5];
    elastic.c2 = x[6];
    uniaxial_stress(elastic, peak[i], 1.0, 1.0, 0.0, lateral, u, slope);
    if (failed > 0) peak[i] = std::numeric_limits<double>::quiet_NaN();
    some[i]->y = {peak[i], x[3] * stretch[i] / G[i], u.tau[0] / peak_stretch[i]};
  }
}

/// Calls body(part) for parts 0 to parts - 1 on several threads and prints progress. An exception of a thread
/// is thrown again here.
template <class Body>
void in_threads(std::size_t parts, unsigned threads, const char* what, const Body& body) {
  std::vector<std::future<void>> workers;
  for (unsigned w = 0; w < threads; ++w) {
    const auto work = [&, w] {
      for (std::size_t part = w; part < parts; part += threads) {
        body(part);
        if (w == 0 && part / threads % (parts / threads / 10 + 1) == 0)
          study::show_progress("\r  %s: %3.0f %%", what,
                               100.0 * static_cast<double>(part) / static_cast<double>(parts));
      }
    };
    try {
      workers.push_back(std::async(std::launch::async, work));
    } catch (const std::system_error& e) {
      throw study::Error(format("--threads = %u: only %u could be started: %s", threads, w, e.what()));
    }
  }
  for (std::future<void>& worker : workers) worker.get();
  study::show_progress("\r  %s: 100 %%\n", what);
}

void run_all(const Case& c, std::vector<History>& all, unsigned threads) {
  std::array<std::vector<History*>, levels> by_level;
  for (History& h : all) by_level[static_cast<std::size_t>(h.level)].push_back(&h);
  std::vector<std::pair<History* const*, std::size_t>> parts;
  for (auto& level : by_level) {
    for (std::size_t i = 0; i < level.size(); i += 256)
      parts.push_back({level.data() + i, std::min<std::size_t>(256, level.size() - i)});
  }
  in_threads(parts.size(), threads, "histories",
             [&](std::size_t p) { run_together(c, parts[p].first, parts[p].second); });
  for (const History& h : all) {
    if (myogrowth::are_finite(h.y.data(), 3)) continue;
    std::string at;
    for (std::size_t i = 0; i < n_inputs; ++i)
      at += format("%s%s = %.6g", i > 0 ? ", " : "", names[i], i == gamma_input ? c.gamma(h.level) : h.x[i]);
    throw study::Error("a history has no result: " + at + ": expected narrower ranges");
  }
}

// ---- Sobol's indices

/// Saltelli's plan: two independent samples A and B, and A with one column of B at a time; n_inputs + 2
/// histories for every row. Uniform between the bounds; std::mt19937_64.
std::vector<History> plan(const Case& c, std::size_t rows, unsigned long seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<History> all;
  all.reserve(rows * (n_inputs + 2));
  for (std::size_t row = 0; row < rows; ++row) {
    History sample[2];
    for (History& s : sample) {
      for (std::size_t i = 0; i < n_inputs; ++i) {
        const double u = uniform();
        s.x[i] = c.low[i] + (c.high[i] - c.low[i]) * u;
        if (i == gamma_input) s.level = static_cast<int>(u * levels);
      }
    }
    all.push_back(sample[0]);
    all.push_back(sample[1]);
    for (std::size_t i = 0; i < n_inputs; ++i) {
      History mixed = sample[0];
      mixed.x[i] = sample[1].x[i];
      if (i == gamma_input) mixed.level = sample[1].level;
      all.push_back(mixed);
    }
  }
  return all;
}

struct Interval {
  double low, high;
};

template <class F>
std::string indices_json(std::size_t rows, const F& f, unsigned threads, unsigned long seed,
                         const Indices<n_inputs>& point, std::vector<std::array<Interval, 2>>& intervals) {
  constexpr std::size_t resamples = 200;
  std::vector<Indices<n_inputs>> again(resamples, point);
  in_threads(resamples, threads, "bootstrap", [&](std::size_t r) {
    std::mt19937_64 random(seed * 1000 + r);
    again[r] = Indices<n_inputs>(rows, f, point.mean, [&](std::size_t) {
      return static_cast<std::size_t>(static_cast<double>(random() >> 11) * 0x1p-53 *
                                      static_cast<double>(rows));
    });
  });
  intervals.assign(n_inputs, {});
  std::vector<std::string> items;
  for (std::size_t i = 0; i < n_inputs; ++i) {
    for (std::size_t kind = 0; kind < 2; ++kind) {
      std::vector<double> values;
      for (const auto& a : again) values.push_back(kind == 0 ? a.first[i] : a.total[i]);
      std::sort(values.begin(), values.end());
      intervals[i][kind] = {values[resamples / 40], values[resamples - 1 - resamples / 40]};
    }
    const auto pair = [&](Interval v) { return json(std::vector<double>{v.low, v.high}); };
    items.push_back(study::json_object({{"name", json(std::string(names[i]))},
                                        {"first", json(point.first[i])},
                                        {"first_interval", pair(intervals[i][0])},
                                        {"total", json(point.total[i])},
                                        {"total_interval", pair(intervals[i][1])}}));
  }
  return study::json_array(items);
}

// ---- The program

constexpr std::array<const char*, 3> output_names = {"peak lambda_e", "final lambda_e", "peak force"};

/// The muscle that these inputs describe, for the check of its parameters.
myogrowth::FibreGrowth<> muscle_of(const Inputs<double>& x) {
  myogrowth::FibreGrowth<> muscle;
  muscle.growth = {x[0], x[1], x[2], x[3]};
  muscle.c1 = x[5];
  muscle.c2 = x[6];
  return muscle;
}

/// --range NAME=LOW:HIGH, all of them. Both ends are checked as parameters of a muscle, which covers all
/// values between them.
void set_ranges(const study::Options& options, Case& c) {
  std::array<std::string, n_inputs> places;
  for (const std::string& text : options.all("range")) {
    const std::string place = "--range " + study::visible(text);
    const std::size_t equals = text.find('='), colon = text.find(':', std::min(equals, text.size()));
    const auto name = std::find(names.begin(), names.end(), text.substr(0, equals));
    if (name == names.end() || colon == text.npos)
      throw study::Error(place +
                         ": expected NAME=LOW:HIGH, NAME one of tau gamma G_max lambda_crit ramp c1 c2");
    const auto number = [&](const std::string& value) {
      double x;
      if (!common::to_number(value, x))
        throw study::Error(place + ": expected a number, found '" + study::visible(value) + "'" +
                           common::hint(value));
      return x;
    };
    const auto i = static_cast<std::size_t>(name - names.begin());
    c.low[i] = number(text.substr(equals + 1, colon - equals - 1));
    c.high[i] = number(text.substr(colon + 1));
    if (!(c.high[i] > c.low[i])) throw study::Error(place + ": expected LOW < HIGH");
    if (i == ramp_input && !(c.low[i] >= study::least_days))
      throw study::Error(place + ": expected days from " + study::text_of(study::least_days) + " on");
    if (!std::exchange(places[i], place).empty())
      throw study::Error(place + ": expected only one range of " + names[i]);
  }
  for (const Inputs<double>& end : {c.low, c.high}) {
    for (std::size_t i = 0; i < n_inputs; ++i) {
      if (i != ramp_input) study::check(muscle_of(end), names[i], places[i]);
    }
  }
}

int sensitivity(int argc, char** argv) {
  const study::Options options(argc, argv, help, {"histories", "stretch", "days", "threads", "seed", "out"},
                               {"range"});
  if (!options.files.empty())
    throw study::Error("'" + study::visible(options.files[0]) +
                       "': no file is read (--help lists the options)");
  Case c{options.number("stretch", 1.1, 1 + 1e-9, study::most_stretch),
         options.number("days", 42, study::least_days, study::most_days),
         {0.25, 1, 1.05, 1.0, 0.25, 8, 2},
         {0.75, 3, 1.15, 1.02, 1.75, 24, 6}};
  set_ranges(options, c);
  if (!(c.high[ramp_input] < c.days))
    throw study::Error("--days = " + study::text_of(c.days) + ": expected more than the longest ramp, " +
                       study::text_of(c.high[ramp_input]));
  constexpr long fewest = 100 * (n_inputs + 2), most = 10000000;  // of about 100 bytes each
  const std::size_t rows =
      static_cast<std::size_t>(options.count("histories", 1000000, fewest, most)) / (n_inputs + 2);
  const long cores = std::max(1u, std::thread::hardware_concurrency());
  const auto threads = static_cast<unsigned>(options.count("threads", cores, 1, 1024));
  const auto seed = static_cast<unsigned long>(options.count("seed", 1, 0, 4294967295));
  const study::Folder out(options.text("out", "out/sensitivity"),
                          {"report.md", "report.json", "local.png", "global.png"}, {});

  Inputs<double> middle;
  for (std::size_t i = 0; i < n_inputs; ++i) middle[i] = (c.low[i] + c.high[i]) / 2;

  // Local: every input a Jet that is its own unit direction.
  using Jet = ceres::Jet<double, static_cast<int>(n_inputs)>;
  Inputs<Jet> jets;
  for (std::size_t i = 0; i < n_inputs; ++i) jets[i] = Jet(middle[i], static_cast<int>(i));
  const auto local_rows = history(jets, c);
  const auto local = outputs(local_rows);

  std::string text =
      format("Stretch %g, held to day %g. Relative derivatives at the middle: (p/y) dy/dp\n\n| |", c.stretch,
             c.days);
  for (const char* name : names) text += format(" %s |", name);
  text += "\n|---|---|---|---|---|---|---|---|\n| low |";
  for (double x : c.low) text += format(" %g |", x);
  text += "\n| middle |";
  for (double x : middle) text += format(" %g |", x);
  text += "\n| high |";
  for (double x : c.high) text += format(" %g |", x);
  text += "\n";
  for (std::size_t k = 0; k < 3; ++k) {
    text += format("| %s %.4f |", output_names[k], local[k].a);
    for (std::size_t i = 0; i < n_inputs; ++i)
      text += format(" %+.4f |", middle[i] * local[k].v[static_cast<int>(i)] / local[k].a);
    text += "\n";
  }

  // Tornado: one input at its low and its high end, the others in the middle.
  std::vector<std::string> tornado;
  for (std::size_t i = 0; i < n_inputs; ++i) {
    Inputs<double> at = middle;
    at[i] = c.low[i];
    const auto low = outputs(history(at, c));
    at[i] = c.high[i];
    const auto high = outputs(history(at, c));
    tornado.push_back(study::json_object({{"name", json(std::string(names[i]))},
                                          {"low", json(std::vector<double>(low.begin(), low.end()))},
                                          {"high", json(std::vector<double>(high.begin(), high.end()))}}));
  }

  // Global.
  std::vector<History> all = plan(c, rows, seed);
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu_begin = std::clock();
  run_all(c, all, threads);
  const double cpu = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // A few of them by the scalar routines in shorter steps.
  std::array<double, 3> off{};
  for (std::size_t k = 0; k < 50; ++k) {
    const History& h = all[k * (all.size() / 50)];
    Inputs<double> x = h.x;
    x[gamma_input] = c.gamma(h.level);
    const auto y = outputs(history(x, c));
    for (std::size_t j = 0; j < 3; ++j) off[j] = std::max(off[j], std::abs(y[j] - h.y[j]));
  }
  const std::string speed = format(
      "%zu histories of 80 steps in %.2f s on %u threads, %.0f a second (%.2f s of CPU, %.0f a second each)",
      all.size(), seconds, threads, static_cast<double>(all.size()) / seconds, cpu,
      static_cast<double>(all.size()) / cpu);
  text += format(
      "\nSobol's indices: %zu rows, %s.\nTheir lambda_e is off by %.1e at the peak and %.1e at the end, the "
      "force by %.1e at most "
      "(50 of them, in shorter steps).\n",
      rows, speed.c_str(), off[0], off[1], off[2]);
  std::vector<std::string> global;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto f = [&](std::size_t row, std::size_t history) {
      return all[row * (n_inputs + 2) + history].y[k];
    };
    double sum = 0;
    for (const History& h : all) sum += h.y[k];
    const Indices<n_inputs> point(rows, f, sum / static_cast<double>(all.size()),
                                  [](std::size_t j) { return j; });
    if (!myogrowth::is_finite(point.variance))
      throw study::Error(std::string("the variance of the ") + output_names[k] +
                         " is beyond the range of double: expected narrower ranges");
    std::vector<std::array<Interval, 2>> intervals;
    const std::string items = indices_json(rows, f, threads, seed, point, intervals);
    text +=
        format("\n| %s: mean %.4f, sd %.4f | first order | 95 %% | total | 95 %% |\n|---|---|---|---|---|\n",
               output_names[k], point.mean, std::sqrt(point.variance));
    for (std::size_t i = 0; i < n_inputs; ++i)
      text += format("| %s | %.4f | %.4f to %.4f | %.4f | %.4f to %.4f |\n", names[i], point.first[i],
                     intervals[i][0].low, intervals[i][0].high, point.total[i], intervals[i][1].low,
                     intervals[i][1].high);
    global.push_back(study::json_object({{"output", json(std::string(output_names[k]))},
                                         {"mean", json(point.mean)},
                                         {"sd", json(std::sqrt(point.variance))},
                                         {"indices", items}}));
  }
  std::vector<std::string> relative, forces;
  for (std::size_t i = 0; i < n_inputs; ++i) {
    relative.push_back(study::json_array(local_rows, [&](const Row<Jet>& r) {
      return middle[i] * r.lambda_e.v[static_cast<int>(i)] / r.lambda_e.a;
    }));
    forces.push_back(study::json_array(local_rows, [&](const Row<Jet>& r) {
      return middle[i] * r.force.v[static_cast<int>(i)] / r.force.a;
    }));
  }
  out.write("report.md", text + "\n![local](local.png)\n![global](global.png)\n");
  out.write("report.json",
            study::json_object(
                {{"stretch", json(c.stretch)},
                 {"days", json(c.days)},
                 {"names", study::json_array(names, [](const char* name) { return std::string(name); })},
                 {"low", json(std::vector<double>(c.low.begin(), c.low.end()))},
                 {"high", json(std::vector<double>(c.high.begin(), c.high.end()))},
                 {"middle", study::json_array(local, [](const Jet& y) { return y.a; })},
                 {"time", study::json_array(local_rows, [](const Row<Jet>& r) { return r.time; })},
                 {"lambda_e", study::json_array(local_rows, [](const Row<Jet>& r) { return r.lambda_e.a; })},
                 {"relative_lambda_e", study::json_array(relative)},
                 {"relative_force", study::json_array(forces)},
                 {"tornado", study::json_array(tornado)},
                 {"global", study::json_array(global)},
                 {"histories", std::to_string(all.size())},
                 {"seconds", json(seconds)},
                 {"cpu_seconds", json(cpu)},
                 {"off", json(std::vector<double>(off.begin(), off.end()))}}));
  common::print(text + out.last_line());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return study::run([&] { return sensitivity(argc, argv); });
}
