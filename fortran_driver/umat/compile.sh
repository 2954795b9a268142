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
# Names of files have no case on Windows, where many UMATs were written.
names=$(grep -aoiE '\baba_param\.inc\b' "$file" | sort -u) || true
for name in $names ABA_PARAM.INC aba_param.inc; do cp "$here/ABA_PARAM.INC" "$work/$name"; done

fortran=(-std=legacy -fdec -fno-align-commons -ffixed-line-length-132 -ffree-line-length-none)
case "${file##*.}" in
  f | for | ftn | F | FOR | FTN)
    form=-ffixed-form
    # Intel's directive for free form in a file that is named for fixed form.
    if grep -aqiE '^[!c*]d(ec|ir)\$ *freeform' "$file"; then form=-ffree-form; fi
    compiler=(gfortran -x f95 "$form") ;;
  f90 | f95 | f03 | f08 | F90 | F95 | F03 | F08) compiler=(gfortran -x f95 -ffree-form) ;;
  cpp | cc | cxx | C) compiler=(g++ -x c++) fortran=() ;;
  c) compiler=(gcc -x c) fortran=() ;;
  *) fail "the ending must be .f, .for or .ftn (fixed form), .f90, .f95, .f03 or .f08 (free form), .c, .cc, .cpp or .cxx" ;;
esac
[ ${#fortran[@]} -eq 0 ] || fortran+=(-J "$work")
if [ ${#fortran[@]} -gt 0 ] && grep -aqE '^#' "$file"; then fortran+=(-cpp); fi
command -v "${compiler[0]}" >/dev/null || fail "needs ${compiler[0]} (Debian: apt-get install gfortran g++)"

# Names that the file defines are its own, whatever the driver's libraries define (-Bsymbolic).
"${compiler[@]}" "${fortran[@]}" -I "$work" -I "$(dirname "$file")" -w -g -O1 -fPIC -c "$file" -o "$work/umat.o" ||
  fail "does not compile (above)"
gfortran -shared -Wl,-Bsymbolic "$work/umat.o" -lstdc++ -o "$library" || fail "does not link (above)"
