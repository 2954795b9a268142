// What of the law Python calls: the update of arrays where they lie, a history of the C API's uniaxial strip,
// its tables of parameters. python/myogrowth/__init__.py is the face, and checks what comes in.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <climits>
#include <system_error>
#include <thread>
#include <vector>

#include "arrays.hpp"
#include "myogrowth.h"

namespace py = pybind11;

namespace {

using Array = py::array_t<double, py::array::c_style>;  // never converted here: what came in is not copied
using AnyOrder = py::array_t<double>;
namespace host = myogrowth::abi;  // (abi is the compiler's)

int props_size(const Array& props) { return static_cast<int>(props.size()); }

/// How far an array goes along its axis, in numbers.
std::ptrdiff_t step(const py::array& a, py::ssize_t axis) {
  return a.strides(axis) / static_cast<std::ptrdiff_t>(sizeof(double));
}

/// The points' axes of an array with so many others, as few of them as do.
std::vector<host::Axis> axes_of_points(const py::array& a, py::ssize_t n_others) {
  std::vector<host::Axis> axes;
  for (py::ssize_t i = 0; i < a.ndim() - n_others; ++i) {
    const host::Axis axis{a.shape(i), step(a, i)};
    if (axis.size == 1) continue;
    if (!axes.empty() && axes.back().step == axis.size * axis.step) {
      axes.back() = {axes.back().size * axis.size, axis.step};
    } else {
      axes.push_back(axis);
    }
  }
  return axes;
}

/// An input of points: `axes` must live as long.
host::Given given(const py::array& a, const std::vector<host::Axis>& axes) {
  host::Given g;
  g.data = static_cast<const double*>(a.data());
  if (axes.size() > 1) g.axis = axes.data(), g.n_axes = static_cast<int>(axes.size());
  if (axes.size() == 1) g.step = axes[0].step;
  for (std::ptrdiff_t c = 0; c < 9; ++c) g.component[c] = 0;
  return g;
}

/// The rows of a block that NumPy's order of a measure's tensors takes: [i, j] and [i, j, k, l].
struct NumpyOrder {
  int stress[9], tangent[81];
  explicit NumpyOrder(int measure) {
    static constexpr int six[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    const bool is_first = measure == MYOGROWTH_FIRST_PIOLA;
    const int n = is_first ? 9 : 6, points = myogrowth_block_points;
    const auto at = [&](int ij) { return is_first ? ij / 3 + 3 * (ij % 3) : six[ij / 3][ij % 3]; };
    for (int ij = 0; ij < 9; ++ij) {
      stress[ij] = myogrowth_row_stress + at(ij) * points;
      for (int kl = 0; kl < 9; ++kl)
        tangent[9 * ij + kl] = myogrowth_row_tangent + (at(ij) + n * at(kl)) * points;
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
  if (energy.size() > INT_MAX - myogrowth_block_points)
    throw py::value_error("too many points for one call: at most 2147483615");
  const int n = static_cast<int>(energy.size());
  host::CallOfMany call{};
  host::Text text;
  if (host::check_props(props.data(), props_size(props), call, text) != MYOGROWTH_OK)
    throw py::value_error(text);
  call.n_state = host::n_kept;
  call.dt = dt;
  call.measure = measure;
  call.with_tangent = !tangent.is_none();

  const auto axes_of_F = axes_of_points(F, 2), axes_of_G = axes_of_points(G, 0),
             axes_of_stretch = axes_of_points(stretch, 0), axes_of_n0 = axes_of_points(n0, 1);
  const NumpyOrder order(measure);
  host::Arrays a;
  a.F = given(F, axes_of_F);
  for (py::ssize_t c = 0; c < 9; ++c)
    a.F.component[c] = c % 3 * step(F, F.ndim() - 2) + c / 3 * step(F, F.ndim() - 1);
  a.G = given(G, axes_of_G);
  a.stretch = given(stretch, axes_of_stretch);
  a.n0 = given(n0, axes_of_n0);
  for (py::ssize_t c = 0; c < 3; ++c) a.n0.component[c] = c * step(n0, n0.ndim() - 1);
  a.give(stress.mutable_data(), 9, 9, order.stress);
  if (call.with_tangent) a.give(py::cast<Array>(tangent).mutable_data(), 81, 81, order.tangent);
  const auto give_row = [&](Array& to, int row) { a.give(to.mutable_data(), 1, 1, host::rows_from(row)); };
  give_row(energy, myogrowth_row_psi);
  Array* const state[] = {&G_end, &lambda_e, &stretch_end, &J, &Je};
  for (int e = 0; e < 5; ++e) give_row(*state[e], host::row_of_state(e));
  a.give(n0_end.mutable_data(), 3, 3, host::rows_from(myogrowth_row_n0));
  a.status = status.mutable_data();
  a.is_known = true;

  const py::gil_scoped_release others_may_run;
  // Parts of whole blocks, one a thread; the last is this one's.
  const int blocks = (n + myogrowth_block_points - 1) / myogrowth_block_points;
  const int parts = std::max(1, std::min(threads, blocks));
  std::vector<int> failed(static_cast<std::size_t>(parts), 0);
  const auto work = [&](int part) {
    const auto start = [&](int p) {
      return std::min(n, static_cast<int>(static_cast<long>(blocks) * p / parts) * myogrowth_block_points);
    };
    host::Text unused;
    failed[static_cast<std::size_t>(part)] =
        host::update_arrays(call, a, start(part), start(part + 1), unused, nullptr);
  };
  std::vector<std::thread> others;
  for (int part = 0; part < parts - 1; ++part) {
    try {
      others.emplace_back(work, part);
    } catch (const std::system_error&) {  // there are no more threads
      work(part);
    }
  }
  work(parts - 1);
  for (std::thread& other : others) other.join();
  int sum = 0;
  for (int f : failed) sum += f;
  return sum;
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
                                    myogrowth_law_default(law, i)));
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
