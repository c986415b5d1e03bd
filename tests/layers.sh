#!/bin/sh
# Layers look down only: a file in include/emmy/LAYER/ or source/LAYER/ includes
# <emmy/...> headers of its own layer and of those below it, and every .h and
# .cc file lives in a layer. `app` has sources only: nothing may include it.
#
# Usage: layers.sh SOURCE_ROOT
set -eu

[ $# -eq 1 ] || { echo "usage: layers.sh SOURCE_ROOT" >&2; exit 2; }
cd "$1"

# Top to bottom; layers on one line are siblings and do not include each other.
order='
  app
  study
  run
  output step
  solve
  effects
  transfer
  system
  particles
  grid
  material
  math
  base
'

# shellcheck disable=SC2016 # the dollar signs are those of awk
check='
  function complain(where, what) { print where ": " what; n_errors++ }

  function layer_of(file,   parts)
  {
    split(file, parts, "/")
    return file ~ "^include/emmy/[^/]+/" ? parts[3] : \
           file ~ "^source/[^/]+/"       ? parts[2] : ""
  }

  BEGIN {
    n_levels = split(order, levels, ";")
    for (i = 1; i <= n_levels; ++i) {
      n_names = split(levels[i], names, " ")
      for (j = 1; j <= n_names; ++j)
        level[names[j]] = i
    }
    for (i = 1; i < ARGC; ++i) {
      layer = layer_of(ARGV[i])
      if (!(layer in level))
        complain(ARGV[i], "not in a layer. Move it to include/emmy/LAYER/ or " \
                          "source/LAYER/, or add its layer to tests/layers.sh.")
      else if (layer == "app" && ARGV[i] ~ "^include/")
        complain(ARGV[i], "app has no public headers: move it to source/app/, " \
                          "or to the layer that offers it.")
    }
  }

  /^[ \t]*#[ \t]*include[ \t]*["<]/ {
    name = $0
    sub(/^[^"<]*["<]/, "", name)
    sub(/[">].*/, "", name)
    where = FILENAME ":" FNR
    if (name ~ "(^|/)\\.\\./") {
      complain(where, "\"" name "\" climbs out of its folder. Write <emmy/LAYER/" \
                      "NAME.h>, so that the layer shows.")
      next
    }
    if (name !~ "^emmy/")
      next
    split(name, parts, "/")
    mine   = layer_of(FILENAME)
    theirs = parts[3] == "" ? "" : parts[2]
    if (!(theirs in level))
      complain(where, "<" name "> is not in a layer.")
    else if ((mine in level) && mine != theirs && level[theirs] <= level[mine])
      complain(where, "layer " mine " includes <" name ">, but " theirs " is " \
               (level[theirs] == level[mine] ? "beside" : "above") " it. Pass " \
               "what is needed in, or move it down.")
  }

  END {
    if (n_errors == 0)
      print (ARGC - 1) " files: every layer looks down only."
    exit (n_errors > 0)
  }
'

for folder in include/emmy source; do
  [ -d "$folder" ] || { echo "no folder $folder in $PWD: give emmy's source root" >&2; exit 2; }
done
files=$(find include source -type f \( -name '*.h' -o -name '*.cc' \) | sort)
[ -n "$files" ] || { echo "no .h or .cc files in include/ and source/ of $PWD" >&2; exit 1; }

# shellcheck disable=SC2086 # one word per file: no spaces in our file names
exec awk -v order="$(printf '%s' "$order" | tr '\n' ';')" "$check" $files
