// What of the law Python calls: the C API over arrays, the uniaxial strip of stress_states.hpp, the table of
// parameters. Arrays come in as myogrowth.h wants them; python/myogrowth/__init__.py is the face.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <climits>
#include <myogrowth/stress_states.hpp>

#include "faults.hpp"
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
  myogrowth::abi::Properties properties;
  myogrowth::abi::Text text = "";
  if (myogrowth::abi::find_props_fault(props.data(), props_size(props), properties, text)) {
    throw py::value_error(text);
  }
  const py::ssize_t n = time.size();
  Array rows({n, py::ssize_t(5)});
  const double *t = time.data(), *lambda = stretch.data();
  double* row = rows.mutable_data();
  myogrowth::Status status = myogrowth::Status::ok;
  py::ssize_t done = 0;
  {
    const py::gil_scoped_release others_may_run;
    double lateral = 1;
    for (; done < n; ++done, row += 5) {
      const py::ssize_t before = done > 0 ? done - 1 : 0;
      myogrowth::PointUpdate<double> u;
      double slope;
      status = myogrowth::uniaxial_stress(properties.material, lambda[done], G, lambda[before],
                                          t[done] - t[before], lateral, u, slope);
      if (status != myogrowth::Status::ok) break;
      G = u.G;
      row[0] = G, row[1] = u.lambda_e, row[2] = lateral, row[3] = u.tau[0] / u.J, row[4] = u.J;
    }
  }
  return py::make_tuple(rows, static_cast<int>(status), done);
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

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.def("update", &update);
  m.def("simulate", &simulate);
  m.def("check", &check);
  m.def("parameters", &parameters);
  m.def("status_text", &myogrowth_status_text);
  m.def("version", &myogrowth_version_text);
}
