// The part of MFEM that examples/mfem uses, with the signatures and layouts of MFEM 4.7
// (fem/hyperelastic.hpp, linalg/densemat.hpp, fem/eltrans.hpp): DenseMatrix is stored column by column.
#ifndef MYOGROWTH_TESTS_MFEM_LIKE_HPP
#define MYOGROWTH_TESTS_MFEM_LIKE_HPP

#include <vector>

namespace mfem {

class DenseMatrix {
 public:
  DenseMatrix(int rows, int columns) : rows_(rows), data_(static_cast<std::size_t>(rows * columns)) {}
  double& operator()(int i, int j) { return data_[static_cast<std::size_t>(i + rows_ * j)]; }
  const double& operator()(int i, int j) const { return data_[static_cast<std::size_t>(i + rows_ * j)]; }
  int Height() const { return rows_; }
  const double* Data() const { return data_.data(); }

 private:
  int rows_;
  std::vector<double> data_;
};

struct IntegrationPoint {
  int index = 0;
};

struct ElementTransformation {
  int ElementNo = 0;
  IntegrationPoint point;
  const IntegrationPoint& GetIntPoint() const { return point; }
};

class HyperelasticModel {
 public:
  virtual ~HyperelasticModel() = default;
  void SetTransformation(ElementTransformation& T) { Ttr = &T; }
  virtual double EvalW(const DenseMatrix& Jpt) const = 0;
  virtual void EvalP(const DenseMatrix& Jpt, DenseMatrix& P) const = 0;
  virtual void AssembleH(const DenseMatrix& Jpt, const DenseMatrix& DS, double weight,
                         DenseMatrix& A) const = 0;

 protected:
  ElementTransformation* Ttr = nullptr;
};

}  // namespace mfem

#endif
