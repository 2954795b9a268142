#!/usr/bin/env bash
# ./run tidy: has clang-tidy look at the headers, the libraries, the C++ examples and the Python module.
set -euo pipefail
mkdir -p out
python_include=$(/usr/bin/python3 -c 'import sysconfig; print(sysconfig.get_path("include"))')
find include/myogrowth -name '*.hpp' -printf '#include <myogrowth/%P>\n' | LC_ALL=C sort >out/headers.cpp
found=0
mapfile -t files < <(find abi examples/cpp python -name '*.cpp' | LC_ALL=C sort)
for file in out/headers.cpp "${files[@]}"; do
  echo "$file"
  clang-tidy --quiet "$file" -- -std=c++17 -Iinclude -Iabi -isystem /usr/include/eigen3 -isystem "$python_include" 2>/dev/null ||
    found=1
done
exit $found
