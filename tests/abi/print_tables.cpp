// Prints the manual's tables of PROPS and STATEV from the tables that the UMAT itself uses.
#include <cstdio>

#include "../../abi/elastic_laws.hpp"

int main() {
  using namespace myogrowth::abi;
  std::printf("| PROPS | symbol | unit | meaning | allowed | default |\n|---|---|---|---|---|---|\n");
  for (int i = 0; i < n_props; ++i) {
    const Property& p = property(i);
    std::printf("| %d | `%s` | %s | %s | %s | ", i + 1, p.symbol, p.unit, p.meaning, text(p.allowed));
    i < n_props_required ? std::printf("required |\n") : std::printf("%g |\n", p.initial);
  }
  std::printf(
      "\n| elastic law | PROPS | symbol | unit | meaning | allowed | default "
      "|\n|---|---|---|---|---|---|---|\n");
  std::printf("| all | %d | `law` | - | 0: eq. 3, 1: Roehrle, 2: Blemker, 3: Ehret | 0, 1, 2 or 3 | 0 |\n",
              law_entry + 1);
  std::printf(
      "| 1, 2, 3 | %d | `activation` | - | constant over the step; -1: field variable 1 | 0 to 1, or -1 | 0 "
      "|\n",
      activation_entry + 1);
  for (int law = 1; law <= n_laws; ++law) {
    const LawParameters& table = parameters_of(static_cast<Law>(law));
    for (int i = 0; i < table.size; ++i) {
      const Property& p = table.entry[i];
      std::printf("| %d %s | %d | `%s` | %s | %s | %s | %g |\n", law, table.name, first_law_parameter + i + 1,
                  p.symbol, p.unit, p.meaning, text(p.allowed), p.initial);
    }
  }
  std::printf("\n| STATEV | symbol | meaning |\n|---|---|---|\n");
  for (int i = 0; i < n_statev; ++i) {
    std::printf("| %d | `%s` | %s |\n", i + 1, state_variable(i).symbol, state_variable(i).meaning);
  }
}
