// What a run leaves behind: history.csv, newton.csv, fields for ParaView, the checkpoint, summary.json, and
// what it says.
#include <deal.II/base/utilities.h>
#include <deal.II/numerics/data_out.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "muscle.hpp"

namespace muscle {

using namespace dealii;

namespace {

std::string number(const char* format, double x) {
  char text[64];
  std::snprintf(text, sizeof text, format, x);
  return text;
}

/// A checkpoint: the header, a key for every cell, and in the same order a record for every cell.
struct Header {
  char magic[8] = {'m', 'y', 'o', 'g', 'r', 'm', 'p', 'i'};
  std::uint64_t cells = 0;
  std::int64_t steps = 0;
  double time = 0, dt = 0;
};
struct Record {
  double G[most_points] = {}, lambda[most_points] = {}, u[3 * most_nodes] = {};
};

void io(int result, const std::string& path, const char* what) {
  if (result != MPI_SUCCESS) throw Error(path + ": cannot be " + what);
}

}  // namespace

void Muscle::say(const std::string& line) const {
  if (rank_ == 0) std::cout << line << std::endl;
}

/// A row of CalculiX's example, whose columns these are: extremes over the points of the muscle, means over
/// its volume before the deformation, the axial reaction, and where lambda_e is largest.
void Muscle::write_history() {
  const double least = std::numeric_limits<double>::lowest();
  std::array<double, 4> largest = {{least, least, least, least}};  // lambda_e, -lambda_e, G, -G
  std::array<double, 3> sums = {{0, 0, 0}};                        // volume, lambda_e, G
  const auto for_points = [&](auto visit) {
    for (const Group& group : groups_) {
      const std::size_t n = group.tendon ? 0 : group.n * static_cast<std::size_t>(n_points(group.shape));
      for (std::size_t p = group.first_point; p < group.first_point + n; ++p) visit(p);
    }
  };
  for_points([&](std::size_t p) {
    const double values[4] = {lambda_e_[p], -lambda_e_[p], G_[p], -G_[p]};
    for (std::size_t i = 0; i < 4; ++i) largest[i] = std::max(largest[i], values[i]);
    sums[0] += volumes_[p];
    sums[1] += volumes_[p] * lambda_e_[p];
    sums[2] += volumes_[p] * G_[p];
  });
  for (double& x : largest) x = Utilities::MPI::max(x, comm_);
  for (double& x : sums) x = Utilities::MPI::sum(x, comm_);
  // Where symmetry has several such points: the one of least z, y, x, so that the number of ranks does not
  // matter.
  std::array<double, 3> place = {{1e300, 1e300, 1e300}};
  for_points([&](std::size_t p) {
    if (lambda_e_[p] < largest[0] - 1e-8) return;
    const auto rounded = [&](std::size_t i) { return std::round(places_[3 * p + i] * 1e7) / 1e7; };
    place = std::min(place, std::array<double, 3>{{rounded(2), rounded(1), rounded(0)}});
  });
  const auto all = Utilities::MPI::all_gather(comm_, place);
  place = *std::min_element(all.begin(), all.end());
  if (rank_ != 0) return;
  std::ofstream out(parameters_.folder + "/history.csv", std::ios::app);
  const double row[11] = {time_,       reaction_,  largest[0],        sums[1] / sums[0],
                          -largest[1], largest[2], sums[2] / sums[0], -largest[3],
                          place[2],    place[1],   place[0]};
  for (int i = 0; i < 11; ++i) out << (i ? "," : "") << number("%.13g", row[i]);
  out << std::endl;
  if (!out) std::cerr << parameters_.folder << "/history.csv: cannot be written" << std::endl;
}

void Muscle::log_newton(int iteration, double residual, int krylov) {
  if (rank_ != 0) return;
  std::ofstream out(parameters_.folder + "/newton.csv", std::ios::app);
  out << number("%.13g", time_) << ',' << iteration << ',' << number("%.6g", residual) << ',' << krylov
      << '\n';
}

/// Empties a CSV file, but for the rows that a resumed run goes on from.
void Muscle::keep_rows_until_now(const std::string& name, const std::string& header) const {
  if (rank_ != 0) return;
  const std::string path = parameters_.folder + "/" + name;
  std::vector<std::string> rows;
  std::ifstream in(path);
  std::string line;
  if (parameters_.resume) std::getline(in, line);
  while (parameters_.resume && std::getline(in, line)) {
    const bool is_of_step_to_come = name == "newton.csv" && std::atof(line.c_str()) >= time_ * (1 - 1e-9);
    if (std::atof(line.c_str()) <= time_ * (1 + 1e-9) && !is_of_step_to_come) rows.push_back(line);
  }
  std::ofstream out(path);
  out << header << '\n';
  for (const std::string& row : rows) out << row << '\n';
}

void Muscle::write_fields() {
  DataOut<3> out;
  out.attach_dof_handler(dofs_);
  const std::vector<DataComponentInterpretation::DataComponentInterpretation> vector(
      3, DataComponentInterpretation::component_is_part_of_vector);
  out.add_data_vector(u_, std::vector<std::string>(3, "displacement"), DataOut<3>::type_dof_data, vector);
  // Means over the volume of every cell.
  const std::vector<std::pair<std::string, const std::vector<double>*>> fields = {
      {"G", &G_}, {"lambda_e", &lambda_e_}, {"lambda", &lambda_}, {"J", &J_}, {"Je", &Je_}};
  std::vector<dealii::Vector<float>> means(fields.size(), dealii::Vector<float>(mesh_->n_active_cells()));
  std::vector<dealii::Vector<float>> fibre(3, dealii::Vector<float>(mesh_->n_active_cells()));
  dealii::Vector<float> tendon(mesh_->n_active_cells());
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      const unsigned cell = cells_[c]->active_cell_index();
      const std::size_t first = first_point_[c],
                        end = first + static_cast<std::size_t>(n_points(group.shape));
      double volume = 0;
      for (std::size_t p = first; p < end; ++p) volume += volumes_[p];
      for (std::size_t k = 0; k < fields.size(); ++k) {
        double sum = 0;
        for (std::size_t p = first; p < end; ++p) sum += volumes_[p] * (*fields[k].second)[p];
        means[k](cell) = static_cast<float>(sum / volume);
      }
      for (unsigned i = 0; i < 3; ++i) fibre[i](cell) = static_cast<float>(n0_[3 * first + i]);
      tendon(cell) = group.tendon;
    }
  }
  for (std::size_t k = 0; k < fields.size(); ++k)
    out.add_data_vector(means[k], fields[k].first, DataOut<3>::type_cell_data);
  const char* components[3] = {"n0_x", "n0_y", "n0_z"};
  for (unsigned i = 0; i < 3; ++i) out.add_data_vector(fibre[i], components[i], DataOut<3>::type_cell_data);
  out.add_data_vector(tendon, "tendon", DataOut<3>::type_cell_data);
  out.build_patches(mappings_);
  const std::string name = "day_" + number("%g", time_);
  const unsigned ranks = Utilities::MPI::n_mpi_processes(comm_);
  for (unsigned r = 0; r < ranks; ++r) {
    if (r != rank_) continue;
    std::ofstream file(parameters_.folder + "/" + name + "." + std::to_string(rank_) + ".vtu");
    out.write_vtu(file);
  }
  if (rank_ != 0) return;
  std::vector<std::string> pieces;
  for (unsigned r = 0; r < ranks; ++r) pieces.push_back(name + "." + std::to_string(r) + ".vtu");
  std::ofstream record(parameters_.folder + "/" + name + ".pvtu");
  out.write_pvtu_record(record, pieces);
  written_.emplace_back(time_, name + ".pvtu");
  std::ofstream collection(parameters_.folder + "/muscle.pvd");
  DataOutBase::write_pvd_record(collection, written_);
}

void Muscle::write_checkpoint() {
  const std::string path = parameters_.folder + "/checkpoint", part = path + ".part";
  Header header;
  header.cells = mesh_->n_global_active_cells();
  header.steps = costs_.steps;
  header.time = time_;
  header.dt = dt_;
  std::vector<std::uint64_t> keys;
  std::vector<Record> records;
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      keys.push_back(cell_key(cells_[c]->id()));
      Record r;
      for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
        r.G[q] = G_n_[first_point_[c] + q];
        r.lambda[q] = lambda_n_[first_point_[c] + q];
      }
      const std::vector<unsigned>& nodes = unknowns_->cell_nodes[c];
      for (std::size_t k = 0; k < 3 * nodes.size(); ++k)
        r.u[k] = u_.local_element(nodes[k / 3] + static_cast<unsigned>(k % 3));
      records.push_back(r);
    }
  }
  const std::uint64_t n = keys.size();
  std::uint64_t before = 0;
  MPI_Exscan(&n, &before, 1, MPI_UINT64_T, MPI_SUM, comm_);
  MPI_Datatype record;
  MPI_Type_contiguous(sizeof(Record), MPI_BYTE, &record);
  MPI_Type_commit(&record);
  MPI_File file;
  io(MPI_File_open(comm_, part.c_str(), MPI_MODE_CREATE | MPI_MODE_WRONLY, MPI_INFO_NULL, &file), part,
     "written");
  const auto offset = [](std::uint64_t bytes) { return static_cast<MPI_Offset>(bytes); };
  int result = MPI_SUCCESS;
  if (rank_ == 0) result = MPI_File_write_at(file, 0, &header, sizeof header, MPI_BYTE, MPI_STATUS_IGNORE);
  const int keys_result = MPI_File_write_at_all(file, offset(sizeof header + 8 * before), keys.data(),
                                                static_cast<int>(n), MPI_UINT64_T, MPI_STATUS_IGNORE);
  const int records_result =
      MPI_File_write_at_all(file, offset(sizeof header + 8 * header.cells + sizeof(Record) * before),
                            records.data(), static_cast<int>(n), record, MPI_STATUS_IGNORE);
  MPI_Type_free(&record);
  const int close_result = MPI_File_close(&file);
  const bool bad = result != MPI_SUCCESS || keys_result != MPI_SUCCESS || records_result != MPI_SUCCESS ||
                   close_result != MPI_SUCCESS;
  if (Utilities::MPI::max(bad ? 1 : 0, comm_) != 0) throw Error(part + ": cannot be written");
  // The old checkpoint is there until the new one is whole.
  if (rank_ == 0) std::rename(part.c_str(), path.c_str());
}

void Muscle::read_checkpoint() {
  const std::string path = parameters_.folder + "/checkpoint";
  MPI_File file;
  io(MPI_File_open(comm_, path.c_str(), MPI_MODE_RDONLY, MPI_INFO_NULL, &file), path, "read");
  const Header wanted;
  Header header;
  MPI_File_read_at_all(file, 0, &header, sizeof header, MPI_BYTE, MPI_STATUS_IGNORE);
  if (!std::equal(wanted.magic, wanted.magic + 8, header.magic)) throw Error(path + ": is not a checkpoint");
  if (header.cells != mesh_->n_global_active_cells()) {
    throw Error(path + ": has " + std::to_string(header.cells) + " cells, the mesh has " +
                std::to_string(mesh_->n_global_active_cells()));
  }
  MPI_Offset size;
  MPI_File_get_size(file, &size);
  if (static_cast<std::uint64_t>(size) != sizeof header + (8 + sizeof(Record)) * header.cells)
    throw Error(path + ": is cut short");
  std::vector<std::uint64_t> keys(header.cells);
  MPI_File_read_at_all(file, sizeof header, keys.data(), static_cast<int>(keys.size()), MPI_UINT64_T,
                       MPI_STATUS_IGNORE);
  std::map<std::uint64_t, std::uint64_t> row_of;
  for (std::uint64_t row = 0; row < keys.size(); ++row) row_of[keys[row]] = row;
  std::string missing;
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n && missing.empty(); ++c) {
      const auto found = row_of.find(cell_key(cells_[c]->id()));
      if (found == row_of.end()) {
        std::ostringstream text;
        text << path << ": has no cell " << cells_[c]->id();
        missing = text.str();
        break;
      }
      Record r;
      MPI_File_read_at(
          file, static_cast<MPI_Offset>(sizeof header + 8 * header.cells + sizeof(Record) * found->second),
          &r, sizeof r, MPI_BYTE, MPI_STATUS_IGNORE);
      for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
        G_n_[first_point_[c] + q] = r.G[q];
        lambda_n_[first_point_[c] + q] = r.lambda[q];
      }
      const std::vector<unsigned>& nodes = unknowns_->cell_nodes[c];
      for (std::size_t k = 0; k < 3 * nodes.size(); ++k)
        u_.local_element(nodes[k / 3] + static_cast<unsigned>(k % 3)) = r.u[k];
    }
  }
  MPI_File_close(&file);
  missing = failure_of_any(missing);
  if (!missing.empty()) throw Error(missing);
  u_.update_ghost_values();
  u_n_ = u_;
  time_ = header.time;
  dt_ = header.dt;
  costs_.steps = static_cast<int>(header.steps);
  for (double t : parameters_.output_times) {
    if (t <= time_) written_.emplace_back(t, "day_" + number("%g", t) + ".pvtu");
  }
  std::sort(written_.begin(), written_.end());
  say("resumed at time " + number("%g", time_));
}

void Muscle::tell_progress(double seconds) const {
  const double left = parameters_.end - time_,
               most = parameters_.steps == "adaptive" ? parameters_.longest_step : parameters_.end;
  const double steps = std::ceil(left / std::min(dt_, most) - 1e-9);
  say("step " + std::to_string(costs_.steps) + "   time " + number("%.4g", time_) + " of " +
      number("%g", parameters_.end) + "   " + number("%.1f", seconds) + " s   reaction " +
      number("%.4g", reaction_) +
      (left > 0 ? "   about " + number("%.0f", steps * seconds) + " s left" : ""));
}

void Muscle::write_summary(double seconds) const {
  const auto mean = [&](double x) {
    return Utilities::MPI::sum(x, comm_) / Utilities::MPI::n_mpi_processes(comm_);
  };
  const std::vector<std::pair<std::string, double>> cpu = {{"law", mean(costs_.law)},
                                                           {"element", mean(costs_.element)},
                                                           {"insertion", mean(costs_.insertion)},
                                                           {"set_up", mean(costs_.set_up)},
                                                           {"krylov", mean(costs_.krylov)},
                                                           {"output", mean(costs_.output)}};
  Utilities::System::MemoryStats memory;
  Utilities::System::get_memory_stats(memory);
  const double megabytes = Utilities::MPI::max(static_cast<double>(memory.VmHWM), comm_) / 1024;
  std::ostringstream json;
  json << "{\"ranks\": " << Utilities::MPI::n_mpi_processes(comm_)
       << ", \"elements\": " << mesh_->n_global_active_cells() << ", \"unknowns\": " << dofs_.n_dofs()
       << ", \"steps\": " << costs_.steps << ", \"cuts\": " << costs_.cuts
       << ", \"newton\": " << costs_.newton << ", \"checks\": " << costs_.checks
       << ", \"solves\": " << costs_.solves << ", \"iterations\": " << costs_.iterations
       << ", \"set_ups\": " << costs_.set_ups << ", \"megabytes\": " << megabytes
       << ", \"seconds\": " << seconds << ", \"cpu\": {";
  std::ostringstream shares;
  double total = 0;
  for (const auto& entry : cpu) total += entry.second;
  for (std::size_t k = 0; k < cpu.size(); ++k) {
    json << (k ? ", " : "") << '"' << cpu[k].first << "\": " << cpu[k].second;
    shares << (k ? ", " : "") << cpu[k].first << ' ' << number("%.1f", cpu[k].second) << " s ("
           << number("%.0f", 100 * cpu[k].second / total) << " %)";
  }
  json << "}}\n";
  if (rank_ == 0) std::ofstream(parameters_.folder + "/summary.json") << json.str();
  say("CPU a rank: " + shares.str());
  say(std::to_string(costs_.steps) + " steps, " + std::to_string(costs_.cuts) + " cut, " +
      std::to_string(costs_.newton) + " Newton iterations, " + std::to_string(costs_.iterations) +
      " of GMRES in " + std::to_string(costs_.solves) + " solves; " + number("%.0f", megabytes) +
      " MB a rank; " + number("%.1f", seconds) + " s");
  say(parameters_.folder + "/: history.csv, newton.csv, muscle.pvd and its files, summary.json");
}

}  // namespace muscle
