#include "element.hpp"

#include <array>
#include <cmath>
#include <ctime>
#include <myogrowth/many/laws.hpp>
#include <utility>

namespace muscle {
namespace {

constexpr int block_points = 64;
constexpr double gauss = 0.57735026918962576451;  // 1/sqrt(3)

/// Derivatives of the shape functions, values and weights at the integration points.
template <Shape shape>
struct Reference {
  static constexpr int nodes = n_nodes(shape), points = n_points(shape);
  double N[points][nodes], dN[points][nodes][3], weight[points];

  Reference() {
    for (int q = 0; q < points; ++q) {
      if constexpr (shape == Shape::hex) hex(q);
      if constexpr (shape == Shape::wedge) wedge(q);
      if constexpr (shape == Shape::tet || shape == Shape::tet10) tet(q);
    }
  }

  void hex(int q) {
    static constexpr int corner[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                         {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    const double xi[3] = {q & 1 ? gauss : -gauss, q & 2 ? gauss : -gauss, q & 4 ? gauss : -gauss};
    weight[q] = 1;
    for (int a = 0; a < nodes; ++a) {
      double f[3];
      for (int i = 0; i < 3; ++i) f[i] = (1 + xi[i] * corner[a][i]) / 2;
      N[q][a] = f[0] * f[1] * f[2];
      for (int i = 0; i < 3; ++i) dN[q][a][i] = corner[a][i] * f[(i + 1) % 3] * f[(i + 2) % 3] / 2;
    }
  }

  void wedge(int q) {
    const double zeta = q ? gauss : -gauss, third = 1. / 3;
    static constexpr double slope[3][2] = {{-1, -1}, {1, 0}, {0, 1}};
    weight[q] = 0.5;
    for (int a = 0; a < nodes; ++a) {
      const int sign = a < 3 ? -1 : 1;
      const double f = (1 + sign * zeta) / 2;
      N[q][a] = third * f;
      dN[q][a][0] = slope[a % 3][0] * f;
      dN[q][a][1] = slope[a % 3][1] * f;
      dN[q][a][2] = third * sign / 2;
    }
  }

  /// One point in the middle, or four; in barycentric coordinates L.
  void tet(int q) {
    static constexpr double slope[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    constexpr double far = points == 1 ? 0.25 : 0.13819660112501051518;  // (5 - sqrt 5)/20
    weight[q] = 1. / (6 * points);
    double L[4] = {far, far, far, far};
    L[(q + 1) % 4] = 1 - 3 * far;
    if (points == 1) L[1] = far;
    for (int a = 0; a < 4; ++a) {
      N[q][a] = nodes == 4 ? L[a] : L[a] * (2 * L[a] - 1);
      for (int i = 0; i < 3; ++i) dN[q][a][i] = (nodes == 4 ? 1 : 4 * L[a] - 1) * slope[a][i];
    }
    for (int e = 0; e < nodes - 4; ++e) {
      const int a = tet_edges[e][0], b = tet_edges[e][1];
      N[q][4 + e] = 4 * L[a] * L[b];
      for (int i = 0; i < 3; ++i) dN[q][4 + e][i] = 4 * (L[a] * slope[b][i] + L[b] * slope[a][i]);
    }
  }
};

template <Shape shape>
const Reference<shape>& reference() {
  static const Reference<shape> r;
  return r;
}

/// m_ij = sum_a x_ai dN_aj, column by column.
template <int nodes>
void gradient(const double* x, const double (*dN)[3], double m[9]) {
  for (int k = 0; k < 9; ++k) m[k] = 0;
  for (int a = 0; a < nodes; ++a) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) m[i + 3 * j] += x[3 * a + i] * dN[a][j];
    }
  }
}

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double determinant(const double m[9]) {
  return m[0] * (m[4] * m[8] - m[7] * m[5]) - m[3] * (m[1] * m[8] - m[7] * m[2]) +
         m[6] * (m[1] * m[5] - m[4] * m[2]);
}

/// K (n x n, row by row) += sum_t left_t⊗right_t, rows of n.
template <int n>
void add_products(int terms, const double (*left)[n], const double (*right)[n], double* K) {
  for (int row = 0; row < n; ++row) {
    double sum[n];
    for (int col = 0; col < n; ++col) sum[col] = K[n * row + col];
    for (int t = 0; t < terms; ++t) {
      const double x = left[t][row];
      for (int col = 0; col < n; ++col) sum[col] += x * right[t][col];
    }
    for (int col = 0; col < n; ++col) K[n * row + col] = sum[col];
  }
}

/// K = sum_t left_t⊗right_t - sum_q (g_q⊗s_q with i and j swapped: g_aj s_bi) + identity_ab delta_ij.
template <int nodes>
void stiffness(int terms, const double (*left)[3 * nodes], const double (*right)[3 * nodes], int points,
               const double (*g)[3 * nodes], const double (*s)[3 * nodes], const double (*identity)[nodes],
               double* K) {
  constexpr int n = 3 * nodes;
  double swapped[n * n] = {};
  add_products<n>(points, g, s, swapped);
  for (int a = 0; a < nodes; ++a) {
    for (int i = 0; i < 3; ++i) {
      for (int c = 0; c < nodes; ++c) {
        for (int j = 0; j < 3; ++j) {
          K[n * (3 * a + i) + 3 * c + j] =
              (i == j ? identity[a][c] : 0) - swapped[n * (3 * a + j) + 3 * c + i];
        }
      }
    }
  }
  add_products<n>(terms, left, right, K);
}

/// A point of an element, its law evaluated: what residual and stiffness are made of.
struct Point {
  double w, J;  // volume before the deformation, det F
  double B[6], f[3];
  double c1, shift, weight;
  double h_ff, h_I, h_B;  // dtau/dG = h_ff f⊗f + h_I I + h_B B
  double trace_B, ff;     // tr B, f.f

  /// From stress, compact tangent and the J that the law saw (many/batch.hpp).
  Point(const myogrowth::FibreGrowth<>& m, double volume, double det_F, const double* sigma,
        const double* compact, std::ptrdiff_t stride)
      : w(volume), J(det_F) {
    for (int i = 0; i < 3; ++i) f[i] = compact[i * stride];
    weight = compact[3 * stride];
    shift = compact[4 * stride];
    const double G = compact[5 * stride], J_law = compact[6 * stride];
    for (int k = 0; k < 6; ++k) B[k] = J_law * sigma[k * stride] - (k < 3 ? shift : 0);
    const bool grown = m.energy == myogrowth::EnergyPer::grown_volume;
    c1 = grown ? G * m.c1 : m.c1;
    const double c2 = grown ? G * m.c2 : m.c2;
    h_ff = -2 * c2 / (G * G * G);
    h_I = -c1 / G + (grown ? shift / G : 0);
    h_B = grown ? 1 / G : 0;
    trace_B = B[0] + B[1] + B[2];
    ff = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
  }

  void times_B(const double g[3], double b[3]) const {
    b[0] = B[0] * g[0] + B[3] * g[1] + B[4] * g[2];
    b[1] = B[3] * g[0] + B[1] * g[1] + B[5] * g[2];
    b[2] = B[4] * g[0] + B[5] * g[1] + B[2] * g[2];
  }
  double mean() const { return shift + trace_B / 3; }  // of tau
  double trace_h() const { return h_ff * ff + 3 * h_I + h_B * trace_B; }
};

/// A point of an element with any law, from stress, modulus and the J that the law saw.
struct FullPoint {
  double w, J;    // volume before the deformation, det F
  double tau[6];  // Kirchhoff stress
  double c[36];   // modulus of its Jaumann rate, column by column

  FullPoint(double volume, double det_F, double J_law, const double* sigma, const double* ddsdde,
            std::ptrdiff_t stride)
      : w(volume), J(det_F) {
    for (int k = 0; k < 6; ++k) tau[k] = J_law * sigma[k * stride];
    for (int k = 0; k < 36 && ddsdde != nullptr; ++k) c[k] = J_law * ddsdde[k * stride];
  }
  double mean() const { return (tau[0] + tau[1] + tau[2]) / 3; }
};

/// An array of what `point` makes.
template <class Point, std::size_t... q, class Make>
std::array<Point, sizeof...(q)> points_at(std::index_sequence<q...>, const Make& point) {
  return {{point(q)...}};
}

/// The pointwise element: R and, if asked for, K.
template <int nodes, int points, bool tangent>
void pointwise(const Point* at, const double (*g)[nodes][3], double* R, double* K) {
  constexpr int n = 3 * nodes;
  double left[2 * points][n], right[2 * points][n], swapped[points][n];
  double identity[nodes][nodes] = {};
  for (int q = 0; q < points; ++q) {
    const Point& p = at[q];
    double b[nodes][3];
    for (int a = 0; a < nodes; ++a) {
      p.times_B(g[q][a], b[a]);
      for (int i = 0; i < 3; ++i) R[3 * a + i] += p.w * (b[a][i] + p.shift * g[q][a][i]);
    }
    if (!tangent) continue;
    for (int a = 0; a < nodes; ++a) {
      const double phi = p.f[0] * g[q][a][0] + p.f[1] * g[q][a][1] + p.f[2] * g[q][a][2];
      for (int i = 0; i < 3; ++i) {
        const int k = 3 * a + i;
        left[q][k] = g[q][a][i];
        right[q][k] = p.w * p.c1 * g[q][a][i];
        swapped[q][k] = p.w * p.shift * g[q][a][i];
        left[points + q][k] = p.h_ff * phi * p.f[i] + p.h_I * g[q][a][i] + p.h_B * b[a][i];
        right[points + q][k] = p.w * p.weight * phi * p.f[i];
      }
      for (int c = 0; c < nodes; ++c) {
        identity[a][c] += p.w * (g[q][c][0] * b[a][0] + g[q][c][1] * b[a][1] + g[q][c][2] * b[a][2]);
      }
    }
  }
  if (!tangent) return;
  stiffness<nodes>(2 * points, left, right, points, left, swapped, identity, K);
}

/// The mean dilatation. tau = dev tau^ + J p I = B + kappa I, p = (1/V) sum w m^/J^ with m^ the mean of tau^;
/// at a fixed J^ its Truesdell modulus is
///   C:D = (J p + 2/9 tr B) tr D I - 2 kappa D - 2/3 (tr D B + (B:D) I) + weight dev h (f.D f - f.f/3 tr D),
/// h = dtau/dG. What J^ adds: dJ^ = v.du, dtau = dev(c^:I)/3 dJ^/J^ and
///   dp = (1/V J^) [slope.du + bulk v.du/J^],   slope.du = sum w I:c^:dev D/3,   bulk = sum w (I:c^:I/9 -
///   m^).
template <int nodes, int points, bool tangent>
void mean_dilatation(const Point* at, const double (*g)[nodes][3], double V, double J_hat, double* R,
                     double* K) {
  constexpr int n = 3 * nodes;
  double pressure = 0;
  for (int q = 0; q < points; ++q) pressure += at[q].w * at[q].mean() / (V * J_hat);
  double left[3 * points + 2][n], right[3 * points + 2][n], swapped[points][n];
  double identity[nodes][nodes] = {};
  double volume[n] = {}, deviator[n] = {}, slope[n] = {}, bulk = 0;
  for (int q = 0; q < points; ++q) {
    const Point& p = at[q];
    const double Jp = p.J * pressure, kappa = p.shift - p.mean() + Jp;
    double b[nodes][3];
    for (int a = 0; a < nodes; ++a) {
      p.times_B(g[q][a], b[a]);
      for (int i = 0; i < 3; ++i) R[3 * a + i] += p.w * (b[a][i] + kappa * g[q][a][i]);
    }
    if (!tangent) continue;
    const double trace_h = p.trace_h();
    bulk += p.w * (p.c1 + (2 * p.trace_B + p.weight * p.ff * trace_h) / 9 - p.mean());
    for (int a = 0; a < nodes; ++a) {
      const double phi = p.f[0] * g[q][a][0] + p.f[1] * g[q][a][1] + p.f[2] * g[q][a][2];
      for (int i = 0; i < 3; ++i) {
        const int k = 3 * a + i;
        const double gi = g[q][a][i], bi = b[a][i], fi = phi * p.f[i];
        const double h = p.h_ff * fi + (p.h_I - trace_h / 3) * gi + p.h_B * bi;
        const double dev_f = fi - p.ff / 3 * gi, dev_b = bi - p.trace_B / 3 * gi;
        left[q][k] = gi;
        right[q][k] = p.w * ((Jp + 2. / 9 * p.trace_B) * gi - 2. / 3 * bi);
        swapped[q][k] = p.w * kappa * gi;
        left[points + q][k] = -2. / 3 * p.w * bi;
        right[points + q][k] = gi;
        left[2 * points + q][k] = h;
        right[2 * points + q][k] = p.w * p.weight * dev_f;
        volume[k] += p.w * p.J * gi / V;
        deviator[k] += p.w * (2 * dev_b + p.weight * p.ff * h) / 3;
        slope[k] += p.w * (2 * dev_b + p.weight * trace_h * dev_f) / 3;
      }
      for (int c = 0; c < nodes; ++c) {
        identity[a][c] += p.w * (g[q][c][0] * b[a][0] + g[q][c][1] * b[a][1] + g[q][c][2] * b[a][2]);
      }
    }
  }
  if (!tangent) return;
  for (int k = 0; k < n; ++k) {
    left[3 * points][k] = deviator[k] / J_hat;
    right[3 * points][k] = volume[k];
    left[3 * points + 1][k] = volume[k] / J_hat;
    right[3 * points + 1][k] = slope[k] + bulk / J_hat * volume[k];
  }
  stiffness<nodes>(3 * points + 2, left, right, points, left, swapped, identity, K);
}

/// The symmetric matrix of six components, `stride` apart, times g.
void times(const double* s, int stride, const double g[3], double product[3]) {
  for (int i = 0; i < 3; ++i) {
    product[i] = s[stride * myogrowth::symmetric_index(i, 0)] * g[0] +
                 s[stride * myogrowth::symmetric_index(i, 1)] * g[1] +
                 s[stride * myogrowth::symmetric_index(i, 2)] * g[2];
  }
}

/// The element with any law: R and, if asked for, K = sum w [B^T c B + geometric part], c the modulus of
/// Truesdell's rate of tau. The mean dilatation has tau and p as above and, with c^ the Jaumann modulus at
/// J^,
///   c:D = dev c^:dev D + J p tr D I - (D tau + tau D) at a fixed J^,
///   dtau = dev(c^:I)/3 dJ^/J^,   slope.du = sum w I:c^:dev D/3,   bulk = sum w (I:c^:I/9 - m^).
template <int nodes, int points, bool tangent>
void with_modulus(FullPoint* at, bool mean_dilatation, const double (*g)[nodes][3], double V, double J_hat,
                  double* R, double* K) {
  constexpr int n = 3 * nodes;
  double pressure = 0;
  for (int q = 0; q < points; ++q) pressure += at[q].w * at[q].mean() / (V * J_hat);
  double products[points][6][n];  // w c:B
  double identity[nodes][nodes] = {};
  double volume[n] = {}, deviator[n] = {}, slope[n] = {}, bulk = 0;
  for (int q = 0; q < points; ++q) {
    FullPoint& p = at[q];
    double c_I[6] = {}, I_c[6] = {}, I_c_I = 0;
    if (mean_dilatation) {
      const double m = p.mean(), Jp = p.J * pressure;
      for (int k = 0; k < 3; ++k) p.tau[k] += Jp - m;
      if (tangent) {
        for (int k = 0; k < 6; ++k) {
          c_I[k] = p.c[k] + p.c[k + 6] + p.c[k + 12];
          I_c[k] = p.c[6 * k] + p.c[6 * k + 1] + p.c[6 * k + 2];
        }
        I_c_I = c_I[0] + c_I[1] + c_I[2];
        bulk += p.w * (I_c_I / 9 - m);
        for (int row = 0; row < 6; ++row) {
          for (int col = 0; col < 6; ++col) {
            p.c[row + 6 * col] += (row < 3 && col < 3 ? I_c_I / 9 + Jp : 0) - (row < 3 ? I_c[col] / 3 : 0) -
                                  (col < 3 ? c_I[row] / 3 : 0);
          }
        }
        for (int k = 0; k < 3; ++k) {
          c_I[k] -= I_c_I / 3;
          I_c[k] -= I_c_I / 3;
        }
      }
    }
    double b[nodes][3];
    for (int a = 0; a < nodes; ++a) {
      times(p.tau, 1, g[q][a], b[a]);
      for (int i = 0; i < 3; ++i) R[3 * a + i] += p.w * b[a][i];
    }
    if (!tangent) continue;
    myogrowth::truesdell_from_jaumann(p.tau, p.c, p.c);
    for (double& x : p.c) x *= p.w;
    for (int a = 0; a < nodes; ++a) {
      for (int row = 0; row < 6; ++row) times(p.c + row, 6, g[q][a], products[q][row] + 3 * a);
      for (int c = 0; c < nodes; ++c) {
        identity[a][c] += p.w * (g[q][c][0] * b[a][0] + g[q][c][1] * b[a][1] + g[q][c][2] * b[a][2]);
      }
      if (!mean_dilatation) continue;
      double of_c_I[3], of_I_c[3];
      times(c_I, 1, g[q][a], of_c_I);
      times(I_c, 1, g[q][a], of_I_c);
      for (int i = 0; i < 3; ++i) {
        volume[3 * a + i] += p.w * p.J * g[q][a][i] / V;
        deviator[3 * a + i] += p.w * of_c_I[i] / 3;
        slope[3 * a + i] += p.w * of_I_c[i] / 3;
      }
    }
  }
  if (!tangent) return;
  for (int row = 0; row < n; ++row) {
    const int a = row / 3, i = row % 3;
    double sum[n] = {};
    for (int q = 0; q < points; ++q) {
      for (int m = 0; m < 3; ++m) {  // of B^T only what is not zero
        const double x = g[q][a][m];
        const double* product = products[q][myogrowth::symmetric_index(i, m)];
        for (int col = 0; col < n; ++col) sum[col] += x * product[col];
      }
    }
    for (int c = 0; c < nodes; ++c) sum[3 * c + i] += identity[a][c];
    for (int col = 0; col < n && mean_dilatation; ++col) {
      sum[col] +=
          (deviator[row] * volume[col] + volume[row] * (slope[col] + bulk / J_hat * volume[col])) / J_hat;
    }
    for (int col = 0; col < n; ++col) K[n * row + col] = sum[col];
  }
}

}  // namespace

/// The law at points start to start + count of the cells: Cauchy stress, G, scalars and the modulus, compact
/// or full. Returns how many have no result.
std::ptrdiff_t Elements::update_points(const Cells& cells, std::ptrdiff_t start, std::ptrdiff_t count,
                                       double dt, const double* F, bool tangent, const PointArrays& out) {
  using namespace myogrowth;
  constexpr std::ptrdiff_t stride = block_points;
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(cells.n) * n_points(cells.shape);
  const batch::Input in{
      batch::soa(F, stride), batch::aos<3>(cells.n0 + 3 * start),     batch::soa(cells.G_n + start, all),
      batch::shared(&dt),    batch::soa(cells.lambda_n + start, all), batch::shared(&elastic_.activation)};
  const batch::Output result{batch::soa(out.sigma, stride), batch::soa(out.G, stride),
                             batch::soa(out.modulus, stride), batch::soa(out.scalars, stride)};
  const batch::Output without{result.stress, result.G, batch::Absent(), result.scalars};
  // Without a tangent the kernel of eq. 3 forms none of its own; the compact one is seven numbers either way.
  if (!full_) return update_batch<Tangent::compact, Measure::cauchy, 8>(material_, count, in, result);
  std::ptrdiff_t without_result = 0;
  const auto update = [&](const auto& material) {
    without_result = tangent ? update_batch<Tangent::full, Measure::cauchy, 8>(material, count, in, result)
                             : update_batch<Tangent::none, Measure::cauchy, 8>(material, count, in, without);
  };
  if (elastic_.law == abi::Law::neo_hookean) {
    update(material_);
  } else {
    abi::with_other_law(material_, elastic_, [&](auto&, const auto& material, double) {
      update(material);
      return UpdateStatus::ok;
    });
  }
  return without_result;
}

template <Shape shape, bool tangent>
Failure Elements::block(const Cells& cells, int first, int n, double dt, const Forces& out) {
  using namespace myogrowth;
  constexpr int nodes = n_nodes(shape), points = n_points(shape), dofs = 3 * nodes;
  constexpr std::ptrdiff_t stride = block_points;
  const Reference<shape>& ref = reference<shape>();
  double F[9 * stride], J[stride], w[stride], g[stride][nodes][3];
  double V[block_points / points] = {}, J_hat[block_points / points] = {};

  const auto failed_at = [&](int i) {
    Failure failure;
    failure.cell = first + i / points;
    failure.point = i % points;
    for (int k = 0; k < 9; ++k) failure.F[k] = F[k * stride + i];
    return failure;
  };

  for (int c = 0; c < n; ++c) {
    const double* X = cells.X + static_cast<std::ptrdiff_t>(first + c) * dofs;
    const double* u = cells.u + static_cast<std::ptrdiff_t>(first + c) * dofs;
    for (int q = 0; q < points; ++q) {
      const int i = points * c + q;
      double dX[9], to_X[9], H[9], F_point[9], to_x[9];
      gradient<nodes>(X, ref.dN[q], dX);
      inverse(dX, to_X);
      w[i] = determinant(dX) * ref.weight[q];
      double dN[nodes][3];  // over X
      for (int a = 0; a < nodes; ++a) {
        for (int j = 0; j < 3; ++j) {
          dN[a][j] = ref.dN[q][a][0] * to_X[3 * j] + ref.dN[q][a][1] * to_X[3 * j + 1] +
                     ref.dN[q][a][2] * to_X[3 * j + 2];
        }
      }
      gradient<nodes>(u, dN, H);
      for (int k = 0; k < 9; ++k) F[k * stride + i] = F_point[k] = H[k] + (k % 4 == 0 ? 1 : 0);
      J[i] = determinant(F_point);
      if (!(J[i] > 0)) return failed_at(i);
      inverse(F_point, to_x);
      for (int a = 0; a < nodes; ++a) {
        for (int j = 0; j < 3; ++j) {
          g[i][a][j] = dN[a][0] * to_x[3 * j] + dN[a][1] * to_x[3 * j + 1] + dN[a][2] * to_x[3 * j + 2];
        }
      }
      V[c] += w[i];
      J_hat[c] += w[i] * J[i];
    }
    J_hat[c] /= V[c];
    if (volume_ != Volume::mean_dilatation) continue;
    for (int i = points * c; i < points * (c + 1); ++i) {
      const double scale = std::cbrt(J_hat[c] / J[i]);
      for (int k = 0; k < 9; ++k) F[k * stride + i] *= scale;
    }
  }

  const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(first) * points,
                       count = static_cast<std::ptrdiff_t>(n) * points;
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(cells.n) * points;
  double sigma[6 * stride], G[stride], modulus[36 * stride], scalars[5 * stride];
  const double before = cpu_seconds();
  const std::ptrdiff_t without_result =
      update_points(cells, start, count, dt, F, tangent, {sigma, G, modulus, scalars});
  law_seconds_ += cpu_seconds() - before;
  if (without_result != 0) {
    for (int i = 0; i < count; ++i) {
      if (!(sigma[i] - sigma[i] == 0)) return failed_at(i);
    }
  }

  for (int c = 0; c < n; ++c) {
    const std::ptrdiff_t cell = first + c;
    double* R = out.residual + cell * dofs;
    double* K = tangent ? out.stiffness + cell * dofs * dofs : nullptr;
    for (int k = 0; k < dofs; ++k) R[k] = 0;
    const auto index = [&](std::size_t q) { return static_cast<std::size_t>(points * c) + q; };
    if (full_) {
      auto at = points_at<FullPoint>(std::make_index_sequence<points>(), [&](std::size_t q) {
        const std::size_t i = index(q);
        return FullPoint(w[i], J[i], scalars[2 * stride + i], sigma + i, tangent ? modulus + i : nullptr,
                         stride);
      });
      with_modulus<nodes, points, tangent>(at.data(), volume_ == Volume::mean_dilatation, g + points * c,
                                           V[c], J_hat[c], R, K);
      continue;
    }
    const auto at = points_at<Point>(std::make_index_sequence<points>(), [&](std::size_t q) {
      const std::size_t i = index(q);
      return Point(material_, w[i], J[i], sigma + i, modulus + i, stride);
    });
    if (volume_ == Volume::pointwise) {
      pointwise<nodes, points, tangent>(at.data(), g + points * c, R, K);
    } else {
      mean_dilatation<nodes, points, tangent>(at.data(), g + points * c, V[c], J_hat[c], R, K);
    }
  }
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    if (out.G != nullptr) out.G[start + i] = G[i];
    for (int k = 0; k < 5 && out.scalars != nullptr; ++k)
      out.scalars[k * all + start + i] = scalars[k * stride + i];
  }
  return {};
}

namespace {

/// Calls f with the shape as a constant.
template <class F>
auto for_shape(Shape shape, const F& f) {
  switch (shape) {
    case Shape::hex:
      return f(std::integral_constant<Shape, Shape::hex>());
    case Shape::wedge:
      return f(std::integral_constant<Shape, Shape::wedge>());
    case Shape::tet:
      return f(std::integral_constant<Shape, Shape::tet>());
    default:
      return f(std::integral_constant<Shape, Shape::tet10>());
  }
}

}  // namespace

Failure Elements::evaluate(const Cells& cells, double dt, const Forces& out) {
  const int most = block_points / n_points(cells.shape);
  for (int first = 0; first < cells.n; first += most) {
    const int n = cells.n - first < most ? cells.n - first : most;
    const bool tangent = out.stiffness != nullptr;
    const Failure failure = for_shape(cells.shape, [&](auto shape) {
      return tangent ? block<shape(), true>(cells, first, n, dt, out)
                     : block<shape(), false>(cells, first, n, dt, out);
    });
    if (failure.point >= 0) return failure;
  }
  return {};
}

void integration_points(Shape shape, const double* X, double* places, double* volumes) {
  for_shape(shape, [&](auto s) {
    const auto& ref = reference<s()>();
    for (int q = 0; q < n_points(s()); ++q) {
      double dX[9];
      gradient<n_nodes(s())>(X, ref.dN[q], dX);
      volumes[q] = determinant(dX) * ref.weight[q];
      for (int i = 0; i < 3; ++i) {
        places[3 * q + i] = 0;
        for (int a = 0; a < n_nodes(s()); ++a) places[3 * q + i] += ref.N[q][a] * X[3 * a + i];
      }
    }
  });
}

void shape_gradients(Shape shape, const double* X, double* gradients) {
  for_shape(shape, [&](auto s) {
    const auto& ref = reference<s()>();
    for (int q = 0; q < n_points(s()); ++q) {
      double dX[9], to_X[9];
      gradient<n_nodes(s())>(X, ref.dN[q], dX);
      myogrowth::inverse(dX, to_X);
      for (int a = 0; a < n_nodes(s()); ++a) {
        for (int j = 0; j < 3; ++j) {
          *gradients++ = ref.dN[q][a][0] * to_X[3 * j] + ref.dN[q][a][1] * to_X[3 * j + 1] +
                         ref.dN[q][a][2] * to_X[3 * j + 2];
        }
      }
    }
  });
}

}  // namespace muscle
