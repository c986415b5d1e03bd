# shellcheck shell=sh
# Checks of the program from the command line. Sourced by the scripts of this
# folder, which set emmy, the program's absolute path, and work in $work, a
# fresh temporary folder that is removed at the end. Each check has a name and
# is counted; `finish` says how many failed.

n_checks=0
n_failed=0
n_skipped=0
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

# absolute PATH: folders change
absolute()
{
  case $1 in
    /*) echo "$1" ;;
    *) echo "$PWD/$1" ;;
  esac
}

# check NAME COMMAND...: a fact that COMMAND, a test, confirms. When it does
# not, the last run of emmy is shown.
check()
{
  check_name=$1
  shift
  n_checks=$((n_checks + 1))
  if ! "$@"; then
    n_failed=$((n_failed + 1))
    echo "FAILED: $check_name"
    echo "  test:   $*"
    echo "  emmy:   $last_run"
    echo "  status: $status"
    [ ! -s "$work/out" ] || tail -n 15 "$work/out" | sed 's/^/  out: /'
    [ ! -s "$work/err" ] || head -n 15 "$work/err" | sed 's/^/  err: /'
  fi
}

# not COMMAND...
not()
{
  ! "$@"
}

# skip NAME REASON: a check that this machine does not allow
skip()
{
  n_skipped=$((n_skipped + 1))
  echo "skipped: $1: $2"
}

# finish: the closing line, and the exit status of the script
finish()
{
  echo "$n_checks checks, $n_failed failed, $n_skipped skipped"
  [ "$n_failed" -eq 0 ]
}

# emmy_run ARGUMENTS...: run emmy on one rank, for a minute at most. Sets
# status; the output is in $work/out and $work/err. The settings spare Open MPI
# the search for neighbours, half of the time that a tiny scene takes.
timeout=$(command -v timeout) || { echo "no program timeout" >&2; exit 2; }
emmy= # set by the script
status=0
last_run=
emmy_run()
{
  last_run=$*
  status=0
  OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_pml=ob1 OMPI_MCA_btl=self \
    "$timeout" 60 "$emmy" "$@" >"$work/out" 2>"$work/err" </dev/null || status=$?
}

# run_on_two_ranks ARGUMENTS...: after a failure Open MPI would wait a second
# for ranks that have left already
launcher= # set by the scripts that need it
run_on_two_ranks()
{
  last_run="$* (two ranks)"
  status=0
  OMPI_MCA_odls_base_sigkill_timeout=0 \
    "$timeout" 60 "$launcher" --oversubscribe --bind-to none -np 2 "$emmy" "$@" \
    >"$work/out" 2>"$work/err" </dev/null || status=$?
}

# says FILE WORDS: the words are there, wherever lines are broken
says()
{
  [ -f "$1" ] && tr -s ' \n' '  ' <"$1" | grep -qF -- "$2"
}

# matches FILE PATTERN: a line of the file matches the extended pattern
matches()
{
  [ -f "$1" ] && grep -qE -- "$2" "$1"
}

# has_lines NUMBER FILE [PATTERN]: so many lines (that match) are in the file
has_lines()
{
  [ -f "$2" ] && [ "$(grep -cE -- "${3-}" "$2")" -eq "$1" ]
}

# state FOLDER: names and contents of all that is in it
state()
{
  (cd "$1" && find . | sort && find . -type f -exec cksum {} + | sort)
}

# columns FOLDER: the ledger's columns between the grid's kinetic energies and
# the work of residuals
columns()
{
  sed -n '1s/.*kinetic_energy_grid_new,\(.*\),residual_work.*/\1/p' "$1/ledger.csv"
}

# last FOLDER COLUMN: its value at the end of the run
last()
{
  awk -F , -v name="$2" '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) column = i }
    END { print (column ? $column : "none") }' "$1/ledger.csv"
}

# is EXPRESSION: of numbers, true
is()
{
  awk "BEGIN { exit !($1) }"
}

# tiny_scene: sixteen particles in flight, in two dimensions
tiny_scene()
{
  cat <<'END'
set Dimension = 2
subsection Grid
  set Lower corner = 0, 0
  set Upper corner = 4, 4
  set Cells        = 4, 4
end
subsection Materials
  set Names = rubber
  subsection rubber
    set Model           = Hencky
    set Density         = 5
    set Young's modulus = 100
    set Poisson's ratio = 0.3
  end
end
subsection Bodies
  set Names = block
  subsection block
    set Shape                = box
    set Material             = rubber
    set Points per direction = 4
    set Initial velocity     = 1; 0
    subsection box
      set Lower corner = 1, 1
      set Upper corner = 2, 2
    end
  end
end
subsection Method
  set Shape functions = linear
  set Starved nodes   = free
end
subsection Time
  set End time  = 1
  set Step rule = fixed
  set Step size = 0.125
end
subsection Output
  set Pictures = false
end
END
}
