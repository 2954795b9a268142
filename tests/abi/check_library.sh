#!/bin/sh
# The UMAT library needs libm and libc alone and exports its own two names: check_library.sh LIBRARY
set -eu
needed=$(readelf -d "$1" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort | tr '\n' ' ')
exported=$(nm -D --defined-only "$1" | awk '{print $3}' | sort | tr '\n' ' ')
echo "needs:   $needed"
echo "exports: $exported"
[ "$needed" = "libc.so.6 libm.so.6 " ] || { echo "it should need libc.so.6 and libm.so.6 alone" >&2; exit 1; }
[ "$exported" = "myogrowth_umat_ umat_ " ] || { echo "it should export myogrowth_umat_ and umat_ alone" >&2; exit 1; }
