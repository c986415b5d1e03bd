# For the scripts of this folder: a folder that goes when they end, one thread,
# and one rank that looks for no neighbours.
need_valgrind()
{
  command -v valgrind >/dev/null || {
    echo "this needs valgrind: apt-get install valgrind" >&2
    exit 2
  }
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
export OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_pml=ob1 OMPI_MCA_btl=self
export OMP_NUM_THREADS=1 DEAL_II_NUM_THREADS=1
