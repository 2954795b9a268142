// Compares protocols of lengthening, and finds the fastest that keeps the elastic stretch below a limit.
//
// Shows from the library: a strip of muscle with free sides under tension (study.hpp, pull: uniaxial_stress
// with the exact flow of eq. 4), and the adaptation function.
#include "../common/study.hpp"
#include "ride.hpp"

namespace {

using study::format;
using study::json;
using study::Point;

const char* const help = R"(usage: ./run protocol FILE.csv [FILE.csv ...] [OPTIONS]
       ./run protocol --design STRETCH --limit LAMBDA_E [FILE.csv] [OPTIONS]

Pulls a strip of muscle with free sides through every protocol (rows: examples/common/study.hpp; examples/protocols
has some) and compares them, in a table and a figure. With --design: the fastest way to STRETCH on which the elastic
stretch never exceeds LAMBDA_E, with its daily schedule; FILE may set the parameters and the rest length.

  --set NAME=VALUE   a parameter of every protocol: c1 c2 tau gamma G_max lambda_crit tau_rev gamma_rev G_min lambda_crit_rev
  --injury LAMBDA_E  elastic stretch above which time is counted; default 1.1, a number to choose, not a finding
  --within X         time to return: until lambda_e stays below 1 + X; default 0.03
  --rest-length MM   length at stretch 1, for the schedule; default: FILE's, else 100
  --out DIR          folder of the tables and pictures; default out/protocol, with --design out/design
)";

struct Outcome {
  std::string title, name;
  double end_of_lengthening, final_stretch;
  double peak, peak_day;      // of lambda_e
  double above_injury, dose;  // days; their integral of lambda_e - injury [days]
  double returned;            // day; 0: never gone, infinite: not within the run
  double peak_force, final_G, final_lambda_e, final_tendon;
};

/// Day at which a straight line between two points has this lambda_e.
double crossing(const Point& a, const Point& b, double level) {
  return a.time + (b.time - a.time) * (level - a.lambda_e) / (b.lambda_e - a.lambda_e);
}

Outcome judge(const study::Study& s, const std::vector<Point>& run, double injury, double within) {
  Outcome o{
      s.title,          s.name, 0, run.back().stretch, 0, 0, 0, 0, 0, 0, run.back().G, run.back().lambda_e,
      run.back().tendon};
  const double level = 1 + within;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const Point &b = run[i], &a = run[i > 0 ? i - 1 : 0];
    if (b.lambda_e > o.peak) {
      o.peak = b.lambda_e;
      o.peak_day = b.time;
    }
    o.peak_force = std::max(o.peak_force, b.force);
    if (b.stretch > a.stretch) o.end_of_lengthening = b.time;
    const double over_a = a.lambda_e - injury, over_b = b.lambda_e - injury;
    if (over_a > 0 || over_b > 0) {
      const double from = over_a < 0 ? crossing(a, b, injury) : a.time;
      const double to = over_b < 0 ? crossing(a, b, injury) : b.time;
      o.above_injury += to - from;
      o.dose += (to - from) * (std::max(over_a, 0.0) + std::max(over_b, 0.0)) / 2;
    }
    if (b.lambda_e > level) {
      o.returned = std::numeric_limits<double>::infinity();
    } else if (a.lambda_e > level) {
      o.returned = crossing(a, b, level);
    }
  }
  return o;
}

std::string csv(const std::vector<Point>& run) {
  std::string text = "day,stretch,G,lambda_e,force_per_reference_area,lateral_stretch,tendon\n";
  for (const Point& p : run)
    text += format("%.10g,%.8g,%.8g,%.8g,%.8g,%.8g,%.8g\n", p.time, p.stretch, p.G, p.lambda_e, p.force,
                   p.lateral, p.tendon);
  return text;
}

std::string json_of(const std::vector<Point>& run) {
  const auto column = [&](double Point::*member) {
    return study::json_array(run, [member](const Point& p) { return p.*member; });
  };
  return study::json_object({{"time", column(&Point::time)},
                             {"stretch", column(&Point::stretch)},
                             {"G", column(&Point::G)},
                             {"lambda_e", column(&Point::lambda_e)},
                             {"force", column(&Point::force)},
                             {"tendon", column(&Point::tendon)}});
}

/// A line that names the rows of a study that are not used here; empty if all are.
std::string not_used(const study::Study& s, bool history_is) {
  std::string rows;
  if (!history_is && s.knots.size() > 1) rows += "its history, ";
  if (!s.fitted.empty()) rows += "its rows 'fit', ";
  if (!s.measurements.empty()) rows += "its measurements, ";
  return rows.empty() ? "" : "\nNot used of " + s.name + ": " + rows.substr(0, rows.size() - 2) + ".\n";
}

int compare(const study::Options& options) {
  for (const char* name : {"limit", "rest-length"}) {
    if (options.has(name)) throw study::Error(std::string("--") + name + ": expected only with --design");
  }
  const double injury = options.number("injury", 1.1, 0), within = options.number("within", 0.03, 0);
  std::vector<study::Study> protocols;
  std::vector<std::string> names{"report.md", "report.json", "protocols.png"};
  double end = 0;
  for (const std::string& file : options.files) {
    protocols.push_back(study::read(file, options));
    const study::Study& read = protocols.back();
    if (read.knots.size() < 2) throw study::Error(file + ": expected a row step, ramp, hold or distract");
    for (const study::Study& other : protocols) {
      if (&other != &read && other.name == read.name)
        throw study::Error(file + ": expected another name than that of a file before");
    }
    names.push_back(read.name + ".csv");
    end = std::max(end, read.knots.back().time);
  }
  // All end on the same day, so that they can be compared.
  std::vector<std::vector<study::Knot>> points;
  std::size_t steps = 0;
  for (const study::Study& s : protocols) {
    points.push_back(study::cut(s.knots, {end}, 0.002, 0.02, s.name));
    if ((steps += points.back().size()) > study::most_steps)
      throw study::Error(s.name + ": more than " + std::to_string(study::most_steps) +
                         " time steps with the protocols before it: expected fewer in one run");
  }
  const study::Folder out(options.text("out", "out/protocol"), names, options.files);
  std::string text = format(
      "| protocol | lengthened by day | peak lambda_e | on day | days above %g | dose above it [days] | "
      "below %g from day | peak force | G at the end | tendon at the end "
      "|\n|---|---|---|---|---|---|---|---|---|---|\n",
      injury, 1 + within);
  std::vector<std::string> items;
  for (std::size_t i = 0; i < protocols.size(); ++i) {
    const study::Study& s = protocols[i];
    const auto run = study::pull(s.muscle, s.tendon, points[i], s.name);
    const Outcome o = judge(s, run, injury, within);
    out.write(s.name + ".csv", csv(run));
    const std::string returned = !std::isfinite(o.returned) ? "never"
                                 : o.returned > 0           ? format("%.2f", o.returned)
                                                            : "always";
    text += format("| %s | %.2f | %.4f | %.2f | %.3f | %.5f | %s | %.4f | %.4f | %.4f |\n",
                   study::cell(o.title).c_str(), o.end_of_lengthening, o.peak, o.peak_day, o.above_injury,
                   o.dose, returned.c_str(), o.peak_force, o.final_G, o.final_tendon);
    items.push_back(study::json_object({{"name", json(o.name)},
                                        {"title", json(o.title)},
                                        {"end_of_lengthening", json(o.end_of_lengthening)},
                                        {"final_stretch", json(o.final_stretch)},
                                        {"peak_lambda_e", json(o.peak)},
                                        {"peak_day", json(o.peak_day)},
                                        {"days_above_injury", json(o.above_injury)},
                                        {"dose_above_injury", json(o.dose)},
                                        {"returned", json(o.returned)},
                                        {"peak_force", json(o.peak_force)},
                                        {"final_G", json(o.final_G)},
                                        {"final_lambda_e", json(o.final_lambda_e)},
                                        {"final_tendon", json(o.final_tendon)},
                                        {"run", json_of(run)}}));
  }
  for (const study::Study& s : protocols) text += not_used(s, true);
  out.write("report.md", text + "\n![protocols](protocols.png)\n");
  out.write("report.json", study::json_object({{"injury", json(injury)},
                                               {"within", json(within)},
                                               {"protocols", study::json_array(items)}}));
  common::print(text + out.last_line());
  return 0;
}

// ---- The fastest admissible protocol (docs/studies.md has the proof)

constexpr int most_days = 36500;  // of a schedule
constexpr int most_step_days = 3650;

/// Knots of the same in daily steps: at the start of each day the stretch rises to the limit for the G of
/// then.
std::vector<study::Knot> daily_steps(const myogrowth::FibreGrowth<>& muscle, double limit, double target) {
  std::vector<study::Knot> knots{{0, 1}};
  double G = 1;
  for (int day = 0; day < most_step_days && knots.back().stretch < target; ++day) {
    const double stretch = std::min(target, std::max(limit * G, knots.back().stretch));
    knots.push_back({static_cast<double>(day), stretch});
    knots.push_back({day + 1.0, stretch});
    G = flow_growth(muscle.growth, muscle.removal, G, stretch, 1.0).G;
  }
  return knots;
}

/// Days of the shortest ramp at a constant rate, from stretch 1, that stays within the limit. Infinite:
/// longer than `most`.
double shortest_ramp(const myogrowth::FibreGrowth<>& muscle, double limit, double target, double most) {
  const auto admissible = [&](double days) {
    const auto run = study::pull(
        muscle, {}, study::cut({{0, 1}, {days, target}}, {}, days / 400, 0, "the ramp"), "the ramp");
    return std::all_of(run.begin(), run.end(), [&](const Point& p) { return p.lambda_e <= limit; });
  };
  if (!admissible(most)) return std::numeric_limits<double>::infinity();
  double low = 0, high = most;
  while (high - low > 1e-4 * high) (admissible((low + high) / 2) ? high : low) = (low + high) / 2;
  return high;
}

int design(const study::Options& options) {
  for (const char* name : {"injury", "within"}) {
    if (options.has(name)) throw study::Error(std::string("--") + name + ": not used with --design");
  }
  if (!options.has("limit")) throw study::Error("--design: expected --limit LAMBDA_E with it");
  if (options.files.size() > 1)
    throw study::Error("--design: expected at most one file, for parameters and rest length");
  const double target = options.number("design", 0, 1 + 1e-9, study::most_stretch);
  const double limit = options.number("limit", 0, study::least_stretch, study::most_stretch);
  study::Study s;
  if (options.files.empty()) {
    options.set(s);
    study::check_parameters(s);
  } else {
    s = study::read(options.files[0], options);
  }
  if (s.tendon.length > 0)
    throw study::Error(s.tendon_place +
                       ": expected no tendon with --design: the fastest way is of muscle only");
  const auto& growth = s.muscle.growth;
  const double rest = options.number("rest-length", s.rest_length > 0 ? s.rest_length : 100,
                                     study::least_length, study::most_length);
  if (!(limit > growth.lambda_crit) || !(limit > 1))
    throw study::Error("--limit = " + study::text_of(limit) +
                       ": expected more than 1 and than lambda_crit = " + study::text_of(growth.lambda_crit) +
                       ", or nothing grows");
  const study::Folder out(options.text("out", "out/design"),
                          {"report.md", "report.json", "design.png", "schedule.csv", "fastest.csv"},
                          options.files);

  const study::Ride ride{growth, limit};
  const double days = ride.day(target);
  if (!(days <= most_days)) {
    const bool ends = growth.gamma < 1;
    common::print(target < limit * growth.G_max
                      ? format("The fastest way to stretch %g with lambda_e <= %g takes %g days, more than "
                               "the %d that are\n"
                               "planned here. Allow a larger lambda_e, or ask for less.\n",
                               target, limit, days, most_days)
                      : format("No protocol reaches stretch %g with lambda_e <= %g: the muscle grows to "
                               "G_max = %g at most, "
                               "and so\nto stretch %g x %g = %g%s. Allow lambda_e > %.5g, or ask for less.\n",
                               target, limit, growth.G_max, limit, growth.G_max, limit * growth.G_max,
                               ends ? "" : ", which it nears without an end", target / growth.G_max));
    return 1;
  }

  // The ride as a history: knots on the closed form, close enough for straight lines between them.
  std::vector<study::Knot> knots{{0, 1}, {0, std::min(limit, target)}};
  constexpr int pieces = 400;
  for (int i = 1; i <= pieces && days > 0; ++i) {
    const double part = static_cast<double>(i) / pieces, t = days * part * part;  // closer at the start
    knots.push_back({t, limit * ride.G(t)});
  }
  const double after = std::max(days, 14.0);
  const auto run = study::pull(
      s.muscle, {}, study::cut(knots, {days + after}, days > 0 ? days / 4000 : 0.01, 0.02, "the fastest"),
      "the fastest");
  double peak = 0, off = 0;
  for (const Point& p : run) {
    peak = std::max(peak, p.lambda_e);
    if (p.time <= days) off = std::max(off, std::abs(p.G - ride.G(p.time)));
  }
  auto step_knots = daily_steps(s.muscle, limit, target);
  const bool steps_arrive = step_knots.back().stretch >= target;
  const double step_days = step_knots[step_knots.size() - 2].time;
  const auto step_run =
      study::pull(s.muscle, {}, study::cut(step_knots, {days + after}, 0.002, 0.02, "the daily steps"),
                  "the daily steps");
  double step_peak = 0;
  for (const Point& p : step_run) step_peak = std::max(step_peak, p.lambda_e);
  const double ramp_days = days > 0 ? shortest_ramp(s.muscle, limit, target, 100 * days) : 0;

  std::string text =
      format("Stretch %g, %g mm of %g mm, with lambda_e <= %g\n\n", target, rest * (target - 1), rest, limit);
  text += "| protocol | days | peak lambda_e |\n|---|---|---|\n";
  text += format("| fastest: at once to %g, then riding the limit (closed form) | %.4f | %g |\n",
                 std::min(limit, target), days, std::min(limit, target));
  text += format("| the same, simulated: G off by %.1e at most | %.4f | %.6f |\n", off, days, peak);
  text += steps_arrive
              ? format("| in steps once a day, up to the limit each | %.0f | %.6f |\n", step_days, step_peak)
              : format("| in steps once a day, up to the limit each | not within %d | |\n", most_step_days);
  text +=
      std::isfinite(ramp_days)
          ? format("| at a constant rate, the shortest that is admissible | %.4f | %g |\n", ramp_days,
                   std::min(limit, target))
          : std::string(
                "| at a constant rate, the shortest that is admissible | more than 100 times the fastest | "
                "|\n");
  if (!options.files.empty()) text += not_used(s, false);

  std::string schedule =
      "day,fastest_stretch,fastest_mm,fastest_mm_this_day,steps_stretch,steps_mm,steps_mm_this_day\n";
  double last = 0, last_step = 0;
  const int last_day = static_cast<int>(std::ceil(std::max(days, steps_arrive ? step_days : 0)));
  const auto stretch_of_steps = [&](int day) {
    const std::size_t i = 1 + 2 * static_cast<std::size_t>(day);
    return i < step_knots.size() ? step_knots[i].stretch : step_knots.back().stretch;
  };
  for (int day = 0; day <= last_day; ++day) {
    const double a = std::min(target, limit * ride.G(std::min(static_cast<double>(day), days)));
    const double b = stretch_of_steps(day), mm = rest * (a - 1), step_mm = rest * (b - 1);
    schedule +=
        format("%d,%.6f,%.4f,%.4f,%.6f,%.4f,%.4f\n", day, a, mm, mm - last, b, step_mm, step_mm - last_step);
    last = mm;
    last_step = step_mm;
  }
  out.write("schedule.csv", schedule);
  out.write("report.md", text + "\n![design](design.png)\n");
  out.write("fastest.csv", csv(run));
  out.write("report.json", study::json_object({{"target", json(target)},
                                               {"limit", json(limit)},
                                               {"days", json(days)},
                                               {"peak", json(peak)},
                                               {"G_off", json(off)},
                                               {"step_days", json(steps_arrive ? step_days : NAN)},
                                               {"step_peak", json(step_peak)},
                                               {"ramp_days", json(ramp_days)},
                                               {"rest_length", json(rest)},
                                               {"run", json_of(run)},
                                               {"steps", json_of(step_run)}}));
  common::print(text + "\nlengths day by day: " + out.path("schedule.csv") + out.last_line());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return study::run([&] {
    const study::Options options(argc, argv, help,
                                 {"injury", "within", "design", "limit", "rest-length", "out"}, {"set"});
    if (options.has("design")) return design(options);
    if (options.files.empty()) throw study::Error("expected a file, or --design (--help says more)");
    return compare(options);
  });
}
