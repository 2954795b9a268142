# shellcheck shell=bash disable=SC2154,SC2034,SC2164 # variables of ./run, and for it
# What ./run does before a job, sourced by it: packages, the lock on the build folder, configuring and building.
# Progress goes to stderr: in one line that moves on a terminal, elsewhere as one line at the start and one at the end.

say() { echo "$*" >&2; }
fail() { say "./run $job: $*"; exit 1; }
usage() { say "./run $job: $*"; exit 2; }
on_terminal() { [ -t 2 ] && [ "${TERM:-dumb}" != dumb ]; }

no_arguments() {
  [ $# -eq 0 ] || usage "takes no options, found '$1'"
}

# CMake, Ninja, the linker and the loader give these characters a meaning of their own.
check_path() {
  case "$top" in
    *[\"\$\#\;:,\|\<\>\`\\[:cntrl:]]*)
      fail "the folder $(printf %q "$top") has one of \" \$ # ; : , | < > \` \\ or a control character in its name, which CMake and linkers cannot take: rename it" ;;
  esac
}

# ---- The lock. Whoever builds holds it; the kernel releases it when the holder and its compilers have ended, however.

lock() {  # LOCK FILE, FILE DESCRIPTOR (8 or 9), WHAT IS HELD
  local who
  command -v flock >/dev/null || { say "./run $job: no flock (util-linux): do not start a second ./run in this tree"; return 0; }
  while true; do
    eval "exec $2<>\"\$1\""
    if ! flock -n "$2"; then
      who=$(cat "$1" 2>/dev/null) || true
      say "./run $job: waits for ${who:-another ./run}, which uses $3"
      flock "$2" || fail "cannot lock $1"
    fi
    [ "/proc/self/fd/$2" -ef "$1" ] && break  # else the folder was removed in the meantime, the lock with it
  done
  echo "./run $job (process $$)" 2>/dev/null >"$1" || true  # the disk may be full: a compiler says so better
}

build_locked=
lock_build() {
  [ -z "$build_locked" ] || return 0
  local dir=$top/build foreign
  check_path
  if [ ! -e "$dir" ] && ! mkdir -p "$dir" 2>/dev/null; then
    fail "cannot make the folder $dir: the disk is full, or $top is not yours to write or read-only; clone it to where you may write"
  fi
  [ -d "$dir" ] || fail "$dir is no folder: remove build"
  foreign=$(find "$dir" ! -user "$(id -u)" ! -writable -printf '%u' -quit 2>/dev/null) || true
  [ -z "$foreign" ] || fail "build/ has files of the user $foreign, which you may not write: remove build/"
  [ -w "$dir" ] || fail "$dir cannot be written (read-only?): clone the tree to where you may write, or remove build/"
  lock "$dir/.lock" 9 build/
  build_locked=yes
}

unlock_build() {
  exec 9>&-
  build_locked=
}

# The folder of a job's results, as options ($out): out/NAME of this tree, of one run at a time; or what the user names,
# without a lock.
results() {  # NAME OPTION ARGUMENTS
  local word
  out=()
  for word in "${@:3}"; do
    case "$word" in --out | --out=* | --help | -h | Output/Folder=*) return 0 ;; esac
  done
  case "$2" in
    *=) out=("$2${root}out/$1") ;;
    *) out=("$2" "${root}out/$1") ;;
  esac
  mkdir -p "$(dirname "$top/out/$1")" 2>/dev/null || fail "cannot make the folder $top/out: name another, or free disk space"
  lock "$top/out/.${1//\//-}.lock" 8 "out/$1/"
}

# ---- Debian's packages by name, installed if missing: with apt-get as root or through sudo; elsewhere they are named.

need() {
  local missing=() as_root=() log progress=0 tries=0
  if command -v dpkg-query >/dev/null; then
    for package in "$@"; do
      [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
    done
  elif ! command -v cmake >/dev/null || ! command -v ninja >/dev/null; then
    missing=("$@")
  fi
  [ ${#missing[@]} -gt 0 ] || return 0
  if [ "$(id -u)" != 0 ]; then as_root=(sudo); fi
  if ! command -v apt-get >/dev/null || ! command -v "${as_root[@]:-true}" >/dev/null; then
    say "./run $job: needs these Debian packages, or what your system has in their place: ${missing[*]}"
    return 1
  fi
  say "installing ${missing[*]}"
  if on_terminal; then progress=1; fi
  # apt waits for others with dpkg's lock, but not with that of its lists.
  until log=$("${as_root[@]}" apt-get -o DPkg::Lock::Timeout=300 update -qq 2>&1 8>&- 9>&-); do
    [[ "$log" == *"Could not get lock"* ]] && [ $((tries += 1)) -lt 60 ] || break
    sleep 5
  done
  # Lists that could not be brought up to date are no error if the packages can be had all the same.
  if ! log+=$("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 install -y -q \
      --no-install-recommends "${missing[@]}" 2>&1 8>&- 9>&- | awk -v progress=$progress '
        { print }
        /newly installed/ { all = $3 } /^Unpacking/ { n++ } /^Setting up/ { m++ }
        progress && /^Unpacking|^Setting up/ { printf "\r  %d of %d packages unpacked, %d set up", n, all, m >"/dev/stderr" }
        END { if (progress && n) print "" >"/dev/stderr" }'); then
    grep -E '^(E|Err|dpkg: error|sudo)[: ]' <<<"$log" >&2 || tail -n 20 <<<"$log" >&2
    say "./run $job: could not install ${missing[*]} (no network, or no rights?): install them, then start it again"
    return 1
  fi
  say "installed"
}

# Debian's own python3 sees Debian's packages; another one may come first on the PATH.
find_python() {
  for python in python3 /usr/bin/python3; do
    if command -v "$python" >/dev/null && "$python" -c 'import matplotlib, numpy, meshio' 2>/dev/null; then
      python=$(command -v "$python")
      return
    fi
  done
  fail "no python3 with matplotlib, numpy and meshio found: install ${python_packages[*]}"
}

# A ccx that loads libraries. MYOGROWTH_CCX names one; else it is built, once.
find_ccx() {
  [ -n "${MYOGROWTH_CCX:-}" ] || ! command -v apt-get >/dev/null || need "${ccx_packages[@]}" || exit
  ccx=$("$top/examples/calculix/build_ccx.sh") || exit
}

# deal.II with MPI, installed if Debian has it; false where it cannot be had.
find_dealii() {
  [ -n "${DEAL_II_DIR:-}" ] && return
  ! command -v apt-get >/dev/null || need "${mpi_packages[@]}" || return
  command -v mpirun >/dev/null
}

# ---- CMake. A build folder that it would refuse, or take and break, is refused here in one sentence.

check_cache() {  # PRESET
  local dir=build cache value name
  [ "$1" = release ] || dir=build/$1
  cache=$dir/CMakeCache.txt
  [ -f "$cache" ] || return 0
  cached() { sed -n "s/^$1:[^=]*=//p" "$cache"; }
  value=$(cached CMAKE_HOME_DIRECTORY)
  [ -z "$value" ] || [ "$value" -ef "$top" ] || fail "$dir/ was made for the tree in $value, not for this one: remove $dir/"
  value=$(cached CMAKE_CACHEFILE_DIR)
  [ -z "$value" ] || [ "$value" -ef "$dir" ] || fail "$dir/ was made as $value, and moved: remove $dir/"
  value=$(cached CMAKE_GENERATOR)
  [ "${value:-Ninja}" = Ninja ] || fail "$dir/ was made for $value, not for Ninja: remove $dir/"
  for name in MAKE_PROGRAM CXX_COMPILER C_COMPILER Fortran_COMPILER; do
    value=$(cached "CMAKE_$name")
    case "$value" in '' | *-NOTFOUND) continue ;; esac
    command -v "$value" >/dev/null || fail "$dir/ was made with $value, which is not there any more: remove $dir/"
  done
  name=g++
  [ "$1" != clang ] || name=clang++
  [ "$1" != windows ] || name=x86_64-w64-mingw32-g++-posix
  value=$(cached CMAKE_CXX_COMPILER)
  [ -z "$value" ] || [ "$(command -v "$value")" -ef "$(command -v "$name")" ] ||
    fail "$dir/ was made with the compiler $value, but $name is now $(command -v "$name"): remove $dir/"
}

# CMake and compilers say what is wrong; of a full disk they tell in many words.
fail_above() {
  local free
  free=$(df -k --output=avail build | tail -n 1)
  [ "${free:-1024}" -ge 1024 ] || fail "$*: the disk is full"
  fail "$* (above)"
}

configure() {  # PRESET [CMAKE OPTIONS]
  local log
  check_cache "$1"
  log=$(cmake --preset "$@" 2>&1) || { echo "$log" >&2; fail_above "CMake could not configure $top"; }
}

build() {  # PRESET [TARGETS AND OPTIONS]
  local command=(cmake --build --preset "$1") what=${*:2} log start=$SECONDS
  [ $# -eq 1 ] || command+=(--target "${@:2}")
  if on_terminal; then
    "${command[@]}" >&2 || fail_above "building ${what:-all} failed"
    return
  fi
  say "building ${what:-all} ($1)"
  if ! log=$("${command[@]}" 2>&1); then
    grep -vE '^\[[0-9]+/[0-9]+\] ' <<<"$log" >&2 || true
    fail_above "building ${what:-all} failed"
  fi
  say "built in $((SECONDS - start)) s"
}

# Packages, lock, the release preset and what of it a program needs.
prepare() {  # TARGETS
  lock_build
  need "${build_packages[@]}" || exit
  configure release -DMYOGROWTH_BUILD_TESTS=OFF
  build release "$@"
}

# Python for a job's pictures.
prepare_python() {
  need "${python_packages[@]}" || exit
  find_python
}
