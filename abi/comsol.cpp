// The law for COMSOL: an External Material of the type "General stress-deformation relation". It is
// given no length of the step, so time comes as a parameter and goes as a state:
//
//   parameters   t, then PROPS(1), PROPS(2) ... (docs/manual.md); t is COMSOL's name of the present time
//   states       9: STATEV(1:8), and the time that they belong to; all 0 at the beginning, or the last the
//   start time
#include <cstdio>

#include "myogrowth.h"

namespace {
constexpr int n_statev = 8, n_states = n_statev + 1;
// Rows and columns of 11 22 33 12 13 23, and COMSOL's order xx yy zz yz xz xy among them.
constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2}, ours[6] = {0, 1, 2, 5, 4, 3};

int refuse(const char* text, double value) {
  std::fprintf(stderr, "myogrowth COMSOL: %s, is %g\n", text, value);
  return 1;
}
}  // namespace

extern "C" {

/// One step at one point. Fl, Jac: row by row, as C stores them. Returns 0, or 1 where there is no result:
/// COMSOL then takes a shorter step. Messages go to standard error.
int eval(double[3][3] /*FlOld*/, double Fl[3][3], double* /*tempOld*/, double* /*temp*/, double* /*sysT*/,
         double* /*delta*/, double Sl[6], double Jac[6][9], int* nPar, double* par, int* nStates1,
         double* states1) {
  if (*nPar < 7) return refuse("parameters: t and at least 6 of PROPS are needed", *nPar);
  if (*nStates1 < n_states) return refuse("states: 9 are needed", *nStates1);
  const double dt = par[0] - states1[n_statev];
  if (!(dt >= 0))
    return refuse(
        "t is before the time of the states: their last initial value must be the start time; the step", dt);
  double F[9], S[6], dS_dE[36], state[n_statev];
  for (int i = 0; i < 9; ++i) F[i] = Fl[i % 3][i / 3];
  char why[200] = "";
  const int status = myogrowth_update(par + 1, *nPar - 1, F, states1, state, n_statev, dt,
                                      MYOGROWTH_SECOND_PIOLA, S, dS_dE, nullptr, why, sizeof why);
  if (status != MYOGROWTH_OK) {
    if (status != MYOGROWTH_INVERTED && status != MYOGROWTH_NOT_FINITE) {
      std::fprintf(stderr, "myogrowth COMSOL: %s\n", why);
    }
    return 1;
  }
  // d(2 E_IJ) = F_kI dF_kJ + F_kJ dF_kI, of which the shears are the columns of dS/dE.
  for (int a = 0; a < 6; ++a) {
    Sl[a] = S[ours[a]];
    for (int kl = 0; kl < 9; ++kl) {
      const int k = kl / 3, l = kl % 3;
      Jac[a][kl] = 0;
      for (int b = 0; b < 6; ++b) {
        const double dE =
            (l == column[b] ? Fl[k][row[b]] : 0) + (b > 2 && l == row[b] ? Fl[k][column[b]] : 0);
        Jac[a][kl] += dS_dE[ours[a] + 6 * b] * dE;
      }
    }
  }
  for (int i = 0; i < n_statev; ++i) states1[i] = state[i];
  states1[n_statev] = par[0];
  return 0;
}
}
