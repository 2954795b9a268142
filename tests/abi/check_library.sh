#!/bin/sh
# A library of ours needs libm and libc alone and exports its own names alone: check_library.sh LIBRARY NAME...
set -eu
library=$1
shift
needed=$(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort | tr '\n' ' ')
exported=$(nm -D --defined-only "$library" | awk '{print $3}' | sort | tr '\n' ' ')
wanted=$(printf '%s\n' "$@" | sort | tr '\n' ' ')
echo "needs:   $needed"
echo "exports: $exported"
[ "$needed" = "libc.so.6 libm.so.6 " ] || { echo "it should need libc.so.6 and libm.so.6 alone" >&2; exit 1; }
[ "$exported" = "$wanted" ] || { echo "it should export $wanted alone" >&2; exit 1; }
