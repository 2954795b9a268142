#!/bin/sh
# same_with_threads.sh PROGRAM: checks that it prints the same with any number of OpenMP threads.
one=$(OMP_NUM_THREADS=1 "$1") || exit 1
echo "1 thread: $one"
case "$one" in *" 0 without result"*) ;; *) exit 1 ;; esac
for threads in 2 3 5; do
  many=$(OMP_NUM_THREADS=$threads "$1")
  echo "$threads threads: $many"
  [ "$many" = "$one" ] || exit 1
done
