/* The C API from C99, all of it, without a test framework: prints what failed, and returns 1 if anything did.
 */
#include <math.h>
#include <myogrowth.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

#define CHECK(condition)                                             \
  do {                                                               \
    if (!(condition)) {                                              \
      ++failures;                                                    \
      printf("%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
    }                                                                \
  } while (0)
/* For numbers: prints them too. */
#define CHECK_NEAR(a, b, tolerance)                                                      \
  do {                                                                                   \
    const double a_ = (a), b_ = (b);                                                     \
    if (!(fabs(a_ - b_) <= (tolerance))) {                                               \
      ++failures;                                                                        \
      printf("%s:%d: %s = %.17g, but %s = %.17g\n", __FILE__, __LINE__, #a, a_, #b, b_); \
    }                                                                                    \
  } while (0)
#define CHECK_TEXT(text, word)                                                 \
  do {                                                                         \
    if ((text) == NULL || strstr((text), (word)) == NULL) {                    \
      ++failures;                                                              \
      printf("%s:%d: no \"%s\" in: %s\n", __FILE__, __LINE__, (word), (text)); \
    }                                                                          \
  } while (0)

enum { n_state = 9, message_length = 300 };
static const double table_1[11] = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0}; /* the paper's: kPa, days */
static const int measures[3] = {MYOGROWTH_CAUCHY, MYOGROWTH_FIRST_PIOLA, MYOGROWTH_SECOND_PIOLA};

/* A growing point with an oblique fibre and shear in every plane. */
static const double oblique[11] = {16, 4, 0.5, 2, 1.3, 1.01, 0.6, 0.48, 0.64, 0, 0};
static const double sheared[9] = {1.15, 0.05, -0.03, 0.1, 1.1, 0.04, -0.06, 0.08, 1.2};

static int all_nan(const double* x, int n) {
  int all = 1;
  for (int i = 0; i < n; ++i) all = all && isnan(x[i]);
  return all;
}

static void fill(double* x, int n, double value) {
  for (int i = 0; i < n; ++i) x[i] = value;
}

/* C = A B, 3 x 3, column by column. */
static void multiply(const double* A, const double* B, double* C) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      C[i + 3 * j] = A[i] * B[3 * j] + A[i + 3] * B[1 + 3 * j] + A[i + 6] * B[2 + 3 * j];
}

static void transpose(const double* A, double* T) {
  for (int i = 0; i < 9; ++i) T[i] = A[i / 3 + 3 * (i % 3)];
}

/* Nine of a symmetric tensor's six; a tensor of strain has half the engineering shear off the diagonal. */
static void nine_of_six(const double* s, double shear, double* A) {
  static const int index[9] = {0, 3, 4, 3, 1, 5, 4, 5, 2};
  for (int i = 0; i < 9; ++i) A[i] = s[index[i]] * (index[i] < 3 ? 1 : shear);
}

static void inverse_transposed(const double* F, double* X) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
      X[i + 3 * j] = F[p + 3 * r] * F[q + 3 * s] - F[p + 3 * s] * F[q + 3 * r];
    }
  const double det = F[0] * X[0] + F[1] * X[1] + F[2] * X[2];
  for (int i = 0; i < 9; ++i) X[i] /= det;
}

static void test_tables(void) {
  int major = -1, minor = -1, patch = -1;
  char version[40];
  myogrowth_version(&major, &minor, &patch);
  snprintf(version, sizeof version, "%d.%d.%d", major, minor, patch);
  CHECK(strcmp(version, myogrowth_version_text()) == 0);
  CHECK(major >= 0 && minor >= 0 && patch >= 0);

  CHECK(myogrowth_n_props() == 18);
  CHECK(myogrowth_n_props_required() == 6);
  for (int i = 0; i < myogrowth_n_props(); ++i) {
    CHECK(strlen(myogrowth_prop_symbol(i)) > 0);
    CHECK(strlen(myogrowth_prop_unit(i)) > 0);
    CHECK(strlen(myogrowth_prop_meaning(i)) > 0);
    CHECK(strlen(myogrowth_prop_allowed(i)) > 0);
    CHECK((isnan(myogrowth_prop_default(i)) != 0) == (i < myogrowth_n_props_required()));
    CHECK(myogrowth_prop_index(myogrowth_prop_symbol(i)) == i);
  }
  CHECK_TEXT(myogrowth_prop_symbol(4), "G_max");
  CHECK_TEXT(myogrowth_prop_allowed(4), "> 1");
  CHECK_TEXT(myogrowth_prop_unit(0), "stress");
  CHECK_TEXT(myogrowth_prop_unit(2), "time");
  CHECK(myogrowth_prop_default(6) == 1);
  CHECK(myogrowth_prop_index("lambda_crit") == 5);

  CHECK(myogrowth_n_state() == n_state);
  CHECK(myogrowth_n_state_required() == 1);
  for (int i = 0; i < myogrowth_n_state(); ++i) {
    CHECK(strlen(myogrowth_state_symbol(i)) > 0);
    CHECK(strcmp(myogrowth_state_unit(i), "-") == 0);
    CHECK(strlen(myogrowth_state_meaning(i)) > 0);
    CHECK(myogrowth_state_initial(i) == (5 <= i && i < 8 ? 0 : 1));
    CHECK(myogrowth_state_index(myogrowth_state_symbol(i)) == i);
  }
  CHECK(myogrowth_state_index("G") == 0);
  CHECK(myogrowth_state_index("lambda_e") == 1);

  const int outside[] = {-1, 18, 1000, -2147483647 - 1, 2147483647};
  for (int k = 0; k < 5; ++k) {
    const int i = outside[k];
    CHECK(myogrowth_prop_symbol(i) == NULL && myogrowth_prop_unit(i) == NULL);
    CHECK(myogrowth_prop_meaning(i) == NULL && myogrowth_prop_allowed(i) == NULL);
    CHECK(isnan(myogrowth_prop_default(i)));
    CHECK(myogrowth_state_symbol(i) == NULL && myogrowth_state_unit(i) == NULL);
    CHECK(myogrowth_state_meaning(i) == NULL && isnan(myogrowth_state_initial(i)));
  }
  CHECK(myogrowth_state_symbol(9) == NULL);
  CHECK(myogrowth_prop_index("nothing") == -1 && myogrowth_prop_index("") == -1);
  CHECK(myogrowth_prop_index(NULL) == -1 && myogrowth_state_index(NULL) == -1);

  for (int status = MYOGROWTH_OK; status <= MYOGROWTH_NOT_CONVERGED; ++status) {
    for (int other = MYOGROWTH_OK; other < status; ++other)
      CHECK(strcmp(myogrowth_status_text(status), myogrowth_status_text(other)) != 0);
  }
  CHECK_TEXT(myogrowth_status_text(-1), "unknown");
  CHECK_TEXT(myogrowth_status_text(8), "unknown");
  CHECK_TEXT(myogrowth_status_text(MYOGROWTH_NOT_CONVERGED),
             "not converged: the stretch that frees the stress");
  CHECK(myogrowth_stress_size(MYOGROWTH_CAUCHY) == 6);
  CHECK(myogrowth_stress_size(MYOGROWTH_FIRST_PIOLA) == 9);
  CHECK(myogrowth_stress_size(MYOGROWTH_SECOND_PIOLA) == 6);
  CHECK(myogrowth_stress_size(3) == 0 && myogrowth_stress_size(-1) == 0);
}

static void test_check(void) {
  static const struct {
    int entry;
    double value;
    const char *named, *allowed;
  } bad[] = {{0, -3, "PROPS(1) = -3: c1", "> -2/3 c2"},
             {0, NAN, "PROPS(1) = nan: c1", "finite"},
             {1, 0, "PROPS(2) = 0: c2", "> 0"},
             {1, INFINITY, "PROPS(2) = inf: c2", "finite"},
             {2, -0.5, "PROPS(3) = -0.5: tau", "> 0"},
             {3, -1e-9, "PROPS(4) = -1e-09: gamma", ">= 0"},
             {4, 1, "PROPS(5) = 1: G_max", "> 1"},
             {5, 0, "PROPS(6) = 0: lambda_crit", "> 0"},
             {6, NAN, "PROPS(7) = nan: n0_1", "finite"},
             {7, NAN, "PROPS(8) = nan: n0_2", "finite"},
             {8, INFINITY, "PROPS(9) = inf: n0_3", "fini"},
             {9, 2, "PROPS(10) = 2: frame", "0 or 1"},
             {10, 0.5, "PROPS(11) = 0.5: energy", "0 or 1"},
             {11, 7, "PROPS(12) = 7: integration", "0 or 1"},
             {13, -1, "PROPS(14) = -1: tau_rev", ">= 0"},
             {17, 1, "PROPS(18) = 1: hybrid", "must be 0 for the C API"},
             {18, 7, "PROPS(19) = 7", "must be 0"}};
  char message[message_length];
  for (int n = 6; n <= 11; ++n) {
    strcpy(message, "old");
    CHECK(myogrowth_check(table_1, n, message, message_length) == MYOGROWTH_OK);
    CHECK(message[0] == '\0');
  }
  for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
    double props[19] = {0}, F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, state[n_state] = {0}, stress[9];
    memcpy(props, table_1, sizeof table_1);
    props[bad[k].entry] = bad[k].value;
    CHECK(myogrowth_check(props, 19, message, message_length) == MYOGROWTH_BAD_PARAMETER);
    CHECK_TEXT(message, bad[k].named);
    CHECK_TEXT(message, bad[k].allowed);
    CHECK(myogrowth_check(props, 19, NULL, 0) == MYOGROWTH_BAD_PARAMETER);
    char again[message_length];
    CHECK(myogrowth_update(props, 19, F, state, state, n_state, 0.1, MYOGROWTH_FIRST_PIOLA, stress, NULL,
                           NULL, again, message_length) == MYOGROWTH_BAD_PARAMETER);
    CHECK(strcmp(again, message) == 0);
    CHECK(all_nan(stress, 9) && state[0] == 0);
  }
  for (int n = -1; n < 6; ++n) {
    CHECK(myogrowth_check(table_1, n, message, message_length) == MYOGROWTH_BAD_PARAMETER);
    CHECK_TEXT(message, "at least 6");
  }
  CHECK(myogrowth_check(NULL, 6, message, message_length) == MYOGROWTH_BAD_ARGUMENT);
  CHECK_TEXT(message, "props = NULL");
}

static void test_messages_are_cut_to_the_room(void) {
  double props[6], F[9] = {-1, 0, 0, 0, 1, 0, 0, 0, 1}, state[n_state] = {0}, stress[6];
  char whole[message_length], cut[16];
  memcpy(props, table_1, sizeof props);
  props[4] = 0.9;
  myogrowth_check(props, 6, whole, message_length);
  for (int length = -1; length <= 10; ++length) {
    const size_t kept = length > 0 ? (size_t)length - 1 : 0;
    memset(cut, '#', sizeof cut);
    CHECK(myogrowth_check(props, 6, cut, length) == MYOGROWTH_BAD_PARAMETER);
    CHECK(length <= 0 || (memcmp(cut, whole, kept) == 0 && cut[kept] == '\0'));
    for (int i = length > 0 ? length : 0; i < 16; ++i) CHECK(cut[i] == '#');

    memset(cut, '#', sizeof cut);
    CHECK(myogrowth_update(table_1, 6, F, state, state, n_state, 0.1, MYOGROWTH_CAUCHY, stress, NULL, NULL,
                           cut, length) == MYOGROWTH_INVERTED);
    CHECK(length <= 0 || (memcmp(cut, "inverted: det F", kept) == 0 && cut[kept] == '\0'));
    for (int i = length > 0 ? length : 0; i < 16; ++i) CHECK(cut[i] == '#');

    memset(cut, '#', sizeof cut);
    CHECK(myogrowth_update_n(1, table_1, 6, F, state, state, n_state, 0.1, MYOGROWTH_CAUCHY, stress, NULL,
                             NULL, NULL, cut, length) == 1);
    CHECK(length <= 0 || (memcmp(cut, "point 0 (of 0 to 0)", kept) == 0 && cut[kept] == '\0'));
    for (int i = length > 0 ? length : 0; i < 16; ++i) CHECK(cut[i] == '#');
  }
}

static void test_cube(void) {
  const double F[9] = {1.1, 0, 0, 0, 1, 0, 0, 0, 1};
  double state[n_state] = {0}, after[n_state], stress[6], tangent[36], energy = -1;
  char message[message_length] = "old";
  CHECK(myogrowth_update(table_1, 6, F, state, after, n_state, 0.5, MYOGROWTH_CAUCHY, stress, tangent,
                         &energy, message, message_length) == MYOGROWTH_OK);
  CHECK(message[0] == '\0');
  CHECK_NEAR(after[0], 1.02931485, 5e-9);
  CHECK_NEAR(after[1], 1.1 / after[0], 1e-15);
  CHECK_NEAR(after[2], 1.1, 1e-15);
  CHECK_NEAR(after[3], 1.1, 1e-15);
  CHECK_NEAR(after[4], 1.1 / after[0], 1e-15);
  CHECK(after[5] == 1 && after[6] == 0 && after[7] == 0);
  /* eq. 3 by hand */
  const double le = after[1], ln_Je = log(le);
  CHECK_NEAR(stress[0], (16 * ln_Je + 4 * (le * le - 1)) / 1.1, 1e-13);
  CHECK_NEAR(stress[1], 16 * ln_Je / 1.1, 1e-13);
  CHECK(stress[3] == 0 && stress[4] == 0 && stress[5] == 0);
  CHECK_NEAR(energy, 8 * ln_Je * ln_Je + 2 * (le * le - 1) - 4 * ln_Je, 1e-13);

  CHECK(myogrowth_update(table_1, 6, F, state, after, n_state, 0.01, MYOGROWTH_CAUCHY, stress, NULL, NULL,
                         NULL, 0) == MYOGROWTH_OK);
  CHECK_NEAR(after[0], 1.00170307, 5e-9);
  CHECK(state[0] == 0);

  /* a history, the state kept in place and kept apart: the same bits, and growth that never ends early */
  double apart[2][n_state] = {{0}, {0}};
  double G = 1;
  for (int step = 0; step < 400; ++step) {
    double other[6];
    double *from = apart[step % 2], *to = apart[1 - step % 2];
    CHECK(myogrowth_update(table_1, 6, F, state, state, n_state, 0.01, MYOGROWTH_CAUCHY, stress, NULL, NULL,
                           NULL, 0) == MYOGROWTH_OK);
    CHECK(myogrowth_update(table_1, 6, F, from, to, n_state, 0.01, MYOGROWTH_CAUCHY, other, NULL, NULL, NULL,
                           0) == MYOGROWTH_OK);
    CHECK(memcmp(state, to, sizeof state) == 0 && memcmp(stress, other, sizeof stress) == 0);
    CHECK(state[0] > G && state[0] < 1.1 / 1.01);
    G = state[0];
  }
}

static void test_state(void) {
  double in[12] = {1.05, 7, 7, 7, 7, 0, 0, 0, 7, 8, 9, 10}, out[12], all[12], stress[6], expected[6];
  CHECK(myogrowth_update(oblique, 11, sheared, in, all, 12, 0.1, MYOGROWTH_CAUCHY, expected, NULL, NULL, NULL,
                         0) == MYOGROWTH_OK);
  CHECK(all[0] > 1.05);
  CHECK(all[8] == 7 && all[9] == 8 && all[10] == 9 && all[11] == 10); /* not ours: carried over */
  for (int n = 1; n < 12; ++n) {
    fill(out, 12, -777);
    CHECK(myogrowth_update(oblique, 11, sheared, in, out, n, 0.1, MYOGROWTH_CAUCHY, stress, NULL, NULL, NULL,
                           0) == MYOGROWTH_OK);
    CHECK(memcmp(stress, expected, sizeof stress) == 0);
    for (int i = 0; i < n; ++i) CHECK(out[i] == (5 <= i && i < 8 && n < 8 ? in[i] : all[i]));
    for (int i = n; i < 12; ++i) CHECK(out[i] == -777);
  }
  /* a fibre in the state overrides that of props */
  double props[11], initial[n_state];
  memcpy(props, oblique, sizeof props);
  props[6] = props[7] = props[8] = 0;
  CHECK(myogrowth_check(props, 11, NULL, 0) == MYOGROWTH_OK);
  for (int i = 0; i < n_state; ++i) initial[i] = myogrowth_state_initial(i);
  initial[0] = 1.05;
  for (int i = 0; i < 3; ++i) initial[5 + i] = oblique[6 + i];
  CHECK(myogrowth_update(props, 11, sheared, initial, out, n_state, 0.1, MYOGROWTH_CAUCHY, stress, NULL, NULL,
                         NULL, 0) == MYOGROWTH_OK);
  CHECK(memcmp(stress, expected, sizeof stress) == 0);
}

static void test_measures_agree(void) {
  double state[n_state] = {0}, after[3][n_state], sigma6[6], P[9], S6[6], energy[3];
  CHECK(myogrowth_update(oblique, 11, sheared, state, after[0], n_state, 0.1, MYOGROWTH_CAUCHY, sigma6, NULL,
                         &energy[0], NULL, 0) == MYOGROWTH_OK);
  CHECK(myogrowth_update(oblique, 11, sheared, state, after[1], n_state, 0.1, MYOGROWTH_FIRST_PIOLA, P, NULL,
                         &energy[1], NULL, 0) == MYOGROWTH_OK);
  CHECK(myogrowth_update(oblique, 11, sheared, state, after[2], n_state, 0.1, MYOGROWTH_SECOND_PIOLA, S6,
                         NULL, &energy[2], NULL, 0) == MYOGROWTH_OK);
  CHECK(memcmp(after[0], after[1], sizeof after[0]) == 0 && memcmp(after[0], after[2], sizeof after[0]) == 0);
  CHECK(energy[0] == energy[1] && energy[0] == energy[2] && energy[0] > 0);
  double sigma[9], S[9], Ft[9], PFt[9], FS[9];
  nine_of_six(sigma6, 1, sigma);
  nine_of_six(S6, 1, S);
  transpose(sheared, Ft);
  multiply(P, Ft, PFt);
  multiply(sheared, S, FS);
  for (int i = 0; i < 9; ++i) {
    CHECK_NEAR(PFt[i], after[0][3] * sigma[i], 1e-13);
    CHECK_NEAR(FS[i], P[i], 1e-13);
  }
}

/* The change of F that belongs to strain component `col` of a measure. */
static void direction(int measure, int col, double* dF) {
  double six[6] = {0}, D[9], X[9];
  fill(dF, 9, 0);
  if (measure == MYOGROWTH_FIRST_PIOLA) {
    dF[col] = 1;
    return;
  }
  six[col] = 1;
  nine_of_six(six, 0.5, D);
  if (measure == MYOGROWTH_CAUCHY) { /* dF = D F: no spin */
    multiply(D, sheared, dF);
  } else { /* F^T dF = dE */
    inverse_transposed(sheared, X);
    multiply(X, D, dF);
  }
}

static void test_tangents(void) {
  const double h = 1e-5;
  for (int k = 0; k < 3; ++k) {
    const int measure = measures[k], n = myogrowth_stress_size(measure);
    double state[n_state] = {0}, after[n_state], stress[9], tangent[81], asymmetry = 0;
    CHECK(myogrowth_update(oblique, 11, sheared, state, after, n_state, 0.1, measure, stress, tangent, NULL,
                           NULL, 0) == MYOGROWTH_OK);
    CHECK(after[0] > 1.001);
    const double per_J = measure == MYOGROWTH_CAUCHY ? 1 / after[3] : 1;
    for (int col = 0; col < n; ++col) {
      double dF[9], F[9], side[2][9];
      direction(measure, col, dF);
      for (int s = 0; s < 2; ++s) {
        for (int i = 0; i < 9; ++i) F[i] = sheared[i] + (s ? h : -h) * dF[i];
        CHECK(myogrowth_update(oblique, 11, F, state, after, n_state, 0.1, measure, side[s], NULL, NULL, NULL,
                               0) == MYOGROWTH_OK);
        for (int i = 0; i < n && measure == MYOGROWTH_CAUCHY; ++i) side[s][i] *= after[3]; /* J sigma */
      }
      for (int row = 0; row < n; ++row) {
        CHECK_NEAR(tangent[row + n * col], per_J * (side[1][row] - side[0][row]) / (2 * h), 2e-8);
        asymmetry = fmax(asymmetry, fabs(tangent[row + n * col] - tangent[col + n * row]));
      }
    }
    CHECK(asymmetry > 0.1); /* so that a transposed tangent cannot pass */
  }
}

static void test_null_outputs(void) {
  for (int k = 0; k < 3; ++k) {
    const int n = myogrowth_stress_size(measures[k]);
    double state[n_state] = {0}, after[n_state], some[n_state], stress[9], same[9], tangent[81], energy = 0;
    CHECK(myogrowth_update(oblique, 11, sheared, state, after, n_state, 0.1, measures[k], stress, tangent,
                           &energy, NULL, 100) == MYOGROWTH_OK);
    CHECK(energy > 0);
    CHECK(myogrowth_update(oblique, 11, sheared, state, some, n_state, 0.1, measures[k], same, NULL, NULL,
                           NULL, 0) == MYOGROWTH_OK);
    CHECK(memcmp(stress, same, (size_t)n * sizeof *stress) == 0 && memcmp(after, some, sizeof after) == 0);
  }
}

/* One refused call: its status, its text, and that nothing is lost. */
static void expect_refusal(int expected, const char* word, const double* props, const double* F,
                           const double* state_in, int n, double dt, int measure) {
  double out[n_state], stress[9], tangent[81], energy = 0;
  char message[message_length] = "";
  const int size = myogrowth_stress_size(measure);
  fill(out, n_state, -777);
  fill(stress, 9, -777);
  fill(tangent, 81, -777);
  const int status = myogrowth_update(props, 11, F, state_in, out, n, dt, measure, stress, tangent, &energy,
                                      message, message_length);
  if (status != expected) printf("expected status %d, got %d\n", expected, status);
  CHECK(status == expected);
  CHECK_TEXT(message, word);
  for (int i = 0; i < n_state; ++i) CHECK(out[i] == -777);
  CHECK(all_nan(stress, size) && all_nan(tangent, size * size) && (size == 0 ? energy == 0 : isnan(energy)));
  for (int i = size; i < 9; ++i) CHECK(stress[i] == -777);
  for (int i = size * size; i < 81; ++i) CHECK(tangent[i] == -777);
}

static void test_refusals(void) {
  double state[n_state] = {0}, bad[n_state] = {0}, F[9], props[11];
  for (int k = 0; k < 3; ++k) {
    const int m = measures[k];
    memcpy(F, sheared, sizeof F);
    F[5] = INFINITY;
    expect_refusal(MYOGROWTH_NOT_FINITE, "not finite: F32 = inf: must be finite.", oblique, F, state, n_state,
                   0.1, m);
    F[5] = 0;
    F[0] = 1e300;
    expect_refusal(MYOGROWTH_NOT_FINITE, "not finite: a result", oblique, F, state, n_state, 0.1, m);
    fill(F, 9, 0);
    expect_refusal(MYOGROWTH_INVERTED, "det F = 0: must be > 0", oblique, F, state, n_state, 0.1, m);
    F[0] = -2, F[4] = 1, F[8] = 3;
    expect_refusal(MYOGROWTH_INVERTED, "det F = -6: must be > 0", oblique, F, state, n_state, 0.1, m);
    expect_refusal(MYOGROWTH_NOT_FINITE, "dt = nan", oblique, sheared, state, n_state, NAN, m);
    expect_refusal(MYOGROWTH_NOT_FINITE, "dt = inf", oblique, sheared, state, n_state, INFINITY, m);

    memcpy(bad, state, sizeof bad);
    bad[0] = -1;
    expect_refusal(MYOGROWTH_BAD_STATE, "STATEV(1) = -1", oblique, sheared, bad, n_state, 0.1, m);
    bad[0] = NAN;
    expect_refusal(MYOGROWTH_BAD_STATE, "STATEV(1) = nan", oblique, sheared, bad, n_state, 0.1, m);
    bad[0] = 1;
    bad[6] = INFINITY;
    expect_refusal(MYOGROWTH_BAD_STATE, "STATEV(7) = inf", oblique, sheared, bad, n_state, 0.1, m);

    memcpy(props, oblique, sizeof props);
    props[6] = props[7] = props[8] = 0;
    expect_refusal(MYOGROWTH_NO_FIBRE, "PROPS(7:9)", props, sheared, state, n_state, 0.1, m);
    bad[6] = 0;
    bad[0] = -1;
    expect_refusal(MYOGROWTH_BAD_STATE, "STATEV(1)", props, sheared, bad, n_state, 0.1, m);
    props[4] = 1;
    expect_refusal(MYOGROWTH_BAD_PARAMETER, "PROPS(5) = 1", props, sheared, state, n_state, 0.1, m);
    expect_refusal(MYOGROWTH_BAD_ARGUMENT, "n_state = 0", oblique, sheared, state, 0, 0.1, m);
    expect_refusal(MYOGROWTH_BAD_ARGUMENT, "n_state = -3", oblique, sheared, state, -3, 0.1, m);
    expect_refusal(MYOGROWTH_BAD_ARGUMENT, "props", NULL, sheared, state, n_state, 0.1, m);
    expect_refusal(MYOGROWTH_BAD_ARGUMENT, "F = NULL", oblique, NULL, state, n_state, 0.1, m);
    expect_refusal(MYOGROWTH_BAD_ARGUMENT, "state_in = NULL", oblique, sheared, NULL, n_state, 0.1, m);
  }
  expect_refusal(MYOGROWTH_BAD_ARGUMENT, "measure = 3", oblique, sheared, state, n_state, 0.1, 3);
  expect_refusal(MYOGROWTH_BAD_ARGUMENT, "measure = -1", oblique, sheared, state, n_state, 0.1, -1);
  memcpy(props, oblique, sizeof props);
  props[9] = 1;
  expect_refusal(MYOGROWTH_BAD_PARAMETER, "PROPS(10) = 1", props, sheared, state, n_state, 0.1,
                 MYOGROWTH_FIRST_PIOLA);
  expect_refusal(MYOGROWTH_BAD_PARAMETER, "PROPS(10) = 1", props, sheared, state, n_state, 0.1,
                 MYOGROWTH_SECOND_PIOLA);

  double stress[6], tangent[36];
  char message[message_length];
  CHECK(myogrowth_update(oblique, 11, sheared, state, NULL, n_state, 0.1, MYOGROWTH_CAUCHY, stress, NULL,
                         NULL, message, message_length) == MYOGROWTH_BAD_ARGUMENT);
  CHECK_TEXT(message, "state_out = NULL");
  CHECK(all_nan(stress, 6));
  CHECK(myogrowth_update(oblique, 11, sheared, state, bad, n_state, 0.1, MYOGROWTH_CAUCHY, NULL, tangent,
                         NULL, message, message_length) == MYOGROWTH_BAD_ARGUMENT);
  CHECK_TEXT(message, "stress = NULL");
  CHECK(all_nan(tangent, 36));

  /* a stress within the range of double, but a modulus, c1 + 2 c2 be, beyond it */
  const double flat[9] = {sqrt(0.5), 0, 0, 0, sqrt(2), 0, 0, 0, 1};
  memcpy(props, table_1, sizeof props);
  props[0] = 1.77e308;
  props[1] = 1e306;
  for (int k = 0; k < 3; ++k) {
    double out[n_state], P[9];
    expect_refusal(MYOGROWTH_NOT_FINITE, "a result", props, flat, state, n_state, 0.1, measures[k]);
    CHECK(myogrowth_update(props, 11, flat, state, out, n_state, 0.1, measures[k], P, NULL, NULL, NULL, 0) ==
          MYOGROWTH_OK);
  }
}

/* to 1e-13 of the largest, or all NaN */
static int is_near(const double* a, const double* b, int n) {
  double size = 0;
  for (int i = 0; i < n; ++i) size = fmax(size, fabs(a[i]));
  for (int i = 0; i < n; ++i) {
    if (!(fabs(a[i] - b[i]) <= 1e-13 * size) && !(isnan(a[i]) && isnan(b[i]))) return 0;
  }
  return 1;
}

static void test_many_points(void) {
  enum { n_points = 17, inverted = 8, last = n_points - 1 };
  static double F[n_points * 9], state[n_points * n_state], before[n_points * n_state],
      after[n_points * n_state];
  static double stress[n_points * 9], tangent[n_points * 81], energy[n_points];
  int status[n_points];
  char message[message_length];
  for (int p = 0; p < n_points; ++p) {
    for (int i = 0; i < 9; ++i) F[9 * p + i] = sheared[i] + 0.02 * sin(7.0 * p + i);
    for (int i = 0; i < n_state; ++i) before[n_state * p + i] = i == 0 ? 1 + 0.005 * p : 0;
  }
  F[9 * inverted] = -1;
  before[n_state * last] = -1;
  for (int k = 0; k < 3; ++k) {
    const int m = measures[k], n = myogrowth_stress_size(m);
    const size_t stress_bytes = (size_t)n * sizeof(double);
    memcpy(state, before, sizeof state);
    CHECK(myogrowth_update_n(n_points, oblique, 11, F, state, state, n_state, 0.1, m, stress, tangent, energy,
                             status, message, message_length) == 2);
    CHECK_TEXT(message, "point 8");
    CHECK_TEXT(message, "det F");
    for (int p = 0; p < n_points; ++p) {
      double one[n_state], s[9], t[81], e;
      memcpy(one, before + n_state * p, sizeof one);
      const int made = myogrowth_update(oblique, 11, F + 9 * p, one, one, n_state, 0.1, m, s, t, &e, NULL, 0);
      CHECK(made == status[p] && made == (p == inverted ? MYOGROWTH_INVERTED
                                          : p == last   ? MYOGROWTH_BAD_STATE
                                                        : MYOGROWTH_OK));
      /* many points are done by packs, which have a logarithm of their own */
      CHECK(is_near(one, state + n_state * p, n_state));
      CHECK(is_near(s, stress + n * p, n));
      CHECK(is_near(t, tangent + n * n * p, n * n));
      CHECK(is_near(&e, energy + p, 1));
      CHECK(all_nan(s, n) == (p == inverted || p == last));
    }
    /* the same apart, with everything left out that may be; a failed point's state_out is not touched */
    static double alone[n_points * 9];
    fill(after, n_points * n_state, -777);
    CHECK(myogrowth_update_n(n_points, oblique, 11, F, before, after, n_state, 0.1, m, alone, NULL, NULL,
                             NULL, NULL, 0) == 2);
    CHECK(memcmp(alone, stress, n_points * stress_bytes) == 0);
    for (int i = 0; i < n_points * n_state; ++i)
      CHECK(after[i] == (i / n_state == inverted || i / n_state == last ? -777 : state[i]));
  }

  /* what is wrong for all is wrong for each */
  double props[11];
  memcpy(props, oblique, sizeof props);
  props[4] = 1;
  fill(after, n_points * n_state, -777);
  fill(stress, n_points * 9, 0);
  CHECK(myogrowth_update_n(n_points, props, 11, F, before, after, n_state, 0.1, MYOGROWTH_FIRST_PIOLA, stress,
                           tangent, energy, status, message, message_length) == n_points);
  CHECK(strncmp(message, "PROPS(5) = 1", 12) == 0);
  CHECK(all_nan(stress, n_points * 9) && all_nan(tangent, n_points * 81) && all_nan(energy, n_points));
  for (int p = 0; p < n_points; ++p) CHECK(status[p] == MYOGROWTH_BAD_PARAMETER);
  for (int i = 0; i < n_points * n_state; ++i) CHECK(after[i] == -777);
  CHECK(myogrowth_update_n(n_points, oblique, 11, NULL, before, after, -2, 0.1, MYOGROWTH_CAUCHY, NULL, NULL,
                           NULL, status, message, message_length) == n_points);
  CHECK(status[n_points - 1] == MYOGROWTH_BAD_ARGUMENT);
  for (int n = -1; n <= 0; ++n) {
    strcpy(message, "old");
    CHECK(myogrowth_update_n(n, NULL, 0, NULL, NULL, NULL, 0, 0, 0, NULL, NULL, NULL, NULL, message,
                             message_length) == 0);
    CHECK(message[0] == '\0');
  }
}

/* Points of test_strided, one of which is inverted, and what myogrowth_update_n gives for them. */
enum { n_strided = 75, inverted_one = 40 };
static double F_all[n_strided * 9], state_all[n_strided * n_state], after_all[n_strided * n_state];
static double stress_all[n_strided * 9], tangent_all[n_strided * 81], energy_all[n_strided];
static int status_all[n_strided];

static int same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

/* Tests of the same bits, in arrays as a caller may have them. */
static void test_strided_is_update_n(int m) {
  static const int of_state[8] = {MYOGROWTH_G_END,  MYOGROWTH_LAMBDA_E, MYOGROWTH_LAMBDA_END,
                                  MYOGROWTH_J,      MYOGROWTH_JE,       MYOGROWTH_N0,
                                  MYOGROWTH_N0 + 1, MYOGROWTH_N0 + 2};
  static const int of_start[8] = {MYOGROWTH_G,      MYOGROWTH_UNUSED, MYOGROWTH_LAMBDA, MYOGROWTH_UNUSED,
                                  MYOGROWTH_UNUSED, MYOGROWTH_N0,     MYOGROWTH_N0 + 1, MYOGROWTH_N0 + 2};
  static const int of_energy = MYOGROWTH_ENERGY;
  const int n = myogrowth_stress_size(m);
  int entry[MYOGROWTH_UNUSED + 1], status[n_strided];
  char message[message_length];
  for (int e = 0; e <= MYOGROWTH_UNUSED; ++e) entry[e] = e;
  CHECK(myogrowth_update_n(n_strided, oblique, 11, F_all, state_all, after_all, n_state, 0.1, m, stress_all,
                           tangent_all, energy_all, status_all, NULL, 0) == 1);

  { /* every component an array of its own, the points from the last to the first; one G and no fibre for all
     */
    static double F[9][n_strided], stress[9][n_strided], tangent[81][n_strided], G[n_strided];
    const double one = 1;
    struct myogrowth_input in[10];
    struct myogrowth_output out[9 + 81 + 1];
    int n_out = 0;
    for (int c = 0; c < 9; ++c) {
      for (int k = 0; k < n_strided; ++k) F[c][n_strided - 1 - k] = F_all[9 * k + c];
      in[c] = (struct myogrowth_input){F[c] + n_strided - 1, -1, 1, entry + MYOGROWTH_F + c};
    }
    in[9] = (struct myogrowth_input){&one, 0, 1, entry + MYOGROWTH_G};
    for (int c = 0; c < n; ++c)
      out[n_out++] =
          (struct myogrowth_output){stress[c] + n_strided - 1, -1, 1, entry + MYOGROWTH_STRESS + c};
    for (int c = 0; c < n * n; ++c)
      out[n_out++] = (struct myogrowth_output){tangent[c], 1, 1, entry + MYOGROWTH_TANGENT + c};
    out[n_out++] = (struct myogrowth_output){G, 1, 1, entry + MYOGROWTH_G_END};
    fill(G, n_strided, -777);
    CHECK(myogrowth_update_strided(n_strided, oblique, 11, in, 10, 0.1, m, out, n_out, 0, status, message,
                                   message_length) == 1);
    CHECK_TEXT(message, "point 40 (of 0 to 74): inverted");
    CHECK(memcmp(status, status_all, sizeof status) == 0);
    for (int k = 0; k < n_strided; ++k) {
      for (int c = 0; c < n; ++c) CHECK(same(stress[c][n_strided - 1 - k], stress_all[n * k + c]));
      for (int c = 0; c < n * n; ++c) CHECK(same(tangent[c][k], tangent_all[n * n * k + c]));
      CHECK(k == inverted_one ? G[k] == -777 : G[k] == after_all[n_state * k]);
    }
  }
  { /* all of a point side by side, the state in place, stress as a matrix of nine and twice */
    enum {
      step = 160,
      at_F = 3,
      at_state = 20,
      at_stress = 30,
      at_tangent = 45,
      at_energy = 140,
      at_again = 150
    };
    static double points[n_strided][step];
    static const int of_six[9] = {0, 3, 4, 3, 1, 5, 4, 5, 2};
    int of_stress[9];
    double* const all = &points[0][0];
    for (int i = 0; i < 9; ++i) of_stress[i] = MYOGROWTH_STRESS + (n == 9 ? i : of_six[i]);
    for (int k = 0; k < n_strided; ++k) {
      fill(points[k], step, -777);
      memcpy(points[k] + at_F, F_all + 9 * k, 9 * sizeof(double));
      memcpy(points[k] + at_state, state_all + n_state * k, 8 * sizeof(double));
    }
    const struct myogrowth_input in[] = {{all + at_F, step, 9, entry + MYOGROWTH_F},
                                         {all + at_state, step, 8, of_start}};
    const struct myogrowth_output out[] = {{all + at_stress, step, 9, of_stress},
                                           {all + at_tangent, step, n * n, entry + MYOGROWTH_TANGENT},
                                           {all + at_state, step, 8, of_state},
                                           {all + at_energy, step, 1, &of_energy},
                                           {all + at_again, step, 9, of_stress}};
    CHECK(myogrowth_update_strided(n_strided, oblique, 11, in, 2, 0.1, m, out, 5, 0, NULL, NULL, 0) == 1);
    for (int k = 0; k < n_strided; ++k) {
      const double* p = points[k];
      for (int i = 0; i < 9; ++i) {
        CHECK(same(p[at_stress + i], stress_all[n * k + of_stress[i] - MYOGROWTH_STRESS]));
        CHECK(same(p[at_again + i], p[at_stress + i]));
      }
      for (int c = 0; c < n * n; ++c) CHECK(same(p[at_tangent + c], tangent_all[n * n * k + c]));
      for (int c = 0; c < 8; ++c)
        CHECK(p[at_state + c] == (k == inverted_one ? state_all : after_all)[n_state * k + c]);
      CHECK(same(p[at_energy], energy_all[k]));
      CHECK(p[at_state + 8] == -777 && p[0] == -777 && p[at_again + 9] == -777 &&
            p[at_tangent + n * n] == -777);
    }
  }
  { /* stress and tangent twice, and some of them once more: whole registers of points, none of which fails */
    enum { first = inverted_one + 1, count = 32 };
    static double tangents[2][count * 81], stresses[2][count * 9], some[count * 4];
    const int of_some[4] = {MYOGROWTH_TANGENT + n, MYOGROWTH_ENERGY, MYOGROWTH_TANGENT, MYOGROWTH_STRESS + 1};
    const double one = 1;
    const struct myogrowth_input in[] = {{F_all + 9 * first, 9, 9, entry + MYOGROWTH_F},
                                         {&one, 0, 1, entry + MYOGROWTH_G}};
    const struct myogrowth_output all[] = {{tangents[0], n * n, n * n, entry + MYOGROWTH_TANGENT},
                                           {tangents[1], n * n, n * n, entry + MYOGROWTH_TANGENT},
                                           {some, 4, 4, of_some},
                                           {stresses[0], n, n, entry + MYOGROWTH_STRESS},
                                           {tangents[0], n * n, n * n, entry + MYOGROWTH_TANGENT},
                                           {stresses[1], n, n, entry + MYOGROWTH_STRESS}};
    const struct myogrowth_output swapped[] = {all[2], all[0]};
    const struct {
      const struct myogrowth_output* out;
      int n_out;
    } ways[] = {{all, 3},     {all, 2},     {all, 1},     {all + 1, 2}, {all + 2, 1}, {swapped, 2},
                {all + 1, 3}, {all + 2, 2}, {all + 2, 3}, {all + 3, 1}, {all + 3, 2}, {all + 3, 3}};
    for (int way = 0; way < 12; ++way) {
      const struct myogrowth_output* const out = ways[way].out;
      const int n_out = ways[way].n_out;
      /* another step first, whose numbers may be left where the blocks of this one lie */
      CHECK(myogrowth_update_strided(count, oblique, 11, in, 2, 7.0, m, all + 2, 1, 0, NULL, NULL, 0) == 0);
      fill(tangents[0], 2 * count * 81, -777);
      fill(stresses[0], 2 * count * 9, -777);
      fill(some, count * 4, -777);
      CHECK(myogrowth_update_strided(count, oblique, 11, in, 2, 0.1, m, out, n_out, 0, NULL, NULL, 0) == 0);
      for (int o = 0; o < n_out; ++o) {
        for (int k = 0; k < count; ++k) {
          const double *of_all = tangent_all + n * n * (first + k), *x = out[o].data + k * out[o].step;
          const double* of_stress = stress_all + n * (first + k);
          if (out[o].size == 4)
            CHECK(x[0] == of_all[n] && x[1] == energy_all[first + k] && x[2] == of_all[0] &&
                  x[3] == of_stress[1]);
          else if (out[o].size == n)
            CHECK(memcmp(x, of_stress, (size_t)n * sizeof(double)) == 0);
          else
            CHECK(memcmp(x, of_all, (size_t)(n * n) * sizeof(double)) == 0);
        }
      }
    }
  }
}

static void test_strided(void) {
  for (int k = 0; k < n_strided; ++k) {
    for (int i = 0; i < 9; ++i) F_all[9 * k + i] = sheared[i] + 0.02 * sin(7.0 * k + i);
    state_all[n_state * k] = 1;
  }
  F_all[9 * inverted_one] = -1;
  for (int i = 0; i < 3; ++i) test_strided_is_update_n(measures[i]);

  /* a known state is > 0, and given back by a point that fails */
  int entry[MYOGROWTH_UNUSED + 1], status[n_strided];
  for (int e = 0; e <= MYOGROWTH_UNUSED; ++e) entry[e] = e;
  double F[9 * 2], start[2 * 5] = {1.02, 1.1, 0.6, 0.48, 0.64, 0, 1.1, 1, 0, 0}, end[2 * 5], rest[2 * 4],
                             P[2 * 9];
  static const int of_end[5] = {MYOGROWTH_G_END, MYOGROWTH_LAMBDA_END, MYOGROWTH_N0, MYOGROWTH_N0 + 1,
                                MYOGROWTH_N0 + 2};
  static const int of_rest[4] = {MYOGROWTH_LAMBDA_E, MYOGROWTH_J, MYOGROWTH_JE, MYOGROWTH_ENERGY};
  memcpy(F, sheared, sizeof sheared);
  memcpy(F + 9, sheared, sizeof sheared);
  struct myogrowth_input in[] = {{F, 9, 9, entry + MYOGROWTH_F}, {start, 5, 5, entry + MYOGROWTH_G}};
  struct myogrowth_output out[] = {
      {end, 5, 5, of_end}, {rest, 4, 4, of_rest}, {P, 9, 9, entry + MYOGROWTH_STRESS}};
  char message[message_length];
  CHECK(myogrowth_update_strided(2, oblique, 11, in, 2, 0.1, MYOGROWTH_FIRST_PIOLA, out, 3, 1, status,
                                 message, message_length) == 1);
  CHECK_TEXT(message, "point 1 (of 0 to 1): G = 0 on entry: must be > 0");
  CHECK(status[0] == MYOGROWTH_OK && status[1] == MYOGROWTH_BAD_STATE);
  CHECK(end[0] > 1.02 && memcmp(end + 5, start + 5, 5 * sizeof(double)) == 0);
  CHECK(all_nan(rest + 4, 4) && all_nan(P + 9, 9) && isfinite(P[0] + rest[0]));
  /* an only point may have any step, its state in place too */
  double only[5];
  memcpy(only, start, sizeof only);
  const struct myogrowth_input one_in[] = {{F, 0, 9, entry + MYOGROWTH_F}, {only, 0, 5, entry + MYOGROWTH_G}};
  const struct myogrowth_output one_out[] = {{only, 0, 1, of_end}};
  CHECK(myogrowth_update_strided(1, oblique, 11, one_in, 2, 0.1, MYOGROWTH_FIRST_PIOLA, one_out, 1, 1, NULL,
                                 message, message_length) == 0);
  CHECK(only[0] == end[0] && memcmp(only + 1, start + 1, 4 * sizeof(double)) == 0);
  /* what is wrong with props is wrong for all */
  CHECK(myogrowth_update_strided(2, table_1, 5, in, 2, 0.1, MYOGROWTH_FIRST_PIOLA, out, 3, 1, status, message,
                                 message_length) == 2);
  CHECK_TEXT(message, "NPROPS = 5");
  CHECK(status[0] == MYOGROWTH_BAD_PARAMETER && all_nan(P, 18) && memcmp(end, start, sizeof end) == 0);

  /* arrays that are not as they have to be: nothing is written */
  double big[100];
  const double second_order[12] = {16, 4, 0.5, 2, 1.3, 1.01, 1, 0, 0, 0, 0, 1};
  const struct {
    const char* words;
    struct myogrowth_input in[2];
    int n_in;
    struct myogrowth_output out[2];
    int n_out, measure, n_props;
  } bad[] = {
#define GOOD_F {F, 9, 9, entry}
#define OUT_P \
  { P, 9, 9, entry + MYOGROWTH_STRESS }
      {"n_in = -1: must be >= 0", {GOOD_F}, -1, {OUT_P}, 1, 1, 11},
      {"F11: is in no array of in", {{start, 5, 5, entry + MYOGROWTH_G}}, 1, {OUT_P}, 1, 1, 11},
      {"F33: is in no array of in", {{F, 9, 8, entry}}, 1, {OUT_P}, 1, 1, 11},
      {"in[0].data = NULL", {{NULL, 9, 9, entry}}, 1, {OUT_P}, 1, 1, 11},
      {"in[0].entry = NULL", {{F, 9, 9, NULL}}, 1, {OUT_P}, 1, 1, 11},
      {"in[0].size = 0: must be >= 1", {{F, 9, 0, entry}}, 1, {OUT_P}, 1, 1, 11},
      {"in[1].entry[0] = 8: must be a number that comes in, and be there once",
       {GOOD_F, {F, 0, 1, entry + 8}},
       2,
       {OUT_P},
       1,
       1,
       11},
      {"in[1].entry[1] = 14", {GOOD_F, {big, 0, 2, entry + 13}}, 2, {OUT_P}, 1, 1, 11},
      {"n_out = -2", {GOOD_F}, 1, {OUT_P}, -2, 1, 11},
      {"out[0].data = NULL", {GOOD_F}, 1, {{NULL, 9, 9, entry + MYOGROWTH_STRESS}}, 1, 1, 11},
      {"out[0].step = 8: must be >= size = 9", {GOOD_F}, 1, {{P, 8, 9, entry + MYOGROWTH_STRESS}}, 1, 1, 11},
      {"out[0].step = -8", {GOOD_F}, 1, {{big + 50, -8, 9, entry + MYOGROWTH_STRESS}}, 1, 1, 11},
      {"out[0].entry[6] = 20: must be a number that comes out, in this measure",
       {GOOD_F},
       1,
       {OUT_P},
       1,
       0,
       11},
      {"out[0].entry[36] = 59", {GOOD_F}, 1, {{big, 40, 37, entry + MYOGROWTH_TANGENT}}, 1, 2, 11},
      {"out[0].entry[0] = 9", {GOOD_F}, 1, {{P, 1, 1, entry + MYOGROWTH_G}}, 1, 1, 11},
      {"out[0].entry[0] = -3", {GOOD_F}, 1, {{P, 1, 1, (const int[]){-3}}}, 1, 1, 11},
      {"out[0] overlaps in[0]", {GOOD_F}, 1, {{F, 9, 9, entry + MYOGROWTH_STRESS}}, 1, 1, 11},
      {"out[0] overlaps in[0]", {GOOD_F}, 1, {{F + 17, 10, 9, entry + MYOGROWTH_STRESS}}, 1, 1, 11},
      {"out[1] overlaps out[0]",
       {GOOD_F},
       1,
       {{big, 40, 9, entry + 14}, {big + 48, 12, 9, entry + 14}},
       2,
       1,
       11},
      {"out[1] overlaps out[0]",
       {GOOD_F},
       1,
       {{big, 40, 9, entry + 14}, {big + 40, 40, 1, entry + 14}},
       2,
       1,
       11},
      {"out[0] overlaps in[1]: only the state",
       {GOOD_F, {big, 5, 5, entry + 9}},
       2,
       {{big, 5, 1, entry + 106}},
       1,
       1,
       11},
      {"measure = 4", {GOOD_F}, 1, {OUT_P}, 1, 4, 11},
      {"lambda: is in no array of in: with PROPS(12) = 1 it is needed", {GOOD_F}, 1, {OUT_P}, 1, 1, 12},
  };
  for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
    double before[18];
    fill(P, 18, -777);
    memcpy(before, F, sizeof F);
    CHECK(myogrowth_update_strided(2, bad[k].n_props == 12 ? second_order : oblique, bad[k].n_props,
                                   bad[k].in, bad[k].n_in, 0.1, bad[k].measure, bad[k].out, bad[k].n_out, 0,
                                   status, message, message_length) == 2);
    CHECK_TEXT(message, bad[k].words);
    CHECK(status[0] == MYOGROWTH_BAD_ARGUMENT && status[1] == MYOGROWTH_BAD_ARGUMENT);
    CHECK(memcmp(before, F, sizeof F) == 0 && (bad[k].n_props == 12 ? isnan(P[0]) : P[0] == -777));
  }
  CHECK(myogrowth_update_strided(2, oblique, 11, NULL, 1, 0.1, 1, out, 1, 0, status, message,
                                 message_length) == 2);
  CHECK_TEXT(message, "in = NULL: n_in = 1 arrays are needed");
  CHECK(myogrowth_update_strided(2, oblique, 11, in, 2, 0.1, 1, NULL, 1, 0, NULL, NULL, 0) == 2);
  CHECK(myogrowth_update_strided(0, NULL, 0, NULL, 1, 0.1, 1, NULL, 1, 0, NULL, NULL, 0) == 0);

  /* an array between the points of another */
  const struct myogrowth_input apart[] = {{big, 60, 9, entry}};
  const struct myogrowth_output between[] = {{big + 10, 9, 9, entry + MYOGROWTH_STRESS}};
  memcpy(big, sheared, sizeof sheared);
  memcpy(big + 60, sheared, sizeof sheared);
  CHECK(myogrowth_update_strided(2, oblique, 11, apart, 1, 0.1, MYOGROWTH_FIRST_PIOLA, between, 1, 0, NULL,
                                 message, message_length) == 0);
  CHECK(memcmp(big + 10, big + 19, 9 * sizeof *big) == 0 && isfinite(big[10]));
}

int main(void) {
  test_tables();
  test_check();
  test_messages_are_cut_to_the_room();
  test_cube();
  test_state();
  test_measures_agree();
  test_tangents();
  test_null_outputs();
  test_refusals();
  test_many_points();
  test_strided();
  printf(failures == 0 ? "C API: all is well\n" : "C API: %d checks failed\n", failures);
  return failures != 0;
}
