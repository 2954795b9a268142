// The UMAT, the VUMAT, the C API and CalculiX's routines from four threads at once, on inputs that the
// threads share, for ThreadSanitizer: no race, and the bits that one thread gets. A program of its own,
// because GoogleTest is not built for that sanitizer. Returns 1 on a difference.
#include <myogrowth.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

#include "../support/ccx_host.hpp"
#include "../support/umat_host.hpp"

namespace {
// What the routines said through the host's utilities: the number of messages, and a sum over their letters.
std::atomic<long> messages{0}, letters{0}, exits{0};

void listen(const char* text, std::size_t length) {
  long sum = 0;
  for (std::size_t i = 0; i < length; ++i) sum += static_cast<long>(i + 1) * text[i];
  ++messages;
  letters += sum;
}
}  // namespace

extern "C" {
void stdb_abqerr_(const int*, const char* text, const int*, const void*, const char*, std::size_t length,
                  std::size_t) {
  listen(text, length);
}
void xplb_abqerr_(const int*, const char* text, const int*, const void*, const char*, std::size_t length,
                  std::size_t) {
  listen(text, length);
}
void xit_() { ++exits; }
void xplb_exit_() { ++exits; }
}

namespace {

constexpr int n_points = 8, n_state = 9, n_rounds = 300;

// What the threads share, and only read.
const std::vector<double> oblique = {16, 4, 0.5, 2, 1.3, 1.01, 0.6, 0.48, 0.64, 0, 0},
                          turned = {16, 4, 0.5, 2, 1.3, 1.01, 0.6, 0.48, 0.64, 1, 0},
                          faulty = {16, 4, 0.5, 2, 0.9, 1.01};

// Everything that came back, in the order of the calls.
using Results = std::vector<double>;

// F of a point in a round, column by column; now and then one that is turned inside out.
std::array<double, 9> deformation(int round, int point) {
  std::array<double, 9> F = {1.15, 0.05, -0.03, 0.1, 1.1, 0.04, -0.06, 0.08, 1.2};
  for (std::size_t i = 0; i < 9; ++i)
    F[i] += 0.02 * ((round * 7 + point * 3 + static_cast<int>(i) * 5) % 11 - 5);
  if ((round + point) % 13 == 0) F[0] = -1;
  return F;
}

const std::vector<double>& props_of(int round) {
  return round % 10 == 9 ? faulty : round % 2 ? turned : oblique;
}

double state_of(int round, int i) { return i > 0 ? 0 : round % 17 == 16 ? -1 : 1 + 0.01 * (round % 5); }

void call_umat(int round, Results& all) {
  const int families[] = {6, 4, 3};
  const std::vector<double>& props = props_of(round);
  for (int point = 0; point < n_points; ++point) {
    const int ntens = families[point % 3], nstatv = n_state, nprops = static_cast<int>(props.size());
    const int nshr = ntens == 6 ? 3 : 1, ndi = ntens - nshr;
    const auto F = deformation(round, point);
    double stress[6] = {}, ddsdde[36] = {}, statev[n_state], sse = 0, rpl = 0, drpldt = 0, ddsddt[6],
           drplde[6];
    for (int i = 0; i < n_state; ++i) statev[i] = state_of(round, i);
    double pnewdt = 1;
    const double dtime = 0.1;
    umat_(stress, statev, ddsdde, &sse, nullptr, nullptr, &rpl, ddsddt, drplde, &drpldt, nullptr, nullptr,
          nullptr, &dtime, nullptr, nullptr, nullptr, nullptr, nullptr, &ndi, &nshr, &ntens, &nstatv,
          props.data(), &nprops, nullptr, nullptr, &pnewdt, nullptr, nullptr, F.data(), nullptr, nullptr,
          nullptr, nullptr, nullptr, nullptr);
    all.insert(all.end(), stress, stress + 6);
    all.insert(all.end(), ddsdde, ddsdde + 36);
    all.insert(all.end(), statev, statev + n_state);
    all.insert(all.end(), {sse, pnewdt});
  }
}

void call_vumat(int round, Results& all) {
  const std::vector<double>& props = props_of(round);
  const int n = n_points, three = 3, nstatev = n_state, nprops = static_cast<int>(props.size());
  const double time = round % 19 == 18 ? 0 : 1, dt = 0.1;
  std::vector<double> U(6 * n_points), old(6 * n_points, 0.0), state(n_state * n_points), ones(n_points, 1.0);
  for (std::size_t k = 0; k < n_points; ++k) {
    const auto F = deformation(round, static_cast<int>(k));
    const std::size_t entry[6] = {0, 4, 8, 3, 7, 6};  // 11 22 33 12 23 31
    for (std::size_t i = 0; i < 6; ++i) U[k + n_points * i] = F[entry[i]];
    for (std::size_t i = 0; i < 3; ++i) old[k + n_points * i] = 1;
    for (std::size_t i = 0; i < n_state; ++i) state[k + n_points * i] = state_of(round, static_cast<int>(i));
  }
  std::vector<double> stress(6 * n_points), state_new(n_state * n_points), intern(n_points), inelas(n_points);
  vumat_(&n, &three, &three, &nstatev, nullptr, &nprops, nullptr, &time, &time, &dt, nullptr, nullptr,
         nullptr, props.data(), ones.data(), U.data(), nullptr, nullptr, old.data(), nullptr, nullptr,
         old.data(), state.data(), ones.data(), ones.data(), nullptr, U.data(), nullptr, nullptr,
         stress.data(), state_new.data(), intern.data(), inelas.data());
  for (const auto* part : {&stress, &state_new, &intern, &inelas})
    all.insert(all.end(), part->begin(), part->end());
}

void call_c_api(int round, Results& all) {
  const std::vector<double>& props = props_of(round);
  const int measure = round % 3;
  for (int point = 0; point < n_points; ++point) {
    const auto F = deformation(round, point);
    double state[n_state], stress[9] = {}, tangent[81] = {}, energy = 0;
    char message[300] = "";
    for (int i = 0; i < n_state; ++i) state[i] = state_of(round, i);
    const int status =
        myogrowth_update(props.data(), static_cast<int>(props.size()), F.data(), state, state, n_state, 0.1,
                         measure, stress, tangent, &energy, message, sizeof message);
    all.insert(all.end(), state, state + n_state);
    all.insert(all.end(), stress, stress + 9);
    all.insert(all.end(), tangent, tangent + 81);
    all.insert(all.end(), {energy, static_cast<double>(status)});
    for (const char* letter = message; *letter; ++letter) all.push_back(*letter);
  }
}

// No faulty input: that ends the process.
void call_ccx(int round, Results& all) {
  const int n_props = static_cast<int>(oblique.size()), n_statev = n_state, kode = -100 - n_props, icmd = 1;
  const int mi[] = {n_points}, iel = 1;
  const double dtime = 0.1;
  double before[n_state * n_points], after[n_state * n_points] = {};
  for (int i = 0; i < n_state * n_points; ++i) before[i] = i % n_state ? 0 : 1 + 0.01 * (round % 5);
  for (int point = 1; point <= n_points; ++point) {
    const auto F = deformation(round, point);
    double S[6], dS_dE[36], stiff[21], statev[n_state], pnewdt = -1;
    for (int i = 0; i < n_state; ++i) statev[i] = before[i];
    CCX(S, statev, dS_dE, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
        nullptr, &dtime, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &n_statev,
        oblique.data(), &n_props, nullptr, nullptr, &pnewdt, nullptr, nullptr, F.data(), nullptr, nullptr,
        nullptr, nullptr, nullptr, nullptr, 0);
    all.insert(all.end(), S, S + 6);
    all.insert(all.end(), dS_dE, dS_dE + 36);
    all.insert(all.end(), statev, statev + n_state);
    NATIVE(nullptr, &iel, &point, &kode, oblique.data(), nullptr, nullptr, nullptr, nullptr, nullptr,
           F.data(), nullptr, nullptr, nullptr, &dtime, nullptr, nullptr, &icmd, nullptr, mi, &n_statev,
           before, after, S, stiff, nullptr, nullptr, nullptr, &pnewdt, nullptr, 0);
    all.insert(all.end(), S, S + 6);
    all.insert(all.end(), stiff, stiff + 21);
    all.push_back(pnewdt);
  }
  all.insert(all.end(), after, after + n_state * n_points);
}

// The routines in turn; `first` is another one for every thread, so that different ones meet.
Results run(int first) {
  void (*const routines[])(int, Results&) = {call_umat, call_vumat, call_c_api, call_ccx};
  Results of[4];
  for (int round = 0; round < n_rounds; ++round) {
    for (int i = 0; i < 4; ++i) routines[(first + i) % 4](round, of[(first + i) % 4]);
  }
  for (int i = 1; i < 4; ++i) of[0].insert(of[0].end(), of[i].begin(), of[i].end());
  return of[0];
}

struct Said {
  long messages_, letters_, exits_;
};
Said said() { return {messages.exchange(0), letters.exchange(0), exits.exchange(0)}; }

}  // namespace

int main() {
  constexpr int n_threads = 4;
  const Results expected = run(0);
  const Said once = said();

  Results made[n_threads];
  std::vector<std::thread> threads;
  for (int i = 0; i < n_threads; ++i) threads.emplace_back([&made, i] { made[i] = run(i); });
  for (std::thread& thread : threads) thread.join();
  const Said by_all = said();

  int differences = 0;
  for (const Results& m : made)
    differences +=
        m.size() != expected.size() || std::memcmp(m.data(), expected.data(), m.size() * sizeof(double)) != 0;
  const bool heard = once.messages_ > 0 && once.exits_ == once.messages_ &&
                     by_all.messages_ == n_threads * once.messages_ &&
                     by_all.letters_ == n_threads * once.letters_ && by_all.exits_ == n_threads * once.exits_;
  std::printf("%zu numbers a thread, %d of %d threads differ; %ld messages a thread%s\n", expected.size(),
              differences, n_threads, once.messages_, heard ? "" : ", but not those of one thread");
  return differences == 0 && heard ? 0 : 1;
}
