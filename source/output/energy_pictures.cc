#include <emmy/output/energy_pictures.h>
#include <emmy/output/gnuplot.h>

#include <algorithm>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** A column of the ledger and how its curve is drawn. */
    struct Curve
    {
      std::string column, name, style;
    };

    // Colours of Okabe and Ito, which the colour-blind can tell apart. The
    // energies of the body, then where energy went; they add up to "total".
    const std::vector<Curve> energies = {
      {"kinetic_energy", "kinetic", "lc rgb '#0072b2'"},
      {"strain_energy", "strain", "lc rgb '#d55e00'"},
      {"hardening_energy", "hardening", "lc rgb '#cc79a7'"},
      {"contact_energy", "contact", "lc rgb '#e69f00'"},
      {"friction_energy", "friction, stored", "lc rgb '#56b4e9'"},
      {"friction_dissipation",
       "friction, dissipated",
       "lc rgb '#56b4e9' dt (4,4)"},
      {"plastic_dissipation", "plastic dissipation", "lc rgb '#009e73'"},
      {"radiated_energy", "radiated", "lc rgb '#999999'"},
      {"damping_loss", "damping", "lc rgb '#999999' dt (4,4)"},
      {"stress_rule_loss", "stress rule loss", "lc rgb '#d55e00' dt (10,4)"},
      {"lumping_loss", "lumping loss", "lc rgb '#e69f00' dt (10,4)"},
      {"mapping_loss", "mapping loss", "lc rgb '#56b4e9' dt (10,4)"},
      {"wall_loss", "wall loss", "lc rgb '#0072b2' dt (10,4)"},
      {"ghost_mass_loss", "ghost mass loss", "lc rgb '#cc79a7' dt (4,4)"},
      {"ghost_stiffness_loss",
       "ghost stiffness loss",
       "lc rgb '#009e73' dt (4,4)"}};

    /** Whether a column is the kinetic energy of a tool that is pushed. */
    bool
    is_of_tool(const std::string &column)
    {
      const std::string beginning = "tool_", ending = "_kinetic_energy";
      return column.size() > beginning.size() + ending.size() &&
             column.compare(0, beginning.size(), beginning) == 0 &&
             column.compare(column.size() - ending.size(),
                            ending.size(),
                            ending) == 0;
    }

    std::vector<Curve>
    present(const std::vector<Curve>       &curves,
            const std::vector<std::string> &columns)
    {
      std::vector<Curve> found;
      for (const Curve &curve : curves)
        if (std::find(columns.begin(), columns.end(), curve.column) !=
            columns.end())
          found.push_back(curve);
      for (const std::string &column : columns)
        if (is_of_tool(column))
          {
            const std::string tool = column.substr(5, column.size() - 20);
            found.push_back(
              {column, "kinetic, " + tool, "lc rgb '#0072b2' dt (4,4)"});
          }
      return found;
    }


    /**
     * The columns of what was brought in from outside: works of loads, of
     * what holds unknowns, of tools; not what solves left.
     */
    std::vector<std::string>
    works_among(const std::vector<std::string> &columns)
    {
      const std::string        ending = "_work";
      std::vector<std::string> found;
      for (const std::string &column : columns)
        if (column.size() > ending.size() && column != "residual_work" &&
            column.compare(column.size() - ending.size(),
                           ending.size(),
                           ending) == 0)
          found.push_back(column);
      return found;
    }


    /** The sum of the columns as a gnuplot expression; 0 of none. */
    std::string
    sum(const std::vector<std::string> &columns)
    {
      std::string terms = "0";
      for (const std::string &column : columns)
        terms += " + column('" + column + "')";
      return terms;
    }


    std::string
    sum(const std::vector<Curve> &curves)
    {
      std::vector<std::string> columns;
      for (const Curve &curve : curves)
        columns.push_back(curve.column);
      return sum(columns);
    }


    /**
     * How curves over time look below a key with so many rows, and the energy
     * at the start of the run.
     */
    void
    write_frame(std::ostream             &script,
                const std::string        &title,
                const std::vector<Curve> &stored,
                const unsigned int        n_key_rows)
    {
      script << "set datafile separator comma\n"
             << "set datafile columnheaders\n"
             << "ledger = '../ledger.csv'\n"
             << "stats ledger using (" << sum(stored)
             << ") every ::0::0 nooutput name 'first'\n"
             << "stats ledger using (" << sum(stored)
             << ") nooutput name 'all'\n"
             << "initial = first_max\n\n"
             << "set label 1 " << gnuplot::quoted(title)
             << " noenhanced at screen 0.5, screen 0.965 center\n"
             << "set tmargin " << (title.empty() ? 1.2 : 3.) + 1.25 * n_key_rows
             << "\n"
             << "set border 3 lw 0.6 lc rgb '#404040'\n"
             << "set tics out nomirror scale 0.5\n"
             << "set grid xtics ytics back lt 1 lw 0.4 lc rgb '#e2e2e2'\n"
             << "set xlabel 'time (s)'\n"
             << "set autoscale xfix\n"
             << "set rmargin 5\n";
    }
  } // namespace


  void
  write_energies_script(std::ostream                   &script,
                        const std::string              &title,
                        const std::vector<std::string> &columns)
  {
    const std::vector<Curve>       stored  = present(energies, columns);
    const std::vector<std::string> outside = works_among(columns);
    const std::size_t n_curves = stored.size() + (outside.empty() ? 1 : 2);

    gnuplot::write_preamble(script, "energies", gnuplot::Canvas());
    write_frame(script, title, stored, (n_curves + 2) / 3);
    // what stores energy in row 0 has worked there
    script << "stats ledger using (" << sum(outside)
           << ") every ::0::0 nooutput name 'before'\n";
    // Round-off below zero shall not open the axis down to the next tic.
    script << "lowest = 0.0\n";
    for (const Curve &curve : stored)
      script << "stats ledger using (column('" << curve.column
             << "')) nooutput name 'one'\n"
             << "lowest = one_min < lowest ? one_min : lowest\n";
    script << "set yrange [(lowest < -1e-4*all_max ? lowest : 0.0):*]\n"
           << "set offsets graph 0, 0, 0.04, 0\n";
    script << "set ylabel 'energy (J)'\n"
           << "set key at screen 0.5, screen " << (title.empty() ? 0.99 : 0.94)
           << " center top horizontal maxcols 3 Left reverse samplen 2\n\n"
           << "plot \\\n";
    if (!outside.empty())
      script << "  ledger using (column('time')):(initial - before_max + "
             << sum(outside)
             << ") with lines lw 3.5 lc rgb '#c8c8c8' "
                "title 'initial + external work', \\\n";
    script << "  ledger using (column('time')):(" << sum(stored)
           << ") with lines lw 1.2 lc rgb '#000000' title 'total'";
    for (const Curve &curve : stored)
      script << ", \\\n  ledger using (column('time')):(column('"
             << curve.column << "')) with lines lw 1.2 " << curve.style
             << " title '" << curve.name << "'";
    script << "\n";
  }


  void
  write_balance_error_script(std::ostream                   &script,
                             const std::string              &title,
                             const std::vector<std::string> &columns)
  {
    const std::vector<Curve> stored = present(energies, columns);

    gnuplot::Canvas canvas;
    canvas.height = 1000.;
    gnuplot::write_preamble(script, "balance_error", canvas);
    write_frame(script, title, stored, 0);
    script
      << "# A body that starts from rest has no energy to compare with.\n"
      << "at_rest = initial <= 1e-6*all_max\n"
      << "scale = !at_rest ? initial : all_max > 0 ? all_max : 1.0\n"
      << "set ylabel '|balance error| / '.(at_rest ? 'largest' : "
         "'initial').' energy'\n\n"
      << "# Zeros are drawn at the floor.\n"
      << "floored(x) = abs(x)/scale > 1e-18 ? abs(x)/scale : 1e-18\n"
      << "stats ledger using (floored(column('balance_error'))) nooutput "
         "name 'error'\n"
      << "set logscale y\n"
      << "set yrange [7e-19:(error_max > 1e-12 ? 3*error_max : 1e-11)]\n"
      << "set format y '10^{%T}'\nset ytics 1e-18,100\nset mytics 1\n"
      << "unset key\n\n"
      << "plot 1e-12 with lines lw 1 lc rgb '#a8a8a8', \\\n"
      << "  ledger using (column('time')):(floored(column('balance_error'))) "
         "with lines lw 0.5 lc rgb '#99c7e0', \\\n"
      << "  ledger using (column('time')):(floored(column('balance_error'))) "
         "with points pt 7 ps 0.35 lc rgb '#0072b2'\n";
  }
} // namespace emmy
