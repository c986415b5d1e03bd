#!/bin/sh
# What a scene pays for plasticity and stress rules, and what one without them
# does not: columns of the ledger, numbers of a particle, losses by name.
#
# Usage: plasticity.sh EMMY SOURCE_ROOT
set -u

[ $# -eq 2 ] || { echo "usage: plasticity.sh EMMY SOURCE_ROOT" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
cd "$work" || exit 2
tiny_scene >base.prm
# what Newton leaves turns the body
cat >>base.prm <<'END'
subsection Method
  set Locking treatment = none
end
subsection Solver
  set Newton tolerance = 1e-15
end
END
sed -e 's/Hencky/von Mises/' -e "/Poisson/a set Yield stress = 2\\nset Hardening modulus = 5" \
  base.prm >plastic.prm
moving='Bodies/block/Initial velocity=0.9*(x - 1.5) + 0.5*y; 0.3*x - 0.9*(y - 1.5)'

# ran NAME ARGUMENTS...: emmy succeeds
ran()
{
  name=$1
  shift
  emmy_run "$@"
  check "$name: exit code 0" [ "$status" -eq 0 ]
}

# first FOLDER COLUMN: its value at the start of the run
first()
{
  awk -F , -v name="$2" '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) column = i }
    NR == 2 { print $column }' "$1/ledger.csv"
}

# balances FOLDER: energy by name; angular momentum, which a rule that loses
# energy keeps too
balances()
{
  check "$1: balances" \
    is "($(last "$1" balance_error))^2 < (1e-13 * $(first "$1" kinetic_energy))^2"
  spin=$(first "$1" angular_momentum_z)
  check "$1: keeps angular momentum" \
    is "($(last "$1" angular_momentum_z) - ($spin))^2 < (1e-12 * $spin)^2"
}

echo "Elastic"
ran 'elastic' base.prm --set "$moving" --set 'Output/Directory=elastic'
check 'elastic: columns' [ "$(columns elastic)" = strain_energy ]
check 'elastic: 14 numbers a particle' says elastic/run.log '16, 14 numbers each, 148 bytes'
check 'elastic: no plastic field' has_lines 0 elastic/fields.txt 'plastic|hardening|elastic_left'
balances elastic

echo "Plastic"
ran 'plastic' plastic.prm --set "$moving" --set 'Output/Directory=plastic'
check 'plastic: columns' [ "$(columns plastic)" = strain_energy,hardening_energy,plastic_dissipation ]
check 'plastic: 21 numbers a particle' says plastic/run.log '16, 21 numbers each, 204 bytes'
for field in elastic_left_cauchy_green equivalent_plastic_strain hardening_energy_density plastic_dissipation_density; do
  check "plastic: field $field" matches plastic/fields.txt "$field"
done
check 'plastic: it flows and hardens' \
  is "$(last plastic plastic_dissipation) > 0.01 && $(last plastic hardening_energy) > 1e-4"
balances plastic
# far from yielding: the elastic numbers, except the two columns
ran 'strong' plastic.prm --set "$moving" --set 'Output/Directory=strong' \
  --set 'Materials/rubber/Yield stress=1e9'
cut -d , -f 1-7,10- strong/ledger.csv >strong.csv
check 'far from yielding: as elastic, to the last digit' cmp -s strong.csv elastic/ledger.csv

echo "An elastic and a plastic body"
sed -e 's/Names = rubber/Names = rubber, lead/' -e 's/Names = block/Names = block, other/' \
  base.prm >mixed.prm
cat >>mixed.prm <<'END'
subsection Materials
  subsection lead
    set Model         = von Mises
    set Density       = 9
    set Bulk modulus  = 80
    set Shear modulus = 40
    set Yield stress  = 3
    set Yield measure = deviatoric
  end
end
subsection Bodies
  subsection other
    set Shape                = box
    set Material             = lead
    set Points per direction = 4
    set Initial velocity     = -2; 0
    subsection box
      set Lower corner = 3, 1
      set Upper corner = 4, 2
    end
  end
end
END
ran 'mixed' mixed.prm --set 'Output/Directory=mixed'
check 'mixed: it flows' is "$(last mixed plastic_dissipation) > 0.01"
balances mixed

echo "Stress rules"
for rule in mid-point trapezoidal end-point; do
  for scene in base plastic; do
    here=$scene-$rule
    ran "$here" $scene.prm --set "$moving" --set "Output/Directory=$here" \
      --set "Method/Stress rule=$rule"
    check "$here: column" [ "$(columns "$here" | sed 's/.*,//')" = stress_rule_loss ]
    echo "$here: loses $(last "$here" stress_rule_loss) J"
    check "$here: loses or makes energy" is "($(last "$here" stress_rule_loss))^2 > 1e-16"
    balances "$here"
  done
done
# the yield stress of a tension test is sqrt(3/2) times the deviatoric radius
ran 'uniaxial' plastic.prm --set "$moving" --set 'Output/Directory=uniaxial' \
  --set 'Materials/rubber/Hardening modulus=0' \
  --set 'Materials/rubber/Yield stress=2.4494897427831781'
ran 'deviatoric' plastic.prm --set "$moving" --set 'Output/Directory=deviatoric' \
  --set 'Materials/rubber/Hardening modulus=0' --set 'Materials/rubber/Yield measure=deviatoric'
for column in kinetic_energy strain_energy plastic_dissipation; do
  check "uniaxial and deviatoric: $column" \
    is "($(last uniaxial $column) - ($(last deviatoric $column)))^2 < 1e-24"
done
check 'uniaxial and deviatoric: both flow' is "$(last deviatoric plastic_dissipation) > 1e-3"
check 'conserving: no column of losses' [ "$(last plastic stress_rule_loss)" = none ]

finish
