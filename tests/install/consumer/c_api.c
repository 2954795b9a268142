/* The same step through the C API. */
#include <myogrowth.h>
#include <stdio.h>

int main(void) {
  const double props[] = {16, 4, 0.5, 2, 1.1, 1.01}, F[9] = {1.2, 0, 0, 0, 0.95, 0, 0, 0, 0.95};
  double state[9] = {0}, sigma[6];
  char why[200];
  if (myogrowth_update(props, 6, F, state, state, 9, 0.1, MYOGROWTH_CAUCHY, sigma, NULL, NULL, why,
                       sizeof why) != MYOGROWTH_OK) {
    fprintf(stderr, "%s\n", why);
    return 1;
  }
  printf("%.17g %.17g\n", state[0], sigma[0]);
  return 0;
}
