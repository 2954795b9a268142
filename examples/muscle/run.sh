# shellcheck shell=bash disable=SC2154,SC2034,SC2164 # variables of ./run, and for it
# ./run muscle, sourced by ./run after examples/dealii/run.sh: builds the solver unless only the mesh is asked for.

muscle_run() {
  local word solver=yes
  for word in "$@"; do
    case "$word" in --entries) mpi_arguments --entries; mpi_build; mpi_run ;; esac
    case "$word" in --check | --export | --export=* | --help | -h) solver= ;; esac
  done
  prepare_python
  if [ -n "$solver" ]; then # wrong options and meshes are told before the minutes of the build
    (cd "$here" && MYOGROWTH_JOB="./run muscle" "$python" "$top/examples/muscle/muscle.py" --check "$@" >/dev/null) || exit
    mpi_build
  fi
  unlock_build
  results muscle --out "$@"
  cd "$here"
  MYOGROWTH_JOB="./run muscle" exec "$python" "$top/examples/muscle/muscle.py" --program "$top/build/examples/dealii/muscle" \
    "${out[@]}" "$@"
}
