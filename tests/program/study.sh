#!/bin/sh
# Studies: their members and table, failures, what is not run again, errors,
# and one rank against two.
#
# Usage: study.sh EMMY SOURCE_ROOT MPI_LAUNCHER
set -u

[ $# -eq 3 ] || { echo "usage: study.sh EMMY SOURCE_ROOT MPI_LAUNCHER" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
root=$(absolute "$2")
launcher=$3
cd "$work" || exit 2
mkdir -p files run
# a block that stretches, so that the step matters
tiny_scene | sed 's/= 1; 0/= 0.3*(x - 1.5); -0.3*(y - 1.5)/' >files/base.prm

# study_file SCENE DIRECTORY COMBINATION: steps and mappings
study_file()
{
  cat <<END
subsection Study
  set Base scene  = $1
  set Directory   = $2
  set Names       = mapping, dt
  set Combination = $3
  set Quantities  = kinetic_energy, largest strain_energy
  subsection mapping
    set Entries = Method/Mapping
    set Values  = PIC | FLIP
  end
  subsection dt
    set Entries = Time/Step size
    set Values  = 0.25 | 0.125
  end
end
END
}
study_file base.prm crossed crossed >files/crossed.prm
study_file base.prm paired paired >files/paired.prm
cd run || exit 2 # the base scene is beside the study, results are here

# cell FOLDER MEMBER COLUMN: of study.csv; no cell before it has a comma
cell()
{
  awk -F , -v member="$2" -v name="$3" '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) column = i }
    $1 == member { print (column ? $column : "none") }' "$1/study.csv"
}
# succeeds NAME: the last run did
succeeds()
{
  check "$1: exit code 0" [ "$status" -eq 0 ]
  check "$1: no complaint" [ ! -s "$work/err" ]
}
# ran NUMBER: so many members ran
ran()
{
  says "$work/out" "members that ran: $1,"
}

echo "Members and table"
emmy_run study ../files/crossed.prm
succeeds crossed
check 'crossed: all ran' ran 4
check 'crossed: 4 rows' has_lines 5 crossed/study.csv
i=0
for values in PIC,0.25 PIC,0.125 FLIP,0.25 FLIP,0.125; do
  i=$((i + 1))
  member=member-00$i
  check "crossed: $member is $values" matches crossed/study.csv "^$member,$values,done,"
  check "crossed: $member has that step" \
    matches crossed/$member/parameters.prm "set Step size +=  *${values#*,}( |\$)"
  check "crossed: $member has that mapping" \
    matches crossed/$member/parameters.prm "set Mapping +=  *${values%,*}( |\$)"
  for file in run.log ledger.csv timing.json; do
    check "crossed: $member has $file" [ -s crossed/$member/$file ]
  done
  check "crossed: $member has no frames" [ ! -e crossed/$member/particles.pvd ]
  check "crossed: $member, energy at the end" \
    is "$(cell crossed $member kinetic_energy) == $(last crossed/$member kinetic_energy)"
  largest=$(awk -F , 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "strain_energy") c = i }
    NR > 1 && $c > most { most = $c } END { printf "%.17g", most }' crossed/$member/ledger.csv)
  check "crossed: $member, largest energy" \
    is "$(cell crossed $member largest_strain_energy) == $largest"
  check "crossed: $member, difference to the last" is "$(cell crossed $member kinetic_energy_difference) == \
    $(cell crossed $member kinetic_energy) - $(cell crossed member-004 kinetic_energy)"
  check "crossed: $member, steps" is "$(cell crossed $member steps) == 1 / ${values#*,}"
  check "crossed: $member, Newton iterations" \
    is "$(cell crossed $member total_newton_iterations) >= $(cell crossed $member steps)"
  check "crossed: $member, balance error" \
    is "$(cell crossed $member final_balance_error) == $(last crossed/$member balance_error)"
  check "crossed: $member, seconds and memory" \
    is "$(cell crossed $member median_seconds) > 0 && $(cell crossed $member peak_memory_bytes) > 1e6"
done
check 'crossed: members differ' \
  is "$(cell crossed member-003 kinetic_energy_difference)^2 > 1e-12"
# a member is what emmy makes of the scene alone
emmy_run ../files/base.prm --set 'Output/Directory=alone' --set 'Method/Mapping=FLIP' \
  --set 'Time/Step size=0.25'
check 'a member is the scene alone' cmp -s alone/ledger.csv crossed/member-003/ledger.csv

emmy_run study ../files/paired.prm --set 'Study/Reference=member-001' --set 'Study/Repetitions=2'
succeeds paired
check 'paired: 2 rows' has_lines 3 paired/study.csv
check 'paired: first with first' matches paired/study.csv '^member-001,PIC,0.25,done,'
check 'paired: second with second' matches paired/study.csv '^member-002,FLIP,0.125,done,'
check 'paired: a named reference' is "$(cell paired member-001 kinetic_energy_difference) == 0"
check 'paired: repetitions' cmp -s paired/member-002/ledger.csv paired/member-002/repetition-2/ledger.csv
check 'paired: the spread of seconds' is "$(cell paired member-002 spread_seconds) > 0"

echo "What is there is not run again"
cp crossed/study.csv before.csv
emmy_run study ../files/crossed.prm
succeeds resumed
check 'resumed: none ran' ran 0
check 'resumed: the table is the same' cmp -s before.csv crossed/study.csv
rm crossed/member-002/member.txt # as an interruption leaves it
emmy_run study ../files/crossed.prm
check 'interrupted: one ran' ran 1
check 'interrupted: the same energy' \
  [ "$(cell crossed member-002 kinetic_energy)" = "$(sed -n 3p before.csv | cut -d, -f5)" ]
emmy_run study ../files/crossed.prm --set 'Study/dt/Values=0.25 | 0.1'
succeeds changed
check 'changed: two ran' ran 2
check 'changed: the others are as before' [ "$(sed -n 2p crossed/study.csv | cut -d, -f1-5)" = \
  "$(sed -n 2p before.csv | cut -d, -f1-5)" ]
check 'changed: the new step' is "$(cell crossed member-004 steps) == 10"
emmy_run study ../files/crossed.prm --set 'Study/dt/Values=0.25 | 0.1' --overwrite
check '--overwrite: all ran' ran 4

echo "A member that fails"
# a mapping that is refused at once; a step too large for one Newton iteration
emmy_run study ../files/crossed.prm --set 'Study/Directory=failing' \
  --set 'Study/mapping/Values=PIC | PAC | FLIP' --set 'Study/Names=mapping, dt, tries' \
  --set 'Study/dt/Values=0.125' --set 'Study/tries/Values=1 | 100' \
  --set 'Study/tries/Entries=Solver/Maximum iterations'
succeeds failing
check 'failing: a refused value, and its reason' \
  matches failing/study.csv '^member-00[34],PAC,0.125,(1|100),"failed: .*Mapping.*PAC'
check 'failing: Newton, and its reason' matches failing/study.csv '^member-005,FLIP,0.125,1,"?failed: .*[Ss]tep'
check 'failing: no numbers' matches failing/study.csv '^member-005.*,,,,,,,,,,,$'
check 'failing: its own run.log says so' says failing/member-005/run.log 'stopped:'
check 'failing: reasons on the screen' has_lines 4 "$work/out" '^member-00. failed: '
check 'failing: the study goes on' matches failing/study.csv '^member-006,FLIP,0.125,100,done,'
cp failing/study.csv before.csv
cp "$work/out" first
emmy_run study ../files/crossed.prm --set 'Study/Directory=failing' \
  --set 'Study/mapping/Values=PIC | PAC | FLIP' --set 'Study/Names=mapping, dt, tries' \
  --set 'Study/dt/Values=0.125' --set 'Study/tries/Values=1 | 100' \
  --set 'Study/tries/Entries=Solver/Maximum iterations'
check 'failing, resumed: what failed in its run is tried again' ran 2
check 'failing, resumed: the table is the same' cmp -s before.csv failing/study.csv
mkdir -p passing/member-001/ledger.csv # in the way, as a full disk would be
emmy_run study ../files/paired.prm --set 'Study/Directory=passing'
check 'in the way: fails, and says which file' matches passing/study.csv '^member-001.*failed: .*ledger.csv> cannot be written'
rmdir passing/member-001/ledger.csv
emmy_run study ../files/paired.prm --set 'Study/Directory=passing'
check 'out of the way: is tried again' ran 1
check 'out of the way: is done' matches passing/study.csv '^member-001,PIC,0.25,done,'
check 'files aside: none is left' [ -z "$(find . -name '*.new')" ]

echo "Errors"
# refused NAME WORDS ARGUMENTS...: one error that says so
refused()
{
  name=$1 words=$2
  shift 2
  emmy_run "$@"
  check "$name: exit code 1" [ "$status" -eq 1 ]
  check "$name: one error" has_lines 1 "$work/err" '^emmy: error: [^ ]'
  check "$name: says <$words>" says "$work/err" "$words"
}
# refused_set NAME WORDS ENTRY=VALUE: of the crossed study, in another folder
refused_set()
{
  called=$1 why=$2 entry=$3
  shift 3
  refused "$called" "$why" study ../files/crossed.prm --set 'Study/Directory=refused' --set "Study/$entry" "$@"
  check "$called: runs nothing" [ ! -e refused ]
}
refused 'no file' 'no parameter file' study
refused 'a scene' 'base.prm> has no section Study' study ../files/base.prm
refused 'not as study' 'run it with emmy study ../files/crossed.prm' ../files/crossed.prm
printf 'subsection Study\nset Base scene = base.prm\nset Directory = refused\nend\n' >../files/empty.prm
refused 'no lists' '<Study/Names> is <>: it is required' study ../files/empty.prm
refused '--list' 'study with --list' study --list
refused '--check' '4 members cannot be read' study --check ../files/crossed.prm --set 'Study/dt/Entries=Time/Step sise'
emmy_run study --check ../files/crossed.prm
succeeds '--check of a good one'
check '--check: members' has_lines 4 "$work/out" '^member-00.: mapping = .*, dt = '
refused_set 'scene' '<Study/Base scene> is <absent.prm>: there is no file <../files/absent.prm>' 'Base scene=absent.prm'
refused_set 'unknown' 'did you mean <Values>?' 'dt/Value=1'
refused_set 'parts' 'give one part for each of the 1 entries' 'dt/Values=0.1 & 0.2'
refused_set 'names of values' 'give one for each of the 2 values' 'dt/Value names=a | b | c'
refused_set 'names twice' '<a> is there twice' 'dt/Value names=a | a'
refused_set 'no values' '<Study/dt/Values> is <>: it is required' 'dt/Values='
refused_set 'twice' '<0.1> is there twice' 'dt/Values=0.1 | 0.1'
refused_set 'directory of a member' "the study chooses each member's folder" 'dt/Entries=Output/Directory'
refused_set 'reference' 'use last, none, limit, a number, or one of member-001 to member-004' 'Reference=finest'
refused_set 'two columns' 'two columns of this name' 'Quantities=kinetic_energy, kinetic_energy'
refused_set 'misspelt entry' 'did you mean <Step size>?' 'dt/Entries=Time/Step sise'
refused 'unequal pairs' 'list <dt> has 3 values, another one before it 2' \
  study ../files/paired.prm --set 'Study/dt/Values=1 | 2 | 3'
refused 'unknown quantity' '<kinetic_enery> (did you mean <kinetic_energy>?)' \
  study ../files/paired.prm --set 'Study/Quantities=kinetic_enery'
check 'unknown quantity: its members are kept' ran 0

refused_set 'references' 'give one for all quantities, or one for each' 'Reference=last, none, 1'
refused_set 'scales' 'give one for all quantities, or one for each' 'Scales=1, 2, 3'
refused_set 'sizes' 'give one for each of the 2 values' 'dt/Sizes=1'
refused_set 'negative size' 'sizes must be positive' 'dt/Sizes=1, 0'
refused_set 'refined list' 'name one of the lists' 'Refined list=mapping'
refused_set 'baseline' 'use one of member-001 to member-004' 'Baseline=1'
refused_set 'no quantity' 'write COLUMN, largest COLUMN' 'Quantities=smallest strain_energy'
refused_set 'no time' 'write COLUMN, largest COLUMN' 'Quantities=strain_energy to end'
refused_set 'path' 'is compared with that of a member' 'Quantities=path of strain_energy' --set 'Study/Reference=1'
refused_set 'part of a rank' 'Ranks takes numbers' 'dt/Entries=Ranks' --set 'Study/dt/Values=1 | 1.5'
refused_set 'number of ranks' 'Ranks takes numbers' 'dt/Entries=Ranks' --set 'Study/dt/Values=one | two'
refused 'no tolerance' 'write a positive number behind it' study ../files/crossed.prm --tolerance fine
refused 'tolerance of a scene' '--tolerance without a study' ../files/base.prm --tolerance 0.1
refused 'folder of another' '<crossed> has the results of study </' \
  study ../files/paired.prm --set 'Study/Directory=crossed'

echo "Errors of quantities"
# value EXPRESSION: that awk makes of it
value()
{
  awk "BEGIN { printf \"%.17g\", $1 }"
}
# a velocity that the grid has not, so that PIC loses energy; end time, s: 0.4
tiny_scene | sed 's/= 1; 0/= 0.3*(x - 1.5)^2; -0.3*(y - 1.5)/; s/End time  = 1/End time = 0.4/' >../files/uneven.prm
study_file uneven.prm errors crossed >../files/errors.prm
emmy_run study ../files/errors.prm --set 'Study/dt/Values=0.04 | 0.02 | 0.01' \
  --set 'Study/Quantities=strain_energy, lost_share, kinetic_energy, time of largest strain_energy from 0.02 to 0.3, path of strain_energy, largest strain_energy to 0.05' \
  --set 'Study/Reference=limit, none, 0.25, last, last, member-004' --set 'Study/Scales=0, 2, 0.5, 0, 0, 0'
succeeds errors
e=errors
# PIC loses energy, FLIP does not
for member in member-001 member-004; do
  first=$(awk -F , 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "kinetic_energy") c = i } NR == 2 { printf "%.17g", $c }' $e/$member/ledger.csv)
  end=$(value "$(last $e/$member kinetic_energy) + $(last $e/$member strain_energy)")
  # the largest total energy is the first one
  check "errors: $member, lost_share over 2" is "($(cell $e $member lost_share_error) - \
    sqrt((1 - $end / $first)^2) / 2)^2 < 1e-24"
done
check 'errors: PIC loses more' is "$(cell $e member-001 lost_share_error) > 1e3 * $(cell $e member-004 lost_share_error)"
check 'errors: none has no difference' [ "$(cell $e member-001 lost_share_difference)" = none ]
check 'errors: a number' is "($(cell $e member-002 kinetic_energy_error) - \
  sqrt(($(cell $e member-002 kinetic_energy) - 0.25)^2) / 0.5)^2 < 1e-24"
q1=$(cell $e member-004 strain_energy) q2=$(cell $e member-005 strain_energy) q3=$(cell $e member-006 strain_energy)
limit=$(value "$q3 - ($q2 - $q3)^2 / (($q1 - $q2) - ($q2 - $q3))") # Aitken: steps are halved
check 'errors: the limit is that of Richardson' is "($(cell $e member-001 strain_energy_error) - \
  sqrt(($(cell $e member-001 strain_energy) / $limit - 1)^2))^2 < 1e-18"
name=time_of_largest_strain_energy_from_0.02_to_0.3
check 'errors: a time is in its window' is "$(cell $e member-006 $name) >= 0.01 && $(cell $e member-006 $name) <= 0.31"
check 'errors: of the reference there is none' [ -z "$(cell $e member-006 path_of_strain_energy_error)" ]
check 'errors: a path' is "$(cell $e member-005 path_of_strain_energy_error) < \
  $(cell $e member-004 path_of_strain_energy_error) && $(cell $e member-005 path_of_strain_energy_error) > 0"
third=$(awk -F , 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "strain_energy") c = i } NR == 3 { printf "%.17g", $c }' $e/member-004/ledger.csv)
check 'errors: a part of a run' is "$(cell $e member-004 largest_strain_energy_to_0.05) == $third"
check 'errors: someone is best' is "$(awk -F , 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "lost_share_is_best") c = i } NR > 1 { n += $c } END { print n }' $e/study.csv) >= 1"
check 'errors: seconds of a phase' is "$(cell $e member-001 seconds_particles_to_grid) > 0"
for words in 'approached with order' '## The cheapest setting' '## What each choice costs' '## Orders in dt' \
  '| mapping | PIC | FLIP |' '6 of 6 members are done'; do
  check "errors: the page says <$words>" says $e/study.md "$words"
done
page=$e/report.html
check 'page: its rows are those of study.md' \
  [ "$(grep -c '^<tr>' "$page")" -eq "$(grep '^|' "$e/study.md" | grep -cv '^|---')" ]
check 'page: no mark of Markdown is left' has_lines 0 "$page" '\*\*|^\||^#|!\['
check 'page: needs no other file' has_lines 0 "$page" '(src|href)="[^d]'
for picture in error-seconds error-size; do
  check "errors: $picture.gp" [ -s $e/$picture.gp ]
  if command -v gnuplot >/dev/null; then
    check "errors: $picture.png" [ -s $e/$picture.png ]
    check "errors: gnuplot has no complaint" [ ! -s $e/gnuplot.log ]
  fi
done

echo "Parts and names of values"
emmy_run study ../files/paired.prm --set 'Study/Directory=parts' --set 'Study/Names=mapping, dt, both' \
  --set 'Study/mapping/Values=FLIP' --set 'Study/dt/Values=0.125' \
  --set 'Study/both/Entries=Method/Lumping | Time/End time' --set 'Study/both/Values=0 & 0.25 | 1 & 0.5' \
  --set 'Study/both/Value names=sharp | lumped'
succeeds parts
check 'parts: names' matches parts/study.csv '^member-002,FLIP,0.125,lumped,done,'
check 'parts: first' matches parts/member-002/parameters.prm 'set Lumping +=  *1( |$)'
check 'parts: second' is "$(last parts/member-002 time) == 0.5"

echo "The cheapest for a tolerance"
emmy_run study ../files/crossed.prm --set 'Study/dt/Values=0.25 | 0.1' --tolerance 1
succeeds tolerance
check 'tolerance: a line for each quantity' has_lines 2 "$work/out" '_energy: mapping = .*; .* s, error '
check 'tolerance: runs nothing' not says "$work/out" 'members that ran'
refused 'tolerance: none meets it' 'no member meets 1e-30' study ../files/crossed.prm --tolerance 1e-30
refused 'tolerance: nothing has run' 'none of its members has run' study ../files/crossed.prm --set 'Study/Directory=nothing' --tolerance 1
check 'tolerance: writes nothing' [ ! -e nothing ]

echo "Two ranks"
run_on_two_ranks study ../files/crossed.prm --set 'Study/Directory=some' --set 'Study/Names=mapping, dt, processes' --set 'Study/dt/Values=0.125' \
  --set 'Study/mapping/Values=FLIP' --set 'Study/processes/Entries=Ranks' --set 'Study/processes/Values=1 | 2 | 3'
succeeds 'some ranks'
check 'some ranks: one' [ "$(cell some member-001 ranks)" = 1 ]
check 'some ranks: two' [ "$(cell some member-002 ranks)" = 2 ]
check 'some ranks: too many' matches some/study.csv '^member-003,FLIP,0.125,3,.*failed: it wants 3 ranks'
emmy_run ../files/base.prm --set 'Output/Directory=alone' --overwrite
mkdir -p some/member-003
check 'some ranks: too many is not remembered' [ ! -e some/member-003/member.txt ]
check 'some ranks: one is as alone' cmp -s alone/ledger.csv some/member-001/ledger.csv
run_on_two_ranks study ../files/paired.prm --set 'Study/Directory=two' \
  --set 'Study/mapping/Entries=Solver/Maximum iterations' --set 'Study/mapping/Values=1 | 100'
succeeds 'two ranks'
check 'two ranks: the member that fails' matches two/study.csv '^member-001,1,0.25,"?failed: '
check 'two ranks: the study goes on' matches two/study.csv '^member-002,100,0.125,done,'
run_on_two_ranks study ../files/paired.prm --set 'Study/Directory=two'
succeeds 'two ranks, mended'
emmy_run study ../files/paired.prm --set 'Study/Directory=one'
succeeds 'one rank'
for column in kinetic_energy_difference largest_strain_energy_difference; do
  one=$(cell one member-001 $column) two=$(cell two member-001 $column)
  check "two ranks: $column" is "($one - $two)^2 < (1e-10 * $one)^2"
done
check 'two ranks: are in the table' [ "$(cell two member-001 ranks)" = 2 ]

echo "Studies in prm/"
for study in "$root"/prm/studies/*.prm; do
  emmy_run study --check "$study"
  succeeds "$study"
done
emmy_run study "$root/prm/studies/block-dt.prm" --set "Study/Directory=study_1" --set 'Study/Repetitions=1'
succeeds block-dt
check "block-dt: all members are done" not matches study_1/study.csv failed
difference=$(cell study_1 member-001 kinetic_energy_difference)
for member in member-002 member-003; do
  finer=$(cell study_1 $member kinetic_energy_difference)
  check "block-dt: half the step, a quarter of the difference" is "$difference / $finer > 4"
  difference=$finer
done

finish
