// Muscle on many cores: mpirun -n RANKS muscle [FILE.prm] [Section/Entry=value ...]; muscle --help lists the
// entries.
#include <deal.II/base/mpi.h>
#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "../common/files.hpp"
#include "muscle.hpp"

namespace {

volatile int asked_to_end = 0;
void ask_to_end(int) { asked_to_end = 1; }

/// Makes the folder, or sees that files can be written there, and keeps other runs out of it. Throws Error.
void take_folder(const std::string& path) {
  try {
    common::make_folder(path);
  } catch (const muscle::Error& e) {
    throw muscle::Error("Output/Folder = " + std::string(e.what()));
  }
  // The system gives the lock back when the program ends, however it ends.
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY);
  if (folder >= 0 && flock(folder, LOCK_EX | LOCK_NB) == 0) return;
  if (errno == EWOULDBLOCK) throw muscle::Error("Output/Folder = " + path + ": another run is writing there");
  std::cerr << "muscle: Output/Folder = " << path << ": cannot be locked (" << std::strerror(errno)
            << "): see to it that no other run writes there" << std::endl;
}

int job(const std::vector<std::string>& arguments, MPI_Comm comm) {
  std::string file;
  std::vector<std::string> overrides;
  for (const std::string& argument : arguments) {
    if (argument.empty()) {
      throw muscle::Error("an argument is empty: expected a parameter file or Section/Entry=value");
    } else if (argument.find('=') != std::string::npos && !std::filesystem::exists(argument)) {
      overrides.push_back(argument);
    } else if (file.empty()) {
      file = argument;
    } else {
      throw muscle::Error(argument + ": there is a parameter file already, " + file);
    }
  }
  muscle::Parameters parameters;
  muscle::together(comm, [&] { parameters = muscle::read_parameters(file, overrides); });
  muscle::on_first(comm, [&] { take_folder(parameters.folder); });
  muscle::Muscle m(parameters, comm);
  return m.run(asked_to_end) ? 0 : 75;  // EX_TEMPFAIL: to be gone on with
}

}  // namespace

int main(int argc, char** argv) {
  try {
    common::check_standard_streams();  // before MPI opens files of its own
  } catch (const muscle::Error& e) {
    std::cerr << "muscle: " << e.what() << std::endl;
    return 1;
  }
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const MPI_Comm comm = MPI_COMM_WORLD;
  const bool first = dealii::Utilities::MPI::this_mpi_process(comm) == 0;
  std::signal(SIGTERM, ask_to_end);
  std::signal(SIGUSR1, ask_to_end);  // mpirun hands this one on to all ranks
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (!arguments.empty() && (arguments[0] == "--help" || arguments[0] == "-h")) {
      if (first)
        common::print(
            "usage: mpirun -n RANKS muscle [FILE.prm] [Section/Entry=value ...]\nAll entries, with their "
            "defaults:\n\n" +
            muscle::parameters_help());
      return 0;
    }
    const int status = job(arguments, comm);
    if (!std::cout.flush()) throw muscle::Error("standard output: cannot be written");
    return status;
  } catch (const muscle::Error& e) {  // on all ranks, or of what rank 0 prints
    if (first) std::cerr << "muscle: " << e.what() << std::endl;
    return 1;
  } catch (const std::exception& e) {  // perhaps on this rank only
    std::cerr << "muscle, rank " << dealii::Utilities::MPI::this_mpi_process(comm) << ": " << e.what()
              << std::endl;
    MPI_Abort(comm, 2);
  }
  return 2;
}
