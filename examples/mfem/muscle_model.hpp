// myogrowth as a material of MFEM's HyperelasticNLFIntegrator, for a whole time step with its state at every
// quadrature point. See docs/hosts.md, MFEM.
//
//   MuscleModel muscle(myogrowth::FibreGrowth<>(), mesh.GetNE(), points per element);
//   form.AddDomainIntegrator(new mfem::HyperelasticNLFIntegrator(&muscle));
//   ... for each time step: muscle.dt = dt; newton.Mult(zero, x); form.Mult(x, residual); muscle.EndStep();
//
// The gradient is unsymmetric where the muscle grows: solve with GMRES or a direct solver, not with CG.
#ifndef MYOGROWTH_EXAMPLES_MUSCLE_MODEL_HPP
#define MYOGROWTH_EXAMPLES_MUSCLE_MODEL_HPP

#include <mfem.hpp>
#include <myogrowth/material.hpp>
#include <vector>

class MuscleModel : public mfem::HyperelasticModel {
 public:
  double dt = 0;

  /// Three dimensions; fibres along x until `state` says otherwise.
  MuscleModel(const myogrowth::FibreGrowth<>& material, int elements, int points_per_element)
      : material_(material),
        points_(points_per_element),
        begin_(static_cast<std::size_t>(elements * points_per_element)),
        end_(begin_) {}

  /// The state at the beginning of the step: G, and the fibre n0 to be set before the first.
  myogrowth::State<>& state(int element, int point) { return begin_[index(element, point)]; }

  /// psi per unit reference volume.
  double EvalW(const mfem::DenseMatrix& F) const override { return update(F).point.psi; }

  /// The first Piola-Kirchhoff stress; NaN where det F <= 0, so that Newton's method stops.
  void EvalP(const mfem::DenseMatrix& F, mfem::DenseMatrix& P) const override {
    const Eigen::Matrix3d P_ = update(F).first_piola();
    for (int i = 0; i < 3; ++i) {
      for (int J = 0; J < 3; ++J) P(i, J) = P_(i, J);
    }
  }

  /// A(a + k dof, b + l dof) += weight DS(a, J) dP_kJ/dF_lL DS(b, L).
  void AssembleH(const mfem::DenseMatrix& F, const mfem::DenseMatrix& DS, const double weight,
                 mfem::DenseMatrix& A) const override {
    const myogrowth::Mat9<double> dP_dF = update(F).dP_dF();
    const int dof = DS.Height();
    for (int a = 0; a < dof; ++a) {
      for (int b = 0; b < dof; ++b) {
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l) {
            double sum = 0;
            for (int J = 0; J < 3; ++J) {
              for (int L = 0; L < 3; ++L) sum += DS(a, J) * dP_dF(k + 3 * J, l + 3 * L) * DS(b, L);
            }
            A(a + k * dof, b + l * dof) += weight * sum;
          }
        }
      }
    }
  }

  /// To be called when the step has converged and EvalP has been called at its end: the result is the start
  /// of the next step.
  void EndStep() { begin_ = end_; }

 private:
  std::size_t index(int element, int point) const {
    return static_cast<std::size_t>(element * points_ + point);
  }

  myogrowth::Update<> update(const mfem::DenseMatrix& F) const {
    const std::size_t here = index(Ttr->ElementNo, Ttr->GetIntPoint().index);
    const Eigen::Map<const Eigen::Matrix3d> F_(F.Data());  // both are stored column by column
    const auto step = myogrowth::update(material_, F_, begin_[here], dt);
    end_[here] = step.state;
    return step;
  }

  myogrowth::FibreGrowth<> material_;
  int points_;
  std::vector<myogrowth::State<>> begin_;
  mutable std::vector<myogrowth::State<>> end_;
};

#endif
