/// @file
/// The muscle on a distributed mesh: quasi-static steps in which it is pulled and grows.
#ifndef MYOGROWTH_DEALII_MUSCLE_HPP
#define MYOGROWTH_DEALII_MUSCLE_HPP

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/hp/fe_collection.h>
#include <deal.II/hp/mapping_collection.h>
#include <deal.II/lac/affine_constraints.h>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "linear_system.hpp"
#include "mesh.hpp"
#include "parameters.hpp"

namespace muscle {

/// CPU seconds by what they were spent on, and counts, of this rank.
struct Costs {
  double law = 0, element = 0, insertion = 0, set_up = 0, krylov = 0, output = 0;
  int steps = 0, cuts = 0, newton = 0, checks = 0, solves = 0, iterations = 0, set_ups = 0;
};

class Muscle {
 public:
  Muscle(const Parameters& parameters, MPI_Comm comm);

  /// Goes on to the end, or until `asked_to_end` is set on any rank; then there is a checkpoint. False: it
  /// was asked to.
  bool run(const volatile int& asked_to_end);

 private:
  /// Cells of one shape and one material, which follow one another in all arrays.
  struct Group {
    Shape shape;
    std::size_t material;
    std::size_t first_cell, n, first_point;
  };
  /// The nodes of a surface and what happens to them.
  struct Attachment {
    Action action;
    dealii::Point<3> centroid;
    dealii::Tensor<1, 3> normal, vector;  ///< mean outward one; displacement or force at factor 1
    double area = 0;
    unsigned nodes = 0;
    dealii::Tensor<1, 3> force;  ///< on the muscle
  };
  /// Directions in which a node is held or moved. The others are free.
  struct Support {
    unsigned n = 0;
    std::array<dealii::Tensor<1, 3>, 3> along;       ///< unit vectors, at right angles
    std::array<int, 3> attachment = {{-1, -1, -1}};  ///< -1: held where it is
    void add(const dealii::Tensor<1, 3>& direction, int of) {
      along[n] = direction;
      attachment[n++] = of;
    }
    /// The part of a vector along these directions.
    dealii::Tensor<1, 3> held(const dealii::Tensor<1, 3>& x) const {
      dealii::Tensor<1, 3> part;
      for (unsigned d = 0; d < n; ++d) part += along[d] * (along[d] * x);
      return part;
    }
  };
  /// A facet of an owned cell that a force acts on.
  struct LoadedFacet {
    std::size_t attachment;
    std::vector<unsigned> nodes;  ///< of the cell
    double sign;                  ///< with which d1 x d2 is the outward normal
  };
  struct Attempt {
    bool converged = false;
    std::string why;  ///< not, in words for the user
  };

  // muscle.cpp: set-up
  void find_materials();
  void tell_laws() const;
  void distribute();
  void sort_cells();
  void find_ends();
  void find_end_supports();
  void find_attachments();
  void start_points();
  std::vector<unsigned> cell_nodes_of(const MeshFile::Facet& facet) const;

  // fibres.cpp
  void find_fibres();
  void find_fibres(const Parameters::Fibre& fibre);
  void flow_fibres(const Parameters::Fibre& fibre);
  void write_fibres() const;
  void trace_fascicles();

  // muscle.cpp: a step
  Attempt step(double dt, double part);
  void predict(double dt);
  double growth_in(double dt) const;
  double mean_G() const;
  std::string assemble(double dt, bool tangent);
  std::string assemble_compact(double dt, bool tangent);
  std::string assemble_dense(double dt);
  void take_supports(const Group& group, std::size_t cell, double* K);
  void add_loads(std::size_t cell, const double* u, double* R, double* K);
  void prepare_supports(double time, double part);
  void solve(double target, bool first);
  std::string describe(const Group& group, const Failure& failure, double dt) const;
  double time_error(double dt) const;
  void commit(double dt);
  std::vector<const TimeTable*> tables() const;
  double next_stop() const;
  bool jumps() const;
  void jump();

  // results.cpp
  void start_rows() const;
  void write_history() const;
  void write_rows();
  void find_regions();
  void write_regions();
  void write_fascicles() const;
  void log_newton(int iteration, double residual, int krylov) const;
  void write_fields();
  void find_fields();
  void write_summary(double seconds) const;
  void tell_progress(double seconds) const;
  void say(const std::string& line) const;

  // checkpoint.cpp
  std::string identity() const;
  void compare_identity(const std::string& path, const std::string& then) const;
  void write_checkpoint() const;
  void read_checkpoint();
  void put_checkpoint_aside() const;

  const myogrowth::FibreGrowth<>& material(const Group& group) const {
    return materials_[group.material].law;
  }
  /// The elastic law and its activation in the step that is tried.
  myogrowth::abi::LawChoice elastic(const Group& group) const {
    return materials_[group.material].elastic_at(load_time_, load_part_);
  }
  bool grows(const Group& group) const { return materials_[group.material].grows; }
  dealii::Point<3> place(std::size_t point) const {
    return {places_[3 * point], places_[3 * point + 1], places_[3 * point + 2]};
  }

  Parameters parameters_;
  MPI_Comm comm_;
  unsigned rank_;
  std::vector<Parameters::Material> materials_;
  MeshFile file_;  // empty where the mesh is made here
  std::unique_ptr<Mesh> mesh_;
  dealii::hp::FECollection<3> elements_;  // wedge, hex, tet: in this order deal.II 9.4 joins their nodes
  dealii::hp::MappingCollection<3> mappings_;
  dealii::DoFHandler<3> dofs_;
  std::unique_ptr<Unknowns> unknowns_;
  std::unique_ptr<LinearSystem> system_;

  std::vector<Group> groups_;
  std::vector<dealii::DoFHandler<3>::active_cell_iterator> cells_;  // owned, in the order of the groups
  std::vector<std::size_t> first_node_, first_point_;  // of every cell, in X_ / 3 and in the points
  std::vector<double> X_, places_, volumes_, n0_, G_n_, lambda_n_;  // corners; points
  std::vector<double> G_, lambda_e_, lambda_, J_, Je_;  // points, at the end of the step that is tried

  /// The nodes at the least or the largest z.
  struct End {
    const char* name;
    double z, toward;      ///< where it is, and its outward direction along z, -1 or 1
    double tolerance = 0;  ///< how far its nodes may be from z [length]
    bool has(double place) const { return toward * (z - place) <= tolerance; }
  };
  End proximal_{"proximal", 0, -1}, distal_{"distal", 0, 1};

  std::vector<Attachment> attachments_;
  dealii::Tensor<1, 3> line_;  // unit vector from the proximal to the distal attachment
  double line_length_ = 0;
  dealii::Point<3> proximal_start_;  // where it begins
  int proximal_attachment_ = -1, distal_attachment_ = -1;
  std::vector<Support> supports_;
  std::vector<int> support_of_;       // local nodes: in supports_, or -1
  std::vector<double> node_X_;        // local nodes: places before the deformation
  std::vector<char> cell_supported_;  // whether a cell has a supported node
  std::vector<double> support_step_;  // local unknowns: what is left to go, 0 where not supported
  std::map<std::size_t, std::vector<LoadedFacet>> loads_;  // of owned cells
  double load_time_ = 0, load_part_ = 0;                   // of the step that is tried

  struct Region {
    std::string name;
    std::vector<std::size_t> points;
    double volume;
  };
  std::vector<Region> regions_;
  /// A part of a streamline in an owned cell.
  struct Piece {
    int fascicle;
    std::size_t cell, point;  // the point whose values hold
    dealii::Tensor<1, 3> dX;
    std::vector<double> dN;  // derivatives of the cell's shape functions over X
  };
  int n_fascicles_ = 0;
  std::vector<Piece> pieces_;
  std::map<std::string, double> found_;            // for summary.json
  dealii::AffineConstraints<double> constraints_;  // the same for the dense loop

  Vector u_, u_n_, residual_, rhs_, x_;
  struct Earlier {
    double time, G;  // G: mean over the muscle
    Vector u;
  };
  std::vector<Earlier> before_;  // the ends of earlier steps, the last first
  double mean_G_ = 1;            // of G_n_
  double free_norm_ = 0, support_norm_ = 0, reaction_ = 0, force_floor_ = 0;
  double time_ = 0, dt_ = 0;
  int fresh_iterations_ = -1;  // of the first solve after the last set-up; -1: set up before the next
  int last_iterations_ = 0;
  std::vector<std::pair<double, std::string>> written_;  // times and files of fields
  std::string identity_;                                 // what this run is, for the checkpoint
  Costs costs_;
};

}  // namespace muscle

#endif
