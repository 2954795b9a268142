// Finds parameters of the growth law from measured sarcomere lengths or numbers: least squares by Ceres
// Solver.
//
// Shows from the library: eq. 4's time step with a dual number as its scalar. A Jet for every parameter
// goes in, and the derivatives of the whole history with respect to tau, gamma, G_max and lambda_crit come
// out (study.hpp, grow); nothing is differentiated by hand or by differences.
#include <ceres/ceres.h>
#if __has_include(<glog/logging.h>)
#include <glog/logging.h>
#endif

#include <Eigen/SVD>
#include <array>
#include <random>

#include "../common/jet.hpp"
#include "../common/study.hpp"

namespace {

using study::format;
using study::json;
using study::n_fit;

const char* const help = R"(usage: ./run fit FILE.csv [FILE.csv ...] [OPTIONS]

Fits parameters of the growth law to measurements under a given history of stretch. FILE holds both, and which
parameters to fit between which bounds (rows: examples/common/study.hpp; examples/identification has some).
Without a `fit` row nothing is fitted: the prediction is compared with the measurements. Several files are fitted
together, each with its own history; the parameters, and what is to be fitted, are those of the first.

  --set NAME=VALUE   a parameter (start of its fit): c1 c2 tau gamma G_max lambda_crit tau_rev gamma_rev G_min lambda_crit_rev
  --robust SD        residuals beyond SD standard deviations count linearly (Huber); default: squares only
  --starts N         fits from N starts, the first from the values set, the others at random; default 8
  --coverage RUNS    takes the values set as true, generates random measurements at the days and with the deviations
                     of FILE, RUNS times, and prints how often the 95 % intervals contain the true values
  --design DAYS      plans an experiment: which DAYS (1 to 4) of the history, and how many subjects, tell the parameters
                     that are set from --against NAME=VALUE, one of those fitted, the others fitted again; simulated
                     with --coverage RUNS, default 200
  --noise SD         scatter of lambda_e between subjects; default 0.07 (Chen et al. 2016: 0.21 of 2.84 um)
  --power P          how often the difference is to be found at the 5 % level; default 0.9
  --seed N           of all random numbers; default 1
  --out DIR          folder of report.json, report.md and the pictures; default out/fit/NAME OF FILE
)";

constexpr double chi2_95 = 3.841458820694124;  // of one degree of freedom
constexpr double z_95 = 1.959963984540054;
constexpr long most_seed = 4294967295;

/// What can be fitted, in the order of study.hpp.
using Values = std::array<double, n_fit>;

/// The history for the parameters that were asked for last: all measurements ask for the same, in turn.
template <class T>
struct Curve {
  Values at{};
  std::vector<T> G;
};

/// What is measured, and at which of all points.
struct Measured {
  study::Measurement what;
  std::size_t at;
  double value;  // measured, or made up
};

/// The law for some values: in numbers of the type T.
template <class T>
struct Law {
  myogrowth::GrowthRate<T> growth;
  myogrowth::RemovalRate<T> removal;
  T amplitude;

  template <class Get>
  explicit Law(const Get& v)
      : growth{v(0), v(1), v(2), v(3)}, removal{v(4), v(5), v(6), v(7)}, amplitude(v(study::amplitude)) {}
};

/// The data of a fit, without its parameters.
struct Question {
  const std::vector<study::Study>& studies;      // the first has the parameters, and what is fitted
  std::vector<std::vector<study::Knot>> points;  // the histories, cut into steps that end at measurements too
  std::vector<Measured> measured;                // `at` counts through all histories
  double robust;                                 // [sd]; 0: squares
  mutable Curve<double> numbers{};
  mutable Curve<ceres::Jet<double, n_fit>> jets{};

  const study::Study& first() const { return studies[0]; }
  const std::vector<study::Bounds>& fitted() const { return studies[0].fitted; }

  Curve<double>& curve(double) const { return numbers; }
  Curve<ceres::Jet<double, n_fit>>& curve(const ceres::Jet<double, n_fit>&) const { return jets; }

  /// The history of a point, and the point there.
  std::size_t part_of(std::size_t at, std::size_t* within = nullptr) const {
    std::size_t part = 0;
    while (at >= points[part].size()) at -= points[part++].size();
    if (within) *within = at;
    return part;
  }
  const study::Knot& point(std::size_t at) const {
    std::size_t within;
    const std::size_t part = part_of(at, &within);
    return points[part][within];
  }

  /// What the law gives for measurement i; in T's derivatives too, which Ceres always asks for with respect
  /// to all values.
  template <class T>
  T computed(const T* x, std::size_t i) const {
    using myogrowth::value;
    Values asked;
    for (std::size_t p = 0; p < n_fit; ++p) asked[p] = value(x[p]);
    Curve<T>& known = curve(x[0]);
    const Law<T> law([&](std::size_t p) { return x[p]; });
    if (known.at != asked || known.G.empty()) {
      known.G.clear();
      for (const auto& part : points) {
        const auto G = study::grow(law.growth, law.removal, law.amplitude, part);
        known.G.insert(known.G.end(), G.begin(), G.end());
      }
      known.at = asked;
    }
    const Measured& m = measured[i];
    const T G = known.G[m.at];
    return m.what.of == study::Quantity::G ? G : T(study::scaled(point(m.at).stretch, law.amplitude) / G);
  }
};

/// One measurement: (computed - measured)/sd, for plain numbers and Jets.
struct Residual {
  const Question& question;
  std::size_t i;

  template <class T>
  bool operator()(const T* x0, const T* x1, const T* x2, const T* x3, const T* x4, const T* x5, const T* x6,
                  const T* x7, const T* x8, T* residual) const {
    const std::array<T, n_fit> x{*x0, *x1, *x2, *x3, *x4, *x5, *x6, *x7, *x8};
    const Measured& m = question.measured[i];
    *residual = (question.computed(x.data(), i) - m.value) / m.what.sd;
    return true;
  }
};

using Free = std::array<bool, n_fit>;

/// Ceres's problem for some values: those not free are held.
struct Problem {
  Values values;
  ceres::Problem ceres;

  Problem(const Question& question, const Values& start, const Free& free) : values(start) {
    for (std::size_t i = 0; i < question.measured.size(); ++i) {
      using Cost = ceres::AutoDiffCostFunction<Residual, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1>;
      auto* cost = new Cost(new Residual{question, i});
      ceres::LossFunction* loss = question.robust > 0 ? new ceres::HuberLoss(question.robust) : nullptr;
      std::vector<double*> blocks;
      for (double& x : values) blocks.push_back(&x);
      ceres.AddResidualBlock(cost, loss, blocks);
    }
    for (std::size_t p = 0; p < n_fit; ++p) {
      if (!free[p]) ceres.SetParameterBlockConstant(&values[p]);
    }
    for (const study::Bounds& b : question.fitted()) {
      double* x = &values[b.index];
      *x = std::min(std::max(*x, b.lower), b.upper);
      if (ceres.IsParameterBlockConstant(x)) continue;
      ceres.SetParameterLowerBound(x, 0, b.lower);
      ceres.SetParameterUpperBound(x, 0, b.upper);
    }
  }
};

struct Fit {
  Values values;
  double chi2;  // sum of squared residuals, or what Huber's loss makes of it
};

std::string text_of(const Values& values) {
  std::string text;
  for (std::size_t i = 0; i < n_fit; ++i)
    text += (i > 0 ? ", " : "") + format("%s = %.10g", study::Bounds{i, 0, 1, ""}.name(), values[i]);
  return text;
}

Fit minimise(const Question& question, const Values& start, const Free& free) {
  Problem problem(question, start, free);
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  if (std::find(free.begin(), free.end(), true) != free.end()) {
    ceres::Solve(options, &problem.ceres, &summary);
    if (!summary.IsSolutionUsable())
      throw study::Error("no fit from " + text_of(start) +
                         ", or near it: results or derivatives are not finite: expected "
                         "narrower bounds");
  }
  double cost;
  if (!problem.ceres.Evaluate({}, &cost, nullptr, nullptr, nullptr) || !std::isfinite(cost))
    throw study::Error("no finite result for " + text_of(problem.values));
  return {problem.values, 2 * cost};
}

/// Fits from several starts within the bounds, the first given. All fits, the best first.
/// progress: whether to print it.
std::vector<Fit> fits_from_starts(const Question& question, const Values& first, const Free& free,
                                  long starts, std::mt19937_64& random, bool progress) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Fit> fits{minimise(question, first, free)};
  for (long s = 1; s < starts && !question.fitted().empty(); ++s) {
    if (progress) study::show_progress("\r  start %ld of %ld", s + 1, starts);
    Values start = first;
    for (const study::Bounds& b : question.fitted()) {
      start[b.index] = b.at(unit(random));
    }
    fits.push_back(minimise(question, start, free));
  }
  std::stable_sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) { return a.chi2 < b.chi2; });
  return fits;
}

/// Derivatives of the residuals with respect to the fitted parameters, by Ceres from the Jets.
Eigen::MatrixXd jacobian(const Question& question, const Values& values, const Free& free) {
  if (question.fitted().empty()) return {};
  Problem problem(question, values, free);
  ceres::Problem::EvaluateOptions options;
  for (const study::Bounds& b : question.fitted())
    options.parameter_blocks.push_back(&problem.values[b.index]);
  ceres::CRSMatrix sparse;
  problem.ceres.Evaluate(options, nullptr, nullptr, nullptr, &sparse);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (std::size_t row = 0; row < static_cast<std::size_t>(sparse.num_rows); ++row) {
    for (int k = sparse.rows[row]; k < sparse.rows[row + 1]; ++k) {
      const auto entry = static_cast<std::size_t>(k);
      J(static_cast<Eigen::Index>(row), sparse.cols[entry]) = sparse.values[entry];
    }
  }
  return J;
}

/// What the curvature at the estimate says. Where the data leave a combination of parameters undetermined,
/// the covariance does not exist and every entry is infinite or NaN.
struct Covariance {
  Eigen::MatrixXd covariance, correlation;
  bool exists;
  std::vector<std::string> undetermined;  // parameters in the combination

  Covariance(const Eigen::MatrixXd& J, const std::vector<study::Bounds>& fitted) {
    const Eigen::Index n = J.cols();
    exists = n == 0;
    if (exists) return;
    // Columns of length 1, so that units do not matter.
    Eigen::VectorXd length = J.colwise().norm().transpose();
    Eigen::MatrixXd scaled = J;
    for (Eigen::Index i = 0; i < n; ++i) {
      // Between its bounds it changes nothing but rounding.
      const study::Bounds& b = fitted[static_cast<std::size_t>(i)];
      if (length[i] * (b.upper - b.lower) < 1e-9) {
        length[i] = 1;
        scaled.col(i).setZero();
      }
      scaled.col(i) /= length[i];
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled, Eigen::ComputeFullV);
    Eigen::VectorXd s = Eigen::VectorXd::Zero(n);
    s.head(svd.singularValues().size()) = svd.singularValues();
    exists = s[n - 1] > 1e-7 * s[0];
    covariance = correlation = Eigen::MatrixXd::Constant(n, n, std::numeric_limits<double>::quiet_NaN());
    if (!exists) {
      for (Eigen::Index i = 0; i < n; ++i) {
        if (std::abs(svd.matrixV()(i, n - 1)) > 1e-3)
          undetermined.push_back(fitted[static_cast<std::size_t>(i)].name());
      }
      return;
    }
    const Eigen::MatrixXd half =
        length.cwiseInverse().asDiagonal() * svd.matrixV() * s.cwiseInverse().asDiagonal();
    covariance = half * half.transpose();
    const Eigen::VectorXd per_sd = covariance.diagonal().cwiseSqrt().cwiseInverse();
    correlation = per_sd.asDiagonal() * covariance * per_sd.asDiagonal();
  }
};

/// The least chi2 with one parameter held, along that parameter.
struct Profile {
  std::vector<double> x, chi2_more;  // chi2 above the minimum
  double lower, upper;               // where it is chi2_95; infinite: nowhere within the bounds
};

/// One side of a profile, from the estimate to `end`: every fit starts from its neighbour's, on the way out
/// and on the way back, since there may be two valleys.
std::vector<Fit> profile_side(const Question& question, const Fit& best, const Free& others, std::size_t p,
                              double end) {
  constexpr int n = 20;
  const double x0 = best.values[p];
  const bool by_factors = end > 0 && x0 > 0 && (end > 4 * x0 || x0 > 4 * end);
  std::vector<Fit> side;
  Fit last = best;
  for (int i = 1; i <= n && last.chi2 - best.chi2 < 5 * chi2_95; ++i) {
    const double part = static_cast<double>(i) / n;
    last.values[p] = by_factors ? x0 * std::pow(end / x0, part) : x0 + (end - x0) * part;
    last = minimise(question, last.values, others);
    side.push_back(last);
  }
  for (std::size_t i = side.size(); i > 1; --i) {
    Values from_outside = side[i - 1].values;
    from_outside[p] = side[i - 2].values[p];
    const Fit again = minimise(question, from_outside, others);
    if (again.chi2 < side[i - 2].chi2) side[i - 2] = again;
  }
  return side;
}

/// Where a side rises through chi2_95 for the last time; infinite: it ends below.
double end_of_interval(const Fit& best, const std::vector<Fit>& side, std::size_t p) {
  const auto root = [&](const Fit& f) { return std::sqrt(std::max(f.chi2 - best.chi2, 0.0)); };
  const double wanted = std::sqrt(chi2_95);
  if (side.empty() || root(side.back()) < wanted) return std::numeric_limits<double>::infinity();
  std::size_t i = side.size() - 1;
  while (i > 0 && root(side[i - 1]) >= wanted) --i;
  const Fit &in = i > 0 ? side[i - 1] : best, &out = side[i];
  return in.values[p] + (out.values[p] - in.values[p]) * (wanted - root(in)) / (root(out) - root(in));
}

/// sd: by curvature, for where to look first.
Profile profile(const Question& question, const Fit& best, const Free& free, const study::Bounds& bounds,
                double sd) {
  const auto p = bounds.index;
  const double x0 = best.values[p], reach = 5 * sd;
  Free others = free;
  others[p] = false;
  const auto look = [&](double bound, double& end) {
    const bool near = std::abs(bound - x0) > reach;
    auto side = profile_side(question, best, others, p, near ? x0 + std::copysign(reach, bound - x0) : bound);
    end = end_of_interval(best, side, p);
    if (near && !std::isfinite(end)) {
      side = profile_side(question, best, others, p, bound);
      end = end_of_interval(best, side, p);
    }
    return side;
  };
  Profile result;
  std::vector<Fit> all = look(bounds.lower, result.lower), high = look(bounds.upper, result.upper);
  std::reverse(all.begin(), all.end());
  all.push_back(best);
  all.insert(all.end(), high.begin(), high.end());
  for (const Fit& f : all) {
    result.x.push_back(f.values[p]);
    result.chi2_more.push_back(f.chi2 - best.chi2);
  }
  return result;
}

Question question_of(const std::vector<study::Study>& studies, double robust) {
  Question q{studies, {}, {}, robust, {}, {}};
  std::size_t begin = 0;
  for (const study::Study& data : studies) {
    std::vector<double> stops;
    for (const auto& m : data.measurements) stops.push_back(m.time);
    q.points.push_back(study::cut(data.knots, stops, 0.002, 0.06, data.name));
    const auto& points = q.points.back();
    for (const auto& m : data.measurements) {
      // The last point of that time: after a step, if there is one.
      std::size_t i = points.size();
      while (points[i - 1].time > m.time + 1e-9) --i;
      q.measured.push_back({m, begin + i - 1, m.value});
    }
    begin += points.size();
  }
  return q;
}

/// By how many sd the results change at most if every time step is halved.
double error_of_steps(const Question& q, const Values& v) {
  Question halved = q;
  halved.numbers = {};
  std::size_t begin = 0, more = 0;  // of a history in all points, and how many have been added before it
  for (auto& part : halved.points) {
    const auto points = part;
    part = {points[0]};
    for (std::size_t i = 1; i < points.size(); ++i) {
      const study::Knot &a = points[i - 1], &b = points[i];
      part.push_back({(a.time + b.time) / 2, (a.stretch + b.stretch) / 2});
      part.push_back(b);
    }
    for (std::size_t i = 0; i < q.measured.size(); ++i) {
      const std::size_t at = q.measured[i].at;
      if (at >= begin && at < begin + points.size()) halved.measured[i].at = at + more + (at - begin);
    }
    begin += points.size();
    more += points.size() - 1;
  }
  double most = 0;
  for (std::size_t i = 0; i < q.measured.size(); ++i)
    most = std::max(most,
                    std::abs(halved.computed(v.data(), i) - q.computed(v.data(), i)) / q.measured[i].what.sd);
  return most;
}

/// What the options ask for.
struct Plan {
  double robust;  // [sd]; 0: squares
  long starts, coverage_runs;
};

/// How often the 95 % intervals hold the truth.
int coverage(Question q, const Values& truth, const Free& free, const Plan& plan, std::mt19937_64& random,
             const study::Folder& out) {
  const study::Study& data = q.first();
  const long runs = plan.coverage_runs;
  std::normal_distribution<double> normal;
  std::vector<double> exact;
  for (std::size_t i = 0; i < q.measured.size(); ++i) exact.push_back(q.computed(truth.data(), i));
  std::vector<long> by_curvature(data.fitted.size(), 0), by_profile(data.fitted.size(), 0);
  std::vector<double> sum(data.fitted.size(), 0);
  for (long run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < exact.size(); ++i)
      q.measured[i].value = exact[i] + q.measured[i].what.sd * normal(random);
    Values middle = truth;
    for (const study::Bounds& b : data.fitted) middle[b.index] = (b.lower + b.upper) / 2;
    const Fit best = fits_from_starts(q, middle, free, plan.starts, random, false)[0];
    const Covariance c(jacobian(q, best.values, free), data.fitted);
    for (std::size_t k = 0; k < data.fitted.size(); ++k) {
      const auto p = data.fitted[k].index;
      const auto d = static_cast<Eigen::Index>(k);
      if (c.exists && std::abs(best.values[p] - truth[p]) <= z_95 * std::sqrt(c.covariance(d, d)))
        ++by_curvature[k];
      Values held = best.values;
      held[p] = truth[p];
      Free others = free;
      others[p] = false;
      if (minimise(q, held, others).chi2 - best.chi2 <= chi2_95) ++by_profile[k];
      sum[k] += best.values[p];
    }
    if (run % 20 == 19) study::show_progress("\r  %ld of %ld runs", run + 1, runs);
  }
  study::show_progress("%s", "\n");
  std::vector<std::string> items;
  std::string text =
      format("%ld runs, %zu measurements each\n%-12s %10s %12s %26s %26s\n", runs, exact.size(), "parameter",
             "truth", "mean found", "held by curvature's 95 %", "held by profile's 95 %");
  for (std::size_t k = 0; k < data.fitted.size(); ++k) {
    const auto p = data.fitted[k].index;
    const double n = static_cast<double>(runs), mean = sum[k] / n;
    text +=
        format("%-12s %10.5g %12.5g %24.1f %% %24.1f %%\n", data.fitted[k].name(), truth[p], mean,
               100 * static_cast<double>(by_curvature[k]) / n, 100 * static_cast<double>(by_profile[k]) / n);
    items.push_back(study::json_object({{"name", json(std::string(data.fitted[k].name()))},
                                        {"truth", json(truth[p])},
                                        {"mean", json(mean)},
                                        {"by_curvature", std::to_string(by_curvature[k])},
                                        {"by_profile", std::to_string(by_profile[k])}}));
  }
  out.write("coverage.json",
            study::json_object({{"runs", std::to_string(runs)}, {"parameters", study::json_array(items)}}));
  common::print(text);
  return 0;
}

/// What an experiment is to tell, and how well.
struct Design {
  std::size_t parameter;  // its truth is what is set
  double against, noise, z_power;
  long days;
};

/// How many sd^2 the best fit with the other value is away, for one subject measured on these days.
double distance(const study::Study& data, const std::vector<double>& days, const Design& d,
                const Values& truth, const Free& free) {
  std::vector<study::Study> one{data};
  one[0].measurements.clear();
  for (double day : days) one[0].measurements.push_back({day, study::Quantity::lambda_e, 1, d.noise});
  Question q = question_of(one, 0);
  for (std::size_t i = 0; i < q.measured.size(); ++i) q.measured[i].value = q.computed(truth.data(), i);
  Values other = truth;
  other[d.parameter] = d.against;
  Free others = free;
  others[d.parameter] = false;
  return minimise(q, other, others).chi2;
}

/// Which days tell most, chosen one after the other, and how many subjects they need.
int design(const study::Study& data, const Values& truth, const Free& free, const Design& d, long runs,
           std::mt19937_64& random, const study::Folder& out) {
  constexpr int n = 40;
  const double end = data.knots.back().time;
  std::vector<double> candidates, days;
  for (int i = 1; i <= n; ++i) candidates.push_back(end * std::pow(static_cast<double>(i) / n, 2));
  double best = 0;
  for (long k = 0; k < d.days; ++k) {
    double chosen = 0, most = best;
    for (double day : candidates) {
      if (std::count(days.begin(), days.end(), day) > 0) continue;
      auto with = days;
      with.push_back(day);
      const double found = distance(data, with, d, truth, free);
      if (found > most * (1 + 1e-9)) {
        most = found;
        chosen = day;
      }
    }
    if (!(chosen > 0)) break;
    days.push_back(chosen);
    best = most;
  }
  std::sort(days.begin(), days.end());
  const char* const name = study::Bounds{d.parameter, 0, 1, ""}.name();
  const double needed = std::pow(z_95 + d.z_power, 2) / best;
  if (!(needed < 1e6)) {
    common::print(format("No %ld days of this history tell %s = %g from %g, the others fitted again.\n",
                         d.days, name, truth[d.parameter], d.against));
    return 1;
  }
  const double subjects = std::max(1.0, std::ceil(needed));
  // The same, simulated: the mean of so many subjects on each day.
  std::vector<study::Study> made{data};
  made[0].measurements.clear();
  const double sd = d.noise / std::sqrt(subjects);
  for (double day : days) made[0].measurements.push_back({day, study::Quantity::lambda_e, 1, sd});
  Question q = question_of(made, 0);
  std::vector<double> exact;
  for (std::size_t i = 0; i < q.measured.size(); ++i) exact.push_back(q.computed(truth.data(), i));
  std::normal_distribution<double> normal;
  long told = 0;
  Free others = free;
  others[d.parameter] = false;
  for (long run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < exact.size(); ++i) q.measured[i].value = exact[i] + sd * normal(random);
    Values other = truth;
    other[d.parameter] = d.against;
    told += minimise(q, other, others).chi2 - minimise(q, truth, free).chi2 > chi2_95;
  }
  const double found = static_cast<double>(told) / static_cast<double>(runs);
  std::string list;
  for (double day : days) list += (list.empty() ? "" : ", ") + format("%.3g", day);
  const std::string text = format(
      "%s = %g against %g, scatter of lambda_e %g: %.0f subjects, measured on day %s.\n"
      "Simulated %ld times: told apart in %.1f %%.\n",
      name, truth[d.parameter], d.against, d.noise, subjects, list.c_str(), runs, 100 * found);
  out.write("design.json", study::json_object({{"days", json(days)},
                                               {"subjects", json(subjects)},
                                               {"distance", json(best)},
                                               {"told", json(found)}}));
  common::print(text);
  return 0;
}

/// The fit, its intervals and what they are worth.
int estimate(const Question& q, const Values& given, const Free& free, const Plan& plan,
             std::mt19937_64& random, const study::Folder& out) {
  const study::Study& data = q.first();
  const std::vector<Fit> fits = fits_from_starts(q, given, free, plan.starts, random, true);
  const Fit& best = fits[0];
  const auto same = [&](const Fit& f) { return f.chi2 <= best.chi2 + 1e-6 * (1 + best.chi2); };
  const auto agreeing = std::count_if(fits.begin(), fits.end(), same);
  const Covariance c(jacobian(q, best.values, free), data.fitted);
  const auto n = static_cast<long>(q.measured.size()), k = static_cast<long>(data.fitted.size());

  std::string text = "# " + data.title + "\n\n";
  std::vector<std::string> warnings, parameters, points, correlation, covariance;
  text += format("%ld measurements, %ld parameters fitted; chi2 = %.3f", n, k, best.chi2);
  if (k > 0) text += format("; %ld of %zu starts end there", static_cast<long>(agreeing), fits.size());
  text += ".\n\n";

  std::string ignored;
  for (std::size_t i = 1; i < q.studies.size(); ++i) {
    if (!q.studies[i].given.empty() || !q.studies[i].fitted.empty())
      ignored += (ignored.empty() ? "" : ", ") + q.studies[i].name;
  }
  if (!ignored.empty()) text += "Not used: the rows 'set' and 'fit' of " + ignored + ".\n\n";

  if (k > 0)
    text +=
        "| parameter | estimate | sd | 95 % by curvature | 95 % by profile likelihood | bounds "
        "|\n|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < data.fitted.size(); ++i) {
    const study::Bounds& b = data.fitted[i];
    const auto d = static_cast<Eigen::Index>(i);
    const double x = best.values[b.index], sd = std::sqrt(c.covariance(d, d));
    study::show_progress("\r  profile of %-12s", b.name());
    const Profile along = profile(q, best, free, b, sd);
    // A curvature of next to nothing is no interval.
    const auto end = [&](double y) {
      return std::isfinite(y) && std::abs(y) < 100 * b.upper ? format("%.5g", y) : std::string("open");
    };
    text += format("| %s | %.5g | %s | %s to %s | %s to %s | %g to %g |\n", b.name(), x, end(sd).c_str(),
                   end(x - z_95 * sd).c_str(), end(x + z_95 * sd).c_str(), end(along.lower).c_str(),
                   end(along.upper).c_str(), b.lower, b.upper);
    if (b.part(x) < 1e-6 || b.part(x) > 1 - 1e-6)
      warnings.push_back(
          format("%s ends at a bound, %.5g: its interval by curvature means nothing.", b.name(), x));
    if (!std::isfinite(along.lower) || !std::isfinite(along.upper))
      warnings.push_back(format("The data do not bound %s %s between %g and %g.", b.name(),
                                std::isfinite(along.lower)   ? "from above"
                                : std::isfinite(along.upper) ? "from below"
                                                             : "at all",
                                b.lower, b.upper));
    parameters.push_back(study::json_object({{"name", json(std::string(b.name()))},
                                             {"estimate", json(x)},
                                             {"sd", json(sd)},
                                             {"lower", json(along.lower)},
                                             {"upper", json(along.upper)},
                                             {"bounds", json(std::vector<double>{b.lower, b.upper})},
                                             {"profile_x", json(along.x)},
                                             {"profile", json(along.chi2_more)}}));
  }
  if (k > 0) study::show_progress("%s", "\n");
  if (!c.exists) {
    std::string names;
    for (const std::string& name : c.undetermined) names += (names.empty() ? "" : ", ") + name;
    warnings.push_back(c.undetermined.size() == 1
                           ? "The data say nothing of " + names + "."
                           : "The data cannot tell " + names + " apart: a combination of them is free.");
  }
  for (Eigen::Index i = 0; i < c.correlation.rows(); ++i) {
    std::vector<double> row, covariance_row;
    for (Eigen::Index j = 0; j < c.correlation.cols(); ++j) {
      row.push_back(c.correlation(i, j));
      covariance_row.push_back(c.covariance(i, j));
      if (j < i && std::abs(row.back()) > 0.95)
        warnings.push_back(format("The data can hardly tell %s and %s apart: correlation %.3f.",
                                  data.fitted[static_cast<std::size_t>(j)].name(),
                                  data.fitted[static_cast<std::size_t>(i)].name(), row.back()));
    }
    correlation.push_back(json(row));
    covariance.push_back(json(covariance_row));
  }
  if (agreeing == 1 && fits.size() > 2 && k > 0)
    warnings.push_back(
        format("Of %zu starts only one ends at this fit: there may be better ones (--starts).", fits.size()));
  const double off_steps = error_of_steps(q, best.values);
  if (!(off_steps < 0.2))
    warnings.push_back(
        format("The time steps are too long for these parameters: what is computed is off by %.2g "
               "sd.",
               off_steps));
  for (std::size_t part = 0; part < q.studies.size(); ++part) {
    const auto& knots = q.studies[part].knots;
    const std::size_t last = knots.size() - 1;
    const double end_of_history = knots[last].time, latest = q.points[part].back().time;
    if (latest > end_of_history * (1 + 1e-9) && end_of_history > knots[last - 1].time)
      warnings.push_back(
          format("The history ends on day %g; for the measurements until day %g its last stretch, %g, is "
                 "taken to stay.",
                 end_of_history, latest, knots[last].stretch));
  }
  if (n < k) warnings.push_back(format("%ld measurements cannot decide %ld parameters.", n, k));
  if (n > k && best.chi2 > static_cast<double>(n - k) + 3 * std::sqrt(2.0 * static_cast<double>(n - k)))
    warnings.push_back(format(
        "chi2 = %.1f for %ld degrees of freedom: the law misses the data by more than their deviations, "
        "and the intervals are too narrow.",
        best.chi2, n - k));

  const auto matrix = [&](const char* title, const char* number, const Eigen::MatrixXd& m) {
    text += format("\n| %s |", title);
    std::string rule = "|---|";
    for (const auto& b : data.fitted) {
      text += std::string(" ") + b.name() + " |";
      rule += "---|";
    }
    text += "\n" + rule + "\n";
    for (Eigen::Index row = 0; row < k; ++row) {
      text += std::string("| ") + data.fitted[static_cast<std::size_t>(row)].name() + " |";
      for (Eigen::Index column = 0; column < k; ++column) text += " " + format(number, m(row, column)) + " |";
      text += "\n";
    }
  };
  if (k > 1 && c.exists) {
    matrix("correlation", "%.3f", c.correlation);
    matrix("covariance", "%.4g", c.covariance);
  }
  const bool joint = q.studies.size() > 1;
  text += std::string(joint ? "\n| study " : "\n") +
          "| day | quantity | measured | sd | computed | off by |\n|---|---|---|---|---|---|" +
          (joint ? "---|\n" : "\n");
  for (std::size_t i = 0; i < q.measured.size(); ++i) {
    const study::Measurement& m = q.measured[i].what;
    const std::string& title = q.studies[q.part_of(q.measured[i].at)].title;
    const std::string which = joint ? "| " + study::cell(title) + " " : "";
    const double y = q.computed(best.values.data(), i), off = 100 * (y - m.value) / m.value;
    text += format("%s| %g | %s | %.4f | %.4f | %.4f | %+.2f %% |\n", which.c_str(), m.time,
                   study::text(m.of), m.value, m.sd, y, off);
    points.push_back(study::json_object({{"title", json(title)},
                                         {"day", json(m.time)},
                                         {"quantity", json(std::string(study::text(m.of)))},
                                         {"value", json(m.value)},
                                         {"sd", json(m.sd)},
                                         {"computed", json(y)}}));
  }
  for (const std::string& warning : warnings) text += "\n**Warning:** " + warning + "\n";

  // The history at the estimate, finer than it was fitted with.
  auto muscle = data.muscle;
  const Law<double> law([&](std::size_t p) { return best.values[p]; });
  muscle.growth = law.growth;
  muscle.removal = law.removal;
  auto knots = data.knots;
  for (study::Knot& knot : knots) knot.stretch = study::scaled(knot.stretch, law.amplitude);
  std::vector<double> stops;
  for (const auto& m : data.measurements) stops.push_back(m.time);
  const auto curve = study::pull(muscle, {}, study::cut(knots, stops, 0.002, 0.03, data.name), data.name);
  out.write("report.md", text + (k > 0 ? "\n![fit](fit.png)\n![profiles](profiles.png)\n" : ""));
  out.write("report.json",
            study::json_object(
                {{"title", json(data.title)},
                 {"name", json(data.name)},
                 {"chi2", json(best.chi2)},
                 {"measurements", study::json_array(points)},
                 {"parameters", study::json_array(parameters)},
                 {"values", json(std::vector<double>(best.values.begin(), best.values.end()))},
                 {"starts_agreeing", std::to_string(agreeing)},
                 {"starts", std::to_string(fits.size())},
                 {"correlation", study::json_array(correlation)},
                 {"covariance", study::json_array(covariance)},
                 {"warnings", study::json_array(warnings, [](const std::string& w) { return w; })},
                 {"time", study::json_array(curve, [](const study::Point& p) { return p.time; })},
                 {"lambda_e", study::json_array(curve, [](const study::Point& p) { return p.lambda_e; })},
                 {"G", study::json_array(curve, [](const study::Point& p) { return p.G; })},
                 {"stretch", study::json_array(curve, [](const study::Point& p) { return p.stretch; })}}));
  common::print(text + out.last_line());
  return 0;
}

int fit(int argc, char** argv) {
  const study::Options options(
      argc, argv, help,
      {"robust", "starts", "coverage", "design", "against", "noise", "power", "seed", "out"}, {"set"});
  if (options.files.empty()) throw study::Error("expected a file (--help says more)");
  const std::string& file = options.files[0];
  std::vector<study::Study> studies;
  for (const std::string& one : options.files) {
    if (std::count(options.files.begin(), options.files.end(), one) > 1)
      throw study::Error(one + ": expected each file only once");
    studies.push_back(study::read(one, options));
    const study::Study& read = studies.back();
    if (read.measurements.empty() && !options.has("design"))
      throw study::Error(one + ": expected a row 'measure, DAY, QUANTITY, VALUE, SD'");
    if (read.knots.size() < 2)
      throw study::Error(one + ": expected a row step, ramp, hold, distract or cycle");
    if (read.tendon.length > 0)
      throw study::Error(read.tendon_place + ": expected no tendon: ./run fit is of muscle only");
    for (const study::Measurement& m : read.measurements) {
      if (m.of == study::Quantity::tendon)
        throw study::Error(one + ": expected no measurement of a tendon: ./run fit is of muscle only");
    }
  }
  const study::Study& data = studies[0];
  const Values given = data.start();
  Free free{};
  for (const study::Bounds& b : data.fitted) free[b.index] = true;
  std::mt19937_64 random(static_cast<unsigned long>(options.count("seed", 1, 0, most_seed)));
  const Plan plan{options.number("robust", 0, 1e-3, 1e6),
                  options.count("starts", options.has("coverage") ? 2 : 8, 1, 10000),
                  options.count("coverage", 0, 1, 1000000)};
  for (const char* name : {"against", "noise", "power"}) {
    if (options.has(name) != options.has("design") && (options.has(name) || name == std::string("against")))
      throw study::Error(std::string("--") + name + ": expected only with --design, and --against with it");
  }
  if (plan.coverage_runs > 0 || options.has("design")) {
    if (data.fitted.empty()) throw study::Error(file + ": expected a row 'fit, NAME, LOWER, UPPER'");
    for (const study::Bounds& b : data.fitted) {
      if (!(b.lower <= given[b.index] && given[b.index] <= b.upper))
        throw study::Error(b.place + ": with --coverage or --design " + b.name() + " = " +
                           study::text_of(given[b.index]) +
                           ", which is taken as true, has to be within the bounds");
    }
  }
  if (options.has("design")) {
    if (studies.size() > 1) throw study::Error("--design: expected one file");
    const std::string text = options.text("against", "");
    const std::size_t equals = std::min(text.find('='), text.size());
    Design d{study::n_fit, 0, options.number("noise", 0.07, 1e-6, 10), 0, options.count("design", 2, 1, 4)};
    for (const study::Bounds& b : data.fitted) {
      if (text.substr(0, equals) == b.name()) {
        d.parameter = b.index;
        if (equals == text.size() || !common::to_number(text.substr(equals + 1), d.against) ||
            !(b.lower <= d.against && d.against <= b.upper) || d.against == given[b.index])
          throw study::Error("--against " + study::visible(text) + ": expected NAME=VALUE, a value from " +
                             study::text_of(b.lower) + " to " + study::text_of(b.upper) +
                             " that is not the one set");
      }
    }
    if (d.parameter == study::n_fit)
      throw study::Error("--against " + study::visible(text) +
                         ": expected NAME=VALUE, NAME one of those to be fitted");
    const double power = options.number("power", 0.9, 0.5, 0.999);
    double low = 0, high = 5;  // the normal distribution's quantile
    while (high - low > 1e-12) {
      const double middle = (low + high) / 2;
      (std::erfc(-middle / std::sqrt(2.0)) / 2 < power ? low : high) = middle;
    }
    d.z_power = low;
    const study::Folder out(options.text("out", "out/design-experiment"), {"design.json"}, options.files);
    return design(data, given, free, d, plan.coverage_runs > 0 ? plan.coverage_runs : 200, random, out);
  }
  const Question q = question_of(studies, plan.robust);
  const study::Folder out(options.text("out", "out/fit/" + data.name),
                          {"report.md", "report.json", "coverage.json", "fit.png", "profiles.png"},
                          options.files);
  return plan.coverage_runs > 0 ? coverage(q, given, free, plan, random, out)
                                : estimate(q, given, free, plan, random, out);
}

}  // namespace

int main(int argc, char** argv) {
#if __has_include(<glog/logging.h>)
  FLAGS_minloglevel = google::GLOG_FATAL;  // our errors replace Ceres's log
#endif
  return study::run([&] { return fit(argc, argv); });
}
