// What is measured of a muscle: percentiles by volume in regions, hot spots, fascicles, forces.
#include <algorithm>
#include <cmath>

#include "muscle.hpp"
#include "results.hpp"

namespace muscle {

using namespace dealii;

namespace {

constexpr std::array<double, 4> shares = {{0.05, 0.5, 0.95, 0.99}};

/// Values with the volume that lies at or below each, sorted by value.
struct Distribution {
  std::vector<double> values, below;
  double at_or_below(double x) const {
    const auto n = std::upper_bound(values.begin(), values.end(), x) - values.begin();
    return n == 0 ? 0 : below[static_cast<std::size_t>(n - 1)];
  }
};

Distribution sorted(const std::vector<std::size_t>& points, const std::vector<double>& values,
                    const std::vector<double>& volumes) {
  std::vector<std::pair<double, double>> rows;
  for (const std::size_t p : points) rows.emplace_back(values[p], volumes[p]);
  std::sort(rows.begin(), rows.end());
  Distribution d;
  double sum = 0;
  for (const auto& row : rows) {
    d.values.push_back(row.first);
    d.below.push_back(sum += row.second);
  }
  return d;
}

/// For each distribution and share the least value with at least this share of the volume at or below it.
/// Bisection, so that only sums go between ranks.
std::vector<double> percentiles(const std::vector<Distribution>& all, const std::vector<double>& totals,
                                MPI_Comm comm) {
  const std::size_t n = all.size(), m = shares.size();
  std::vector<double> low(n * m), high(n * m), sums(n * m);
  for (std::size_t d = 0; d < n; ++d) {
    const bool any = !all[d].values.empty();
    const double least = Utilities::MPI::min(any ? all[d].values.front() : 1e300, comm),
                 most = Utilities::MPI::max(any ? all[d].values.back() : -1e300, comm);
    for (std::size_t k = 0; k < m; ++k) {
      low[m * d + k] = least - 1e-9;
      high[m * d + k] = most;
    }
  }
  for (int iteration = 0; iteration < 46; ++iteration) {
    for (std::size_t i = 0; i < n * m; ++i) sums[i] = all[i / m].at_or_below((low[i] + high[i]) / 2);
    Utilities::MPI::sum(sums, comm, sums);
    for (std::size_t i = 0; i < n * m; ++i) {
      const bool enough = sums[i] >= shares[i % m] * totals[i / m] * (1 - 1e-9);
      (enough ? high : low)[i] = (low[i] + high[i]) / 2;
    }
  }
  return high;
}

}  // namespace

/// The thirds of the length between the attachments' centroids, what lies beyond them included; all; and
/// every section and set of the mesh file.
void Muscle::find_regions() {
  const auto add = [&](const std::string& name, const auto& has) {
    Region region{name, {}, 0};
    for (const Group& group : groups_) {
      const auto n = static_cast<std::size_t>(n_points(group.shape));
      for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
        for (std::size_t p = first_point_[c]; p < first_point_[c] + n; ++p) {
          if (has(group, c, p)) region.points.push_back(p);
        }
      }
    }
    for (const std::size_t p : region.points) region.volume += volumes_[p];
    region.volume = Utilities::MPI::sum(region.volume, comm_);
    if (region.volume > 0) regions_.push_back(region);
  };
  const Point<3> start = proximal_start_;
  const char* const thirds[] = {"proximal", "middle", "distal"};
  for (int third = 0; third < 3; ++third) {
    add(thirds[third], [&](const Group& group, std::size_t, std::size_t p) {
      const double part = (place(p) - start) * line_ / line_length_;
      return grows(group) && std::min(2, std::max(0, static_cast<int>(std::floor(3 * part)))) == third;
    });
  }
  add("all", [&](const Group& group, std::size_t, std::size_t) { return grows(group); });
  for (std::size_t m = 0; m < materials_.size() && file_.has_sections; ++m) {
    add(materials_[m].section,
        [&](const Group& group, std::size_t, std::size_t) { return group.material == m; });
  }
  for (const MeshFile::Set& set : file_.sets) {
    const std::vector<char> in_set = file_.cells_of(set.name);
    add(set.name, [&](const Group&, std::size_t c, std::size_t) {
      return in_set[cells_[c]->id().get_coarse_cell_id()] != 0;
    });
  }
}

void Muscle::write_regions() {
  std::vector<Distribution> all;
  std::vector<double> totals, sums;
  for (const Region& region : regions_) {
    for (const std::vector<double>* values : {&lambda_e_, &G_}) {
      all.push_back(sorted(region.points, *values, volumes_));
      totals.push_back(region.volume);
      double sum = 0;
      for (const std::size_t p : region.points) sum += volumes_[p] * (*values)[p];
      sums.push_back(sum);
    }
    double above = 0;
    for (const std::size_t p : region.points) above += lambda_e_[p] > parameters_.threshold ? volumes_[p] : 0;
    sums.push_back(above);
  }
  Utilities::MPI::sum(sums, comm_, sums);
  const std::vector<double> at = percentiles(all, totals, comm_);
  std::string rows, spots, forces;
  for (std::size_t r = 0; r < regions_.size(); ++r) {
    const std::string start = number("%.13g", time_) + "," + regions_[r].name + ",";
    rows += start + number("%.13g", regions_[r].volume);
    for (std::size_t quantity = 0; quantity < 2; ++quantity) {
      rows += number(",%.13g", sums[3 * r + quantity] / regions_[r].volume);
      for (std::size_t k = 0; k < shares.size(); ++k)
        rows += number(",%.10g", at[shares.size() * (2 * r + quantity) + k]);
    }
    rows += "\n";
    spots += start + number("%.10g", parameters_.threshold) + number(",%.13g", sums[3 * r + 2]) + "\n";
    if (regions_[r].name == "all" && sums[3 * r + 2] > found_["volume_above_threshold_max"]) {
      found_["volume_above_threshold_max"] = sums[3 * r + 2];
      found_["volume_above_threshold_max_time"] = time_;
    }
  }
  for (const Attachment& a : attachments_) {
    forces += number("%.13g", time_) + "," + a.action.surface;
    for (unsigned i = 0; i < 3; ++i) forces += number(",%.10g", a.force[i]);
    forces += number(",%.10g", a.force * line_) + "\n";
  }
  on_first(comm_, [&] {
    append(parameters_.folder + "/regions.csv", rows);
    append(parameters_.folder + "/hot_spots.csv", spots);
    append(parameters_.folder + "/attachments.csv", forces);
  });
}

/// Lengths of the streamlines, and means along them.
void Muscle::write_fascicles() const {
  std::vector<double> sums(4 * static_cast<std::size_t>(n_fascicles_), 0.0);  // length, length_0, lambda_e, G
  for (const Piece& piece : pieces_) {
    Tensor<1, 3> dx = piece.dX;  // F dX
    const auto& nodes = unknowns_->cell_nodes[piece.cell];
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      double along = 0;
      for (unsigned i = 0; i < 3; ++i) along += piece.dN[3 * a + i] * piece.dX[i];
      for (unsigned i = 0; i < 3; ++i) dx[i] += along * u_.local_element(nodes[a] + i);
    }
    double* sum = sums.data() + 4 * piece.fascicle;
    sum[0] += dx.norm();
    sum[1] += piece.dX.norm();
    sum[2] += piece.dX.norm() * lambda_e_[piece.point];
    sum[3] += piece.dX.norm() * G_[piece.point];
  }
  Utilities::MPI::sum(sums, comm_, sums);
  std::string rows;
  for (std::size_t f = 0; 4 * f < sums.size(); ++f) {
    const double* sum = sums.data() + 4 * f;
    if (!(sum[1] > 0)) continue;  // it has no part in muscle
    rows += number("%.13g", time_) + "," + std::to_string(f) + number(",%.13g", sum[0]) +
            number(",%.13g", sum[1]) + number(",%.13g", sum[2] / sum[1]) + number(",%.13g", sum[3] / sum[1]) +
            "\n";
  }
  on_first(comm_, [&] { append(parameters_.folder + "/fascicles.csv", rows); });
}

void Muscle::write_rows() {
  write_history();
  write_regions();
  if (n_fascicles_ > 0) write_fascicles();
}

}  // namespace muscle
