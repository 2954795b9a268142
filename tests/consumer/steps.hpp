// One step by every routine of the headers, as plain numbers: a translation unit of its own for each set of
// options.
#ifndef MYOGROWTH_TESTS_STEPS_HPP
#define MYOGROWTH_TESTS_STEPS_HPP

namespace steps {

struct Input {
  double F[9] = {1.2, 0.01, 0, 0.02, 0.95, 0, 0, 0.03, 0.95};
  double n0[3] = {1, 0.1, 0};
  double G = 1, lambda = 1, dt = 0.1;
  double gamma = 2, tau_rev = 0;
  bool second_order = false;
};
/// status: that of the routine, 0 for ok. Everything that it gives is in `numbers`.
struct Output {
  int status;
  double numbers[50];
};

Output by_update(const Input& in);
Output by_batch(const Input& in);
Output by_update_fast(const Input& in);
Output by_batch_fast(const Input& in);

}  // namespace steps

#endif
