/// @file
/// myogrowth for C, and for all that can call C: stretch-driven muscle growth at a material point.
///
///     double props[] = {16, 4, 0.5, 2, 1.1, 1.01};            // the paper's Table 1: kPa, days
///     double state[9] = {0};                                  // 0: not known yet
///     double F[9] = {1.1, 0, 0, 0, 1, 0, 0, 0, 1}, P[9], dP_dF[81];
///     char why[200];
///     if (myogrowth_update(props, 6, F, state, state, 9, 0.1, MYOGROWTH_FIRST_PIOLA, P, dP_dF, NULL,
///                          why, sizeof why) != MYOGROWTH_OK)
///       fprintf(stderr, "%s\n", why);
///
/// Parameters and state are those of the UMAT, PROPS and STATEV, with the meaning that docs/manual.md gives
/// them; the functions over an index below are the same tables. Indices count from 0; texts name an entry as
/// the manual does, from 1, e.g. PROPS(5). Units are the caller's, one for stress and one for time.
///
/// Arrays are plain doubles. Second-order tensors that need not be symmetric are 9, COLUMN BY COLUMN:
///
///     F = {F11, F21, F31, F12, F22, F32, F13, F23, F33}
///
/// (a row-major array, as C and NumPy would write F[i][j], is the transpose: turn it round first). Symmetric
/// ones are 6, in the order 11 22 33 12 13 23. Tangents are column-major too: entry row + n column.
///
/// All functions may be called from several threads at once; none allocates, prints, or remembers anything.
/// Output arrays must not overlap one another or the input, but for state_out, which may be state_in.
#ifndef MYOGROWTH_H
#define MYOGROWTH_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What became of a call.
enum myogrowth_status {
  MYOGROWTH_OK = 0,
  MYOGROWTH_NOT_FINITE = 1,     ///< NaN or infinity in F or dt, or a result beyond the range of double
  MYOGROWTH_INVERTED = 2,       ///< det F <= 0: take a smaller step
  MYOGROWTH_NO_FIBRE = 3,       ///< the fibre direction is zero in props, and not in the state either
  MYOGROWTH_BAD_STATE = 4,      ///< G < 0, or G or the fibre in the state is not finite
  MYOGROWTH_BAD_PARAMETER = 5,  ///< an entry of props is missing or not allowed
  MYOGROWTH_BAD_ARGUMENT = 6,   ///< a needed pointer is NULL; an unknown measure; no room for the state
  MYOGROWTH_NOT_CONVERGED = 7   ///< the stretch that frees the stress was not found in 200 iterations
};

/// The measures of stress and tangent, and their sizes.
enum myogrowth_measure {
  MYOGROWTH_CAUCHY = 0,       ///< sigma[6]; [36]: Abaqus's DDSDDE, (1/J) d(J sigma) under the Jaumann rate
  MYOGROWTH_FIRST_PIOLA = 1,  ///< P[9]; [81]: dP_iJ/dF_kL at (i + 3J) + 9 (k + 3L), counted from 0
  MYOGROWTH_SECOND_PIOLA = 2  ///< S[6]; [36]: dS/dE, columns belong to engineering shears 2E
};

/// A few words on a status; never NULL.
const char* myogrowth_status_text(int status);
/// Numbers in the stress of a measure: 6, 9 or 6; 0 for an unknown one. The tangent has the square of it.
int myogrowth_stress_size(int measure);

/// The version of the library, three numbers.
void myogrowth_version(int* major, int* minor, int* patch);
/// The same as "major.minor.patch".
const char* myogrowth_version_text(void);

/// Entries of props that mean something.
int myogrowth_n_props(void);
/// How many of them, the first ones, have no default.
int myogrowth_n_props_required(void);
/// Symbol of entry i; NULL if there is none.
const char* myogrowth_prop_symbol(int i);
/// Unit of entry i, "stress", "time" or "-"; NULL if there is none.
const char* myogrowth_prop_unit(int i);
/// Meaning of entry i, in words; NULL if there is none.
const char* myogrowth_prop_meaning(int i);
/// Allowed range of entry i, in words; NULL if there is none.
const char* myogrowth_prop_allowed(int i);
/// What entry i is taken as when props ends before it; NaN if it is required or there is none.
double myogrowth_prop_default(int i);
/// Index of the entry of that symbol; -1 if there is none.
int myogrowth_prop_index(const char* symbol);

/// The elastic laws that props[18] chooses, 1 to 3 (docs/laws.md); 0, or no such entry, is the neo-Hookean
/// law. With one of them props[0] and props[1] must be 0, props[19] is the activation, 0 to 1, and the law's
/// parameters begin at props[20]. Those that props leaves out have their defaults.
int myogrowth_n_laws(void);
/// Name of a law; NULL if there is none.
const char* myogrowth_law_name(int law);
/// Number of its parameters; 0 if there is none.
int myogrowth_law_n_parameters(int law);
/// Symbol of its parameter i; NULL if there is none.
const char* myogrowth_law_symbol(int law, int i);
/// Unit of parameter i, "stress" or "-"; NULL if there is none.
const char* myogrowth_law_unit(int law, int i);
/// Meaning of parameter i, in words; NULL if there is none.
const char* myogrowth_law_meaning(int law, int i);
/// Allowed range of parameter i, in words; NULL if there is none.
const char* myogrowth_law_allowed(int law, int i);
/// Default of parameter i; NaN if there is none.
double myogrowth_law_default(int law, int i);
/// The same for tendon: law 2 has other published values for it. With law 2 the flag tendon is 1 then.
double myogrowth_law_default_of_tendon(int law, int i);

/// Entries of the state.
int myogrowth_n_state(void);
/// How many of them, the first ones, must be kept at least: 1, G.
int myogrowth_n_state_required(void);
/// Symbol of entry i; NULL if there is none.
const char* myogrowth_state_symbol(int i);
/// Unit of entry i: "-"; NULL if there is none.
const char* myogrowth_state_unit(int i);
/// Meaning of entry i, in words; NULL if there is none.
const char* myogrowth_state_meaning(int i);
/// Entry i of a point at rest: 1 for G and the ratios, 0 for the fibre, which means "that of props"; NaN if
/// there is none. A state of zeros does as well.
double myogrowth_state_initial(int i);
/// Index of the entry of that symbol; -1 if there is none.
int myogrowth_state_index(const char* symbol);

/// Checks props[n_props]. Returns MYOGROWTH_OK, _BAD_PARAMETER, or _BAD_ARGUMENT if props is NULL.
/// message[message_length], as everywhere below: NULL, or gets a text that ends in 0 and is cut to the room
/// there is; it names the entry, its value and what is allowed, and is empty if all is well.
/// A fibre direction of zero passes: it may yet come with the state.
int myogrowth_check(const double* props, int n_props, char* message, int message_length);

/// One step of length dt [time] to the deformation gradient F at its end; dt <= 0: nothing grows.
///
/// state_in[n_state]: the state at the beginning of the step; G = 0 there is taken as 1, and a fibre that is
/// not zero overrides that of props. state_out[n_state]: the state at the end, and may be state_in. Of the
/// state's entries what fits is kept, the fibre whole or not at all; others are carried over as they are.
/// stress, tangent: in the measure asked for [stress]; the tangent is that of this discrete step, growth
/// included, and unsymmetric where the muscle grows. energy: psi per unit reference volume [stress].
/// tangent, energy and message may be NULL, and are not made then.
///
/// The entry `frame` of props, for hosts with a basis that turns with the material, goes with
/// MYOGROWTH_CAUCHY only.
///
/// Returns a myogrowth_status. On failure state_out is not touched, and stress, tangent and energy become
/// NaN, so that a host that ignores the status cannot continue silently (not where the measure, and so their
/// size, is unknown).
int myogrowth_update(const double* props, int n_props, const double F[9], const double* state_in,
                     double* state_out, int n_state, double dt, int measure, double* stress, double* tangent,
                     double* energy, char* message, int message_length);

/// myogrowth_update for n_points points of one material and one dt, in SIMD packs of the machine where they
/// can be. A point's results do not depend on the number or the order of the points, to the bit; they are
/// those of myogrowth_update to rounding (1e-12, relative; less in dS/dE at stretches above 100, where terms
/// of myogrowth_update cancel), with the same status, and bits may differ between machines.
///
/// The arrays hold one point after the other: F n_points x 9, state_in and state_out n_points x n_state,
/// stress and tangent n_points x their size, energy n_points. status[n_points], or NULL: the
/// myogrowth_status of every point. Points that fail do not hold up the others.
///
/// Returns the number of points that failed: all of them if it is props or an argument that is wrong. The
/// message is about the first. n_points <= 0: nothing is done.
int myogrowth_update_n(int n_points, const double* props, int n_props, const double* F,
                       const double* state_in, double* state_out, int n_state, double dt, int measure,
                       double* stress, double* tangent, double* energy, int* status, char* message,
                       int message_length);

/// The numbers of a point that myogrowth_update_strided reads and writes. Where a name stands for several,
/// they are this and the next ones, in the order of the measure.
enum myogrowth_entry {
  MYOGROWTH_F = 0,             ///< in, 9, column by column; all of them are needed
  MYOGROWTH_G = 9,             ///< in: of the state at the beginning of the step
  MYOGROWTH_LAMBDA = 10,       ///< in: likewise
  MYOGROWTH_N0 = 11,           ///< in, 3: the fibre; out: the same, of unit length
  MYOGROWTH_STRESS = 14,       ///< out, up to 9: the size of the measure
  MYOGROWTH_TANGENT = 23,      ///< out, up to 81
  MYOGROWTH_G_END = 104,       ///< out: of the state at the end of the step, as the next four
  MYOGROWTH_LAMBDA_E = 105,    ///< out
  MYOGROWTH_LAMBDA_END = 106,  ///< out
  MYOGROWTH_J = 107,           ///< out
  MYOGROWTH_JE = 108,          ///< out
  MYOGROWTH_ENERGY = 109,      ///< out: psi
  MYOGROWTH_UNUSED = 110       ///< in: something else
};

/// An array of points to read: number c of point k, at data[k * step + c], is entry[c].
struct myogrowth_input {
  const double* data;  ///< number 0 of point 0
  ptrdiff_t step;      ///< from a point to the next, in numbers; 0: all have the same
  int size;            ///< numbers of a point that lie side by side
  const int* entry;    ///< what they are: size values of myogrowth_entry
};

/// An array of points to write, likewise. |step| is at least size.
struct myogrowth_output {
  double* data;      ///< number 0 of point 0
  ptrdiff_t step;    ///< from a point to the next, in numbers
  int size;          ///< numbers of a point that lie side by side
  const int* entry;  ///< what they are: size values of myogrowth_entry; one may be there several times
};

/// myogrowth_update_n for arrays in any order of memory: components apart or side by side, symmetric tensors
/// in six numbers or nine, points among other data. Only what is asked for is written. A matrix F[i][j] in
/// C's order, n_points of them, and P[i][j] likewise:
///
///     const int of_F[9] = {0, 3, 6, 1, 4, 7, 2, 5, 8};        // MYOGROWTH_F is 0
///     const int of_P[9] = {14, 17, 20, 15, 18, 21, 16, 19, 22};
///     const struct myogrowth_input in[] = {{F, 9, 9, of_F}};
///     const struct myogrowth_output out[] = {{P, 9, 9, of_P}};
///     myogrowth_update_strided(n_points, props, 6, in, 1, 0.1, MYOGROWTH_FIRST_PIOLA, out, 1, 0, NULL, NULL,
///     0);
///
/// in[n_in]: every entry once at most. G and lambda that are not there, or 0, are not known yet and taken as
/// 1, as in myogrowth_update, and the fibre is then that of props. state_is_known != 0: they are, and must be
/// > 0; a point that fails then gets its state as it came in, and NaN as lambda_e, J and Je; else its state
/// is not touched. status[n_points], or NULL: the myogrowth_status of every point.
///
/// Outputs may not overlap one another or an input, except that the state may be written where it is read:
/// G_end, lambda_end and n0 over G, lambda and n0 with the same step.
///
/// Returns the number of points that failed. The message is about the first. All of them fail if it is props
/// or an argument that is wrong; no output is written then if it is in or out, n_in or n_out.
int myogrowth_update_strided(int n_points, const double* props, int n_props, const struct myogrowth_input* in,
                             int n_in, double dt, int measure, const struct myogrowth_output* out, int n_out,
                             int state_is_known, int* status, char* message, int message_length);

/// One step of a strip that is pulled along its fibre with its sides free, uniaxial stress: to the total
/// stretch at its end. Of the rest as myogrowth_update; the direction of the fibre plays no part.
///
/// lateral: in, a start for the stretch of the sides (<= 0: none); out, the stretch at which they are free of
/// stress. stress, energy: one number each, the Cauchy stress along the fibre and psi [stress]. modulus: its
/// derivative, dtau/dln(stretch)/J at free sides, growth included [stress]. lateral, modulus, energy and
/// message may be NULL.
///
/// Returns a myogrowth_status; MYOGROWTH_NOT_CONVERGED if no such lateral stretch was found. On failure
/// state_out and lateral are not touched, and stress, modulus and energy become NaN.
int myogrowth_uniaxial(const double* props, int n_props, double stretch, const double* state_in,
                       double* state_out, int n_state, double dt, double* lateral, double* stress,
                       double* modulus, double* energy, char* message, int message_length);

#ifdef __cplusplus
}
#endif

#endif
