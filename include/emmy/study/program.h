#ifndef emmy_study_program_h
#define emmy_study_program_h

namespace emmy
{
  /**
   * The program: what the command line asks for, from parameter file to
   * results. Starts and ends MPI, one thread per rank; prints errors. A
   * program that brings its own materials or effects adds them to their
   * libraries, for both dimensions, and then calls this:
   * see doc/examples/neo-hooke.
   *
   * @return the exit code for main(): 0, or 1 after an error
   */
  int
  run_program(int argc, char *argv[]);
} // namespace emmy

#endif
