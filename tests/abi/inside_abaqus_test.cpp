// The single-file UMAT as it is compiled inside Abaqus: every name comes from FOR_NAME of (a stand-in for)
// omi_for_c.h.
#include <cstddef>
#include <cstdio>
#include <string>

#include "../support/umat_host.hpp"

extern "C" {
static std::string message;
static int exits = 0;
void stdb_abqerr_in_abaqus(const int*, const char* text, const int*, const void*, const char*,
                           std::size_t length, std::size_t) {
  message.assign(text, length);
}
void xit_in_abaqus() { ++exits; }
}

int main() {
  host::Call good, same, bad;
  good.F(0, 0) = same.F(0, 0) = 1.1;
  good.dtime = same.dtime = 0.5;
  good.run(umat_in_abaqus);
  same.run(myogrowth_umat_in_abaqus);
  bad.props[2] = 0;
  bad.run(umat_in_abaqus);
  const bool right = std::abs(good.statev[0] - 1.02931485) < 5e-9 && good.stress == same.stress &&
                     exits == 1 && message.find("PROPS(3) = 0: tau") != std::string::npos;
  if (!right) std::printf("G %.10f, exits %d, message: %s\n", good.statev[0], exits, message.c_str());
  return right ? 0 : 1;
}
