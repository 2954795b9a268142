/// @file
/// What goes wrong on one rank is told to all, so that none waits for a rank that has left.
#ifndef MYOGROWTH_DEALII_RANKS_HPP
#define MYOGROWTH_DEALII_RANKS_HPP

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <sstream>
#include <string>

#include "../common/files.hpp"

namespace muscle {

/// What ends the job, in words for the user. Thrown on all ranks, or on none.
using common::Error;

/// The text of the lowest rank that has one, on all ranks; empty if none has.
inline std::string first_text(MPI_Comm comm, const std::string& mine) {
  const unsigned n = dealii::Utilities::MPI::n_mpi_processes(comm);
  const unsigned first =
      dealii::Utilities::MPI::min(mine.empty() ? n : dealii::Utilities::MPI::this_mpi_process(comm), comm);
  return first == n ? std::string() : dealii::Utilities::MPI::broadcast(comm, mine, first);
}

/// deal.II's words of an exception, without its line breaks.
inline std::string words_of(const dealii::ExceptionBase& e) {
  std::ostringstream text;
  e.print_info(text);
  std::istringstream words(text.str());
  std::string line, word;
  while (words >> word) line += (line.empty() ? "" : " ") + word;
  return line;
}

/// Has every rank do its part of something. What is thrown on any of them becomes an Error on all.
template <class Work>
void together(MPI_Comm comm, const Work& work) {
  std::string wrong;
  try {
    work();
  } catch (const dealii::ExceptionBase& e) {
    wrong = words_of(e);
  } catch (const std::exception& e) {
    wrong = e.what();
  }
  wrong = first_text(comm, wrong);
  if (!wrong.empty()) throw Error(wrong);
}

/// The same for what only rank 0 does.
template <class Work>
void on_first(MPI_Comm comm, const Work& work) {
  together(comm, [&] {
    if (dealii::Utilities::MPI::this_mpi_process(comm) == 0) work();
  });
}

}  // namespace muscle

#endif
