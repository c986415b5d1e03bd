#include <emmy/run/interrupt.h>

#include <unistd.h>

#include <cstring>

namespace emmy
{
  namespace
  {
    constexpr int watched[3] = {SIGTERM, SIGINT, SIGUSR1};

    volatile std::sig_atomic_t first_signal = 0;

    extern "C" void
    note_signal(int signal)
    {
      if (first_signal == 0)
        first_signal = signal;
      if (signal != SIGINT)
        return;
      // only what is safe in a handler
      const char    text[]  = "\nemmy: finishing this step, then writing a "
                              "checkpoint; Ctrl-C once more ends it at once\n";
      const ssize_t ignored = ::write(STDERR_FILENO, text, sizeof(text) - 1);
      (void)ignored;
    }
  } // namespace

  SignalWatch::SignalWatch()
  {
    first_signal = 0;
    for (unsigned int i = 0; i < 3; ++i)
      ::sigaction(watched[i], nullptr, &before[i]);
    renew();
  }

  void
  SignalWatch::renew()
  {
    for (unsigned int i = 0; i < 3; ++i)
      {
        struct sigaction action;
        std::memset(&action, 0, sizeof(action));
        action.sa_handler = note_signal;
        sigemptyset(&action.sa_mask);
        // reads and writes go on
        action.sa_flags = SA_RESTART;
        if (watched[i] == SIGINT)
          action.sa_flags |= SA_RESETHAND;
        ::sigaction(watched[i], &action, nullptr);
      }
  }

  SignalWatch::~SignalWatch()
  {
    for (unsigned int i = 0; i < 3; ++i)
      ::sigaction(watched[i], &before[i], nullptr);
  }

  int
  SignalWatch::received() const
  {
    return static_cast<int>(first_signal);
  }

  std::string
  SignalWatch::name(const int signal)
  {
    return signal == SIGTERM   ? "SIGTERM"
           : signal == SIGINT  ? "SIGINT"
           : signal == SIGUSR1 ? "SIGUSR1"
                               : "signal " + std::to_string(signal);
  }
} // namespace emmy
