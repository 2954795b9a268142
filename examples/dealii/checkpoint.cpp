// The checkpoint: what a run goes on from, and what the run was.
//
// Header; what the run was, in lines "name = value"; a key for every cell; in the same order a record for
// every cell. Nothing in it depends on the number of ranks but the order of the cells.
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <map>

#include "muscle.hpp"

namespace muscle {

using namespace dealii;

namespace {

constexpr std::uint32_t this_order = 0x01020304, other_order = 0x04030201, this_version = 3;

struct Header {
  char magic[8] = {'m', 'y', 'o', 'g', 'r', 'm', 'p', 'i'};
  std::uint32_t byte_order = this_order, version = this_version;
  std::uint64_t cells = 0, text_bytes = 0;
  std::int64_t steps = 0;
  double time = 0, dt = 0;
  std::uint64_t checksum = 0;         // of the cells
  std::uint64_t header_checksum = 0;  // of this, while it is 0, and of the text
};
struct Record {
  double G[most_points] = {}, lambda[most_points] = {}, u[3 * most_nodes] = {};
};
static_assert(sizeof(Header) == 72 && sizeof(Record) == 368, "no gaps, which would be written");

/// CRC-32 of bytes, after `before` of others.
std::uint64_t crc(const void* bytes, std::size_t n, std::uint64_t before = 0) {
  return crc32_z(before, static_cast<const unsigned char*>(bytes), n);
}

std::uint64_t checksum_of(Header header, const std::string& text) {
  header.header_checksum = 0;
  return crc(text.data(), text.size(), crc(&header, sizeof header));
}

/// The checksum of a cell, to be summed over the cells.
std::uint64_t checksum_of(std::uint64_t key, const void* bytes, std::size_t n) {
  return crc(bytes, n, crc(&key, sizeof key));
}

std::string hex(std::uint64_t x) {
  char text[20];
  std::snprintf(text, sizeof text, "%llx", static_cast<unsigned long long>(x));
  return text;
}

/// Throws Error with the reason if a call of MPI-IO has failed.
void io(int result, const std::string& path, const char* what) {
  if (result == MPI_SUCCESS) return;
  const int reason = errno;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(result, text, &length);
  throw Error(path + ": cannot be " + what + ": " + (reason ? std::strerror(reason) : text));
}

MPI_Offset offset(std::uint64_t bytes) { return static_cast<MPI_Offset>(bytes); }

/// Has what a folder lists written to the disk. File systems that cannot do that for a folder are not at
/// fault.
void sync_folder(const std::string& path) {
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY);
  if (folder < 0) return;
  fsync(folder);
  close(folder);
}

/// Reads the header and what the run was. Throws Error if the file is no whole checkpoint of this version.
Header read_header(const std::string& path, std::string& text) {
  common::Input in(path);
  const std::uint64_t size = std::filesystem::file_size(path);
  const auto check = [&](bool good, const std::string& why) {
    if (!good) throw Error(path + ": " + why);
  };
  const auto read = [&](char* bytes, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) bytes[i] = static_cast<char>(in.get());
  };
  const Header mine;
  Header header;
  check(size > 0, "is empty");
  char bytes[sizeof header] = {};
  read(bytes, std::min<std::uint64_t>(size, sizeof header));
  std::memcpy(&header, bytes, sizeof header);
  check(std::equal(mine.magic, mine.magic + std::min<std::uint64_t>(size, 8), header.magic),
        "is not a checkpoint of this program");
  check(size >= sizeof header, "is cut short: it has " + std::to_string(size) + " bytes");
  check(header.byte_order != other_order, "is of a machine with another order of bytes");
  check(header.byte_order == this_order, "is of an older version of this program, or damaged");
  check(header.version == this_version, "is of version " + std::to_string(header.version) +
                                            " of checkpoints; this program reads " +
                                            std::to_string(this_version));
  check(header.text_bytes <= size - sizeof header, "is cut short, or its header is damaged");
  text.resize(header.text_bytes);
  read(&text[0], text.size());
  check(header.header_checksum == checksum_of(header, text),
        "its header is damaged: the checksum is another");
  const std::uint64_t wanted = sizeof header + text.size() + (8 + sizeof(Record)) * header.cells;
  check(size == wanted, (size < wanted ? "is cut short: " : "has something after its end: ") +
                            std::to_string(size) + " bytes, it should have " + std::to_string(wanted));
  return header;
}

std::string section_of(const std::string& entry) { return entry.substr(0, entry.find('/')); }

/// Whether a run that goes on may have another value of an entry. What Geometry, Fibre and Ends/Tolerance
/// have made is compared itself.
bool may_change(const std::string& entry) {
  const std::string section = section_of(entry);
  return section == "Solver" || section == "Output" || section == "Geometry" || section == "Fibre" ||
         section == "Mesh" || entry == "Ends/Tolerance" || (section == "Time" && entry != "Time/Ramp");
}

}  // namespace

/// What this run is: "name = value" lines. Of mesh, fibres and supports a checksum, summed over the cells.
std::string Muscle::identity() const {
  std::array<std::uint64_t, 3> sums = {{0, 0, 0}};
  std::array<std::uint64_t, 4> counts = {{0, 0, 0, 0}};
  for (const Group& group : groups_) {
    const auto nodes = static_cast<std::size_t>(n_nodes(group.shape)),
               points = static_cast<std::size_t>(n_points(group.shape));
    counts[group.shape == Shape::hex ? 0 : group.shape == Shape::wedge ? 1 : 2] += group.n;
    counts[3] += grows(group) ? 0 : group.n;
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      const std::uint64_t key = cell_key(cells_[c]->id());
      std::vector<double> X{static_cast<double>(group.material)};
      for (std::size_t k = 0; k < 3 * nodes; ++k) X.push_back(X_[3 * first_node_[c] + k] + 0.0);  // no -0
      std::vector<float> n0;  // in which the last digit of a fibre function does not matter
      for (std::size_t k = 0; k < 3 * points; ++k)
        n0.push_back(static_cast<float>(n0_[3 * first_point_[c] + k]) + 0.0f);
      std::vector<float> supports;
      for (const unsigned node : unknowns_->cell_nodes[c]) {
        const int index = support_of_[node / 3];
        if (index < 0) continue;
        const Support& support = supports_[static_cast<std::size_t>(index)];
        for (unsigned d = 0; d < support.n; ++d) {
          supports.push_back(static_cast<float>(support.attachment[d]));
          for (unsigned i = 0; i < 3; ++i) supports.push_back(static_cast<float>(support.along[d][i]) + 0.0f);
        }
      }
      sums[0] += checksum_of(key, X.data(), sizeof(double) * X.size());
      sums[1] += checksum_of(key, n0.data(), sizeof(float) * n0.size());
      sums[2] += checksum_of(key, supports.data(), sizeof(float) * supports.size());
    }
  }
  for (std::uint64_t& x : sums) x = Utilities::MPI::sum(x, comm_);
  for (std::uint64_t& x : counts) x = Utilities::MPI::sum(x, comm_);
  std::string text = "mesh = " + std::to_string(counts[0]) + " hexahedra, " + std::to_string(counts[1]) +
                     " wedges, " + std::to_string(counts[2]) + " tetrahedra, " + std::to_string(counts[3]) +
                     " of them tendon, checksum " + hex(sums[0]) + "\nfibres = checksum " + hex(sums[1]) +
                     "\nsupports = checksum " + hex(sums[2]) + "\n";
  if (!parameters_.attachments.protocol.empty()) {
    const auto& rows = parameters_.attachments.stretching.rows();
    text += "protocol = checksum " + hex(crc(rows.data(), sizeof(rows[0]) * rows.size())) + "\n";
  }
  for (const auto& entry : parameters_.entries) text += entry.first + " = " + entry.second + "\n";
  return text;
}

/// Compares what a checkpoint's run was with what this one is. Throws Error where it must be the same.
void Muscle::compare_identity(const std::string& path, const std::string& then) const {
  const auto entries = [](const std::string& text) {
    std::map<std::string, std::string> result;
    for (std::size_t from = 0; from < text.size();) {
      const std::size_t end = text.find('\n', from), equals = text.find(" = ", from);
      result[text.substr(from, equals - from)] = text.substr(equals + 3, end - equals - 3);
      from = end + 1;
    }
    return result;
  };
  const auto before = entries(then), now = entries(identity_);
  // An older version of the program had fewer entries, and did what the defaults of the new ones do.
  const auto is_default = [&](const std::pair<const std::string, std::string>& entry) {
    const auto& all = parameters_.defaults;
    return std::any_of(all.begin(), all.end(),
                       [&](const auto& d) { return d.first == entry.first && d.second == entry.second; });
  };
  std::string wrong, changed;
  for (const auto& entry : now) {
    const auto found = before.find(entry.first);
    if (found != before.end() ? found->second == entry.second : is_default(entry)) continue;
    if (entry.first == "Output/Resume") continue;
    const std::string line = "\n  " + entry.first + " = " + entry.second + ", in the checkpoint " +
                             (found == before.end() ? "not said" : found->second);
    (may_change(entry.first) ? changed : wrong) += line;
  }
  if (!wrong.empty() && !parameters_.force)
    throw Error(path + ": is of another run; Output/Resume=force goes on from it all the same:" + wrong +
                changed);
  if (!(wrong + changed).empty()) say("the checkpoint's run had other entries:" + wrong + changed);
}

void Muscle::write_checkpoint() const {
  const std::string path = parameters_.folder + "/checkpoint", part = path + ".part";
  std::vector<std::uint64_t> keys;
  std::vector<Record> records;
  Header header;
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      Record r;
      for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
        r.G[q] = G_n_[first_point_[c] + q];
        r.lambda[q] = lambda_n_[first_point_[c] + q];
      }
      const std::vector<unsigned>& nodes = unknowns_->cell_nodes[c];
      for (std::size_t k = 0; k < 3 * nodes.size(); ++k)
        r.u[k] = u_.local_element(nodes[k / 3] + static_cast<unsigned>(k % 3));
      keys.push_back(cell_key(cells_[c]->id()));
      records.push_back(r);
      header.checksum += checksum_of(keys.back(), &r, sizeof r);
    }
  }
  const std::string& text = identity_;
  header.cells = mesh_->n_global_active_cells();
  header.text_bytes = text.size();
  header.steps = costs_.steps;
  header.time = time_;
  header.dt = dt_;
  header.checksum = Utilities::MPI::sum(header.checksum, comm_);
  header.header_checksum = checksum_of(header, text);

  const std::uint64_t n = keys.size(), head = sizeof header + text.size(),
                      size = head + (8 + sizeof(Record)) * header.cells;
  std::uint64_t before = 0;
  MPI_Exscan(&n, &before, 1, MPI_UINT64_T, MPI_SUM, comm_);
  // What a run that was killed has left is cut away.
  on_first(comm_, [&] { common::Output(part).close(); });
  MPI_File file;
  errno = 0;
  const int opened = MPI_File_open(comm_, part.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file);
  together(comm_, [&] { io(opened, part, "written"); });
  std::string wrong;
  try {
    together(comm_, [&] {
      const auto write = [&](std::uint64_t place, const void* data, std::size_t bytes) {
        // In pieces, since MPI counts in int.
        const char* from = static_cast<const char*>(data);
        for (std::size_t done = 0; done < bytes;) {
          const int piece = static_cast<int>(std::min(bytes - done, std::size_t(1) << 30));
          MPI_Status status;
          errno = 0;
          io(MPI_File_write_at(file, offset(place + done), from + done, piece, MPI_BYTE, &status), part,
             "written");
          int written = 0;
          MPI_Get_count(&status, MPI_BYTE, &written);
          // Open MPI calls it a success if a disk is full, and nothing was written.
          if (written <= 0) io(MPI_ERR_NO_SPACE, part, "written");
          done += static_cast<std::size_t>(written);
        }
      };
      if (rank_ == 0) {
        write(0, &header, sizeof header);
        write(sizeof header, text.data(), text.size());
      }
      write(head + 8 * before, keys.data(), 8 * n);
      write(head + 8 * header.cells + sizeof(Record) * before, records.data(), sizeof(Record) * n);
    });
    errno = 0;
    const int synced = MPI_File_sync(file);
    together(comm_, [&] { io(synced, part, "written"); });
  } catch (const Error& e) {
    wrong = e.what();
  }
  errno = 0;
  const int closed = MPI_File_close(&file);
  if (!wrong.empty()) throw Error(wrong);
  together(comm_, [&] { io(closed, part, "written"); });
  // The old checkpoint is there until the new one is whole.
  on_first(comm_, [&] {
    if (std::filesystem::file_size(part) != size) throw Error(part + ": cannot be written: it is too short");
    if (std::rename(part.c_str(), path.c_str()) != 0) common::cannot_be(path, "written");
    sync_folder(parameters_.folder);
  });
}

void Muscle::read_checkpoint() {
  const std::string path = parameters_.folder + "/checkpoint";
  Header header;
  std::string text;
  on_first(comm_, [&] { header = read_header(path, text); });
  MPI_Bcast(&header, sizeof header, MPI_BYTE, 0, comm_);
  text = Utilities::MPI::broadcast(comm_, text);
  compare_identity(path, text);
  if (header.cells != mesh_->n_global_active_cells())
    throw Error(path + ": has " + std::to_string(header.cells) + " cells, the mesh has " +
                std::to_string(mesh_->n_global_active_cells()));
  if (header.time > parameters_.end * (1 + 1e-12))
    throw Error(path + ": is of time " + number("%g", header.time) + ", after the end, which is at " +
                number("%g", parameters_.end));

  MPI_File file;
  errno = 0;
  const int opened = MPI_File_open(comm_, path.c_str(), MPI_MODE_RDONLY, MPI_INFO_NULL, &file);
  together(comm_, [&] { io(opened, path, "read"); });
  std::uint64_t checksum = 0;
  together(comm_, [&] {
    const auto read = [&](std::uint64_t place, void* data, std::size_t bytes) {
      char* to = static_cast<char*>(data);
      for (std::size_t done = 0; done < bytes;) {
        const int piece = static_cast<int>(std::min(bytes - done, std::size_t(1) << 30));
        errno = 0;
        io(MPI_File_read_at(file, offset(place + done), to + done, piece, MPI_BYTE, MPI_STATUS_IGNORE), path,
           "read");
        done += static_cast<std::size_t>(piece);
      }
    };
    const std::uint64_t head = sizeof header + text.size();
    std::vector<std::uint64_t> keys(header.cells);
    read(head, keys.data(), 8 * keys.size());
    std::map<std::uint64_t, std::uint64_t> row_of;
    for (std::uint64_t row = 0; row < keys.size(); ++row) row_of[keys[row]] = row;
    for (const Group& group : groups_) {
      for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
        const std::uint64_t key = cell_key(cells_[c]->id());
        const auto found = row_of.find(key);
        if (found == row_of.end())
          throw Error(path + ": has no cell " + cells_[c]->id().to_string() +
                      ": damaged, or of another mesh");
        Record r;
        read(head + 8 * header.cells + sizeof(Record) * found->second, &r, sizeof r);
        checksum += checksum_of(key, &r, sizeof r);
        for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
          G_n_[first_point_[c] + q] = r.G[q];
          lambda_n_[first_point_[c] + q] = r.lambda[q];
        }
        const std::vector<unsigned>& nodes = unknowns_->cell_nodes[c];
        for (std::size_t k = 0; k < 3 * nodes.size(); ++k)
          u_.local_element(nodes[k / 3] + static_cast<unsigned>(k % 3)) = r.u[k];
      }
    }
  });
  MPI_File_close(&file);
  if (Utilities::MPI::sum(checksum, comm_) != header.checksum)
    throw Error(path + ": its data are damaged: the checksum is another");
  u_.update_ghost_values();
  u_n_ = u_;
  time_ = header.time;
  dt_ = std::min(header.dt, parameters_.steps == "fixed" ? parameters_.step : header.dt);
  costs_.steps = static_cast<int>(header.steps);
}

/// A run that starts anew keeps what another one has left as checkpoint.old: no run is to go on from it by
/// mistake.
void Muscle::put_checkpoint_aside() const {
  on_first(comm_, [&] {
    const std::string path = parameters_.folder + "/checkpoint", old = path + ".old";
    if (!std::filesystem::exists(path)) return;
    if (std::rename(path.c_str(), old.c_str()) != 0) common::cannot_be(path, "renamed to checkpoint.old");
    say("this run starts anew: the checkpoint that was there is now " + old);
  });
}

}  // namespace muscle
