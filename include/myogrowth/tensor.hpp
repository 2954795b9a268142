/// @file
/// Eigen names of the tensors that myogrowth speaks of, and the way to and from the layouts of kernel.hpp.
///
/// Take care with complex and dual scalars: Eigen's norm(), squaredNorm(), dot() and adjoint() conjugate,
/// which loses a complex-step derivative without a word. Use contraction() and transpose().
#ifndef MYOGROWTH_TENSOR_HPP
#define MYOGROWTH_TENSOR_HPP

#include <Eigen/Core>
#include <Eigen/LU>

#include "measures.hpp"

namespace myogrowth {

// Column by column, whatever Eigen is told to do with matrices of which nothing is said.
template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1, Eigen::ColMajor>;  ///< vector
template <class T>
using Mat3 = Eigen::Matrix<T, 3, 3, Eigen::ColMajor>;  ///< second-order tensor
// Not aligned, so that a struct of these has one layout whatever the compiler's -m flags are.
template <class T>
using Vec6 =
    Eigen::Matrix<T, 6, 1, Eigen::ColMajor | Eigen::DontAlign>;  ///< symmetric tensor, 11 22 33 12 13 23
template <class T>
using Mat6 =
    Eigen::Matrix<T, 6, 6,
                  Eigen::ColMajor | Eigen::DontAlign>;  ///< fourth-order tensor with both minor symmetries
template <class T>
using Mat9 =
    Eigen::Matrix<T, 9, 9,
                  Eigen::ColMajor | Eigen::DontAlign>;  ///< fourth-order tensor A_iJkL at (i + 3J, k + 3L)

/// A:B = A_ij B_ij, without conjugation.
template <class T>
T contraction(const Mat3<T>& A, const Mat3<T>& B) {
  return A.cwiseProduct(B).sum();
}

/// The six components of a symmetric tensor.
template <class T>
Vec6<T> to_six(const Mat3<T>& A) {
  Vec6<T> six;
  for (int a = 0; a < 6; ++a) six[a] = A(symmetric_row(a), symmetric_column(a));
  return six;
}

/// The symmetric tensor of six components.
template <class T>
Mat3<T> from_six(const Vec6<T>& six) {
  Mat3<T> A;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) A(i, j) = six[symmetric_index(i, j)];
  }
  return A;
}

/// A⊗B for symmetric A and B.
template <class T>
Mat6<T> dyad(const Mat3<T>& A, const Mat3<T>& B) {
  return to_six(A) * to_six(B).transpose();
}

/// (A ⊙ B)_ijkl = (A_ik B_jl + A_il B_jk + B_ik A_jl + B_il A_jk)/4 for symmetric A and B;
/// I ⊙ I is the symmetric identity.
template <class T>
Mat6<T> symmetric_product(const Mat3<T>& A, const Mat3<T>& B) {
  Mat6<T> C;
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) {
      const int i = symmetric_row(row), j = symmetric_column(row);
      const int k = symmetric_row(col), l = symmetric_column(col);
      C(row, col) =
          (A(i, k) * B(j, l) + A(i, l) * B(j, k) + B(i, k) * A(j, l) + B(i, l) * A(j, k)) / Real<T>(4);
    }
  }
  return C;
}

}  // namespace myogrowth

#endif
