#include <emmy/study/program.h>

int
main(int argc, char *argv[])
{
  return emmy::run_program(argc, argv);
}
