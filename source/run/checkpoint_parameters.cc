#include <emmy/run/checkpoint_parameters.h>

namespace emmy
{
  CheckpointParameters::CheckpointParameters()
    : Section("Checkpoint")
  {
    add_parameter("Every steps",
                  every_steps,
                  "A checkpoint is written after each so many steps. 0: not "
                  "by steps. With this or <Every minutes> there is one of the "
                  "last state too. emmy --restart DIRECTORY goes on from it.",
                  prm,
                  dealii::Patterns::Integer(0));
    add_parameter("Every minutes",
                  every_minutes,
                  "A checkpoint is written after the first step that ends so "
                  "long after the last one was. Unit: minutes of the clock. "
                  "0: not by time. SIGTERM, SIGINT and SIGUSR1 have one "
                  "written in any case, and end the run.",
                  prm,
                  dealii::Patterns::Double(0.));
    add_parameter("Keep",
                  keep,
                  "How many checkpoints are kept: the last ones. Two, so that "
                  "there is one if the last is damaged.",
                  prm,
                  dealii::Patterns::Integer(1));
  }
} // namespace emmy
