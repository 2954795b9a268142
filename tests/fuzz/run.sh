#!/usr/bin/env bash
# ./run fuzz, after the build: every fuzzer for so many seconds, from the corpus that is kept and what was found before.
#
#   run.sh BUILD_FOLDER OUT SECONDS       from the top of the tree
set -euo pipefail
for target in umat vumat c_api; do
  mkdir -p "$2/$target"
  "$1/tests/${target}_fuzz" -max_total_time="$3" -max_len=400 -timeout=20 -artifact_prefix="$2/" "$2/$target" "tests/fuzz/corpus_$target"
done
