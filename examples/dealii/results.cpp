// What a run leaves behind, but for its checkpoint: history.csv, newton.csv, fields for ParaView,
// summary.json, and what it says.
#include <deal.II/base/utilities.h>
#include <deal.II/numerics/data_out.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "../common/rows.hpp"
#include "muscle.hpp"
#include "results.hpp"

namespace muscle {

using namespace dealii;

namespace {

const char* const history_columns =
    "time,reaction,lambda_e_max,lambda_e_mean,lambda_e_min,G_max,G_mean,G_min,x,y,z";
const char* const newton_columns = "time,iteration,residual,krylov";

/// The tables with several rows of one time, which have names in their second column.
const std::pair<const char*, const char*> named_tables[] = {
    {"regions.csv",
     "time,region,volume,lambda_e_mean,lambda_e_p05,lambda_e_p50,lambda_e_p95,lambda_e_p99,G_mean,G_p05,G_"
     "p50,"
     "G_p95,G_p99"},
    {"hot_spots.csv", "time,region,threshold,volume_above"},
    {"attachments.csv", "time,attachment,force_x,force_y,force_z,force_along_line"},
    {"fascicles.csv", "time,fascicle,length,length_0,lambda_e_mean,G_mean"}};

/// The rows of a CSV file of an earlier run that a resumed one goes on from: those up to `time`, as `keep`
/// says. What is no row is dropped, and told by `tell`.
template <class Keep, class Tell>
std::string rows_to_keep(const std::string& path, const std::string& columns, bool named, const Keep& keep,
                         const Tell& tell) {
  std::string kept;
  if (!std::filesystem::exists(path)) {
    tell(path + ": is not there; its rows begin now");
    return kept;
  }
  common::Rows rows(path, common::Separator::comma);
  const auto n = static_cast<std::size_t>(std::count(columns.begin(), columns.end(), ',') + 1);
  if (!rows.next() || rows.text_from(0, columns) != columns)
    throw Error(rows.place(0) + ": must be " + columns);
  while (rows.next()) {
    try {
      double time = rows.number(0, "the time");
      for (std::size_t i = named ? 2 : 1; i < n; ++i) {
        const std::string column = "column " + std::to_string(i + 1);
        if (rows.text(i, column) != "nan") rows.number(i, column);
      }
      rows.ends_after(n);
      if (keep(time)) kept += rows.text_from(0, columns) + "\n";
    } catch (const Error& e) {
      tell(std::string(e.what()) + "; the row is dropped");
    }
  }
  return kept;
}

}  // namespace

void replace_file(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  common::write_file(part, text);
  if (std::rename(part.c_str(), path.c_str()) != 0) common::cannot_be(path, "written");
}

void append(const std::string& path, const std::string& text) {
  common::Output out(path, "a");
  out << text;
  out.close();
}

void Muscle::say(const std::string& line) const {
  if (rank_ == 0) std::cout << line << std::endl;
}

/// A row of CalculiX's example, whose columns these are: extremes over the points of the muscle, means over
/// its volume before the deformation, the axial reaction, and where lambda_e is largest; nan where all is
/// tendon.
void Muscle::write_history() const {
  const double least = std::numeric_limits<double>::lowest();
  std::array<double, 4> largest = {{least, least, least, least}};  // lambda_e, -lambda_e, G, -G
  std::array<double, 3> sums = {{0, 0, 0}};                        // volume, lambda_e, G
  const auto for_points = [&](auto visit) {
    for (const Group& group : groups_) {
      const std::size_t n = !grows(group) ? 0 : group.n * static_cast<std::size_t>(n_points(group.shape));
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
  const double row[11] = {time_,       reaction_,  largest[0],        sums[1] / sums[0],
                          -largest[1], largest[2], sums[2] / sums[0], -largest[3],
                          place[2],    place[1],   place[0]};
  std::string text;
  for (int i = 0; i < 11; ++i)
    text += (i ? "," : "") + (i > 1 && sums[0] == 0 ? "nan" : number("%.13g", row[i]));
  on_first(comm_, [&] { append(parameters_.folder + "/history.csv", text + "\n"); });
}

void Muscle::log_newton(int iteration, double residual, int krylov) const {
  on_first(comm_, [&] {
    append(parameters_.folder + "/newton.csv", number("%.13g", time_) + "," + std::to_string(iteration) +
                                                   "," + number("%.6g", residual) + "," +
                                                   std::to_string(krylov) + "\n");
  });
}

/// Starts history.csv and newton.csv, with the rows that a resumed run goes on from.
void Muscle::start_rows() const {
  on_first(comm_, [&] {
    const std::string history = parameters_.folder + "/history.csv",
                      newton = parameters_.folder + "/newton.csv";
    std::string rows, checks;
    if (parameters_.resume) {
      const auto tell = [&](const std::string& line) { say(line); };
      int n = 0;
      rows = rows_to_keep(
          history, history_columns, false,
          [&](double t) {
            const bool past = t <= time_ * (1 + 1e-9);
            n += past;
            return past;
          },
          tell);
      if (n != costs_.steps)
        say(history + ": has " + std::to_string(n) + " rows up to time " + number("%g", time_) +
            ", the run made " + std::to_string(costs_.steps) + " steps" +
            (n < costs_.steps ? ": rows are missing" : ": there are rows that it did not write"));
      checks = rows_to_keep(
          newton, newton_columns, false, [&](double t) { return t < time_ * (1 - 1e-9); }, tell);
    }
    replace_file(history, std::string(history_columns) + "\n" + rows);
    replace_file(newton, std::string(newton_columns) + "\n" + checks);
    for (const auto& table : named_tables) {
      const std::string path = parameters_.folder + "/" + table.first;
      if (table.first == std::string("fascicles.csv") && n_fascicles_ == 0) continue;
      std::string kept;
      if (parameters_.resume)
        kept = rows_to_keep(
            path, table.second, true, [&](double t) { return t <= time_ * (1 + 1e-9); },
            [&](const std::string& line) { say(line); });
      replace_file(path, std::string(table.second) + "\n" + kept);
    }
  });
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
  dealii::Vector<float> tendon(mesh_->n_active_cells()), activation(mesh_->n_active_cells());
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
      tendon(cell) = grows(group) ? 0 : 1;
      activation(cell) = static_cast<float>(elastic(group).activation);
    }
  }
  for (std::size_t k = 0; k < fields.size(); ++k)
    out.add_data_vector(means[k], fields[k].first, DataOut<3>::type_cell_data);
  const char* components[3] = {"n0_x", "n0_y", "n0_z"};
  for (unsigned i = 0; i < 3; ++i) out.add_data_vector(fibre[i], components[i], DataOut<3>::type_cell_data);
  out.add_data_vector(tendon, "tendon", DataOut<3>::type_cell_data);
  const bool may_be_active = std::any_of(
      materials_.begin(), materials_.end(),
      [](const Parameters::Material& m) { return m.elastic.law != myogrowth::abi::Law::neo_hookean; });
  if (may_be_active) out.add_data_vector(activation, "activation", DataOut<3>::type_cell_data);
  out.build_patches(mappings_);
  const std::string name = "day_" + number("%.10g", time_), folder = parameters_.folder + "/";
  together(comm_, [&] {
    common::Output file(folder + name + "." + std::to_string(rank_) + ".vtu");
    out.write_vtu(file);
    file.close();
  });
  on_first(comm_, [&] {
    std::vector<std::string> pieces;
    for (unsigned r = 0; r < Utilities::MPI::n_mpi_processes(comm_); ++r)
      pieces.push_back(name + "." + std::to_string(r) + ".vtu");
    std::ostringstream record, collection;
    out.write_pvtu_record(record, pieces);
    replace_file(folder + name + ".pvtu", record.str());
    written_.emplace_back(time_, name + ".pvtu");
    DataOutBase::write_pvd_record(collection, written_);
    replace_file(folder + "muscle.pvd", collection.str());
  });
}

/// The fields that a resumed run's earlier part has written.
void Muscle::find_fields() {
  for (const double t : parameters_.output_times) {
    if (t > time_) continue;
    const std::string name = "day_" + number("%.10g", t) + ".pvtu";
    if (std::filesystem::exists(parameters_.folder + "/" + name)) {
      written_.emplace_back(t, name);
    } else {
      say(parameters_.folder + "/" + name + ": is not there; muscle.pvd will not list it");
    }
  }
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
       << ", \"seconds\": " << seconds << ", \"length\": " << line_length_
       << ", \"threshold\": " << parameters_.threshold;
  for (const auto& entry : found_) json << ", \"" << entry.first << "\": " << entry.second;
  json << ", \"attachments\": {";
  for (std::size_t k = 0; k < attachments_.size() && file_.has_sections; ++k)
    json << (k ? ", " : "") << '"' << attachments_[k].action.surface
         << "\": {\"nodes\": " << attachments_[k].nodes << ", \"area\": " << attachments_[k].area << "}";
  json << "}, \"regions\": {";
  for (std::size_t k = 0; k < regions_.size(); ++k)
    json << (k ? ", " : "") << '"' << regions_[k].name << "\": " << regions_[k].volume;
  json << "}, \"cpu\": {";
  std::ostringstream shares;
  double total = 0;
  for (const auto& entry : cpu) total += entry.second;
  for (std::size_t k = 0; k < cpu.size(); ++k) {
    json << (k ? ", " : "") << '"' << cpu[k].first << "\": " << cpu[k].second;
    shares << (k ? ", " : "") << cpu[k].first << ' ' << number("%.1f", cpu[k].second) << " s ("
           << number("%.0f", 100 * cpu[k].second / total) << " %)";
  }
  json << "}}\n";
  on_first(comm_, [&] { replace_file(parameters_.folder + "/summary.json", json.str()); });
  say("CPU a rank: " + shares.str());
  say(std::to_string(costs_.steps) + " steps, " + std::to_string(costs_.cuts) + " cut, " +
      std::to_string(costs_.newton) + " Newton iterations, " + std::to_string(costs_.iterations) +
      " of GMRES in " + std::to_string(costs_.solves) + " solves; " + number("%.0f", megabytes) +
      " MB a rank; " + number("%.1f", seconds) + " s");
  say(parameters_.folder + "/: history.csv, regions.csv, hot_spots.csv, attachments.csv, " +
      (n_fascicles_ > 0 ? "fascicles.csv, " : "") + "newton.csv, muscle.pvd and its files, summary.json");
}

}  // namespace muscle
