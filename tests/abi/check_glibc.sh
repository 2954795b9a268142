#!/bin/sh
# The libraries need no glibc newer than VERSION: check_glibc.sh VERSION LIBRARY...
set -eu
most=$1
shift
for library in "$@"; do
  needs=$(objdump -T "$library" | sed -n 's/.*(GLIBC_\([0-9.]*\)).*/\1/p' | sort -Vu | tail -n 1)
  [ -n "$needs" ] || { echo "$library: no version of glibc found" >&2; exit 1; }
  echo "$needs ${library##*/}"
  [ "$(printf '%s\n' "$needs" "$most" | sort -V | tail -n 1)" = "$most" ] || {
    echo "$library needs glibc $needs: at most $most is in docs/manual.md" >&2
    objdump -T "$library" | grep -F "GLIBC_$needs" >&2
    exit 1
  }
done
