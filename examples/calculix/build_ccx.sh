#!/usr/bin/env bash
# Builds CalculiX's ccx from Debian's own, unedited source package with the one upstream flag that lets it load
# material libraries: Debian's binary cannot. Once; the last line printed is the path of the executable.
#
#   build_ccx.sh [FOLDER]     default: $XDG_CACHE_HOME/myogrowth, or ~/.cache/myogrowth
#
# MYOGROWTH_CCX=/path/to/ccx names a ccx that already has the flag; nothing is built then. Build-dependencies are
# installed by ./run ccx before this is called.
set -euo pipefail

if [ -n "${MYOGROWTH_CCX:-}" ]; then
  if [ ! -f "$MYOGROWTH_CCX" ] || [ ! -x "$MYOGROWTH_CCX" ]; then
    echo "MYOGROWTH_CCX=$MYOGROWTH_CCX is not an executable file" >&2
    exit 1
  fi
  echo "$MYOGROWTH_CCX"
  exit
fi
folder=${1:-${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/myogrowth}
starts() { grep -q Version <<<"$("$1" -v 2>&1 || true)"; } # its status is 201
if [ -e "$folder/ccx" ]; then
  starts "$folder/ccx" || { echo "$folder/ccx does not start: remove it to have it built again" >&2; exit 1; }
  echo "$folder/ccx"
  exit
fi
if ! command -v apt-get >/dev/null || ! command -v dpkg-source >/dev/null; then
  cat >&2 <<'TEXT'
Building ccx needs a Debian machine with dpkg-dev. Elsewhere, build CalculiX 2.20 or newer from its own source with
  -DCALCULIX_EXTERNAL_BEHAVIOURS_SUPPORT added to CFLAGS in its Makefile, and -ldl where it links, without -rdynamic;
then name it:
  MYOGROWTH_CCX=/path/to/ccx ./run cylinder
TEXT
  exit 1
fi
mkdir -p "$folder"
folder=$(CDPATH='' cd "$folder" && pwd)
work=$(mktemp -d "$folder/build.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work"

# The source by apt itself, with its check-sums, from where this machine has its packages.
echo "ccx: fetching Debian's source package" >&2
apt-get indextargets --format '$(ORIGIN)|$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' | sort -u |
  while IFS='|' read -r origin place; do
    key=/usr/share/keyrings/${origin,,}-archive-keyring.gpg
    if [ -f "$key" ]; then echo "deb-src [signed-by=$key] $place"; fi
  done >sources.list
mkdir -p lists/partial cache/archives/partial
apt=(apt-get -qq -o "Dir::Etc::sourcelist=$work/sources.list" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$work/lists"
  -o "Dir::Cache=$work/cache" -o APT::Sandbox::User=root -o Debug::NoLocking=1)
"${apt[@]}" update >log 2>&1 || { cat log >&2; exit 1; }
"${apt[@]}" source --download-only calculix-ccx >log 2>&1 || { cat log >&2; exit 1; }
dpkg-source -x ./calculix-ccx_*.dsc source >log 2>&1 || { cat log >&2; exit 1; }

src=$(dirname "$(find source -name ccx_2.\*.c | head -1)")
cd "$src"
name=$(basename "$(ls ccx_2.*.c)" .c)
total=$(find . -maxdepth 1 -name '*.[cf]' | wc -l)
echo "ccx: compiling $name, $total files" >&2
make -k -j "$(nproc)" "$name.a" "$name.o" FC=gfortran CC=gcc \
  CFLAGS="-w -O2 -I/usr/include/spooles -DARCH=\"Linux\" -DSPOOLES -DARPACK -DMATRIXSTORAGE -DUSE_MT=1 -DCALCULIX_EXTERNAL_BEHAVIOURS_SUPPORT" \
  FFLAGS="-w -O2 -fallow-argument-mismatch" >"$work/make.log" 2>&1 &
while [ -t 2 ] && kill -0 $! 2>/dev/null; do
  printf '\r  %d of %d' "$(find . -maxdepth 1 -name '*.o' | wc -l)" "$total" >&2
  sleep 1
done
if [ -t 2 ]; then echo >&2; fi
wait $! || { grep -iE 'error|undefined|cannot' "$work/make.log" >&2 || true; tail -30 "$work/make.log" >&2; exit 1; }
gfortran -o ccx "$name.o" "$name.a" -lspooles -lpthread -larpack -llapack -lblas -lm -ldl -fopenmp
starts ./ccx || { echo "ccx: what was built does not start" >&2; exit 1; }
mv ccx "$folder/ccx.new"
mv "$folder/ccx.new" "$folder/ccx"
echo "$folder/ccx"
