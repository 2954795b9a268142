# shellcheck shell=bash disable=SC2154,SC2034,SC2164 # variables of ./run, and for it
# ./run mpi and ./run mpi-bench, sourced by ./run: their arguments, the build where deal.II can be had, the start.

ranks=2 mesh="" prm="" given="" arguments=()

mpi_arguments() {
  if [ "$job" = mpi-bench ]; then
    [[ $# -eq 0 || ($# -eq 1 && "$1" =~ ^PART=(loops|krylov|ranks|weak|muscle|answer)(,(loops|krylov|ranks|weak|muscle|answer))*$) ]] ||
      usage "expected PART= and some of loops,krylov,ranks,weak,muscle,answer, found '$*'"
  fi
  while [ $# -gt 0 ]; do
    case "$1" in
      --ranks | --prm | --mesh)
        [ -n "${2:-}" ] || usage "$1 needs a value"
        [[ " $given " != *" $1 "* ]] || usage "$1 is given twice"
        given+=" $1"
        declare -g "${1#--}=$2"
        shift
        ;;
      --entries | --help | -h) ranks=1 prm=--help ;;
      *=*) arguments+=("$1") ;;
      *) usage "no option '$1' (--ranks N, --prm FILE, --mesh SIZE, --entries, Section/Entry=value)" ;;
    esac
    shift
  done
  [[ "$ranks" =~ ^[1-9][0-9]{0,5}$ ]] || usage "--ranks $ranks: must be a whole number from 1 to 999999"
}

mpi_skip() {
  say "./run $job: skipped: $*; set DEAL_II_DIR if it is elsewhere"
  exit 77
}

mpi_build() {
  local targets
  lock_build
  need "${build_packages[@]}" || exit
  find_dealii || mpi_skip "deal.II with MPI (libdeal.ii-dev) could not be installed"
  configure release -DMYOGROWTH_BUILD_TESTS=OFF
  targets=$(cmake --build --preset release --target help) || fail "cannot list the build's targets"
  grep -q '^muscle:' <<<"$targets" || mpi_skip "deal.II 9.4 with MPI, p4est, Trilinos and METIS was not found"
  build release muscle -j 1 # each file takes up to 2 GB
  if [ -n "$mesh" ]; then
    prepare_python
    mkdir -p out
    "$python" examples/calculix/cylinder_mesh.py "$mesh" "out/$mesh.mesh"
    arguments=(Geometry/Kind=file "Geometry/File=${root}out/$mesh.mesh" "${arguments[@]}")
  fi
  unlock_build
  # Open MPI: as root in a container, more ranks than cores.
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
    OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_mpi_yield_when_idle=1 OMP_NUM_THREADS=1
}

mpi_run() {
  if [ -z "$prm" ]; then
    prm=$top/examples/dealii/biceps.prm
    results mpi Output/Folder= "${arguments[@]}"
    arguments=("${out[@]}" "${arguments[@]}")
  fi
  cd "$here"
  # mpirun ends with 0 where it cannot hand on what is printed.
  [ "$prm" = --help ] || echo "mpirun -n $ranks muscle $prm ${arguments[*]}" || fail "standard output cannot be written"
  exec mpirun -n "$ranks" "$top/build/examples/dealii/muscle" "$prm" "${arguments[@]}"
}
