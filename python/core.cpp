// What of the law Python calls: the update of arrays where they lie, a history of the C API's uniaxial strip,
// its tables of parameters. python/myogrowth/__init__.py is the face, and checks what comes in.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <climits>
#include <cstddef>
#include <iterator>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <myogrowth.h>

namespace py = pybind11;

namespace {

using Array = py::array_t<double, py::array::c_style>;  // never converted here: what came in is not copied
using AnyOrder = py::array_t<double>;

int props_size(const Array& props) { return static_cast<int>(props.size()); }

/// How far an array goes along its axis, in numbers.
std::ptrdiff_t step(const py::array& a, py::ssize_t axis) {
  return a.strides(axis) / static_cast<std::ptrdiff_t>(sizeof(double));
}

/// Axes of points, the last one fastest.
struct Axis {
  std::ptrdiff_t size, step;
};

/// An input: `n` numbers of a point, the first of them `entry`, where they are from the point's first one on.
/// The points have one axis, or as few as do.
struct Given {
  const double* data;
  std::vector<Axis> axes;
  int n, entry[9], of_memory[9];  ///< of_memory: the entries as they lie side by side, if they do
  std::ptrdiff_t component[9];
  bool is_dense = true;

  /// component: where a point's numbers are.
  Given(const py::array& a, py::ssize_t n_axes_of_components, int first_entry, int size)
      : data(static_cast<const double*>(a.data())), n(size) {
    const py::ssize_t n_axes = a.ndim() - n_axes_of_components;
    for (py::ssize_t i = 0; i < n_axes; ++i) {
      const Axis axis{a.shape(i), step(a, i)};
      if (axis.size == 1) continue;
      if (!axes.empty() && axes.back().step == axis.size * axis.step) {
        axes.back() = {axes.back().size * axis.size, axis.step};
      } else {
        axes.push_back(axis);
      }
    }
    std::fill_n(of_memory, n, -1);
    for (int c = 0; c < n; ++c) {
      entry[c] = first_entry + c;
      component[c] = n_axes_of_components == 0   ? 0
                     : n_axes_of_components == 1 ? c * step(a, n_axes)
                                                 : c % 3 * step(a, n_axes) + c / 3 * step(a, n_axes + 1);
      is_dense = is_dense && component[c] >= 0 && component[c] < n && of_memory[component[c]] < 0;
      if (is_dense) of_memory[component[c]] = entry[c];
    }
  }
  bool has_one_step() const { return axes.size() < 2; }
  const double* at(std::ptrdiff_t point) const {
    const double* p = data;
    for (std::size_t i = axes.size(); i-- > 0; point /= axes[i].size)
      p += point % axes[i].size * axes[i].step;
    return p;
  }
  /// The points from one on, as they lie; or, where they have no one step, `count` of them copied to a
  /// buffer.
  void give(std::ptrdiff_t first, std::ptrdiff_t count, double* buffer,
            std::vector<myogrowth_input>& in) const {
    if (!has_one_step()) {
      for (std::ptrdiff_t k = 0; k < count; ++k) {
        const double* const point = at(first + k);
        for (int c = 0; c < n; ++c) buffer[k * n + c] = point[component[c]];
      }
      in.push_back({buffer, n, n, entry});
      return;
    }
    const std::ptrdiff_t points_step = axes.empty() ? 0 : axes[0].step;
    const double* const from = data + first * points_step;
    if (is_dense) {
      in.push_back({from, points_step, n, of_memory});
    } else {
      for (int c = 0; c < n; ++c) in.push_back({from + component[c], points_step, 1, entry + c});
    }
  }
};

/// The entries of a measure's tensors in NumPy's order: [i, j] and [i, j, k, l].
struct NumpyOrder {
  int stress[9], tangent[81];
  explicit NumpyOrder(int measure) {
    static constexpr int six[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    const bool is_first = measure == MYOGROWTH_FIRST_PIOLA;
    const auto at = [&](int ij) { return is_first ? ij / 3 + 3 * (ij % 3) : six[ij / 3][ij % 3]; };
    for (int ij = 0; ij < 9; ++ij) {
      stress[ij] = MYOGROWTH_STRESS + at(ij);
      for (int kl = 0; kl < 9; ++kl)
        tangent[9 * ij + kl] = MYOGROWTH_TANGENT + at(ij) + myogrowth_stress_size(measure) * at(kl);
    }
  }
};

/// F: (..., 3, 3), G and stretch: (...), n0: (..., 3), in any memory order. The others are written to, in C's
/// order: stress (..., 3, 3), tangent (..., 3, 3, 3, 3) or None, numbers (...): energy and those of the
/// state. Returns how many points have no result.
int update(const Array& props, const AnyOrder& F, const AnyOrder& G, const AnyOrder& stretch,
           const AnyOrder& n0, double dt, int measure, int threads, Array stress, const py::object& tangent,
           Array energy, Array G_end, Array stretch_end, Array n0_end, Array lambda_e, Array J, Array Je,
           py::array_t<int, py::array::c_style> status) {
  constexpr int at_once = 256;  // points, where some of them are copied first
  if (energy.size() > INT_MAX - at_once)
    throw py::value_error("too many points for one call: at most " + std::to_string(INT_MAX - at_once));
  const int n = static_cast<int>(energy.size());
  char message[400];
  if (myogrowth_check(props.data(), props_size(props), message, sizeof message) != MYOGROWTH_OK)
    throw py::value_error(message);

  const Given given[] = {{G, 0, MYOGROWTH_G, 1},
                         {stretch, 0, MYOGROWTH_LAMBDA, 1},
                         {n0, 1, MYOGROWTH_N0, 3},
                         {F, 2, MYOGROWTH_F, 9}};
  const bool all_have_one_step =
      std::all_of(std::begin(given), std::end(given), [](const Given& g) { return g.has_one_step(); });
  const NumpyOrder order(measure);
  static constexpr int of_state[] = {MYOGROWTH_G_END, MYOGROWTH_LAMBDA_E, MYOGROWTH_LAMBDA_END,
                                     MYOGROWTH_J,     MYOGROWTH_JE,       MYOGROWTH_ENERGY};
  static constexpr int of_n0[] = {MYOGROWTH_N0, MYOGROWTH_N0 + 1, MYOGROWTH_N0 + 2};
  std::vector<myogrowth_output> out = {{stress.mutable_data(), 9, 9, order.stress},
                                       {n0_end.mutable_data(), 3, 3, of_n0}};
  if (!tangent.is_none()) out.push_back({py::cast<Array>(tangent).mutable_data(), 81, 81, order.tangent});
  Array* const numbers[] = {&G_end, &lambda_e, &stretch_end, &J, &Je, &energy};
  for (int e = 0; e < 6; ++e) out.push_back({numbers[e]->mutable_data(), 1, 1, of_state + e});
  int* const status_of = status.mutable_data();
  const double* const constants = props.data();
  const int n_constants = props_size(props);

  const py::gil_scoped_release others_may_run;
  // Parts of whole blocks, one a thread; the last is this one's.
  const int blocks = (n + at_once - 1) / at_once;
  const int parts = std::max(1, std::min(threads, blocks));
  struct Part {
    std::vector<myogrowth_input> in;
    std::vector<myogrowth_output> out;
    std::vector<double> copied;
    int failed = 0;
  };
  std::vector<Part> all_parts(static_cast<std::size_t>(parts));
  for (Part& p : all_parts)
    p.in.reserve(14), p.out = out, p.copied.resize(all_have_one_step ? 0 : 14 * at_once);
  const auto work = [&](int number) {
    Part& part = all_parts[static_cast<std::size_t>(number)];
    const auto start = [&](int p) {
      return std::min(n, static_cast<int>(static_cast<long long>(blocks) * p / parts) * at_once);
    };
    for (int first = start(number), count; first < start(number + 1); first += count) {
      count = start(number + 1) - first;
      if (!all_have_one_step) count = std::min(count, at_once);
      part.in.clear();
      double* buffer = part.copied.data();
      for (const Given& g : given) {
        g.give(first, count, buffer, part.in);
        if (!all_have_one_step) buffer += g.n * at_once;
      }
      for (std::size_t o = 0; o < out.size(); ++o) part.out[o].data = out[o].data + first * out[o].step;
      part.failed += myogrowth_update_strided(
          count, constants, n_constants, part.in.data(), static_cast<int>(part.in.size()), dt, measure,
          part.out.data(), static_cast<int>(out.size()), true, status_of + first, nullptr, 0);
    }
  };
  std::vector<std::thread> others;
  for (int number = 0; number < parts - 1; ++number) {
    try {
      others.emplace_back(work, number);
    } catch (const std::system_error&) {  // there are no more threads
      work(number);
    }
  }
  work(parts - 1);
  for (std::thread& other : others) other.join();
  int failed = 0;
  for (const Part& part : all_parts) failed += part.failed;
  return failed;
}

/// A strip pulled along its fibre with free sides: time[n], stretch[n]; the first row is the start, where
/// nothing has grown yet. Returns n x 5: G, lambda_e, lateral stretch, Cauchy stress along the fibre, J; the
/// status; and the number of rows that have a result.
py::tuple simulate(const Array& props, const Array& time, const Array& stretch, double G) {
  char message[400] = "";
  if (myogrowth_check(props.data(), props_size(props), message, sizeof message) != MYOGROWTH_OK) {
    throw py::value_error(message);
  }
  const py::ssize_t n = time.size();
  Array rows({n, py::ssize_t(5)});
  const double *constants = props.data(), *t = time.data(), *lambda = stretch.data();
  double* row = rows.mutable_data();
  int status = MYOGROWTH_OK;
  py::ssize_t done = 0;
  {
    const py::gil_scoped_release others_may_run;
    enum { of_G, of_lambda_e, of_lambda, of_J, n_state = 5 };  // the state's entries
    double state[n_state] = {G, 0, n > 0 ? lambda[0] : 1, 0, 0}, lateral = 1, stress;
    for (; done < n; ++done, row += 5) {
      const double dt = done > 0 ? t[done] - t[done - 1] : 0;
      status = myogrowth_uniaxial(constants, props_size(props), lambda[done], state, state, n_state, dt,
                                  &lateral, &stress, nullptr, nullptr, nullptr, 0);
      if (status != MYOGROWTH_OK) break;
      row[0] = state[of_G], row[1] = state[of_lambda_e], row[2] = lateral, row[3] = stress,
      row[4] = state[of_J];
    }
  }
  return py::make_tuple(rows, status, done);
}

py::tuple check(const Array& props) {
  char message[400];
  const int status = myogrowth_check(props.data(), props_size(props), message, sizeof message);
  return py::make_tuple(status, message);
}

/// Symbol, unit, meaning, what is allowed, default (NaN: required) of every entry of PROPS.
py::list parameters() {
  py::list entries;
  for (int i = 0; i < myogrowth_n_props(); ++i) {
    entries.append(py::make_tuple(myogrowth_prop_symbol(i), myogrowth_prop_unit(i), myogrowth_prop_meaning(i),
                                  myogrowth_prop_allowed(i), myogrowth_prop_default(i)));
  }
  return entries;
}

/// Name and parameters of every elastic law, those as above.
py::list laws() {
  py::list all;
  for (int law = 1; law <= myogrowth_n_laws(); ++law) {
    py::list entries;
    for (int i = 0; i < myogrowth_law_n_parameters(law); ++i) {
      entries.append(py::make_tuple(myogrowth_law_symbol(law, i), myogrowth_law_unit(law, i),
                                    myogrowth_law_meaning(law, i), myogrowth_law_allowed(law, i),
                                    myogrowth_law_default(law, i), myogrowth_law_default_of_tendon(law, i)));
    }
    all.append(py::make_tuple(myogrowth_law_name(law), entries));
  }
  return all;
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.def("update", &update, py::arg().noconvert(), py::arg().noconvert(), py::arg().noconvert(),
        py::arg().noconvert(), py::arg().noconvert(), py::arg(), py::arg(), py::arg(), py::arg().noconvert(),
        py::arg(), py::arg().noconvert(), py::arg().noconvert(), py::arg().noconvert(), py::arg().noconvert(),
        py::arg().noconvert(), py::arg().noconvert(), py::arg().noconvert(), py::arg().noconvert());
  m.def("simulate", &simulate);
  m.def("check", &check);
  m.def("parameters", &parameters);
  m.def("laws", &laws);
  m.def("status_text", &myogrowth_status_text);
  m.def("version", &myogrowth_version_text);
}
