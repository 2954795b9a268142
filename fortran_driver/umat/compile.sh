#!/usr/bin/env bash
# A UMAT's source as Abaqus's compiler takes it, made into a library for the driver: compile.sh FILE LIBRARY
# Fixed form with 132 columns and tabs, or free form; the extensions of DEC's compilers; COMMON without gaps; ABA_PARAM.INC.
set -euo pipefail
export LC_ALL=C  # a source is bytes, in whatever encoding
file=$1
library=$2
here=$(cd "$(dirname "$0")" && pwd -P)
fail() { echo "$file: $*" >&2; exit 1; }
[ -f "$file" ] || fail "there is no such file"
[ -r "$file" ] || fail "cannot be read"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Abaqus's own headers: the functions that have another type than their first letter says; the name that Fortran gives a
# routine of C.
headers=$work/headers
mkdir "$headers"
: >"$headers/none"
printf '      %s get_thread_id, getnumthreads\n' integer external >"$headers/utilities"
for name in omi_for_c.h aba_for_c.h; do echo '#define FOR_NAME(name, ...) name##_' >"$headers/$name"; done

# The source with what it includes in place of its INCLUDE and #include lines, each file under its own name and lines for
# the compiler's messages. Files are found as Intel's compiler finds them on Windows, where many UMATs were written: names
# have no case, a folder's name ends with a backslash, a path begins at the file with the line. Published UMATs have
# directives in capitals, with '...' for "..." and blanks before them. (A # in column 6 of fixed form continues a line.)
declare -A place
find_included() { # FOLDER NAME: sets found, empty if there is no such file
  local folder=$1 path base steps
  found=${place[$folder:$2]:-}
  [ -z "${place[$folder:$2]+known}" ] || return 0
  read -r path <<<"${2//\\//}" || true  # blanks around it do not count
  case "${path,,}" in
    aba_param.inc | aba_param_dp.inc) found=$here/ABA_PARAM.INC ;;
    smaaspuserarrays.hdr) found=$headers/none ;;
    smaaspuser*.hdr) found=$headers/utilities ;;
    /*) [ ! -f "$path" ] || found=$path ;;
    *)
      if [ -f "$folder/$path" ]; then
        found=$folder/$path
      else
        base=.
        while [[ "$path" = ./* || "$path" = ../* ]]; do base+=/${path%%/*} path=${path#*/}; done
        steps=${path//[^\/]/}
        found=$(cd "$folder" && find -L "$base" -maxdepth $((${#steps} + 1)) -type f -ipath "$base/$path" -print -quit 2>/dev/null) || true
        found=${found:+$folder/$found}
      fi ;;
  esac
  place[$folder:$2]=$found
}
in_unit=false
expand() { # FILE, THE FILES THAT INCLUDE IT
  local folder number line name found last=0
  folder=$(cd "$(dirname "$1")" && pwd -P)
  echo "# 1 \"$1\""
  while IFS=: read -r number line; do
    [[ "$line" =~ [\'\"\<]([^\'\"\>]+) ]]
    name=${BASH_REMATCH[1]}
    find_included "$folder" "$name"
    # C's headers may say #pragma once: only those that the compiler does not find are put in place.
    if [ -z "$found" ] || { [ ${#fortran[@]} -eq 0 ] && [ -f "$folder/$name" ]; }; then continue; fi
    for name in "$@"; do [ ! "$name" -ef "$found" ] || continue 2; done
    # Before the first routine nothing can be declared.
    $in_unit || ! awk -v n="$number" 'NR >= n { exit } { sub(/!.*/, "") }
                                      !/^([*#]|[cC][^hHoO])/ && tolower($0) ~ /subroutine|function|module/ { found = 1 }
                                      END { exit !found }' "$1" || in_unit=true
    if [ "$found" = "$headers/utilities" ] && ! $in_unit; then found=$headers/none; fi
    head -n $((number - 1)) "$1" | tail -n +$((last + 1))
    expand "$found" "$@"
    echo "# $((number + 1)) \"$1\""
    last=$number
  done < <(grep -naiE "^[[:space:]]*#?[[:space:]]*include[[:space:]]*['\"<][^'\">]+['\">]" "$1")
  tail -n +$((last + 1)) "$1" | awk 1  # which ends the last line too
}
directives() {
  sed -E -e $'s/^\xef\xbb\xbf//' -e "/^ {5}#/b" \
    -e 's/^[[:space:]]*#[[:space:]]*(define|undef|if|ifdef|ifndef|elif|else|endif|include)\>/#\L\1/I' \
    -e "s/^(#include[[:space:]]*)'([^']+)'/\1\"\2\"/"
}

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
command -v "${compiler[0]}" >/dev/null || fail "needs ${compiler[0]} (Debian: apt-get install gfortran g++)"
source=$work/source
expand "$file" | directives >"$source"
if [ ${#fortran[@]} -gt 0 ]; then
  fortran+=(-J "$work")
  if grep -aqE '^#[a-z]' "$source"; then fortran+=(-cpp); fi
  # DEC's structures have dots before their components, which makes one of the user's own operator in a.op.b.
  if ! grep -aqiE '^[[:space:]]*(structure|record)[[:space:]]*/' "$source"; then fortran+=(-fno-dec-structure); fi
fi

compile() { # FILE FOR THE ERRORS
  "${compiler[@]}" "${fortran[@]}" -I "$headers" -I "$(dirname "$file")" -w -g -O1 -fPIC -c "$source" -o "$work/umat.o" 2>"$1"
}
first_line() { # of the errors in FILE: the line of the source, a large number if all are in included files
  awk -v name="$file:" 'index($0, name) == 1 { print $0; exit }' "$1" | cut -c $((${#file} + 2))- | grep -oE '^[0-9]+' || echo 999999999
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
