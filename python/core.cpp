// What of the law Python calls: the C API over arrays, a history of its uniaxial strip, its table of
// parameters. Arrays come in as myogrowth.h wants them; python/myogrowth/__init__.py is the face.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <climits>

#include "myogrowth.h"

namespace py = pybind11;

namespace {

using Array = py::array_t<double, py::array::c_style>;  // never converted here: what came in is not copied

int props_size(const Array& props) { return static_cast<int>(props.size()); }

/// F: n x 9, state: n x n_state. Returns stress, tangent or None, energy, state, status, message.
py::tuple update(const Array& props, const Array& F, const Array& state, double dt, int measure,
                 bool with_tangent) {
  const py::ssize_t n = F.shape(0), n_state = state.shape(1), size = myogrowth_stress_size(measure);
  if (n > INT_MAX) throw py::value_error("too many points for one call: at most 2147483647");
  Array stress({n, size}), energy(n), state_out({n, n_state});
  py::object tangent = py::none();
  double* tangent_data = nullptr;
  if (with_tangent) {
    Array filled({n, size * size});
    tangent_data = filled.mutable_data();
    tangent = std::move(filled);
  }
  py::array_t<int> status(n);
  char message[400] = "";
  const double *F_data = F.data(), *state_data = state.data(), *props_data = props.data();
  double *stress_data = stress.mutable_data(), *energy_data = energy.mutable_data(),
         *out_data = state_out.mutable_data();
  int* status_data = status.mutable_data();
  {
    const py::gil_scoped_release others_may_run;
    std::copy(state_data, state_data + n * n_state, out_data);  // what a point that fails keeps
    myogrowth_update_n(static_cast<int>(n), props_data, props_size(props), F_data, state_data, out_data,
                       static_cast<int>(n_state), dt, measure, stress_data, tangent_data, energy_data,
                       status_data, message, sizeof message);
  }
  return py::make_tuple(stress, tangent, energy, state_out, status, message);
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
  m.def("update", &update);
  m.def("simulate", &simulate);
  m.def("check", &check);
  m.def("parameters", &parameters);
  m.def("laws", &laws);
  m.def("status_text", &myogrowth_status_text);
  m.def("version", &myogrowth_version_text);
}
