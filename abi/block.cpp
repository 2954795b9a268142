// The batch for one instruction set: compiled for each, with -Dmyogrowth=myogrowth_<it>. The library's
// namespace then has a name of its own, so that the linker cannot take this code for that of another set;
// block.hpp is plain C.
#include "block.hpp"

#include <myogrowth/many/batch.hpp>

#include "properties.hpp"

namespace {

using namespace myogrowth;

constexpr int points = myogrowth_block_points;
constexpr int lanes = simd::native_lanes<double>;
using P = simd::Pack<double, lanes>;

// Between points that lie one after the other and rows there are squares to transpose, of `side` registers.
constexpr int side = lanes < 4 ? 2 : 4;
using Lanes = simd::Register<double, side>::Lanes;
using InMemory = simd::Register<double, side>::InMemory;
inline void transpose(Lanes (&r)[side]) {
#if defined(__AVX2__)
  const Lanes a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6);
  const Lanes b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
  const Lanes c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6);
  const Lanes d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
  r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  r[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  r[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
#else
  const Lanes a = __builtin_shufflevector(r[0], r[1], 0, 2);
  r[1] = __builtin_shufflevector(r[0], r[1], 1, 3);
  r[0] = a;
#endif
}

// Calls square(point, k, c) for squares that cover n points of so many components, the last of which overlap
// those before; one(k, c) where they are fewer than a square has. point: the `side` points from k on.
template <class V, class Square, class One>
void in_squares(V* data, std::ptrdiff_t step, std::ptrdiff_t n, std::ptrdiff_t components,
                const Square& square, const One& one) {
  const std::ptrdiff_t last_k = n - side, last_c = components - side;
  if (last_k < 0 || last_c < 0) {
    for (std::ptrdiff_t c = 0; c < components; ++c) {
      for (std::ptrdiff_t k = 0; k < n; ++k) one(k, c);
    }
    return;
  }
  for (std::ptrdiff_t k = 0;; k = k + side < last_k ? k + side : last_k) {
    V* point[side];
    for (int i = 0; i < side; ++i) point[i] = data + (k + i) * step;
    for (std::ptrdiff_t c = 0;; c = c + side < last_c ? c + side : last_c) {
      square(point, k, c);
      if (c == last_c) break;
    }
    if (k == last_k) break;
  }
}

// (Captured by value: a store to memory may change anything that is not.)
MYOGROWTH_FLAT void gather(const MyogrowthPlaces<const double>& from, int n, double* rows) {
  const double* const data = from.data;
  const std::ptrdiff_t step = from.step;
  const int* const row = from.row;
  in_squares(
      data, step, n, from.size,
      [=](const double* const(&point)[side], std::ptrdiff_t k, std::ptrdiff_t c) {
        Lanes r[side];
        for (int i = 0; i < side; ++i) r[i] = *reinterpret_cast<const InMemory*>(point[i] + c);
        transpose(r);
        double* const to = rows + k;
        for (int i = 0; i < side; ++i) *reinterpret_cast<InMemory*>(to + row[c + i]) = r[i];
      },
      [=](std::ptrdiff_t k, std::ptrdiff_t c) { rows[row[c] + k] = data[k * step + c]; });
}
MYOGROWTH_FLAT void scatter(const MyogrowthPlaces<double>& to, int n, const double* rows) {
  double* const data = to.data;
  const std::ptrdiff_t step = to.step;
  const int* const row = to.row;
  in_squares(
      data, step, n, to.size,
      [=](double* const(&point)[side], std::ptrdiff_t k, std::ptrdiff_t c) {
        const double* const from = rows + k;
        Lanes r[side];
        for (int i = 0; i < side; ++i) r[i] = *reinterpret_cast<const InMemory*>(from + row[c + i]);
        transpose(r);
        for (int i = 0; i < side; ++i) *reinterpret_cast<InMemory*>(point[i] + c) = r[i];
      },
      [=](std::ptrdiff_t k, std::ptrdiff_t c) { data[k * step + c] = rows[row[c] + k]; });
}

inline double* row_of(MyogrowthBlock& b, int row) { return b.number + row; }

// What is not known yet takes its default, and n0 unit length. Packs are not made for numbers so large or
// small that a product of a few is out of range: there, and where the host is at fault, an undeformed point
// stands in the place, and check is NaN.
void prepare(int n, MyogrowthBlock& b) {
  const P zero(0.0), one(1.0), nan(std::numeric_limits<double>::quiet_NaN());
  for (int k = 0; k < n; k += lanes) {
    const auto load = [&](int row) { return P::load(row_of(b, row) + k); };
    const auto store = [&](const P& p, int row) { p.store(row_of(b, row) + k); };
    const P G_given = load(myogrowth_row_G), stretch = load(myogrowth_row_lambda);
    const P G = b.is_known ? G_given : select(G_given == zero, one, G_given);
    P n0[3] = {load(myogrowth_row_n0), load(myogrowth_row_n0 + points), load(myogrowth_row_n0 + 2 * points)};
    const auto none = (n0[0] == zero) & (n0[1] == zero) & (n0[2] == zero);
    for (int i = 0; i < 3; ++i) n0[i] = select(none, P(b.fibre[i]), n0[i]);
    P square_of_F = zero;
    for (int c = 0; c < 9; ++c)
      square_of_F = square_of_F + load(myogrowth_row_F + c * points) * load(myogrowth_row_F + c * points);
    auto can = (G >= P(1e-10)) & (G <= P(1e10)) & (square_of_F <= P(1e20));
    if (b.stretch_is_checked || b.is_known) can = can & (stretch >= zero) & is_finite(stretch);
    if (b.is_known) can = can & (stretch > zero);

    const P square = n0[0] * n0[0] + n0[1] * n0[1] + n0[2] * n0[2];
    unsigned others = bits(!(abs(square - one) <= P(4 * last_place<double>())));  // than of unit length
    P has_fibre = one;
    for (int lane = 0; others != 0; ++lane, others >>= 1) {
      if ((others & 1) == 0) continue;
      const double given[3] = {n0[0][lane], n0[1][lane], n0[2][lane]};
      double unit[3] = {1, 0, 0};
      has_fibre.set(lane, normalise(given, unit) ? 1 : 0);
      for (int i = 0; i < 3; ++i) n0[i].set(lane, unit[i]);
    }
    can = can & (has_fibre > zero);
    for (int i = 0; i < 3; ++i) store(select(can, n0[i], i == 0 ? one : zero), myogrowth_row_n0 + i * points);
    store(select(can, G, one), myogrowth_row_G);
    store(select(can & (stretch > zero), stretch, one), myogrowth_row_lambda);
    store(select(can, zero, nan), myogrowth_row_check);
    if (!any(!can)) continue;
    for (int c = 0; c < 9; ++c)
      store(select(can, load(myogrowth_row_F + c * points), c % 4 == 0 ? one : zero),
            myogrowth_row_F + c * points);
  }
}

template <Tangent tangent, Measure measure>
void update(const FibreGrowth<double>& material, int n, MyogrowthBlock& b) {
  const auto row = [&b](int r) { return batch::soa(row_of(b, r), points); };
  const batch::Input<batch::Soa<double>, batch::Soa<double>, batch::Soa<double>, batch::Shared<double>,
                     batch::Soa<double>>
      in{row(myogrowth_row_F), row(myogrowth_row_n0), row(myogrowth_row_G), batch::shared(&b.dt),
         row(myogrowth_row_lambda)};
  const batch::Output<batch::Soa<double>, batch::Soa<double>, batch::Soa<double>, batch::Soa<double>> out{
      row(myogrowth_row_stress), row(myogrowth_row_G_end), row(myogrowth_row_tangent),
      row(myogrowth_row_G_end + points)};
  update_batch<tangent, measure>(material, n, in, out);

  constexpr int n_stress = measure == Measure::first_piola ? 9 : 6;
  constexpr int n_tangent = tangent == Tangent::none ? 0 : n_stress * n_stress;
  for (int k = 0; k < n; k += lanes) {
    const auto load = [&](int r) { return P::load(row_of(b, r) + k); };
    P sum = load(myogrowth_row_check), other(0.0);  // (two that do not wait for each other)
    const auto add = [&](int first, int size) {
      for (int c = 0; c + 1 < size; c += 2) {
        sum = sum + load(first + c * points);
        other = other + load(first + (c + 1) * points);
      }
      if (size % 2 == 1) sum = sum + load(first + (size - 1) * points);
    };
    add(myogrowth_row_G_end, 6);
    add(myogrowth_row_stress, n_stress);
    // The tangent of numbers that packs can take overflows only where det F, by which it is divided, is close
    // to zero.
    if (any(!(load(myogrowth_row_G_end + 3 * points) > P(1e-3)))) add(myogrowth_row_tangent, n_tangent);
    ((sum + other) * P(0.0)).store(row_of(b, myogrowth_row_check) + k);
  }
}

}  // namespace

extern "C" void MYOGROWTH_UPDATE_BLOCK(const double* props, int n, int measure, int with_tangent,
                                       MyogrowthBlock* block) {
  double known[abi::n_props];
  for (int i = 0; i < abi::n_props; ++i) known[i] = props[i];
  abi::Properties properties;
  abi::read(known, properties);
  MyogrowthBlock& b = *block;
  for (int i = 0; i < b.n_in; ++i) gather(b.in[i], n, b.number);
  const int whole = (n + lanes - 1) / lanes * lanes;
  for (int r = 0; r < myogrowth_row_stress; r += points) {  // the last point again, to fill a register
    for (int k = n; k < whole; ++k) row_of(b, r)[k] = row_of(b, r)[n - 1];
  }
  prepare(whole, b);
  using Update = void(const FibreGrowth<double>&, int, MyogrowthBlock&);
  static constexpr Update* updates[3][2] = {
      {update<Tangent::none, Measure::cauchy>, update<Tangent::full, Measure::cauchy>},
      {update<Tangent::none, Measure::first_piola>, update<Tangent::full, Measure::first_piola>},
      {update<Tangent::none, Measure::second_piola>, update<Tangent::full, Measure::second_piola>}};
  updates[measure][with_tangent](properties.material, whole, b);
  P all(0.0);
  for (int k = 0; k < whole; k += lanes) all = all + P::load(row_of(b, myogrowth_row_check) + k);
  b.is_given = b.n_out > 0 && !any(!(all == P(0.0)));
  for (int i = 0; i < b.n_out && b.is_given; ++i) scatter(b.out[i], n, b.number);
}
