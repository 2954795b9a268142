// Coverage-guided fuzzing of the VUMAT in double precision under the sanitizers (clang's libFuzzer), a block
// at a time: whatever a host passes, nothing crashes, what is not allowed is reported once, a point that
// fails keeps its state and its neighbours, and a result is a result.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "../../abi/abaqus.h"
#include "bytes.hpp"
#include "rules.hpp"

namespace {
std::string message;
int messages, exits;
}  // namespace

extern "C" {
void xplb_abqerr_(const int* lop, const char* text, const int*, const void*, const char*, std::size_t length,
                  std::size_t) {
  message.assign(text, length);
  messages += *lop == -2;
}
void xplb_exit_() { ++exits; }
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
}

namespace {

using rules::Numbers;
constexpr double untouched = -777;

/// One call's arguments and what came back, all of the size that the VUMAT is told.
struct Block {
  std::size_t size = 1;
  int ndir = 3, nshr = 3;
  double step_time = 1, total_time = 1, dt = 0.1;
  Numbers props, density, strain_inc, stretch_old, stress_old, state_old, intern_old, inelas_old, stretch,
      field;
  Numbers stress, state, intern, inelas;

  std::size_t components() const { return static_cast<std::size_t>(std::max(0, ndir + nshr)); }
  bool is_data_check() const { return step_time == 0 && total_time == 0; }

  void run() {
    const int n = static_cast<int>(size), nstatev = static_cast<int>(state_old.size() / size);
    const int nprops = static_cast<int>(props.size()), n_fields = 1;
    stress.assign(components() * size, untouched);
    state.assign(state_old.size(), untouched);
    intern.assign(size, untouched);
    inelas.assign(size, untouched);
    message.clear();
    messages = exits = 0;
    vumat_(&n, &ndir, &nshr, &nstatev, &n_fields, &nprops, nullptr, &step_time, &total_time, &dt, nullptr,
           nullptr, nullptr, props.data(), density.data(), strain_inc.data(), nullptr, nullptr,
           stretch_old.data(), nullptr, nullptr, stress_old.data(), state_old.data(), intern_old.data(),
           inelas_old.data(), nullptr, stretch.data(), nullptr, field.data(), stress.data(), state.data(),
           intern.data(), inelas.data());
  }

  /// What belongs to point k of an array of the block.
  Numbers at(const Numbers& array, std::size_t k) const {
    Numbers own;
    for (std::size_t i = k; i < array.size(); i += size) own.push_back(array[i]);
    return own;
  }
  Block alone(std::size_t k) const {
    Block one = *this;
    one.size = 1;
    for (Numbers Block::*array :
         {&Block::density, &Block::strain_inc, &Block::stretch_old, &Block::stress_old, &Block::state_old,
          &Block::intern_old, &Block::inelas_old, &Block::stretch, &Block::field})
      one.*array = at(this->*array, k);
    return one;
  }
};

void print(const char* name, const Numbers& x) {
  std::fprintf(stderr, "\n%s", name);
  for (double y : x) std::fprintf(stderr, " %.17g", y);
}

/// b: a single point, the one that is at fault.
void require(bool holds, const char* what, const Block& b) {
  if (holds) return;
  std::fprintf(stderr, "FAILED: %s\n%d messages, the last: %s\nNDIR %d NSHR %d times %.17g %.17g DT %.17g",
               what, messages, message.c_str(), b.ndir, b.nshr, b.step_time, b.total_time, b.dt);
  print("PROPS", b.props);
  print("stretchNew", b.stretch);
  print("stretchOld", b.stretch_old);
  print("stateOld", b.state_old);
  print("density", b.density);
  print("strainInc", b.strain_inc);
  print("stressOld", b.stress_old);
  print("stressNew", b.stress);
  print("stateNew", b.state);
  print("enerInternNew", b.intern);
  std::fprintf(stderr, "\n");
  std::abort();
}

bool reads_field(const Block& b) { return b.props.size() > 19 && b.props[18] != 0 && b.props[19] == -1; }
/// What is wrong for all points at once.
bool is_faulty(const Block& b) {
  if (reads_field(b)) {
    Block number = b;
    number.props[19] = 0.5;
    return is_faulty(number);
  }
  return b.ndir != 3 || b.nshr != 3 || rules::has_no_room(b.props, b.state_old.size() / b.size) ||
         rules::props_are_faulty_with_laws(b.props);
}
bool has_faulty_state(const Block& point) {
  const double a = point.field[0];
  if (reads_field(point) && !(a >= -1e-9 && a <= 1 + 1e-9)) return true;
  return rules::state_is_faulty(point.props, point.state_old) ||
         rules::has_no_fibre(point.props, point.state_old);
}

/// F of a symmetric stretch in VUMAT's order, 11 22 33 12 23 31.
Numbers nine_of(const Numbers& s) { return {s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]}; }

double stretch_along(const Numbers& F, Numbers n) {
  const double longest = rules::largest(n);
  for (double& x : n) x /= longest;
  const double length = std::hypot(n[0], n[1], n[2]);
  for (double& x : n) x /= length;
  return std::hypot(F[0] * n[0] + F[3] * n[1] + F[6] * n[2], F[1] * n[0] + F[4] * n[1] + F[7] * n[2],
                    F[2] * n[0] + F[5] * n[1] + F[8] * n[2]);
}

bool same_but_for_nans(const Numbers& a, const Numbers& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!rules::same_bits({a[i]}, {b[i]}) && !(std::isnan(a[i]) && std::isnan(b[i]))) return false;
  }
  return a.size() == b.size();
}

/// Hooke's law for made-up strain increments; the state stands still.
void check_data_check(const Block& b) {
  require(rules::same_bits(b.state, b.state_old) && rules::same_bits(b.intern, b.intern_old),
          "the data check touched the state", b);
  const bool has_law = b.props.size() > 18 && b.props[18] != 0;  // another one's moduli: vumat_test.cpp
  if (has_law || rules::largest(b.strain_inc) > 1e3 || rules::largest(b.stress_old) > 1e3 ||
      b.props[0] > 1e3 || b.props[1] > 1e3 || !rules::all_finite(b.strain_inc) ||
      !rules::all_finite(b.stress_old))
    return;
  for (std::size_t i = 0; i < 6; ++i) {
    const double volume = i < 3 ? b.strain_inc[0] + b.strain_inc[1] + b.strain_inc[2] : 0;
    const double expected = b.stress_old[i] + b.props[0] * volume + 2 * b.props[1] * b.strain_inc[i];
    require(std::abs(b.stress[i] - expected) < 1e-8, "not Hooke's law", b);
  }
}

/// b: a single point that has been run, of a call without a fault.
void check_point(const Block& b) {
  const Numbers F = nine_of(b.stretch);
  require(rules::same_bits(b.inelas, b.inelas_old), "enerInelas was not carried over", b);
  if (!rules::all_finite(b.stress)) {
    require(rules::all_nan(b.stress), "no result, and the stress is not NaN", b);
    require(rules::same_bits(b.state, b.state_old), "no result, and the state was touched", b);
    require(rules::all_nan(b.intern), "no result, and the energy is not NaN", b);
    require(has_faulty_state(b) || !rules::is_ordinary(b.props, b.state_old, F, b.dt) ||
                !std::isfinite(b.intern_old[0]) || !(b.density[0] > 1e-20) ||
                !rules::all_finite(b.stretch_old) || rules::largest(b.stretch_old) > 10 ||
                rules::det(nine_of(b.stretch_old)) < 0,
            "an ordinary point was refused", b);
    return;
  }
  require(!has_faulty_state(b) && !rules::is_hopeless(F, b.dt), "a result in spite of a fault", b);
  const double along = stretch_along(F, rules::fibre(b.props, b.state_old));
  const char* wrong = rules::what_is_wrong(b.state, b.state_old, b.props, F, along);
  require(!wrong, wrong, b);
  require(std::isfinite(b.intern[0]), "enerIntern is not finite", b);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes{data, size};
  const unsigned kind = bytes.byte(), shape = bytes.byte();
  Block b;
  b.size = 1 + kind % 5;
  if (shape >= 240) b.ndir = static_cast<int>(shape % 6) - 1, b.nshr = static_cast<int>(bytes.byte() % 6) - 1;
  const std::size_t n_state = shape % 4 ? 7 + shape % 4 : shape / 4 % 14;
  if (kind % 8 == 0) b.step_time = b.total_time = 0;
  if (kind % 8 == 1) b.step_time = bytes.number(), b.total_time = bytes.number();
  b.dt = kind & 8 ? bytes.number() : std::exp2(10 * bytes.mild());
  b.props = bytes.props();
  if (b.props.size() > 19 && shape & 1) b.props[19] = -1;

  // A point at a time, for the sake of the mutations; the arrays have them one beside the other.
  const std::size_t n = b.size, six = b.components();
  const auto put = [n](Numbers& array, std::size_t k, const Numbers& own) {
    array.resize(own.size() * n);
    for (std::size_t i = 0; i < own.size(); ++i) array[k + n * i] = own[i];
  };
  for (std::size_t k = 0; k < n; ++k) {
    const unsigned point = bytes.byte();
    Numbers U(six, 0), U_old(six, 0);
    for (std::size_t i = 0; i < six; ++i) U[i] = (i < 3 ? 1 : 0) + 0.4 * bytes.mild();
    for (std::size_t i = 0; i < six && i < 3; ++i) U_old[i] = 1;
    put(b.stretch, k, point & 1 ? bytes.numbers(six) : U);
    put(b.stretch_old, k, point & 2 ? bytes.numbers(six) : U_old);
    put(b.state_old, k, bytes.state(n_state));
    put(b.density, k, {point & 4 ? bytes.number() : 1});
    put(b.intern_old, k, {point & 8 ? bytes.number() : 3});
    put(b.inelas_old, k, {point & 8 ? bytes.number() : 4});
    put(b.field, k, {point & 16 ? bytes.number() : 0.5});
    put(b.strain_inc, k, b.is_data_check() ? bytes.numbers(six) : Numbers(six, NAN));
    put(b.stress_old, k, b.is_data_check() ? bytes.numbers(six) : Numbers(six, NAN));
  }

  b.run();
  require(message.size() <= 500 && message.find('%') == std::string::npos, "a message not fit for Abaqus", b);
  bool expected = is_faulty(b);
  for (std::size_t k = 0; k < n && !is_faulty(b) && !b.is_data_check(); ++k)
    expected = expected || has_faulty_state(b.alone(k));
  require(messages == exits && messages == (expected ? 1 : 0), "one message for a fault, else none", b);
  if (is_faulty(b)) {
    require(rules::all_nan(b.stress) && rules::all_nan(b.intern), "a fault, and stress or energy is not NaN",
            b);
    require(rules::same_bits(b.state, b.state_old) && rules::same_bits(b.inelas, b.inelas_old),
            "a fault, and the state was touched", b);
    return 0;
  }
  for (std::size_t k = 0; k < n; ++k) {
    Block one = b.alone(k);
    one.run();
    b.is_data_check() ? check_data_check(one) : check_point(one);
    require(same_but_for_nans(one.stress, b.at(b.stress, k)) &&
                same_but_for_nans(one.state, b.at(b.state, k)) &&
                same_but_for_nans(one.intern, b.at(b.intern, k)) &&
                same_but_for_nans(one.inelas, b.at(b.inelas, k)),
            "a point depends on its neighbours", one);
  }
  return 0;
}
