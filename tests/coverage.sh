#!/usr/bin/env bash
# ./run coverage, after the build: runs the tests and writes which lines of include/ and abi/ they run.
#
#   coverage.sh BUILD_FOLDER OUT TESTS...       from the top of the tree
set -euo pipefail
build=$1 out=$2
shift 2
find "$build" -name '*.gcda' -delete
rm -rf "$out"
mkdir -p "$out"
for test in "$@"; do
  echo "== $test"
  program=$(find "$build/tests" -name "$test" -type f)
  # (A convergence study with meshes that runs no line of its own takes minutes without optimisation.)
  "$program" --gtest_filter=-MixedElements.DoNotLock >"$out/log.txt" 2>&1 || { cat "$out/log.txt" >&2; exit 1; }
done
gcovr --root . --object-directory "$build" --filter include/ --filter abi/ --exclude-throw-branches \
  --txt --html-details "$out/index.html" --fail-under-line 95 "$build"
