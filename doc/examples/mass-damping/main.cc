// emmy with one more value in <Effects/Names>.
#include <emmy/study/program.h>

#include "mass_damping.h"

int
main(int argc, char *argv[])
{
  add_mass_damping();
  return emmy::run_program(argc, argv);
}
