/// @file
/// What happens to the attachments of a muscle: entries of the section Attachments, time tables, surfaces.
#ifndef MYOGROWTH_DEALII_ATTACHMENTS_HPP
#define MYOGROWTH_DEALII_ATTACHMENTS_HPP

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace muscle {

/// A factor over time, linear between rows; two rows of one time are a jump. The last value stays.
class TimeTable {
 public:
  TimeTable() = default;
  explicit TimeTable(std::vector<std::pair<double, double>> rows) : rows_(std::move(rows)) {}

  /// The value before a jump at that time (part = 0), after it (1) or on the way.
  double at(double time, double part) const;
  bool jumps_at(double time) const;
  /// Of the row next after that time; infinity after the last.
  double next_row(double time) const;
  /// How long the rows about a time are apart if the value changes between them; else infinity.
  double changing_for(double time) const;
  const std::vector<std::pair<double, double>>& rows() const { return rows_; }

 private:
  std::vector<std::pair<double, double>> rows_{{0, 0}};
};

/// What happens to one surface.
struct Action {
  enum Kind {
    fixed,        ///< u = 0
    displaced,    ///< u = vector
    away,         ///< u = amount x distance of the attachments, along their line, away from the other one
    turned,       ///< about an axis through point: amount [rad]
    slides,       ///< normal.u = amount, free in its plane
    slides_away,  ///< the same, normal.u as of `away`
    pulled,       ///< a dead force, vector [force]
    pressed,      ///< a force along the outward normals as they turn, amount [force]
  };
  std::string surface;
  Kind kind = fixed;
  dealii::Tensor<1, 3> vector, axis;
  dealii::Point<3> point;
  double amount = 0;
  bool own_table = false;
  TimeTable table;

  bool holds() const { return kind != pulled && kind != pressed; }
};

/// The table of rows "TIME:NAME", where NAME is what a message calls the value; it begins with 0 at time 0 if
/// no row does. `place`: where the rows are, as " after 'at'". `fail` throws with the reason.
TimeTable read_table(const std::vector<std::string>& rows, const std::string& name, const std::string& place,
                     const std::function<void(const std::string&)>& fail);

/// Reads Attachments/List. Throws Error with what is wrong and what is allowed. `ramp`: the table of actions
/// that have none.
std::vector<Action> read_actions(const std::string& text, const TimeTable& ramp);

/// The stretch of a study's file (examples/common/study.hpp) minus 1, repeated every `cycle` until `end`; 0:
/// not repeated.
TimeTable read_protocol(const std::string& path, double cycle, double end);

/// A point of a facet, for integrals over it.
struct FacetPoint {
  double weight;
  double N[6], d1[6], d2[6];  ///< shape functions and their derivatives along the two coordinates
};
/// Of facets with 3, 4 or 6 nodes (corners, then those between them).
const std::vector<FacetPoint>& facet_points(unsigned n_nodes);

}  // namespace muscle

#endif
