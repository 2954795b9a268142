// Makes numbers and arguments, valid or wild, from the bytes that libFuzzer passes.
#ifndef MYOGROWTH_TESTS_FUZZ_BYTES_HPP
#define MYOGROWTH_TESTS_FUZZ_BYTES_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

/// Reads numbers from the fuzzer's bytes: special values by a single byte, any value by nine. Zeros after the
/// end.
struct Bytes {
  const std::uint8_t* at;
  std::size_t left;

  unsigned byte() {
    if (left == 0) return 0;
    --left;
    return *at++;
  }
  double number() {
    static const double telling[] = {0,    1,      -1,       1.1,  1.01,      0.5,    2,    16,
                                     4,    1e-300, 1e300,    1e-8, 1 + 1e-15, 0.999,  -0.3, 3,
                                     1e-3, 100,    INFINITY, NAN,  5e-324,    -1e-320};
    const unsigned choice = byte();
    constexpr unsigned n = sizeof telling / sizeof *telling;
    if (choice < 200) return telling[choice % n];
    double x = 0;
    unsigned char raw[8];
    for (unsigned char& b : raw) b = static_cast<unsigned char>(byte());
    std::memcpy(&x, raw, 8);
    return x;
  }
  /// In [-1, 1), by a single byte.
  double mild() { return (static_cast<int>(byte() ^ 128u) - 128) / 128.0; }

  /// n numbers of any kind.
  std::vector<double> numbers(std::size_t n) {
    std::vector<double> all(n);
    for (double& x : all) x = number();
    return all;
  }
  /// PROPS: valid in two of four cases, valid except one entry in one of four, otherwise of any kind and
  /// number.
  std::vector<double> props() {
    const unsigned kind = byte();
    if (kind % 4 == 3) return numbers(byte() % 20);
    std::vector<double> p = {16, 4, 0.5, 2, 0.1, 1.01, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    for (std::size_t i = 0; i < 6; ++i) p[i] *= std::exp2((i < 5 ? 4 : 1) * mild());
    p[4] += 1;  // G_max
    for (std::size_t i = 6; i < 9; ++i) p[i] += mild();
    const unsigned options = byte(), n = byte() % 16;
    for (std::size_t i = 9; i < 12; ++i) p[i] = options >> i % 3 & 1;  // frame, energy, integration
    if (options & 8) p[12] = std::exp2(10 * mild() - 10);
    if (options & 16) {  // removal
      const double removal[4] = {std::exp2(4 * mild()), 2 + 2 * mild(), 0.5 + 0.4 * mild(),
                                 p[5] * (0.8 + 0.2 * mild())};
      std::copy(removal, removal + 4, p.begin() + 13);
    }
    p.resize(n < 13 && !(options & 16) ? 6 + n : 17);
    if (options >= 192) {  // an elastic law with its defaults
      p.resize(20);
      p[0] = p[1] = 0, p[6] = 1;
      p[18] = 1 + n % 3, p[19] = 0.5 + 0.5 * mild();
    }
    if (kind % 4 == 2) p[byte() % p.size()] = number();
    return p;
  }
  /// A point's state of n entries.
  std::vector<double> state(std::size_t n) {
    const unsigned kind = byte();
    if (kind % 4 == 3) return numbers(n);
    std::vector<double> s(n, kind % 4 == 2 ? NAN : 0);  // unused entries may have any value
    if (n > 0) s[0] = kind & 4 ? 1 + 0.3 * mild() : 0;
    for (std::size_t i = 5; i < 8 && i < n; ++i) s[i] = kind & 8 ? mild() : 0;
    if (kind & 16 && n > 0) s[byte() % n] = number();
    return s;
  }
};

#endif
