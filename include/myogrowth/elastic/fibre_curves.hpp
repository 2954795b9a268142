/// @file
/// The force-length curves of muscle that laws 1 and 2 share, of the normalised stretch l =
/// lambda_e/lambda_opt, and what the energy needs of them.
///
///   active:   9 (l-0.4)^2 | 1 - 4 (1-l)^2 | 9 (l-1.6)^2    on 0.4 | 0.6 | 1.4 | 1.6, else 0
///   passive:  0 (l <= 1);  a (e^{b (l-1)} - 1);  its tangent line beyond l = end
///
/// The slopes jump at l = 0.6, 1 and 1.4; there the tangent is the one from below.
#ifndef MYOGROWTH_ELASTIC_FIBRE_CURVES_HPP
#define MYOGROWTH_ELASTIC_FIBRE_CURVES_HPP

#include "../scalar.hpp"

namespace myogrowth {

/// A curve at one stretch.
template <class T>
struct Curve {
  T f;   ///< force [-, or stress]
  T df;  ///< its slope df/dl
};

/// What its energy needs.
template <class T>
struct CurveAreas {
  T area;        ///< integral of f dl from where it is 0
  T area_per_l;  ///< integral of (f/l) dl from where it is 0
};

namespace detail {

/// Integral from 1 to l of (e^{b (s-1)} - 1)/s ds, by Gauss's rule with 16 points: to rounding for
/// b (l-1) <= 16. (In closed form it is an exponential integral.)
template <class T, class P>
MYOGROWTH_FUNCTION T expm1_per_l(const P& b, const T& l) {
  using V = Real<T>;
  constexpr double node[8] = {0.09501250983763744, 0.2816035507792589, 0.45801677765722737,
                              0.6178762444026438,  0.755404408355003,  0.8656312023878318,
                              0.9445750230732326,  0.9894009349916499};
  constexpr double weight[8] = {0.18945061045506834,  0.1826034150449235,  0.16915651939500254,
                                0.1495959888165766,   0.12462897125553402, 0.09515851168249282,
                                0.062253523938647824, 0.027152459411754093};
  const T half = (l - V(1)) / V(2);
  T sum(V(0));
  for (int i = 0; i < 8; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      const T distance = half * V(1 + side * node[i]);
      sum = sum + V(weight[i]) * expm1(T(b * distance)) / (V(1) + distance);
    }
  }
  return half * sum;
}

}  // namespace detail

/// The passive curve. T may be a pack.
template <class T, class P>
MYOGROWTH_FUNCTION Curve<T> passive_curve(const T& l, const P& a, const P& b, const P& end) {
  const T zero(Real<T>(0)), one(Real<T>(1)), last(end);
  const T s = minimum(maximum(l, one), last);
  const T e = expm1(T(b * (s - one)));
  const T df = a * b * (e + one);
  const T f = select(deciding(l) > deciding(last), T(a * e + df * (l - last)), T(a * e));
  const auto tense = deciding(l) > deciding(one);
  return {select(tense, f, zero), select(tense, df, zero)};
}

/// Its areas.
template <class T, class P>
MYOGROWTH_FUNCTION CurveAreas<T> passive_areas(const T& l, const P& a, const P& b, const P& end) {
  using V = Real<T>;
  const V one(1);
  if (!(value(l) > one)) return {T(V(0)), T(V(0))};
  const T s = value(l) > value(end) ? T(end) : l, d = l - s;
  const Curve<T> c = passive_curve(s, a, b, end);
  return {c.f / b - a * (s - one) + d * (c.f + c.df * d / V(2)),
          a * detail::expm1_per_l(b, s) + (c.f - c.df * s) * log(T(l / s)) + c.df * d};
}

namespace detail {

/// The pieces of the active curve, p (l-q)^2 + r from one stretch to the next.
template <class V>
struct ActivePieces {
  struct {
    V from, to, p, q, r;
  } all[3];
};
template <class V>
MYOGROWTH_FUNCTION constexpr ActivePieces<V> active_pieces() {
  return {{{V(0.4), V(0.6), V(9), V(0.4), V(0)},
           {V(0.6), V(1.4), V(-4), V(1), V(1)},
           {V(1.4), V(1.6), V(9), V(1.6), V(0)}}};
}

}  // namespace detail

/// The active curve. T may be a pack.
template <class T>
MYOGROWTH_FUNCTION Curve<T> active_curve(const T& l) {
  using V = Real<T>;
  Curve<T> c{T(V(0)), T(V(0))};
  const auto pieces = detail::active_pieces<V>();
  for (const auto& i : pieces.all) {
    const T distance = l - T(i.q);
    const auto after = deciding(l) > deciding(T(i.from)), before = deciding(l) <= deciding(T(i.to));
    const auto here = after & before;
    c.f = select(here, T(i.p * distance * distance + i.r), c.f);
    c.df = select(here, T(V(2) * i.p * distance), c.df);
  }
  return c;
}

/// Its areas.
template <class T>
MYOGROWTH_FUNCTION CurveAreas<T> active_areas(const T& l) {
  using V = Real<T>;
  CurveAreas<T> c{T(V(0)), T(V(0))};
  const auto pieces = detail::active_pieces<V>();
  for (const auto& i : pieces.all) {
    if (!(value(l) > i.from)) break;
    const T to = value(l) > i.to ? T(i.to) : l, length = to - i.from, end = to - i.q;
    const V start = i.from - i.q;
    c.area = c.area + i.p / V(3) * (end * end * end - T(start * start * start)) + i.r * length;
    c.area_per_l = c.area_per_l + (i.p * i.q * i.q + i.r) * log(T(to / i.from)) - V(2) * i.p * i.q * length +
                   i.p / V(2) * length * (to + i.from);
  }
  return c;
}

}  // namespace myogrowth

#endif
