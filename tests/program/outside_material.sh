#!/bin/sh
# A program outside emmy, built as its user would, brings a material: it reads
# no header of another material or of an effect, its scene runs and balances,
# messages know the material, and an installation has all that such a program
# needs.
#
# Usage: outside_material.sh BUILD_FOLDER SOURCE_ROOT CMAKE
set -u

[ $# -eq 3 ] || { echo "usage: outside_material.sh BUILD_FOLDER SOURCE_ROOT CMAKE" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
build=$(absolute "$1")
example=$(absolute "$2")/doc/examples/neo-hooke
cmake=$3
cd "$work" || exit 2

# -H: the compiler lists the headers that it reads
built 'configure' -S "$example" -B outside -Demmy_DIR="$build" -DCMAKE_CXX_FLAGS=-H
started=$(date +%s)
built 'build' --build outside
echo "built in $(($(date +%s) - started)) s"
cat out err | sed -n 's|^\.\.* .*include/emmy/||p' | sort -u >headers
echo "headers of emmy: $(tr '\n' ' ' <headers)"
check 'it reads the interface of materials' has_lines 1 headers '^material/material\.h$'
check 'and no other material, no effect' has_lines 0 headers \
  '^(material/(hencky|von_mises|stress_rules)|grid|particles|transfer|assembly|solve|step|output)'
check 'of the layers above only the program' has_lines 1 headers '^(app|study)/'

emmy=$work/outside/neo-hooke
emmy_run "$example/block.prm" --set 'Output/Directory=block'
check 'its scene runs' [ "$status" -eq 0 ]
check 'its scene runs without complaint' [ ! -s err ]
# the largest balance error, relative to the initial energy
balance=$(awk -F , '
  NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
  NR == 2 { scale = $column["kinetic_energy"] }
  { error = $column["balance_error"] / scale
    if (error < 0) error = -error
    if (error > largest) largest = error
    if ($column["strain_energy"] > strain) strain = $column["strain_energy"] }
  END { print largest, (NR > 10 && strain > 0.01 * scale && largest < 1e-12) }
' block/ledger.csv)
echo "balance error ${balance% *} of the initial energy"
check 'its ledger balances to 1e-12' [ "${balance#* }" = 1 ]

sed -e 's/Dimension = 2/Dimension = 3/' -e 's/= 0, 0$/= 0, 0, 0/' \
  -e 's/= 6, 6$/= 6, 6, 6/' -e 's/= 2, 2$/= 2, 2, 2/' -e 's/= 4, 4$/= 4, 4, 4/' \
  -e '/Initial velocity/s/$/; 0/' -e 's/= 8$/= 3/' "$example/block.prm" >space.prm
emmy_run space.prm --set 'Time/Maximum steps=2' --set 'Output/Directory=space'
check 'it runs in three dimensions' [ "$status" -eq 0 ]
emmy_run "$example/block.prm" --set 'Materials/gum/Model=my neo-Hook'
check 'an unknown model is an error' [ "$status" -eq 1 ]
check 'the message knows the new one' says err 'did you mean <my neo-Hooke>?'
check 'and lists it' says err 'Known are: Hencky, von Mises, Drucker-Prager, neo-Hooke, my neo-Hooke.'
emmy_run --list
check 'the list of what there is has it' has_lines 1 out '^  my neo-Hooke +neo-Hooke elasticity$'
emmy_run --check --all "$example/block.prm"
check 'the scene card has it' matches out '^    material gum +0 +0  Newton, internal force: my neo-Hooke$'
emmy_run --print-parameters
check 'the reference of parameters has it' matches out 'set Model += my neo-Hooke'

built 'install' --install "$build" --prefix "$work/installed"
built 'configure with the installation' -S "$example" -B other \
  -DCMAKE_PREFIX_PATH="$work/installed"
check 'the installation is found' grep -q "^emmy_DIR:PATH=$work/installed" other/CMakeCache.txt
check 'the installation has the program' [ -x installed/bin/emmy ]

finish
