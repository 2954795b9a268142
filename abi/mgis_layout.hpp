/// @file
/// How MGIS passes a point: structures, requests, the order of components, operators.
///
/// Neither MGIS nor MFront is needed to build this. What is laid out here in our own words are facts of
/// theirs:
///   structures, K, error_message     TFEL 4.1, MFront/GenericBehaviour/BehaviourData.h and State.h;
///                                    MGIS 3, Behaviour/BehaviourDataView.hxx and StateView.hxx
///   K[0], rdt, what is returned      TFEL 4.1, MFront/GenericBehaviour/Integrate.hxx
///   names of the symbols             TFEL 4.1, SymbolsGenerator.cxx, GenericBehaviourSymbolsGenerator.cxx
///   API version 1                    MGIS 3, Config.hxx
///   what a host reads, K[2] = 3      MGIS 3, LibrariesManager.cxx, BehaviourDescription.cxx, Behaviour.cxx
///   component orders, rows first     MGIS 3, FiniteStrainSupport.cxx
///
/// Components: tensors 11 22 33 12 21 13 31 23 32, symmetric ones 11 22 33 12 13 23 with shears times
/// sqrt(2); in two dimensions the first five and four. Operators are stored row by row.
#ifndef MYOGROWTH_ABI_MGIS_LAYOUT_HPP
#define MYOGROWTH_ABI_MGIS_LAYOUT_HPP

#include <cstring>

#include "point.hpp"

namespace myogrowth {
namespace abi {
namespace mgis {

// The material at one end of the time step. `Out`: const double at its beginning.
template <class Out>
struct StateView {
  const double* gradients;
  Out* thermodynamic_forces;
  const double* mass_density;
  const double* material_properties;
  Out* internal_state_variables;
  Out* stored_energy;
  Out* dissipated_energy;
  const double* external_state_variables;
};

struct BehaviourData {
  char* error_message;  // null, or room for 512 characters
  double dt;
  double* K;  // in: what is asked for, K[0..2]; out: the operator
  double* rdt;
  double* speed_of_sound;
  StateView<const double> s0;
  StateView<double> s1;
};

struct Hypothesis {
  int n_tensor, n_symmetric;
  bool plane_stress;
  int n_stress(int measure) const { return measure == 2 ? n_tensor : n_symmetric; }
  int n_operator(int tangent) const {
    return (tangent == 2 ? n_tensor : n_symmetric) * (tangent == 1 ? n_symmetric : n_tensor);
  }
};

// Where the components of F are in our nine, column by column.
constexpr int place[9] = {0, 4, 8, 3, 1, 6, 2, 7, 5};
constexpr double root_two = 1.4142135623730950488;

inline double weight(int a) { return a < 3 ? 1 : root_two; }

// What K[0..2] ask for.
struct Request {
  bool only_prediction, with_operator, with_growth;
  int measure;  // 0: Cauchy, 1: second Piola, 2: first Piola
  int tangent;  // 0: dsigma/dF, 1: dS/dE, 2: dP/dF, 3: dtau/d(F F0^-1)
};

inline int nearest(double x, int last) {
  for (int i = 0; i <= last; ++i) {
    if (x < i + 0.5) return i;
  }
  return -1;
}

inline bool find_request_fault(const double* K, Request& r, Text& text) {
  if (K[0] > 50) return tell(text, "K[0] = %g: the speed of sound is not computed.", K[0]);
  r.only_prediction = K[0] < -0.25;
  r.with_operator = r.only_prediction || K[0] >= 0.5;
  r.with_growth = K[0] < -2.5 || K[0] >= 2.5;  // else the elastic operator, which is the secant one too
  r.measure = nearest(K[1], 2);
  r.tangent = nearest(K[2], 3);
  if (r.measure < 0) return tell(text, "K[1] = %g: the stress measure must be 0, 1 or 2.", K[1]);
  if (r.tangent < 0) return tell(text, "K[2] = %g: the operator must be 0, 1, 2 or 3.", K[2]);
  return false;
}

inline void take_deformation(const double* gradients, const Hypothesis& h, double F[9]) {
  for (int i = 0; i < 9; ++i) F[i] = i % 4 == 0 ? 1 : 0;
  for (int i = 0; i < h.n_tensor; ++i) F[place[i]] = gradients[i];
}

// In plane stress F33 follows the plane, by dP33 = 0 (for dS/dE: dS33 = 0). To X[rows x columns] its part is
// added; `row`: of the stress that vanishes, i33: its column.
inline void condense(double* X, int rows, int columns, const double* row, int i33) {
  double ratio[9], column33[9];
  for (int j = 0; j < columns; ++j) ratio[j] = row[j] / row[i33];
  for (int i = 0; i < rows; ++i) column33[i] = X[i + rows * i33];
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) X[i + rows * j] -= column33[i] * ratio[j];
  }
}

inline void write_stress(int measure, const Hypothesis& h, const double* F, const PointUpdate<double>& u,
                         double* stress) {
  const int measure_of_c_api[3] = {0, 2, 1};
  double all[9];
  convert(measure_of_c_api[measure], F, u, all, nullptr);
  for (int i = 0; i < h.n_stress(measure); ++i) stress[i] = measure == 2 ? all[place[i]] : weight(i) * all[i];
}

// dS/dE: both sides have shears times sqrt(2), while ours has columns of engineering shear.
inline void write_dS_dE(const Hypothesis& h, const double* F, const PointUpdate<double>& u, const double* c,
                        double* K) {
  double X[36];
  dS_dE_from_jaumann(F, u.tau, c, X);
  if (h.plane_stress) {
    double row[6];
    for (int j = 0; j < 6; ++j) row[j] = X[2 + 6 * j];
    condense(X, 6, 6, row, 2);
  }
  for (int a = 0; a < h.n_symmetric; ++a) {
    for (int b = 0; b < h.n_symmetric; ++b) K[b + h.n_symmetric * a] = weight(a) * weight(b) * X[a + 6 * b];
  }
}

// The others, which differentiate by F. F0: at the beginning of the step, for dtau/d(F F0^-1).
inline void write_dX_dF(int tangent, const Hypothesis& h, const double* F, const double* F0,
                        const PointUpdate<double>& u, const double* c, double* K) {
  double P[9], A[81], X[54], Y[54], row[9];
  first_piola_from_kirchhoff(F, u.tau, P);
  dP_dF_from_jaumann(F, u.tau, c, A);
  dtau_dF_from_dP_dF(F, P, A, X);
  if (tangent == 0) {
    dsigma_dF_from_dtau_dF(F, u.J, u.tau, X, Y);
    std::memcpy(X, Y, sizeof X);
  }
  if (h.plane_stress) {
    for (int j = 0; j < 9; ++j) row[j] = A[8 + 9 * j];
    condense(A, 9, 9, row, 8);
    condense(X, 6, 9, row, 8);
  }
  if (tangent == 3) {  // F = (F F0^-1) F0
    for (int a = 0; a < 6; ++a) {
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) {
          Y[a + 6 * (k + 3 * l)] =
              X[a + 6 * k] * F0[l] + X[a + 6 * (k + 3)] * F0[l + 3] + X[a + 6 * (k + 6)] * F0[l + 6];
        }
      }
    }
    std::memcpy(X, Y, sizeof X);
  }
  const int rows = tangent == 2 ? h.n_tensor : h.n_symmetric;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < h.n_tensor; ++j) {
      K[j + h.n_tensor * i] = tangent == 2 ? A[place[i] + 9 * place[j]] : weight(i) * X[i + 6 * place[j]];
    }
  }
}

}  // namespace mgis
}  // namespace abi
}  // namespace myogrowth

#endif
