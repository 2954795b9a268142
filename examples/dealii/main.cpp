// Muscle on many cores: mpirun -n RANKS muscle [FILE.prm] [Section/Entry=value ...]; muscle --help lists the
// entries.
#include <deal.II/base/mpi.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>

#include "muscle.hpp"

namespace {

volatile int asked_to_end = 0;
void ask_to_end(int) { asked_to_end = 1; }

/// The folder and those it lies in, made if they are not there. Throws Error.
void make_folder(const std::string& path) {
  for (std::size_t slash = 0; slash != std::string::npos;) {
    slash = path.find('/', slash + 1);
    const std::string part = path.substr(0, slash);
    if (mkdir(part.c_str(), 0777) != 0 && errno != EEXIST) {
      throw muscle::Error("Output/Folder = " + path + ": " + part + ": " + std::strerror(errno));
    }
  }
}

int job(const std::vector<std::string>& arguments, MPI_Comm comm) {
  std::string file;
  std::vector<std::string> overrides;
  for (const std::string& argument : arguments) {
    if (argument.find('=') != std::string::npos) {
      overrides.push_back(argument);
    } else if (file.empty()) {
      file = argument;
    } else {
      throw muscle::Error(argument + ": there is a parameter file already, " + file);
    }
  }
  const muscle::Parameters parameters = muscle::read_parameters(file, overrides);
  make_folder(parameters.folder);
  MPI_Barrier(comm);
  muscle::Muscle m(parameters, comm);
  return m.run(asked_to_end) ? 0 : 75;  // EX_TEMPFAIL: to be gone on with
}

}  // namespace

int main(int argc, char** argv) {
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const MPI_Comm comm = MPI_COMM_WORLD;
  const bool first = dealii::Utilities::MPI::this_mpi_process(comm) == 0;
  std::signal(SIGTERM, ask_to_end);
  std::signal(SIGUSR1, ask_to_end);  // mpirun hands this one on to all ranks
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && (arguments[0] == "--help" || arguments[0] == "-h")) {
    if (first) {
      std::cout << "usage: mpirun -n RANKS muscle [FILE.prm] [Section/Entry=value ...]\nAll entries, with "
                   "their defaults:\n\n"
                << muscle::parameters_help();
    }
    return 0;
  }
  try {
    return job(arguments, comm);
  } catch (const muscle::Error& e) {  // on all ranks alike
    if (first) std::cerr << "muscle: " << e.what() << std::endl;
    return 1;
  } catch (const std::exception& e) {  // perhaps on this rank alone
    std::cerr << "muscle, rank " << dealii::Utilities::MPI::this_mpi_process(comm) << ": " << e.what()
              << std::endl;
    MPI_Abort(comm, 2);
  }
  return 2;
}
