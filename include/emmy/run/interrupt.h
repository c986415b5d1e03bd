#ifndef emmy_run_interrupt_h
#define emmy_run_interrupt_h

#include <string>

#include <csignal>

namespace emmy
{
  /**
   * While it lives, SIGTERM, SIGINT (Ctrl-C) and SIGUSR1 (the warning of a
   * batch system) do not end the program, but are noted. A second Ctrl-C ends
   * it at once. At most one may live at a time.
   */
  class SignalWatch
  {
  public:
    /** @param is_on false: signals do what they always do */
    explicit SignalWatch(const bool is_on);
    ~SignalWatch();
    SignalWatch(const SignalWatch &) = delete;
    SignalWatch &
    operator=(const SignalWatch &) = delete;

    /** The number of the first signal that came to this rank; 0: none did. */
    int
    received() const;

    /** "SIGTERM" and so on. */
    static std::string
    name(const int signal);

  private:
    const bool       is_on;
    struct sigaction before[3];
  };
} // namespace emmy

#endif
