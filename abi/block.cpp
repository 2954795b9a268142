// The batch for one instruction set: compiled for each, with -Dmyogrowth=myogrowth_<it>. The library's
// namespace then has a name of its own, so that the linker cannot take this code for that of another set;
// block.hpp is plain C.
#include "block.hpp"

#include <cstring>
#include <myogrowth/many/batch.hpp>

namespace {

using namespace myogrowth;

constexpr int points = myogrowth_block_points;
constexpr int lanes = simd::native_lanes<double>;
using P = simd::Pack<double, lanes>;

// Moves n points of an array, from `first` on, to the rows of a block if it is an input, else from them: four
// numbers of a register's points at once, the last ones again where they are fewer.
template <class Array>
MYOGROWTH_FLAT void turn(const Array& array, std::ptrdiff_t first, std::ptrdiff_t n, double* rows) {
  constexpr bool is_input = std::is_same<Array, myogrowth_input>::value;
  constexpr int side = 4;
  const std::ptrdiff_t step = array.step, size = array.size, last_c = size - side;
  const int* const entry = array.entry;
  auto* const data = array.data + first * step;
  if (n < lanes || last_c < 0) {
    for (std::ptrdiff_t c = 0; c < size; ++c) {
      double* const row = rows + myogrowth_row(entry[c]);
      const auto move = [&](std::ptrdiff_t k, std::ptrdiff_t at) {
        if constexpr (is_input) {
          row[k] = data[at + c];
        } else {
          data[at + c] = row[k];
        }
      };
      if (step == 1) {
        for (std::ptrdiff_t k = 0; k < n; ++k) move(k, k);
      } else {
        for (std::ptrdiff_t k = 0; k < n; ++k) move(k, k * step);
      }
    }
    return;
  }
  for (std::ptrdiff_t c = 0;; c = c + side < last_c ? c + side : last_c) {
    double* row[side];
    for (int i = 0; i < side; ++i) row[i] = rows + myogrowth_row(entry[c + i]);
    const auto square = [&](auto* at, std::ptrdiff_t k) {
      P p[side];
      if constexpr (is_input) {
        load_side_by_side(p, at, step);
        for (int i = 0; i < side; ++i) p[i].store(row[i] + k);
      } else {
        for (int i = 0; i < side; ++i) p[i] = P::load(row[i] + k);
        store_side_by_side(p, at, step);
      }
    };
    auto* at = data + c;
    for (std::ptrdiff_t k = 0; k + lanes <= n; k += lanes, at += lanes * step) square(at, k);
    if (n % lanes != 0) square(data + c + (n - lanes) * step, n - lanes);
    if (c == last_c) break;
  }
}

inline double* row_of(MyogrowthBlock& b, int row) { return b.number + row; }

// What is not known yet takes its default, and n0 unit length. Packs are not made for numbers so large or
// small that a product of a few is out of range: there, and where the host is at fault, an undeformed point
// stands in the place, and check is NaN.
// Returns whether all points are ready.
bool prepare(int n, MyogrowthBlock& b) {
  bool all_are_ready = true;
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
    const P square = n0[0] * n0[0] + n0[1] * n0[1] + n0[2] * n0[2];
    const auto is_unit = abs(square - one) <= P(4 * last_place<double>());
    auto is_ready = can & is_unit & !none & (G == G_given);
    if (b.stretch_is_checked || b.is_known) is_ready = is_ready & (stretch > zero) & is_finite(stretch);
    if (!any(!is_ready)) {
      store(zero, myogrowth_row_check);
      continue;
    }
    if (b.stretch_is_checked || b.is_known) can = can & (stretch >= zero) & is_finite(stretch);
    if (b.is_known) can = can & (stretch > zero);

    unsigned others = bits(!is_unit);
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
    all_are_ready = false;
    for (int c = 0; c < 9; ++c)
      store(select(can, load(myogrowth_row_F + c * points), c % 4 == 0 ? one : zero),
            myogrowth_row_F + c * points);
  }
  return all_are_ready;
}

constexpr int n_stress(Measure measure) { return measure == Measure::first_piola ? 9 : 6; }

// An output of the host's, from the block's first point on.
template <int size>
batch::Aos<double, size> array_of(const MyogrowthBlock& b, int o) {
  return batch::aos<size>(b.out[o].data + b.first * b.out[o].step, b.out[o].step);
}

// is_direct: stresses and tangents go to the host's arrays, and not to rows. Returns whether all points have
// got their results, and tells of each by its check.
template <Tangent tangent, Measure measure, bool is_direct = false>
bool update(const FibreGrowth<double>& material, int n, MyogrowthBlock& b) {
  constexpr int n_tangent = tangent == Tangent::none ? 0 : n_stress(measure) * n_stress(measure);
  const auto row = [&b](int r) { return batch::soa(row_of(b, r), points); };
  const auto stresses = [&] {
    if constexpr (is_direct)
      return array_of<n_stress(measure)>(b, b.stress);
    else
      return row(myogrowth_row_stress);
  }();
  const auto tangents = [&] {
    if constexpr (is_direct && tangent == Tangent::full)
      return array_of<n_tangent>(b, b.tangent);
    else
      return row(myogrowth_row_tangent);
  }();
  const batch::Input<batch::Soa<double>, batch::Soa<double>, batch::Soa<double>, batch::Shared<double>,
                     batch::Soa<double>>
      in{row(myogrowth_row_F), row(myogrowth_row_n0), row(myogrowth_row_G), batch::shared(&b.dt),
         row(myogrowth_row_lambda)};
  const batch::Output<std::decay_t<decltype(stresses)>, batch::Soa<double>, std::decay_t<decltype(tangents)>,
                      batch::Soa<double>>
      out{stresses, row(myogrowth_row_G_end), tangents, row(myogrowth_row_G_end + points)};
  const bool all_have = update_batch<tangent, measure>(material, n, in, out) == 0;
  // Of numbers that packs can take, the results overflow only where det F, by which they are divided, is
  // close to zero.
  const P least_J(1e-3);
  if constexpr (is_direct) {
    auto far = P(0.0) == P(0.0);
    for (int k = 0; k < n; k += lanes) far = far & (P::load(row_of(b, myogrowth_row_J) + k) > least_J);
    return all_have && !any(!far);
  }
  P all(0.0);
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
    add(myogrowth_row_stress, n_stress(measure));
    if (any(!(load(myogrowth_row_J) > least_J))) add(myogrowth_row_tangent, n_tangent);
    const P check = (sum + other) * P(0.0);
    check.store(row_of(b, myogrowth_row_check) + k);
    all = all + check;
  }
  return !any(!(all == P(0.0)));
}

}  // namespace

extern "C" void MYOGROWTH_UPDATE_BLOCK(const void* bytes, int n, int measure, int with_tangent,
                                       MyogrowthBlock* block) {
  static_assert(std::is_trivially_copyable<FibreGrowth<double>>::value, "it comes as bytes");
  FibreGrowth<double> material;
  std::memcpy(&material, bytes, sizeof material);
  MyogrowthBlock& b = *block;
  for (int i = 0; i < b.n_in; ++i) turn(b.in[i], b.first, n, b.number);
  const int whole = (n + lanes - 1) / lanes * lanes;
  for (int r = 0; r < myogrowth_row_stress; r += points) {  // the last point again, to fill a register
    for (int k = n; k < whole; ++k) row_of(b, r)[k] = row_of(b, r)[n - 1];
  }
  const bool all_are_ready = prepare(whole, b);
  using Update = bool(const FibreGrowth<double>&, int, MyogrowthBlock&);
  static constexpr Update* updates[3][2] = {
      {update<Tangent::none, Measure::cauchy>, update<Tangent::full, Measure::cauchy>},
      {update<Tangent::none, Measure::first_piola>, update<Tangent::full, Measure::first_piola>},
      {update<Tangent::none, Measure::second_piola>, update<Tangent::full, Measure::second_piola>}};
  static constexpr Update* direct_updates[3][2] = {
      {update<Tangent::none, Measure::cauchy, true>, update<Tangent::full, Measure::cauchy, true>},
      {update<Tangent::none, Measure::first_piola, true>, update<Tangent::full, Measure::first_piola, true>},
      {update<Tangent::none, Measure::second_piola, true>,
       update<Tangent::full, Measure::second_piola, true>}};
  const bool is_direct = b.stress >= 0 && (!with_tangent || b.tangent >= 0) && n == whole && all_are_ready &&
                         direct_updates[measure][with_tangent](material, n, b);
  const bool all_have = is_direct || updates[measure][with_tangent](material, whole, b);
  b.is_given = b.n_out > 0 && all_have;
  for (int i = 0; i < b.n_out && b.is_given; ++i) {
    if (!is_direct || (i != b.stress && i != b.tangent)) turn(b.out[i], b.first, n, b.number);
  }
}
