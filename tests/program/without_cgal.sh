#!/bin/sh
# emmy can be configured without CGAL: what differs compiles, has nothing of it,
# and says which package is missing.
#
#   without_cgal.sh CMAKE SOURCE_ROOT GENERATOR COMPILER BUILD_TYPE
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
"$1" -S "$2" -B "$work" -G "$3" "-DCMAKE_CXX_COMPILER=$4" "-DCMAKE_BUILD_TYPE=$5" -DEMMY_CGAL_HEADERS=OFF \
  -DEMMY_TESTS=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
grep -q 'No CGAL: bodies cannot be read from surfaces' "$work/log" || { echo 'FAILED: it says so'; exit 1; }
object=CMakeFiles/emmy_library.dir/source/particles/surface_mesh.cc.o
case $3 in
  Ninja) target=$object ;;
  *) target=source/particles/surface_mesh.o ;;
esac
"$1" --build "$work" --target "$target" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
if nm -C "$work/$object" | grep -q 'CGAL::'; then
  echo 'FAILED: it has symbols of CGAL'
  exit 1
fi
grep -q 'Install the package libcgal-dev' "$work/$object" || grep -aq 'libcgal-dev' "$work/$object" || {
  echo 'FAILED: it names the package'
  exit 1
}
