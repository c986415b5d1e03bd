#ifndef emmy_run_interrupt_h
#define emmy_run_interrupt_h

#include <string>

#include <csignal>

namespace emmy
{
  /**
   * While it lives, SIGTERM, SIGINT (Ctrl-C) and SIGUSR1 (the warning of a
   * batch system) do not end the program, but are noted. A second Ctrl-C ends
   * it at once. At most one may live at a time; made before MPI starts, as a
   * batch system may warn while ranks are still starting.
   */
  class SignalWatch
  {
  public:
    SignalWatch();
    /** Signals do again what they did before. */
    ~SignalWatch();
    SignalWatch(const SignalWatch &) = delete;
    SignalWatch &
    operator=(const SignalWatch &) = delete;

    /** Once MPI has started, which may handle signals itself. */
    void
    renew();

    /** The number of the first signal that came to this rank; 0: none did. */
    int
    received() const;

    /** "SIGTERM" and so on. */
    static std::string
    name(const int signal);

  private:
    struct sigaction before[3];
  };
} // namespace emmy

#endif
