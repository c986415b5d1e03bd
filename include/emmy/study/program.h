#ifndef emmy_study_program_h
#define emmy_study_program_h

namespace emmy
{
  /** The exit code of a run that a signal ended and that can go on: "try again
   * later" (EX_TEMPFAIL of sysexits.h). */
  constexpr int interrupted_exit_code = 75;

  /**
   * The program: what the command line asks for, from parameter file to
   * results. Starts and ends MPI, one thread per rank; prints errors. A
   * program that brings its own materials or effects adds them to their
   * libraries, for both dimensions, and then calls this:
   * see doc/tutorials.
   *
   * @return the exit code for main(): 0, 1 after an error,
   *   interrupted_exit_code after a signal
   */
  int
  run_program(int argc, char *argv[]);
} // namespace emmy

#endif
