#ifndef emmy_effects_amplitude_h
#define emmy_effects_amplitude_h

#include <deal.II/base/function_parser.h>

#include <emmy/base/section.h>
#include <emmy/effects/time_history.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** The entries of a load's section that say how it changes with time. */
  struct AmplitudeParameters
  {
    std::string expression = "1"; ///< of t, s
    std::string table;            ///< "time: value, ..."; empty: none
    std::string sampling = "mid"; ///< or end

    /** Declare `Amplitude`, `Amplitude table` and `Sampling` there. */
    void
    declare(Section &section);

    /**
     * The factor over time. Throws ExcParameter for what cannot be read.
     * @param name of the load
     */
    TimeHistory
    history(const std::string &name, const std::string &section) const;
  };

  /**
   * The factor of a load over time, dimensionless: a formula in t, or a table
   * with straight lines between its times and constant beyond both ends. Two
   * equal times in a table are a jump; the earlier value holds at the time
   * itself. A load is constant in a step, so its amplitude is sampled once per
   * step: in the middle, as the mid-point rule wants it (Pretti et al. 2023,
   * eqs 20-24), or at the end, as the beam of their section 7.1 has it.
   *
   * Owned by the load. The formula is parsed once; cost: one evaluation per
   * step.
   */
  class Amplitude
  {
  public:
    /** 1 at all times. */
    Amplitude() = default;

    /**
     * Throws ExcParameter for what cannot be read, and if a table and a
     * formula other than 1 are given.
     *
     * @param section the load's section, for messages
     */
    Amplitude(const AmplitudeParameters &parameters,
              const std::string         &section);

    /**
     * The amplitude of the step from @p time to @p time + @p time_step, s.
     * Throws ExcRun if it is not finite: on all ranks, as it depends on
     * nothing else.
     */
    double
    over(const double time, const double time_step) const;

  private:
    /**
     * @param tolerance a jump that lies no more than this before @p time, s,
     *   has not come yet
     */
    double
    in_table(const double time, const double tolerance) const;

    std::string                                section, text;
    std::vector<std::pair<double, double>>     table; // times, s, and values
    std::unique_ptr<dealii::FunctionParser<1>> formula;
    double sampled_part = 0.5; // of the step that has passed
  };
} // namespace emmy

#endif
