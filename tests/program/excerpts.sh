#!/bin/sh
# A page that quotes files quotes what stands there: after ```LANGUAGE FILE, with
# FILE relative to the source root, the lines up to ``` follow one another in FILE.
#
# Usage: excerpts.sh SOURCE_ROOT PAGE...
set -eu

[ $# -ge 2 ] || { echo "usage: excerpts.sh SOURCE_ROOT PAGE..." >&2; exit 2; }
cd "$1"
shift

for page; do
  # shellcheck disable=SC2016 # the dollar signs are those of awk
  awk '
    function content(file,   line, all, status)
    {
      all = "\n"
      while ((status = (getline line < file)) > 0)
        all = all line "\n"
      close(file)
      if (status < 0)
        complain("cannot read <" file ">")
      return all
    }
    function complain(what) { print FILENAME ":" start ": " what; n_wrong++ }

    /^```/ && file != "" {
      n_excerpts++
      if (!index(content(file), "\n" excerpt))
        complain("not what stands in " file ":\n" excerpt)
      file = ""
      next
    }
    /^```[a-z]+ [^ ]+$/ { file = $2; start = FNR; excerpt = ""; next }
    file != "" { excerpt = excerpt $0 "\n" }

    END {
      if (!n_excerpts)
        complain("no excerpts")
      print FILENAME ": " n_excerpts " excerpts, " n_wrong + 0 " wrong"
      exit (n_wrong > 0)
    }
  ' "$page"
done
