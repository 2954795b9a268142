// Prints the manual's tables of PROPS and STATEV from the tables that the UMAT itself uses.
#include <cstdio>

#include "../../abi/properties.hpp"

int main() {
  using namespace myogrowth::abi;
  std::printf("| PROPS | symbol | unit | meaning | allowed | default |\n|---|---|---|---|---|---|\n");
  for (int i = 0; i < n_props; ++i) {
    const Property& p = property(i);
    std::printf("| %d | `%s` | %s | %s | %s | ", i + 1, p.symbol, p.unit, p.meaning, text(p.allowed));
    i < n_props_required ? std::printf("required |\n") : std::printf("%g |\n", p.initial);
  }
  std::printf("\n| STATEV | symbol | meaning |\n|---|---|---|\n");
  for (int i = 0; i < n_statev; ++i) {
    std::printf("| %d | `%s` | %s |\n", i + 1, state_variable(i).symbol, state_variable(i).meaning);
  }
}
