#!/usr/bin/env bash
# A UMAT's source as Abaqus's compiler takes it, made into a library for the driver: compile.sh FILE LIBRARY
# Fixed form with 132 columns and tabs, or free form; the extensions of DEC's compilers; COMMON without gaps; ABA_PARAM.INC.
set -euo pipefail
file=$1
library=$2
here=$(cd "$(dirname "$0")" && pwd -P)
fail() { echo "$file: $*" >&2; exit 1; }
[ -f "$file" ] || fail "there is no such file"
[ -r "$file" ] || fail "cannot be read"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# On Windows, where many UMATs were written, names of files have no case, and a folder's name ends with a backslash: what
# INCLUDE lines name so, here and in the included files, gets a link under the name as it is written.
link_included() { # FILE
  local folder name path base found
  folder=$(cd "$(dirname "$1")" && pwd -P)
  while IFS= read -r name; do
    read -r path <<<"${name//\\//}" || true  # blanks around it do not count
    if [[ "${path,,}" = aba_param.inc ]]; then found=$here/ABA_PARAM.INC
    elif [ -f "$folder/$name" ]; then found=$folder/$name
    else
      base=.
      while [[ "$path" = ../* ]]; do base+=/.. path=${path#../}; done
      found=${path//[^\/]/}
      found=$(cd "$folder" && find -L "$base" -maxdepth $((${#found} + 1)) -type f -ipath "$base/$path" -print -quit 2>/dev/null) || true
      found=${found:+$folder/$found}
    fi
    if [ -z "$found" ] || [ -n "${linked[$found:$name]:-}" ]; then continue; fi
    linked[$found:$name]=1
    if [ ! -f "$folder/$name" ] && [[ "$name" != /* && "$name" != ../* ]]; then
      mkdir -p "$work/$(dirname "$name")"
      ln -sf "$(realpath "$found")" "$work/$name"
    fi
    link_included "$found"
  done < <(LC_ALL=C sed -nE "s/^[[:space:]]*#?[[:space:]]*include[[:space:]]*['\"<]([^'\">]+)['\">].*/\1/Ip" "$1")
}
declare -A linked
link_included "$file"
# Abaqus's own headers: mutexes and threads need no declarations; the name that Fortran gives a routine of C.
: >"$work/SMAAspUserSubroutines.hdr"
for name in omi_for_c.h aba_for_c.h; do echo '#define FOR_NAME(name, ...) name##_' >"$work/$name"; done

fortran=(-std=legacy -fdec -fno-align-commons -ffixed-line-length-132 -ffree-line-length-none)
case "${file##*.}" in
  f | for | ftn | F | FOR | FTN)
    form=-ffixed-form
    # Intel's directive for free form in a file that is named for fixed form.
    if grep -aqiE '^[!c*]d(ec|ir)\$ *freeform' "$file"; then form=-ffree-form; fi
    compiler=(gfortran -x f95 "$form") ;;
  f90 | f95 | f03 | f08 | F90 | F95 | F03 | F08) compiler=(gfortran -x f95 -ffree-form) ;;
  cpp | cc | cxx | C) compiler=(g++ -x c++ -idirafter /usr/include/eigen3) fortran=() ;;  # where Linux systems have Eigen
  c) compiler=(gcc -x c) fortran=() ;;
  *) fail "the ending must be .f, .for or .ftn (fixed form), .f90, .f95, .f03 or .f08 (free form), .c, .cc, .cpp or .cxx" ;;
esac
[ ${#fortran[@]} -eq 0 ] || fortran+=(-J "$work")
if [ ${#fortran[@]} -gt 0 ] && grep -aqE '^#' "$file"; then fortran+=(-cpp); fi
command -v "${compiler[0]}" >/dev/null || fail "needs ${compiler[0]} (Debian: apt-get install gfortran g++)"

compile() { # FILE FOR THE ERRORS
  "${compiler[@]}" "${fortran[@]}" -I "$work" -I "$(dirname "$file")" -w -g -O1 -fPIC -c "$file" -o "$work/umat.o" 2>"$1"
}
first_line() { # of the errors in FILE
  local line
  line=$(grep -aoE -m 1 ':[0-9]+:[0-9]+:$' "$1") || line=:0:
  cut -d : -f 2 <<<"$line"
}
if ! compile "$work/errors"; then
  # Free form under an ending of fixed form, which Abaqus takes by an option in the user's abaqus_v6.env.
  if [ "${form:-}" = -ffixed-form ] && compiler=(gfortran -x f95 -ffree-form) && compile "$work/free"; then
    echo "note: $file is not in fixed form; it is taken as free form, in which it compiles" >&2
  else
    # In the form that it is not written in, a file has an error in one of its first lines.
    if [ -f "$work/free" ] && [ "$(first_line "$work/free")" -gt "$(first_line "$work/errors")" ]; then mv "$work/free" "$work/errors"; fi
    cat "$work/errors" >&2
    fail "does not compile (above)"
  fi
fi
# Names that the file defines are its own, whatever the driver's libraries define (-Bsymbolic).
gfortran -shared -Wl,-Bsymbolic "$work/umat.o" -lstdc++ -o "$library" || fail "does not link (above)"
